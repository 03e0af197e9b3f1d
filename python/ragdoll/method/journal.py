"""The journal of an experiment: what is finished, so that nothing is done twice.

A file of lines of JSON. The first line tells what the experiment is; every other one is a finished
task. Lines are only ever appended, and each is flushed; a kill costs at most the line being
written, which the next run drops.
"""

import fcntl
import os
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..journal_lines import entry_of, line_of

_FORMAT = 1


class Journal:
    """The open journal of one experiment; a context manager.

    Attributes:
        finished: results by the names of their tasks.
    """

    def __init__(self, path: Path, fingerprint: str, about: dict[str, Any], replace: bool = False):
        """Open a journal, or start one.

        Args:
            path: the file.
            fingerprint: of all that decides the results.
            about: the same for people; stands in the first line.
            replace: start anew where the journal is that of another experiment.

        Raises:
            InputError: the journal is that of another experiment, or another process writes it.
        """
        self.path = path
        self.finished: dict[str, dict[str, Any]] = {}
        self._file = open(path, "a+b")  # noqa: SIM115  (closed by close)
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            self._file.close()
            raise InputError(
                f"Another experiment writes {path.parent} now; wait for it or give another folder."
            ) from None
        header = {"ragdoll_experiment": _FORMAT, "fingerprint": fingerprint, "about": about}
        try:
            self._read(header, replace)
        except BaseException:
            self._file.close()
            raise

    def _read(self, header: dict[str, Any], replace: bool) -> None:
        self._file.seek(0)
        lines = self._file.read().splitlines(keepends=True)
        good = 0
        for number, line in enumerate(lines):
            entry = entry_of(line, "task")
            if entry is None:
                break
            if number == 0 and entry.get("fingerprint") != header["fingerprint"]:
                if replace:
                    break
                raise InputError(
                    f"{self.path.parent} holds another experiment (another set, or other "
                    "parameters); give another folder, or --force to replace it."
                )
            if number > 0:
                self.finished[entry["task"]] = entry["result"]
            good += len(line)
        self._file.truncate(good)
        self._file.seek(0, os.SEEK_END)
        if good == 0:
            self._write(header)

    def add(self, task: str, result: dict[str, Any]) -> None:
        """Append a finished task. Its result is plain values; floats come back bit for bit."""
        self._write({"task": task, "result": result})
        self.finished[task] = result

    def _write(self, entry: dict[str, Any]) -> None:
        self._file.write(line_of(entry))
        self._file.flush()

    def close(self) -> None:
        """Close the file, which gives up its lock."""
        self._file.close()

    def __enter__(self) -> "Journal":
        return self

    def __exit__(self, kind, error, traceback) -> None:
        self.close()


def is_journal(path: Path) -> bool:
    """Whether a file is the journal of some experiment, or the torn beginning of one."""
    try:
        with open(path, "rb") as file:
            start = file.read(64)
    except OSError:
        return False
    return start.startswith(b'{"ragdoll_experiment"') or (b"\n" not in start and len(start) < 22)
