"""``ragdoll experiment``: every technique on every structure and force of a set."""

from pathlib import Path
from typing import Annotated

import typer
from rich.box import SIMPLE_HEAD
from rich.console import Group
from rich.table import Table

from ..exits import DONE
from .method_options import AsJson, Force, Quiet, Seed, names_of, progress_bar, show


def run(
    input: Annotated[Path, typer.Argument(metavar="SET", help="Folder of a set.")],
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="REPORT", help="Folder of the report.")
    ],
    orders: Annotated[
        str | None, typer.Option(help="With commas between them; default: all.")
    ] = None,
    weightings: Annotated[
        str | None, typer.Option(help="With commas; default: .5/.5,.75/.25,1/0.")
    ] = None,
    solvers: Annotated[str | None, typer.Option(help="With commas; default: ordered.")] = None,
    verlet: Annotated[str, typer.Option(help="affected or all.")] = "affected",
    tolerance: Annotated[
        float | None, typer.Option(help="In the place of the force files'.")
    ] = None,
    scale: Annotated[float, typer.Option(help="What every force is multiplied by.")] = 1.0,
    max_iterations: Annotated[
        int | None, typer.Option(help="In the place of the force files'.")
    ] = None,
    frames: Annotated[
        bool, typer.Option("--frames", help="Write frames.h5 into the technique folders.")
    ] = False,
    threads: Annotated[int | None, typer.Option(help="Default: all cores.")] = None,
    seed: Seed = 0,
    as_json: AsJson = False,
    force: Force = False,
    quiet: Quiet = False,
) -> int:
    """Resolve every force of a set by every technique, and report.

    The same command on the same REPORT goes on where it was stopped. The report's face is
    index.html. Forces that are not resolved are a result: the exit code is 0.
    """
    from ..method.experiment import experiment

    with progress_bar("resolving", quiet) as progress:
        report = experiment(
            input,
            output,
            orders=names_of(orders),
            weightings=names_of(weightings),
            solvers=names_of(solvers),
            verlet=verlet,
            tolerance=tolerance,
            scale=scale,
            max_iterations=max_iterations,
            frames=frames,
            threads=threads,
            seed=seed,
            force=force,
            progress=progress,
        )
    show(report.as_dict(), as_json, quiet, lambda: Group(_best(report), _claims(report)))
    return DONE


def _best(report) -> Table:
    """The technique with the lowest mean of each class, and Ragdoll beside it."""
    table = Table(
        title="Lowest mean of iterations, and Ragdoll", title_justify="left", box=SIMPLE_HEAD
    )
    for name in ("class", "technique"):
        table.add_column(name, no_wrap=True)
    for name in ("mean", "mode", "sd", "p99", "failed", "visits"):
        table.add_column(name, justify="right", no_wrap=True)
    cells = report.table
    for class_name in cells.classes:
        best = min(cells.of_class(class_name), key=lambda cell: cell.statistics.mean)
        ragdoll = [
            cell
            for cell in cells.of_class(class_name)
            if cell.technique.name == "random .5/.5" and cell is not best
        ]
        for cell in [best, *ragdoll]:
            s = cell.statistics
            table.add_row(
                class_name,
                cell.technique.name,
                f"{s.mean:.4g}",
                str(s.mode),
                f"{s.stdev:.3g}",
                str(s.p99),
                str(s.failed),
                f"{s.bar_visits_mean:.0f}",
            )
    return table


def _claims(report) -> Table:
    table = Table(title="The thesis' claims", title_justify="left", box=SIMPLE_HEAD)
    table.add_column("")
    table.add_column("holds")
    table.add_column("claim")
    words = {True: "yes", False: "no", None: "not tried"}
    for name, claim in report.claims.items():
        table.add_row(name, words[claim.holds], claim.title)
    table.caption = f"{report.folder / 'index.html'} shows it all"
    return table
