"""What the commands of the method have in common: options, ranges, progress, checks of outputs."""

import json
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from ..errors import InputError

AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object.")]
Force = Annotated[bool, typer.Option("--force", help="Replace existing outputs.")]
Quiet = Annotated[bool, typer.Option("--quiet", help="No progress, notes and tables.")]
Seed = Annotated[
    int, typer.Option(min=0, max=2**31 - 1, help="Decides all random numbers.", metavar="N")
]


def names_of(text: str | None) -> list[str] | None:
    """The names in a list with commas; None stays None."""
    return None if text is None else [name.strip() for name in text.split(",") if name.strip()]


def range_of(flag: str, text: str, kind: type = float) -> tuple[Any, Any]:
    """The two numbers of ``lo:hi``; a single number is both.

    Raises:
        InputError: the text is no such range.
    """
    low, colon, high = text.partition(":")
    try:
        return kind(low), kind(high if colon else low)
    except ValueError:
        raise InputError(f"{flag} must be lo:hi, two numbers, not '{text}'.") from None


def check_file(path: Path | None, force: bool, inputs: Sequence[Path] = ()) -> None:
    """Refuse now an output that could not be written later.

    Raises:
        InputError: it is there already, its folder is not, or it is one of the inputs.
    """
    if path is None:
        return
    for source in inputs:
        if path.exists() and source.exists() and path.samefile(source):
            raise InputError(f"{path} is the input; give another name for the output.")
    if path.is_dir():
        raise InputError(f"{path} is a folder; give the name of a file.")
    if path.exists() and not force:
        raise InputError(f"{path} exists already; give --force to replace it.")
    if not path.absolute().parent.is_dir():
        raise InputError(f"The folder {path.absolute().parent} does not exist; make it first.")


def messages(quiet: bool) -> Console:
    """Where progress and notes go: standard error."""
    return Console(stderr=True, quiet=quiet, highlight=False, markup=False, soft_wrap=True)


def tell(warnings: Sequence[str], quiet: bool) -> None:
    """Print what readers ignored."""
    console = messages(quiet)
    for warning in warnings:
        console.print(warning)


@contextmanager
def progress_bar(words: str, quiet: bool) -> Iterator[Callable[[int, int], None]]:
    """A bar on a terminal; yields what is called with the number done and the number asked."""
    with Progress(
        TextColumn(words),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
        console=messages(quiet),
        transient=True,
        disable=quiet or not sys.stderr.isatty(),
    ) as progress:
        task = progress.add_task(words, total=None)
        yield lambda done, asked: progress.update(task, completed=done, total=asked)


def show(document: dict[str, Any], as_json: bool, quiet: bool, table: Callable[[], Any]) -> None:
    """Print the result: the JSON object, or the table unless it is to be quiet."""
    if as_json:
        typer.echo(json.dumps(document))
    elif not quiet:
        Console(highlight=False, markup=False).print(table())
