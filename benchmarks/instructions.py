"""Instructions of the inner loops, counted by callgrind: the same on a busy machine.

Valgrind has no AVX-512: lanes are then those of AVX2.
"""

import shutil
import sys

from rich.console import Console
from rich.table import Table

import programs

LOOPS = (
    "ordered",
    "ordered-ensemble",
    "newton",
    "newton-ensemble",
    "block",
    "contacts",
    "contacts-kept",
)


def per_unit(loop: str, few: int = 2, many: int = 6) -> tuple[float, str]:
    """Instructions for each unit of a loop: what more repetitions cost more."""
    (less, first), (more, last) = (
        programs.instructions("loop", loop, repetitions) for repetitions in (few, many)
    )
    return (more - less) / (last[0]["units"] - first[0]["units"]), first[0]["unit"]


def print_table() -> None:
    if shutil.which("valgrind") is None:
        print("benchmarks/run: valgrind is not installed; no instructions counted", file=sys.stderr)
        return
    table = Table("loop", "instructions", "for each")
    for loop in LOOPS:
        count, unit = per_unit(loop)
        table.add_row(loop, f"{count:.4g}", unit)
    Console(highlight=False).print(table)
