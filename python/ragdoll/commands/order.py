"""``ragdoll order``: the order in which a structure's bars are resolved."""

from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from ..exits import DONE
from ..method.ordering import BarOrder
from ..method.ordering import order as order_of
from ..method.sources import refusals, structure_of
from .method_options import AsJson, Force, Quiet, Seed, check_file, show, tell

_MOST_ROWS = 60


def run(
    input: Annotated[Path, typer.Argument(help="The structure, XML.")],
    order: Annotated[
        str, typer.Option(help="A name such as bfs_cycle, or file:PATH.")
    ] = "bfs_cycle",
    root: Annotated[
        str | None, typer.Option(help="Id of the joint to start from; default: the first.")
    ] = None,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="The order, XML.")] = None,
    seed: Seed = 0,
    as_json: AsJson = False,
    force: Force = False,
    quiet: Quiet = False,
) -> int:
    """Print the bars in the order of the first iteration, each with its nearer end first."""
    check_file(output, force, [input])
    warnings: list[str] = []
    structure = structure_of(input, warnings)
    tell(warnings, quiet)
    found = order_of(structure, order, root, seed=seed)
    if output is not None:
        from .. import _method_files

        name = Path(found.name).stem if found.name.startswith("file:") else found.name
        with refusals():
            _method_files.write_order(
                str(output),
                structure,
                found.bars,
                found.closes_cycle,
                found.root,
                name,
                force=force,
                structure_path=input.name,
            )
    show(found.as_dict(), as_json, quiet, lambda: _table(found))
    return DONE


def _table(found: BarOrder) -> Table:
    start = f" from {found.root}" if found.root else ""
    table = Table(title=f"{found.name}{start}: {len(found.bars)} visits", title_justify="left")
    table.add_column("visit", justify="right")
    table.add_column("near")
    table.add_column("far")
    table.add_column("closes a cycle")
    for record in found.records()[:_MOST_ROWS]:
        mark = "yes" if record["problem"] else ""
        table.add_row(str(record["visit"] + 1), record["near"], record["far"], mark)
    if len(found.bars) > _MOST_ROWS:
        table.caption = f"{len(found.bars) - _MOST_ROWS} more; --json or -o has them all"
    return table
