"""What a run has done so far, on the disk, so that another run goes on from there.

Beside the output lie ``NAME.partial``, the conformers of molecule after molecule, and
``NAME.partial.jsonl``, the journal: its first line tells what the run is, every other one is a
molecule that is done, with the size of the data file after it. Both only grow. A kill costs at most
the molecule being written: what the journal does not know is cut off.
"""

import fcntl
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO

from ..errors import InputError
from ..journal_lines import entry_of, line_of

_FORMAT = 1
_START = b'{"ragdoll_conformers":'


class PartFile:
    """The unfinished output of a run; a context manager that closes it.

    Attributes:
        count: molecules done.
        size: bytes of their data.
        taken_up: how many of them by earlier runs.
        about: the journal's first line.
    """

    def __init__(self, output: Path, about: dict[str, Any], fingerprint: str, force: bool):
        """Start, or take up what an earlier run left.

        Args:
            output: the file that is to be.
            about: of the run, for people; plain values.
            fingerprint: of all that decides the result.
            force: start anew where what is left is of another run.

        Raises:
            InputError: another run left something else, or is running now.
            OSError: nothing can be written; a sentence.
        """
        self.output = output
        self.path = output.with_name(f"{output.name}.partial")
        self.journal_path = output.with_name(f"{output.name}.partial.jsonl")
        self.count = 0
        self.size = 0
        self._journal = self._opened(self.journal_path)
        try:
            self._lock()
            self._data = self._opened(self.path)
            try:
                self._take_up(about, fingerprint, force)
            except BaseException:
                self._data.close()
                raise
        except BaseException:
            self._journal.close()
            raise
        self.taken_up = self.count

    def _opened(self, path: Path) -> BinaryIO:
        try:
            return open(path, "a+b", buffering=0)  # noqa: SIM115  (closed by close)
        except OSError as error:
            raise OSError(f"{path} cannot be written: {error.strerror}.") from None

    def _lock(self) -> None:
        """Keep other runs away, until this process ends: workers let go of what they inherit."""
        try:
            fcntl.flock(self._journal, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise InputError(
                f"Another run writes {self.output} now; wait for it or give another name."
            ) from None

    def _take_up(self, about: dict[str, Any], fingerprint: str, force: bool) -> None:
        """Find what is whole, and cut off the rest."""
        self.about = {"ragdoll_conformers": _FORMAT, "fingerprint": fingerprint, "about": about}
        data_size = os.fstat(self._data.fileno()).st_size
        good, is_first = 0, True
        for line in self._lines():
            entry = entry_of(line, "end")
            if is_first and not (line.startswith(_START) or _START.startswith(line)):
                raise InputError(f"{self.journal_path} is no journal of such a run; move it away.")
            if entry is None:
                break
            if is_first:
                is_first = False
                if entry.get("fingerprint") != fingerprint:
                    if force:
                        break
                    raise InputError(
                        f"{self.path} is left from a run with {_difference(entry, about)}; give "
                        "the same to go on, or --force to start anew."
                    )
            else:
                if entry["end"] > data_size:  # the machine went down before the data was written
                    break
                self.size = entry["end"]
                self.count += 1
            good += len(line)
        if good == 0 and data_size and is_first and not force:
            raise InputError(
                f"{self.path} is in the way and is not of such a run; move it away, or give "
                "--force to replace it."
            )
        self._guarded(self._journal.truncate, good)
        self._guarded(self._data.truncate, self.size)
        if good == 0:
            self.size = self.count = 0
            self._guarded(self._data.truncate, 0)
            self._write(self._journal, line_of(self.about))

    def _lines(self) -> Iterator[bytes]:
        with open(self.journal_path, "rb") as file:
            yield from file

    def add(self, data: bytes, facts: dict[str, Any]) -> None:
        """Append a molecule that is done, with plain values about it.

        Raises:
            OSError: the disk takes no more; what was added before is kept.
        """
        self._write(self._data, data)
        self._write(self._journal, line_of({**facts, "end": self.size + len(data)}))
        self.size += len(data)
        self.count += 1

    def entries(self) -> Iterator[dict[str, Any]]:
        """The facts of all molecules that are done, in order."""
        lines = self._lines()
        next(lines, None)
        for line in lines:
            entry = entry_of(line, "end")
            if entry is not None:
                yield entry

    def blocks(self) -> Iterator[tuple[dict[str, Any], bytes]]:
        """Facts and data of all molecules that are done, in order."""
        start = 0
        with open(self.path, "rb") as file:
            for entry in self.entries():
                yield entry, file.read(entry["end"] - start)
                start = entry["end"]

    def publish(self) -> None:
        """Let the data file become the output, and remove the journal."""
        self._guarded(os.fsync, self._data.fileno())
        self._guarded(self.path.replace, self.output)
        self.discard()

    def discard(self) -> None:
        """Remove both files."""
        self.path.unlink(missing_ok=True)
        self.journal_path.unlink(missing_ok=True)

    def _write(self, file: BinaryIO, data: bytes) -> None:
        view = memoryview(data)
        while view:
            view = view[self._guarded(file.write, view) :]

    def _guarded(self, action, *arguments):
        try:
            return action(*arguments)
        except OSError as error:
            raise OSError(
                f"{self.path} cannot be written: {error.strerror}; what was done before is kept, "
                "and the same command goes on from there."
            ) from None

    def close(self) -> None:
        """Close the files, which gives up the lock; they stay unless published or discarded."""
        self._data.close()
        self._journal.close()

    def __enter__(self) -> "PartFile":
        return self

    def __exit__(self, kind, error, traceback) -> None:
        self.close()


def is_left(output: Path) -> bool:
    """Whether an earlier run left something that could be gone on with."""
    return output.with_name(f"{output.name}.partial.jsonl").exists()


def _difference(entry: dict[str, Any], about: dict[str, Any]) -> str:
    """What differs between two runs, in words."""
    old = entry.get("about", {})
    names = [name for name in about if old.get(name) != about[name]]
    if not names:
        return "another input or version"
    words = [f"{name} {old.get(name)}" for name in names[:3]]
    return " and ".join(words)
