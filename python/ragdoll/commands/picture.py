"""``ragdoll picture``: a trajectory at a glance, as a PNG."""

from pathlib import Path
from typing import Annotated

import typer

from ..errors import InputError
from ..exits import DONE


def run(
    input: Annotated[Path, typer.Argument(help="A trajectory of ragdoll.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="The picture, PNG.")],
    force: Annotated[bool, typer.Option("--force", help="Replace an existing picture.")] = False,
) -> int:
    """Draw a trajectory: its conformations superposed, how far they went, and what moved."""
    if output.exists() and not force:
        raise InputError(f"{output} exists already; give --force to replace it.")
    if output.suffix.lower() != ".png":
        raise InputError(f"{output} is not a PNG; give a name that ends in .png.")
    if not output.parent.is_dir():
        raise InputError(f"The folder {output.parent} does not exist; make it first.")
    from ..picture import draw

    draw(input, output)
    return DONE
