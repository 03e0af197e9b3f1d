"""``ragdoll quality``: stereochemistry, clashes and backbone of the frames of a file."""

from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table
from rich.text import Text

from ..exits import DONE
from ..quality_report import QualityReport, quality
from .method_options import AsJson, Quiet, show

_ROWS = {
    "bonds off, RMS, Å": "bond_rms_angstrom",
    "bonds off, most, Å": "bond_max_angstrom",
    "angles off, RMS, °": "angle_rms_degree",
    "angles off, most, °": "angle_max_degree",
    "bonds, RMSZ": "bond_rmsz",
    "angles, RMSZ": "angle_rmsz",
    "clashes per 1000 atoms": "clashes_per_1000",
    "all-atom clashscore": "all_atom_clashscore",
    "Ramachandran core, %": "ramachandran_core_percent",
    "Ramachandran outliers, %": "ramachandran_outlier_percent",
    "omega, RMS, °": "omega_rms_degree",
    "omega off by over 30°, %": "omega_over_30_percent",
    "inverted CA": "inverted_alphas",
    "inverted centres": "inverted_centres",
}


def run(
    input: Annotated[
        Path, typer.Argument(help="A trajectory, .h5; or a PDB or mmCIF file, for it alone.")
    ],
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> int:
    """Measure the quality of the frames of a trajectory, against its input and ideal values."""
    report = quality(input)
    show(report.as_dict(), as_json, quiet, lambda: quality_table(report, str(input)))
    return DONE


def quality_table(report: QualityReport, title: str) -> Table:
    """What was measured: of the input, the mean over the frames, and the worst frame."""
    table = Table(title=Text(title), title_justify="left")
    table.add_column("")
    for name in ("input", "mean", "worst", "in frame"):
        table.add_column(name, justify="right")
    rows = dict(_ROWS)
    for kind in report.counts["bounds"]:
        rows[f"{kind.replace('_', ' ')} bounds exceeded, Å"] = f"excess_{kind}_angstrom"
    for words, name in rows.items():
        if report.input[name] is None:
            continue
        frame = report.worst_frame[name]
        table.add_row(
            words,
            *(_number(of[name]) for of in (report.input, report.mean, report.worst)),
            "" if frame is None else str(frame),
        )
    return table


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.4g}" if abs(value) >= 0.0005 else f"{value:.1g}"
