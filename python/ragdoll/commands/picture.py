"""``ragdoll picture``: a trajectory at a glance, as a PNG."""

import os
from pathlib import Path
from typing import Annotated

import typer

from ..errors import InputError
from ..exits import DONE
from ..whole_file import part_of


def run(
    input: Annotated[Path, typer.Argument(help="A trajectory of ragdoll.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="The picture, PNG.")],
    force: Annotated[bool, typer.Option("--force", help="Replace an existing picture.")] = False,
) -> int:
    """Draw a trajectory: its conformations superposed, how far they went, and what moved."""
    _check(output, force)
    from ..picture import draw

    draw(input, output)
    return DONE


def _check(output: Path, force: bool) -> None:
    """Refuse now what could not be written after the drawing."""
    if output.suffix.lower() != ".png":
        raise InputError(f"{output} is not a PNG; give a name that ends in .png.")
    if os.path.lexists(output) and not force:
        raise InputError(f"{output} exists already; give --force to replace it.")
    if os.path.isdir(output):
        raise InputError(f"{output} is a folder; give the name of a file in it.")
    if not output.parent.is_dir():
        raise InputError(f"The folder {output.parent} does not exist; make it first.")
    part = part_of(output)
    try:
        part.touch()
        part.unlink()
    except OSError as error:
        raise InputError(f"{output} cannot be written: {error.strerror}.") from None
