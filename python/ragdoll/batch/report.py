"""What a run over many molecules came to."""

import csv
from collections.abc import Iterable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from ..whole_file import whole_file

MOST_LISTED = 1000  # failures, and short ones; --report has all of them
_COLUMNS = (
    "record",
    "line",
    "title",
    "atoms",
    "heavy_atoms",
    "conformers",
    "asked",
    "status",
    "reason",
    "notes",
    "lowest_energy_kcal_mol",
    "energy_by",
    "seed",
    "seconds",
)


@dataclass
class MoleculeFault:
    """A molecule without conformers, or with fewer than asked.

    Attributes:
        record: place in the file, from 0.
        line: where it starts in the file, from 1.
        title: its name.
        conformers: how many there are.
        reason: why not more.
    """

    record: int
    line: int
    title: str
    conformers: int
    reason: str


@dataclass
class BatchReport:
    """Counts of a run; ``as_dict`` is what ``--json`` prints.

    Attributes:
        input, output: the files.
        molecules: read.
        complete: molecules with all the conformers that were asked for.
        conformers: in the output.
        failed_count, short_count: molecules without conformers, and with too few.
        failed, short: the first 1000 of these.
        taken_up: molecules that earlier runs had done.
        seconds: wall time of this run.
        workers: processes.
        interrupted: whether the run was ended before its end.
        written: whether the output is there.
        parameters: all that decides the result.
    """

    input: str
    output: str
    molecules: int = 0
    complete: int = 0
    conformers: int = 0
    failed_count: int = 0
    short_count: int = 0
    failed: list[MoleculeFault] = field(default_factory=list)
    short: list[MoleculeFault] = field(default_factory=list)
    taken_up: int = 0
    seconds: float = 0.0
    workers: int = 1
    interrupted: bool = False
    written: bool = False
    parameters: dict[str, Any] = field(default_factory=dict)

    def count(self, facts: dict[str, Any]) -> MoleculeFault | None:
        """Count a molecule; gives what is wrong with it, if anything is."""
        self.molecules += 1
        self.conformers += facts["conformers"]
        reason = facts.get("error") or facts.get("reason")
        if not reason:
            self.complete += 1
            return None
        fault = MoleculeFault(
            facts["record"], facts["line"], facts["title"], facts["conformers"], reason
        )
        if facts["conformers"]:
            self.short_count += 1
            listed = self.short
        else:
            self.failed_count += 1
            listed = self.failed
        if len(listed) < MOST_LISTED:
            listed.append(fault)
        return fault

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON."""
        return asdict(self)


def write_table(path: Path, entries: Iterable[dict[str, Any]], asked: int) -> None:
    """Write a CSV file with a row for each molecule.

    Raises:
        OSError: it cannot be written; a sentence.
    """
    with (
        whole_file(path) as part,
        open(part, "w", newline="", encoding="utf-8", errors="replace") as file,
    ):
        table = csv.writer(file)
        table.writerow(_COLUMNS)
        for facts in entries:
            reason = facts.get("error") or facts.get("reason") or ""
            status = "failed" if not facts["conformers"] else "short" if reason else "complete"
            row = {
                "asked": asked,
                **facts,
                "status": status,
                "reason": reason,
                "notes": "; ".join(facts.get("notes", [])),
            }
            table.writerow([row.get(name, "") for name in _COLUMNS])
