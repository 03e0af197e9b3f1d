"""``ragdoll conformers``: conformers of many small molecules, from SMILES, SD or MOL2 files."""

import json
import sys
import time
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from ..batch.conforming import ConformerOptions
from ..batch.report import BatchReport, MoleculeFault
from ..batch.run import conformers_of_file
from ..exits import DONE, INCOMPLETE, INTERRUPTED, EndedShort
from .method_options import check_file

_DEFAULT = ConformerOptions()
_BETWEEN = 0.5  # s, of progress


def run(
    input: Annotated[
        Path, typer.Argument(help=".smi, .csv, .sdf, .mol or .mol2, also .gz; many molecules.")
    ],
    output: Annotated[
        Path, typer.Option("--output", "-o", help="The conformers: .sdf, .sdf.gz or .h5.")
    ],
    count: Annotated[
        int, typer.Option("--count", "-n", help="Conformers of each molecule.")
    ] = _DEFAULT.count,
    seed: Annotated[int, typer.Option(help="Decides all random numbers.")] = _DEFAULT.seed,
    start: Annotated[
        str,
        typer.Option(
            help="input: from the given coordinates where they are 3-D, else embedded by RDKit; "
            "embed: always embedded."
        ),
    ] = _DEFAULT.start,
    relax_start: Annotated[
        bool,
        typer.Option(
            "--relax-start", help="Give embedded starts the bonds and angles of MMFF94s, or UFF."
        ),
    ] = _DEFAULT.relax_start,
    fragments: Annotated[
        str, typer.Option(help="Of salts and the like: all, or the largest.")
    ] = _DEFAULT.fragments,
    stereo_isomers: Annotated[
        int,
        typer.Option(
            help="Of the configurations left open, make so many, each with --count conformers; "
            "0: the one that the embedding chooses."
        ),
    ] = _DEFAULT.stereo_isomers,
    rmsd_prune_angstrom: Annotated[
        float,
        typer.Option(
            help="Least RMSD of any two conformers: heavy atoms, superposed, symmetric atoms "
            "exchanged. 0: alike ones stay."
        ),
    ] = _DEFAULT.rmsd_prune_angstrom,
    energy_window_kcal: Annotated[
        float | None,
        typer.Option(
            help="Most energy above the lowest: of the force field with --minimize, else the "
            "score of the torsions. Default: any."
        ),
    ] = _DEFAULT.energy_window_kcal,
    minimize: Annotated[
        str | None,
        typer.Option(help="mmff94s or uff: minimise by RDKit and rank by energy. Default: no."),
    ] = _DEFAULT.minimize,
    workers: Annotated[
        int | None,
        typer.Option(help="Processes; default: all cores. The output is the same."),
    ] = None,
    seconds_per_molecule: Annotated[
        float, typer.Option(help="After which a molecule is given up.")
    ] = _DEFAULT.seconds_per_molecule,
    report: Annotated[
        Path | None, typer.Option(help="A CSV file with a row for each molecule.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
    force: Annotated[
        bool,
        typer.Option(
            "--force", help="Replace an existing output, and what another run left of it."
        ),
    ] = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="No progress, log and table.")] = False,
) -> int:
    """Conformers of small molecules, each from one start: turns about bonds and through rings,
    without clashes, with the start's configuration, bonds and angles.

    A molecule that cannot be done costs a line of the log. A run that was ended goes on where it
    stopped when it is started again.

    Exit code 0: all molecules have all conformers; 3: some have none or fewer.
    """
    options = ConformerOptions(
        count=count,
        seed=seed,
        start=start.lower(),
        relax_start=relax_start,
        fragments=fragments.lower(),
        stereo_isomers=stereo_isomers,
        rmsd_prune_angstrom=rmsd_prune_angstrom,
        energy_window_kcal=energy_window_kcal,
        minimize=None if minimize is None else minimize.lower(),
        seconds_per_molecule=seconds_per_molecule,
    )
    options.check()
    check_file(report, force, [input, output])
    log = _Log(quiet)
    result = conformers_of_file(
        input,
        output,
        options,
        workers=workers,
        force=force,
        table=report,
        progress=log.progress,
        tell=log.fault,
    )
    log.end()
    if as_json:
        typer.echo(json.dumps(result.as_dict(), indent=2))
    elif not quiet and not result.interrupted:
        Console(highlight=False).print(_table(result))
    _check_complete(result)
    return DONE


class _Log:
    """Lines on standard error: one for each molecule that is not complete, and the progress."""

    def __init__(self, quiet: bool):
        self._quiet = quiet
        self._is_terminal = sys.stderr.isatty()
        self._next = 0.0
        self._begin = time.monotonic()

    def progress(self, report: BatchReport, share: float) -> None:
        """Show how far the run is, now and then, in one line that is written over."""
        now = time.monotonic()
        if self._quiet or not self._is_terminal or now < self._next:
            return
        self._next = now + _BETWEEN
        words = f"{report.molecules} molecules, {report.conformers} conformers, {100 * share:.0f} %"
        if report.failed_count:
            words += f", {report.failed_count} failed"
        sys.stderr.write(f"\r{words}\033[K")
        sys.stderr.flush()

    def fault(self, fault: MoleculeFault) -> None:
        """Say what became of a molecule."""
        if self._quiet:
            return
        self.end()
        name = f"line {fault.line}"
        if fault.title and fault.title != name:
            name += f" ({fault.title})"
        outcome = "no conformers" if not fault.conformers else f"{fault.conformers} conformers"
        sys.stderr.write(f"{name}: {outcome}: {fault.reason}.\n")

    def end(self) -> None:
        """Take the line of progress away."""
        if not self._quiet and self._is_terminal:
            sys.stderr.write("\r\033[K")
        sys.stderr.flush()


def _table(report: BatchReport) -> Table:
    table = Table(title=Text(report.output), show_header=False, title_justify="left")
    table.add_row("molecules", f"{report.molecules}")
    if report.taken_up:
        table.add_row("of an earlier run", f"{report.taken_up}")
    table.add_row("conformers", f"{report.conformers}")
    table.add_row("all conformers", f"{report.complete} molecules")
    table.add_row("fewer", f"{report.short_count} molecules")
    table.add_row("none", f"{report.failed_count} molecules")
    table.add_row("time", f"{report.seconds:.2f} s, {report.workers} process(es)")
    return table


def _check_complete(report: BatchReport) -> None:
    if report.interrupted:
        raise EndedShort(
            f"Interrupted; {report.molecules} molecules are done and kept beside {report.output}, "
            "the same command goes on from there.",
            INTERRUPTED,
        )
    if report.conformers == 0:
        first = report.failed[0]
        raise EndedShort(
            f"No molecule gave conformers, so {report.output} was not written; the first, in line "
            f"{first.line}: {first.reason}.",
            INCOMPLETE,
        )
    if report.failed_count or report.short_count:
        raise EndedShort(
            f"Of {report.molecules} molecules, {report.failed_count} have no conformers and "
            f"{report.short_count} have fewer than {report.parameters['count']}; --json and "
            "--report tell why.",
            INCOMPLETE,
        )
