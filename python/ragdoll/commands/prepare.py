"""``ragdoll prepare``: what stands in the way of a structure, mended."""

import json
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from ..errors import InputError
from ..exits import DONE
from ..prepare_report import PrepareOptions, PrepareReport
from .ligand_flags import NO_LIGANDS, LigandFlags, takes_ligands
from .method_options import AsJson, Force, Quiet, tell

_DEFAULT = PrepareOptions()


@takes_ligands
def run(
    input: Annotated[Path, typer.Argument(help="PDB or mmCIF file, also .gz.")],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="The prepared structure, .pdb or .cif.")
    ] = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Only report.")] = False,
    heterogens: Annotated[
        str, typer.Option(help="keep, or ligands without single ions, or drop.")
    ] = _DEFAULT.heterogens,
    keep_water: Annotated[bool, typer.Option("--keep-water", help="Keep waters.")] = False,
    replace_nonstandard: Annotated[
        bool,
        typer.Option(
            "--replace-nonstandard/--keep-nonstandard",
            help="Replace residues such as MSE by standard ones.",
        ),
    ] = _DEFAULT.replace_nonstandard,
    longest_loop: Annotated[
        int, typer.Option(help="Missing residues in a row that are built at most; 0: none.")
    ] = _DEFAULT.longest_loop,
    build_ends: Annotated[
        bool, typer.Option("--build-ends", help="Build missing ends of chains too.")
    ] = False,
    add_hydrogens: Annotated[
        bool, typer.Option("--hydrogens/--no-hydrogens", help="Add missing hydrogens.")
    ] = _DEFAULT.add_hydrogens,
    ph: Annotated[float, typer.Option("--ph", help="Decides protonation.")] = _DEFAULT.ph,
    ligands: LigandFlags = NO_LIGANDS,
    model: Annotated[int, typer.Option(help="Model of the file, from 1.")] = _DEFAULT.model,
    altloc: Annotated[
        str | None, typer.Option(help="Alternate location; by default each residue's first.")
    ] = None,
    chain: Annotated[
        list[str] | None, typer.Option(help="Chain to keep; may be repeated. Default: all.")
    ] = None,
    as_json: AsJson = False,
    force: Force = False,
    quiet: Quiet = False,
) -> int:
    """Report what stands in the way of a structure and mend it: missing atoms and loops, alternate
    locations, non-standard residues, hydrogens, waters. Atoms that are there stay in place.
    """
    if output is None and not dry_run:
        raise InputError("Give --output for the prepared structure, or --dry-run.")
    options = PrepareOptions(
        heterogens=heterogens,
        keep_water=keep_water,
        replace_nonstandard=replace_nonstandard,
        longest_loop=longest_loop,
        build_ends=build_ends,
        add_hydrogens=add_hydrogens,
        ph=ph,
        model=model,
        altloc=altloc,
        chains=None if chain is None else tuple(chain),
        ligands=ligands.files,
        ligand_smiles=ligands.smiles,
        covalent_bonds=ligands.covalent_bonds,
    )
    from ..preparing import prepare

    report = prepare(input, output, options, dry_run=dry_run, force=force)
    if as_json:
        typer.echo(json.dumps(report.as_dict(), indent=2))
        tell(report.notes, quiet)
    elif not quiet:
        _print(report, output)
    return DONE


def _print(report: PrepareReport, output: Path | None) -> None:
    console = Console(highlight=False, markup=False, soft_wrap=True)
    parts = {"Found": report.found(), "Done": report.done, "Left": report.left}
    for title, sentences in {**parts, "Notes": report.notes}.items():
        for sentence in sentences:
            console.print(f"{title + ':' if sentence is sentences[0] else '':<7}{sentence}")
    if report.molecule is not None and output is not None:
        console.print(f"{len(report.molecule)} atoms were written to {output}.")
