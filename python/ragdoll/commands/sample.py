"""``ragdoll sample``: conformations of a molecule, into an HDF5 trajectory."""

import json
import sys
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table
from rich.text import Text

from ..constraint_options import ConstraintOptions
from ..errors import InputError
from ..exits import DONE, INCOMPLETE, INTERRUPTED, EndedShort
from ..molecule import Molecule
from ..motion_options import MotionOptions
from ..quality_limits import QualityLimits
from ..sampling import SampleOptions, SampleReport, check_paths
from ..sampling import sample as sample_molecule
from .constraint_flags import takes_constraints
from .ligand_flags import NO_LIGANDS, LigandFlags, takes_ligands
from .method_options import check_file
from .motion_flags import takes_motion
from .quality_rows import counted, quality_rows

_DEFAULT = SampleOptions()
_LIMITS = _DEFAULT.limits


@takes_constraints
@takes_ligands
@takes_motion
def run(
    input: Annotated[Path, typer.Argument(help="PDB or mmCIF file, also .gz.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="The trajectory, HDF5.")],
    frames: Annotated[int, typer.Option(help="Frames to write.")] = _DEFAULT.frames,
    stride: Annotated[
        int | None,
        typer.Option(help="Accepted steps per frame.", show_default="thermal: 1, others: 10"),
    ] = None,
    step_angstrom: Annotated[
        float | None,
        typer.Option(
            help="Size of the random moves: deviation per coordinate, or radius.",
            show_default="thermal: 0.05, others: 0.1",
        ),
    ] = None,
    perturbation: Annotated[
        str | None,
        typer.Option(
            show_default="thermal; gaussian for fewer than 10 residues",
            help="What moves atoms: thermal, gaussian, ball (random), momentum, hinge, modes, steer or away."
        ),
    ] = None,
    motion: MotionOptions = _DEFAULT.motion,
    order: Annotated[str, typer.Option(help="Which bar is resolved when.")] = _DEFAULT.order,
    weighting: Annotated[
        str, typer.Option(help="How an error is shared, far end first.")
    ] = _DEFAULT.weighting,
    solver: Annotated[
        str, typer.Option(help="ordered, newton, block, templates or auto; --json says what.")
    ] = _DEFAULT.solver,
    tolerance: Annotated[
        float | None,
        typer.Option(
            help="Largest relative violation of a constraint.",
            show_default=f"{_DEFAULT.tolerance:g}",
        ),
    ] = None,
    tolerance_angstrom: Annotated[
        float | None,
        typer.Option(help="In the place of --tolerance: largest |d - L| of any constraint."),
    ] = None,
    precision: Annotated[
        str, typer.Option(help="Of the solvers' numbers: double or single.")
    ] = _DEFAULT.precision,
    max_iterations: Annotated[
        int, typer.Option(help="Iterations after which a step is rejected.")
    ] = _DEFAULT.max_iterations,
    contacts: Annotated[
        bool, typer.Option("--contacts/--no-contacts", help="Keep atoms apart.")
    ] = _DEFAULT.contacts,
    contact_scale: Annotated[
        float, typer.Option(help="Share of the sum of van der Waals radii that contacts keep.")
    ] = _DEFAULT.contact_scale,
    planarity_degree: Annotated[
        float, typer.Option(help="How far planar units may turn or bend.")
    ] = _DEFAULT.planarity_degree,
    constraints: ConstraintOptions = _DEFAULT.constraints,
    ligands: LigandFlags = NO_LIGANDS,
    model: Annotated[int, typer.Option(help="Model of the file, from 1.")] = 1,
    altloc: Annotated[
        str | None, typer.Option(help="Alternate location; by default each residue's first.")
    ] = None,
    chain: Annotated[
        list[str] | None, typer.Option(help="Chain to keep; may be repeated. Default: all.")
    ] = None,
    keep_solvent: Annotated[
        bool, typer.Option("--keep-solvent", help="Keep waters, ions and the box.")
    ] = False,
    add_hydrogens: Annotated[
        bool, typer.Option("--add-hydrogens", help="Add missing hydrogens by PDBFixer.")
    ] = False,
    ph: Annotated[float, typer.Option("--ph", help="For --add-hydrogens.")] = 7.0,
    platform: Annotated[
        str, typer.Option(help="Reference or CPU; without a meaning for --replicas.")
    ] = _DEFAULT.platform,
    seed: Annotated[int, typer.Option(help="Decides all random numbers.")] = _DEFAULT.seed,
    replicas: Annotated[
        int | None,
        typer.Option(
            help="Independent walkers, side by side: replica k is what a run with seed + k would "
            "be. Each writes --frames into the one file."
        ),
    ] = None,
    threads: Annotated[
        int | None,
        typer.Option(help="For --replicas, at most; default: all cores. The frames are the same."),
    ] = None,
    allow_low_quality: Annotated[
        bool, typer.Option("--allow-low-quality", help="Write frames below the limits too.")
    ] = False,
    max_bond_rms_angstrom: Annotated[
        float, typer.Option(help="Limit of frames: RMS of bonds against the input.")
    ] = _LIMITS.bond_rms_angstrom,
    max_angle_rms_degree: Annotated[
        float, typer.Option(help="The same of angles.")
    ] = _LIMITS.angle_rms_degree,
    max_clash_growth: Annotated[
        float, typer.Option(help="Clashes per 1000 heavy atoms more than in the input.")
    ] = _LIMITS.clash_growth,
    max_outlier_growth_percent: Annotated[
        float, typer.Option(help="Ramachandran outliers more than in the input.")
    ] = _LIMITS.outlier_growth_percent,
    max_core_loss_percent: Annotated[
        float | None, typer.Option(help="Residues less in the Ramachandran core. Default: any.")
    ] = _LIMITS.core_loss_percent,
    max_omega_growth_percent: Annotated[
        float, typer.Option(help="Peptide bonds more that are off by over 30 degrees.")
    ] = _LIMITS.omega_growth_percent,
    max_excess_angstrom: Annotated[
        float | None, typer.Option(help="Over any upper bound. Default: any.")
    ] = _LIMITS.excess_angstrom,
    state: Annotated[
        Path | None,
        typer.Option(help="Write here, .npz, the state that the walk ends in, for --restart."),
    ] = None,
    restart: Annotated[
        Path | None,
        typer.Option(help="Go on from a state that a run with the same options wrote."),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing output.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="No progress, notes and table.")] = False,
) -> int:
    """Sample conformations of a molecule: its thermal modes, or what --perturbation says, move it,
    and each step is resolved.

    Exit code 0: all frames were written; 3: fewer were.
    """
    options = SampleOptions(
        frames=frames,
        stride=stride,
        step_angstrom=step_angstrom,
        perturbation=perturbation,
        motion=motion,
        order=order,
        weighting=weighting,
        solver=solver,
        tolerance=tolerance,
        tolerance_angstrom=tolerance_angstrom,
        precision=precision,
        max_iterations=max_iterations,
        contacts=contacts,
        contact_scale=contact_scale,
        planarity_degree=planarity_degree,
        constraints=constraints,
        seed=seed,
        platform=platform,
        replicas=replicas,
        threads=threads,
        limits=QualityLimits(
            bond_rms_angstrom=max_bond_rms_angstrom,
            angle_rms_degree=max_angle_rms_degree,
            clash_growth=max_clash_growth,
            outlier_growth_percent=max_outlier_growth_percent,
            core_loss_percent=max_core_loss_percent,
            omega_growth_percent=max_omega_growth_percent,
            excess_angstrom=max_excess_angstrom,
        ),
        allow_low_quality=allow_low_quality,
    )
    # refuse before a large file is read
    options.check()
    check_paths(input, output, force)
    # a state may replace the one that the run goes on from
    check_file(state, force or state == restart, [input, output])
    if not 0 <= ph <= 14:
        raise InputError(f"--ph must be from 0 to 14, not {ph}.")
    reading = {
        "model": model,
        "altloc": altloc,
        "chains": chain,
        "keep_solvent": keep_solvent,
        "add_hydrogens": add_hydrogens,
        "ph": ph,
    }
    of_ligands = ligands.check()
    molecule = Molecule.from_file(input, **reading, **ligands.arguments())
    messages = Console(stderr=True, quiet=quiet, highlight=False)
    _print_notes(messages, molecule.notes)
    _print_gaps(messages, molecule)
    with Progress(
        TextColumn("sampling"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
        console=messages,
        transient=True,
        disable=quiet or not sys.stderr.isatty(),
    ) as progress:
        task = progress.add_task("frames", total=frames * (replicas or 1))
        report = sample_molecule(
            molecule,
            output,
            options,
            force=force,
            progress=lambda done, asked: progress.update(task, completed=done, total=asked),
            parameters={**reading, **of_ligands},
            restart=restart,
            state=state,
        )
    _print_notes(messages, report.notes[len(molecule.notes) :])
    if as_json:
        typer.echo(json.dumps(report.as_dict(), indent=2))
    elif not quiet:
        Console(highlight=False).print(_table(report, output))
    _check_complete(report)
    return DONE


def _print_notes(messages: Console, notes: list[str]) -> None:
    for note in notes:
        messages.print(note, markup=False, soft_wrap=True)


def _print_gaps(messages: Console, molecule: Molecule) -> None:
    gaps = molecule.missing_atoms
    for gap in gaps[:5]:
        messages.print(f"{gap.residue} lacks {', '.join(gap.names)}.", markup=False, soft_wrap=True)
    if len(gaps) > 5:
        messages.print(f"{len(gaps) - 5} more residues lack atoms; --json lists them.")


def _table(report: SampleReport, output: Path) -> Table:
    geometry = report.geometry
    table = Table(title=Text(str(output)), show_header=False, title_justify="left")
    table.add_row("atoms, bars, contacts", f"{report.atoms}, {report.bars}, {report.contacts}")
    held = _held(report)
    if held:
        table.add_row("held", held)
    table.add_row(
        "bond graph",
        f"{report.class_}, cycle rank {report.cycle_rank}, {report.components} component(s)",
    )
    table.add_row("frames", f"{report.frames} of {report.frames_asked}")
    if report.replicas:
        table.add_row(
            "replicas",
            f"{len(report.replicas)}, by {report.threads} thread(s) of {report.lanes} lane(s)",
        )
    chosen = "" if report.solver == report.solver_asked else f", chosen by {report.solver_asked}"
    table.add_row("solver", f"{report.solver}{chosen}, {report.precision} precision")
    table.add_row(
        "steps, rejected",
        f"{report.steps}, {report.rejected_steps} ({100 * report.rejected_share:.2g} %)",
    )
    table.add_row(
        "iterations", f"mean {report.iterations_mean:.1f}, p99 {report.iterations_p99:.0f}"
    )
    table.add_row(
        "time", f"{report.seconds:.2f} s, {report.frames_per_second:.1f} frames per second"
    )
    if geometry:
        table.add_row(
            "RMSD from the input",
            f"last {geometry['rmsd_last_angstrom']:.2f}, "
            f"most {geometry['rmsd_max_angstrom']:.2f} Å",
        )
        table.add_row(
            "bonds",
            f"RMS {geometry['bond_rms_angstrom']:.4f}, most {geometry['bond_max_angstrom']:.4f} Å",
        )
        table.add_row(
            "all bars",
            f"most {geometry['bar_max_angstrom']:.4f} Å, "
            f"{100 * geometry['bar_max_relative']:.2g} %",
        )
        table.add_row("angles", f"RMS {geometry['angle_rms_degree']:.2f}°")
        table.add_row("peptide torsions", f"most {geometry['omega_max_deviation_degree']:.1f}°")
        table.add_row("beyond their bounds", _beyond(geometry))
        table.add_row("contacts violated", f"{geometry['contact_violations']}")
        table.add_row("chirality inverted", f"{geometry['chirality_inverted']}")
    for words, text in quality_rows(report.quality):
        table.add_row(words, text)
    if report.low_frames:
        table.add_row("frames of low quality", counted(report.low_frames))
    return table


def _held(report: SampleReport) -> str:
    """What holds beside covalent bonds, counted by kind."""
    counts = report.constraints
    bonds = counts["hydrogen_bonds"]
    tethers, contacts, bars = counts["tethers"], counts["contacts"], counts["bars"]
    parts = [
        (bonds, "hydrogen bonds"),
        (tethers["hydrophobic"], "hydrophobic tethers"),
        (tethers["stacking"], "stacking tethers"),
        (bars["metal"], "metal bars"),
        (
            tethers["backbone"] + contacts["backbone"],
            "backbone bounds",
        ),
        (contacts["side chain"], "side-chain bounds"),
        (bars["user"] + tethers["user"] + contacts["user"], "of the user's"),
    ]
    return ", ".join(f"{count} {what}" for count, what in parts if count)


def _beyond(geometry: dict) -> str:
    worst = {**geometry["tether_excess_angstrom"]}
    for kind, value in geometry["contact_excess_angstrom"].items():
        worst[kind] = max(worst.get(kind, 0.0), value)
    beyond = [f"{kind} {value:.1g} Å" for kind, value in worst.items() if value > 0]
    return ", ".join(beyond) or "none of what is held"


def _check_complete(report: SampleReport) -> None:
    frames = f"{report.frames} of {report.frames_asked} frames"
    if report.interrupted:
        kept = f"{frames} were written" if report.frames else "no frame was written"
        raise EndedShort(f"Interrupted; {kept}.", INTERRUPTED)
    if report.frames < report.frames_asked:
        if sum(report.low_frames.values()) > report.rejected_steps / report.parameters["stride"]:
            raise EndedShort(
                f"{frames} were written: others had low quality ({counted(report.low_frames)}; the "
                f"last: {report.last_fault}); --allow-low-quality writes them.",
                INCOMPLETE,
            )
        short = [r for r in report.replicas if r.frames < report.parameters["frames"]]
        whose = f" in {len(short)} of {len(report.replicas)} replicas" if short else ""
        raise EndedShort(
            f"{frames} were written: {report.rejected_steps} of {report.steps} steps were "
            f"rejected{whose}, the last because of {report.last_rejection}.",
            INCOMPLETE,
        )
