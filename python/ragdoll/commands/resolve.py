"""``ragdoll resolve``: forces on one structure, resolved by one technique."""

from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.table import Table

from ..exits import DONE, INCOMPLETE
from ..method.frames import write_frames
from ..method.resolving import Resolution, resolve
from ..method.sources import forces_of, refusals, structure_of
from ..trajectory import check_output
from .method_options import AsJson, Force, Quiet, Seed, check_file, progress_bar, show, tell
from .streams import complain


def run(
    input: Annotated[Path, typer.Argument(help="The structure, XML.")],
    forces: Annotated[Path, typer.Option(help="The forces, XML.")],
    order: Annotated[
        str, typer.Option(help="A name such as bfs_cycle, or file:PATH.")
    ] = "bfs_cycle",
    weighting: Annotated[
        str, typer.Option(help="How an error is shared, far end first.")
    ] = ".5/.5",
    solver: Annotated[
        str, typer.Option(help="ordered, newton, block, templates or auto; --json says what.")
    ] = "ordered",
    verlet: Annotated[str, typer.Option(help="What moves: affected joints, or all.")] = "affected",
    tolerance: Annotated[
        float | None, typer.Option(help="In the place of the force file's.")
    ] = None,
    tolerance_angstrom: Annotated[
        float | None,
        typer.Option(
            help="In the place of a relative tolerance: largest |d - L| of any constraint. One "
            "unit of a structure without a unit of length counts as 1 nm."
        ),
    ] = None,
    precision: Annotated[
        str, typer.Option(help="Of the solver's numbers: double or single.")
    ] = "double",
    max_iterations: Annotated[
        int | None, typer.Option(help="In the place of the force file's.")
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Frames after each force, HDF5.")
    ] = None,
    final: Annotated[
        Path | None, typer.Option(help="The last positions as a structure, XML.")
    ] = None,
    seed: Seed = 0,
    as_json: AsJson = False,
    force: Force = False,
    quiet: Quiet = False,
) -> int:
    """Break a structure by each force in turn, and resolve it.

    Exit code 0: every force was resolved; 3: one was not; what was asked for is written.
    """
    inputs = [input, forces] + ([Path(order[5:])] if order.startswith("file:") else [])
    check_file(final, force, inputs)
    check_file(output, force, inputs)
    if output is not None:
        check_output(output, force)
    warnings: list[str] = []
    structure = structure_of(input, warnings)
    force_set = forces_of(forces, structure, warnings)
    tell(warnings, quiet)
    with progress_bar("resolving", quiet) as progress:
        done = resolve(
            structure,
            force_set,
            order,
            weighting,
            solver=solver,
            verlet=verlet,
            seed=seed,
            frames=output is not None,
            tolerance=tolerance,
            tolerance_angstrom=tolerance_angstrom,
            precision=precision,
            max_iterations=max_iterations,
            progress=progress,
        )
        if output is not None:
            _write_frames(output, structure, done, force)
    if final is not None:
        _write_final(final, structure, done, force)
    show(done.as_dict(), as_json, quiet, lambda: _table(done))
    failed = np.flatnonzero(~done.converged)
    if len(failed) == 0:
        return DONE
    first = failed[0]
    complain(
        f"{len(failed)} of {len(done)} forces were not resolved, the first is number {first + 1} "
        f"on joint {done.ids[done.joints[first]]}: {done.reasons[first]}, "
        f"largest violation {done.residual[first]:.3g}."
    )
    return INCOMPLETE


def _write_frames(path: Path, structure, done: Resolution, force: bool) -> None:
    observables = {
        "iterations": done.iterations,
        "bar_visits": done.bar_visits,
        "residual": done.residual,
        "converged": done.converged.astype(int),
    }
    names = (
        *("order", "weighting", "solver", "solver_chosen", "verlet", "seed", "precision"),
        *("tolerance", "tolerance_angstrom", "max_iterations"),
    )
    parameters = {name: getattr(done, name) for name in names}
    write_frames(
        path,
        structure,
        done.frames,
        observables,
        parameters,
        timestep=done.timestep,
        force=force,
    )


def _write_final(path: Path, structure, done: Resolution, force: bool) -> None:
    from .. import _method_files

    with refusals():
        moved = structure.moved(done.positions)
        _method_files.write_structure(str(path), moved, force=force, digits=17)


def _table(done: Resolution) -> Table:
    s = done.statistics()
    chosen = "" if done.solver_chosen == done.solver else f" ({done.solver_chosen})"
    table = Table(
        title=f"{done.order} {done.weighting}, {done.solver}{chosen}",
        show_header=False,
        title_justify="left",
    )
    table.add_row("forces, not resolved", f"{s.forces}, {s.failed}")
    if s.forces:
        table.add_row("iterations", f"mean {s.mean:.2f}, mode {s.mode}, st. dev. {s.stdev:.2f}")
        table.add_row("", f"p50 {s.p50}, p99 {s.p99}")
        table.add_row("bar visits", f"mean {s.bar_visits_mean:.1f}")
        angstrom = done.residual_angstrom
        length = "" if angstrom is None else f", {angstrom.max():.3g} Å"
        table.add_row("largest violation", f"{done.residual.max():.3g}{length}")
        if done.carried is not None and done.carried.any():
            table.add_row("cycle blocks carried whole", f"{done.carried.sum()}")
    return table
