"""``ragdoll generate``: structures, sets of them, and forces, drawn at random from a seed."""

from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from ..exits import DONE
from ..method import generating
from ..method.sources import refusals, structure_of
from .method_options import (
    AsJson,
    Force,
    Quiet,
    Seed,
    check_file,
    names_of,
    progress_bar,
    range_of,
    show,
    tell,
)

app = typer.Typer(
    help="Draw structures, sets of structures, or forces.",
    rich_markup_mode=None,
)


@app.callback(invoke_without_command=True)
def _options(context: typer.Context) -> None:
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())
        raise typer.BadParameter("Say what to generate: structure, set or forces.")


_SCALE = f"{generating.SCALE_BARS[0]:g}:{generating.SCALE_BARS[1]:g}"
_JOINTS = f"{generating.JOINTS[0]}:{generating.JOINTS[1]}"
_CLASSES = "tree, 1-cycle, 2-cycle, n-cycle, grid, ring-chain, regular, cloth, thread or protein"
_HELP_OF_SCALE = "|F|/m dt^2 is uniform between these, in mean bar lengths."


@app.command("structure")
def structure(
    class_name: Annotated[str, typer.Option("--class", help=f"{_CLASSES}.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="The structure, XML.")],
    type_: Annotated[
        str, typer.Option("--type", help="Of a 2-cycle: path, shared-joint or theta.")
    ] = "",
    cycles: Annotated[
        int, typer.Option(min=0, help="Cycle rank of an n-cycle, rings of a ring-chain; 0: drawn.")
    ] = 0,
    joints: Annotated[int, typer.Option(min=1, help="How many.")] = 30,
    seed: Seed = 0,
    as_json: AsJson = False,
    force: Force = False,
    quiet: Quiet = False,
) -> int:
    """Draw one structure of a class."""
    check_file(output, force)
    from .. import _method_files
    from ..method.classifying import classify

    drawn = generating.generate(class_name, type_, cycles=cycles, joints=joints, seed=seed)
    with refusals():
        _method_files.write_structure(str(output), drawn, force=force)
    facts = {
        "joints": len(drawn.positions),
        "bars": len(drawn.bars),
        "cycle_rank": classify(drawn).cycle_rank,
        "class": drawn.class_name,
        "type": drawn.type,
        "seed": seed,
    }
    show(facts, as_json, quiet, lambda: _table(str(output), facts))
    return DONE


@app.command("set")
def result_set(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder of the set.")],
    count: Annotated[int, typer.Option(help="Structures of each class.")] = 20,
    forces: Annotated[int, typer.Option(help="Force files of each structure.")] = 50,
    classes: Annotated[str, typer.Option(help="With commas between them.")] = ",".join(
        generating.CLASSES
    ),
    joints: Annotated[str, typer.Option(help="Least and most joints, lo:hi.")] = _JOINTS,
    cycles: Annotated[int, typer.Option(min=0, help="Of n-cycles; 0: drawn.")] = 0,
    scale_bars: Annotated[str, typer.Option(help=_HELP_OF_SCALE)] = _SCALE,
    per_file: Annotated[
        int, typer.Option(help="Forces in each file; each starts where the one before ended.")
    ] = 1,
    given: Annotated[
        list[Path] | None,
        typer.Option(
            "--from",
            help="A structure or molecule (XML, PDB, mmCIF, SDF) to take instead of drawing; "
            "may be repeated.",
        ),
    ] = None,
    seed: Seed = 0,
    as_json: AsJson = False,
    force: Force = False,
    quiet: Quiet = False,
) -> int:
    """Write a set as the thesis' test mode does: structures, orders, force files, results.xml."""
    with progress_bar("generating", quiet) as progress:
        report = generating.generate_set(
            output,
            classes=names_of(classes),
            count=count,
            forces=forces,
            joints=range_of("--joints", joints, int),
            cycles=cycles,
            scale_bars=range_of("--scale-bars", scale_bars),
            per_file=per_file,
            given=given or (),
            seed=seed,
            force=force,
            progress=progress,
        )
    facts = {
        "set": str(output),
        "structures": report.structures,
        "force_files": report.force_files,
        "seed": seed,
    }
    show(facts, as_json, quiet, lambda: _table(str(output), facts))
    return DONE


@app.command("forces")
def forces(
    input: Annotated[Path, typer.Argument(help="The structure, XML.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="The forces, XML.")],
    count: Annotated[int, typer.Option(help="How many.")] = 50,
    scale_bars: Annotated[str, typer.Option(help=_HELP_OF_SCALE)] = _SCALE,
    seed: Seed = 0,
    as_json: AsJson = False,
    force: Force = False,
    quiet: Quiet = False,
) -> int:
    """Draw forces on the joints of a structure."""
    check_file(output, force, [input])
    from .. import _method_files

    warnings: list[str] = []
    of = structure_of(input, warnings)
    tell(warnings, quiet)
    drawn = generating.generate_forces(
        of, count, scale_bars=range_of("--scale-bars", scale_bars), seed=seed
    )
    drawn.structure = input.name
    with refusals():
        _method_files.write_forces(str(output), of, drawn, force=force)
    facts = {"forces": len(drawn.joints), "seed": seed}
    show(facts, as_json, quiet, lambda: _table(str(output), facts))
    return DONE


def _table(title: str, facts: dict) -> Table:
    table = Table(title=title, show_header=False, title_justify="left")
    for name, value in facts.items():
        table.add_row(name.replace("_", " "), str(value))
    return table
