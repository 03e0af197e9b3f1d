"""``ragdoll classify``: class, cycle rank, bridges and cycle blocks of a structure or molecule."""

from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from ..exits import DONE
from ..method.classifying import Classification, classify
from .method_options import AsJson, Force, Quiet, Seed, show, tell


def run(
    input: Annotated[
        Path, typer.Argument(help="A structure (XML), or a molecule (PDB, mmCIF, SDF; also .gz).")
    ],
    model: Annotated[
        int, typer.Option(min=1, help="Model of a PDB file, molecule of an SDF file, from 1.")
    ] = 1,
    seed: Seed = 0,
    as_json: AsJson = False,
    force: Force = False,
    quiet: Quiet = False,
) -> int:
    """Find the class of each component, the cycle rank, bridges and cycle blocks.

    Of a molecule the bond graph is classified.
    """
    warnings: list[str] = []
    found = classify(input, model=model, warnings=warnings)
    tell(warnings, quiet)
    show(found.as_dict(), as_json, quiet, lambda: _table(str(input), found))
    return DONE


def _table(title: str, found: Classification) -> Table:
    table = Table(title=title, show_header=False, title_justify="left")
    kind = f"{found.class_name} ({found.type})" if found.type else found.class_name
    table.add_row("class", kind)
    table.add_row("joints, bars", f"{found.joints}, {found.bars}")
    table.add_row("cycle rank", str(found.cycle_rank))
    table.add_row("components", str(len(found.components)))
    table.add_row("bridges", str(len(found.bridges)))
    sizes = sorted((len(block["joints"]) for block in found.blocks), reverse=True)
    some = ", ".join(map(str, sizes[:8])) + (", ..." if len(sizes) > 8 else "")
    table.add_row("cycle blocks", f"{len(sizes)}" + (f" of {some} joints" if sizes else ""))
    table.add_row("diameter of the largest", str(found.diameter))
    return table
