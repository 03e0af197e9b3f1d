"""``ragdoll target``: a path from one structure to another."""

from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table
from rich.text import Text

from ..constraint_options import ConstraintOptions
from ..exits import DONE, INCOMPLETE, INTERRUPTED, EndedShort
from ..molecule import Molecule
from ..sampling import check_paths
from ..targeting import TargetOptions, TargetReport
from ..targeting import target as go_to_target
from .constraint_flags import takes_constraints
from .ligand_flags import NO_LIGANDS, LigandFlags, takes_ligands
from .method_options import AsJson, Quiet, Seed, progress_bar, show, tell
from .quality_rows import quality_rows

_DEFAULT = TargetOptions()


@takes_constraints
@takes_ligands
def run(
    start: Annotated[Path, typer.Argument(help="PDB or mmCIF file to start from, also .gz.")],
    end: Annotated[Path, typer.Argument(help="PDB or mmCIF file to move towards, also .gz.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="The trajectory, HDF5.")],
    chain: Annotated[
        list[str] | None, typer.Option(help="Chain of START; may be repeated. Default: all.")
    ] = None,
    target_chain: Annotated[
        list[str] | None, typer.Option(help="Chain of END; may be repeated. Default: all.")
    ] = None,
    reverse: Annotated[
        bool, typer.Option("--reverse", help="The way back: from END to START.")
    ] = False,
    variant: Annotated[
        str, typer.Option(help="least-work, or random: another path for each seed.")
    ] = _DEFAULT.variant,
    step_angstrom: Annotated[
        float, typer.Option(help="By which the RMSD is to come down in one step.")
    ] = _DEFAULT.step_angstrom,
    random_angstrom: Annotated[
        float, typer.Option(help="Size of random moves: deviation per coordinate.")
    ] = _DEFAULT.random_angstrom,
    spacing_angstrom: Annotated[
        float, typer.Option(help="How far a CA goes between frames, about; at most 0.5.")
    ] = _DEFAULT.spacing_angstrom,
    arrive_angstrom: Annotated[
        float, typer.Option(help="CA RMSD at which END counts as reached.")
    ] = _DEFAULT.arrive_angstrom,
    retries: Annotated[
        int, typer.Option(help="Times that random moves free what is stuck.")
    ] = _DEFAULT.retries,
    tolerance_angstrom: Annotated[
        float, typer.Option(help="Largest |d - L| of any constraint.")
    ] = _DEFAULT.tolerance_angstrom,
    contact_scale: Annotated[
        float, typer.Option(help="Share of the sum of van der Waals radii that contacts keep.")
    ] = _DEFAULT.contact_scale,
    heavy_allowance_angstrom: Annotated[
        float, typer.Option(help="How much closer pairs of N, O, F and S may come.")
    ] = _DEFAULT.heavy_allowance_angstrom,
    planarity_degree: Annotated[
        float, typer.Option(help="How far planar units may turn or bend.")
    ] = _DEFAULT.planarity_degree,
    mend: Annotated[
        bool,
        typer.Option("--mend/--no-mend", help="Mend implausible torsions and atoms too close."),
    ] = _DEFAULT.mend,
    constraints: ConstraintOptions = _DEFAULT.constraints,
    solver: Annotated[str, typer.Option(help="ordered, newton, block or auto.")] = _DEFAULT.solver,
    max_iterations: Annotated[
        int, typer.Option(help="Iterations after which a step is taken back.")
    ] = _DEFAULT.max_iterations,
    ligands: LigandFlags = NO_LIGANDS,
    target_ligand: Annotated[
        list[str] | None,
        typer.Option(metavar="FILE[:RECORD]", help="As --ligand, of END. May be repeated."),
    ] = None,
    model: Annotated[int, typer.Option(help="Model of START, from 1.")] = 1,
    target_model: Annotated[int, typer.Option(help="Model of END, from 1.")] = 1,
    add_hydrogens: Annotated[
        bool, typer.Option("--add-hydrogens", help="Add missing hydrogens by PDBFixer.")
    ] = False,
    seed: Seed = _DEFAULT.seed,
    as_json: AsJson = False,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing output.")] = False,
    quiet: Quiet = False,
) -> int:
    """Move a structure towards another one, in small steps that keep all its constraints.

    Exit code 0: the target was reached; 3: it was not, and what was reached is written.
    """
    options = TargetOptions(
        variant=variant,
        step_angstrom=step_angstrom,
        random_angstrom=random_angstrom,
        spacing_angstrom=spacing_angstrom,
        arrive_angstrom=arrive_angstrom,
        retries=retries,
        tolerance_angstrom=tolerance_angstrom,
        contact_scale=contact_scale,
        heavy_allowance_angstrom=heavy_allowance_angstrom,
        planarity_degree=planarity_degree,
        mend=mend,
        constraints=constraints,
        solver=solver,
        max_iterations=max_iterations,
        seed=seed,
    )
    # refuse before a large file is read
    options.check()
    for source in (start, end):
        check_paths(source, output, force)
    of_ligands = ligands.check()
    first = Molecule.from_file(
        start, model=model, chains=chain, add_hydrogens=add_hydrogens, **ligands.arguments()
    )
    second = Molecule.from_file(
        end,
        model=target_model,
        chains=target_chain,
        add_hydrogens=add_hydrogens,
        ligands=target_ligand or (),
    )
    if reverse:
        first, second = second, first
    tell([*first.notes, *second.notes], quiet)
    with progress_bar("moving", quiet) as progress:
        report = go_to_target(
            first,
            second,
            output,
            options,
            force=force,
            progress=progress,
            parameters={
                "model": model,
                "chains": chain,
                "target_model": target_model,
                "target_chains": target_chain,
                "reverse": reverse,
                "add_hydrogens": add_hydrogens,
                "target_ligands": target_ligand,
                **of_ligands,
            },
        )
    show(report.as_dict(), as_json, quiet, lambda: _table(report, output))
    if report.interrupted:
        raise EndedShort(
            f"Interrupted; {report.frames} frames were written, the last "
            f"{report.rmsd_end_angstrom:.2f} angstrom from the target.",
            INTERRUPTED,
        )
    if not report.arrived:
        raise EndedShort(
            f"The path ends {report.rmsd_end_angstrom:.2f} angstrom from the target, after "
            f"{report.rmsd_start_angstrom:.2f} at its start; the last step was taken back because "
            f"of {report.last_rejection or 'too small a gain'}. What was reached is written.",
            INCOMPLETE,
        )
    return DONE


def _table(report: TargetReport, output: Path) -> Table:
    geometry = report.geometry
    table = Table(title=Text(str(output)), show_header=False, title_justify="left")
    table.add_row(
        "atoms, matched", f"{report.atoms}, {report.matched_atoms}, {report.matched_residues} res."
    )
    table.add_row(
        "CA RMSD from the target",
        f"{report.rmsd_start_angstrom:.2f} at the start, {report.rmsd_end_angstrom:.3f} Å at the "
        "end",
    )
    table.add_row("frames", f"{report.frames}, a CA moves {report.widest_step_angstrom:.2f} Å most")
    table.add_row(
        "steps, rejected, retries", f"{report.steps}, {report.rejected_steps}, {report.retries}"
    )
    table.add_row("CPU time", f"{report.cpu_seconds:.2f} s, solver {report.solver}")
    if geometry:
        table.add_row(
            "bonds",
            f"RMS {geometry['bond_rms_angstrom']:.4f}, most {geometry['bond_max_angstrom']:.4f} Å",
        )
        table.add_row("angles", f"RMS {geometry['angle_rms_degree']:.2f}°")
        table.add_row("chirality inverted", f"{geometry['chirality_inverted']}")
    for words, text in quality_rows(report.quality):
        table.add_row(words, text)
    return table
