"""Rows on quality in the closing tables of commands."""

from collections.abc import Mapping
from typing import Any

_ROWS = {
    "clashes per 1000 atoms": ("clashes_per_1000", ".2f", ""),
    "Ramachandran core": ("ramachandran_core_percent", ".1f", " %"),
    "Ramachandran outliers": ("ramachandran_outlier_percent", ".1f", " %"),
    "omega off by over 30°": ("omega_over_30_percent", ".1f", " %"),
    "bonds, angles against ideal, RMSZ": (("bond_rmsz", "angle_rmsz"), ".2f", ""),
    "bounds exceeded": ("excess_angstrom", ".2g", " Å"),
}


def quality_rows(quality: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Words and text for a table: the mean of the frames, the worst one, and the input.

    Args:
        quality: QualityReport.as_dict(), or nothing.
    """
    rows = []
    for words, (names, form, unit) in _ROWS.items() if quality else ():
        names = (names,) if isinstance(names, str) else names
        if quality["input"][names[0]] is None:
            continue
        mean, worst, own = (
            ", ".join(f"{quality[of][name]:{form}}" for name in names)
            for of in ("mean", "worst", "input")
        )
        rows.append((words, f"mean {mean}{unit}, worst {worst}{unit}, input {own}{unit}"))
    return rows


def counted(low_frames: Mapping[str, int]) -> str:
    """How many frames were low by which measure."""
    return ", ".join(
        f"{count} by {measure.replace('_', ' ')}" for measure, count in low_frames.items()
    )
