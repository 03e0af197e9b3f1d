"""Files that appear when they are complete."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


def part_of(path: Path) -> Path:
    """Where a file is while it is being written."""
    return path.with_name(f"{path.name}.part")


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """A path to write to; when that is done, the file is at ``path``, and nowhere if it failed.

    Raises:
        OSError: the file cannot be written; one sentence that names it.
    """
    part = part_of(path)
    try:
        yield part
        part.replace(path)
    except BaseException as error:
        part.unlink(missing_ok=True)
        if isinstance(error, OSError):
            raise OSError(f"{path} cannot be written: {error.strerror}.") from None
        raise
