"""The files of a report: tables, charts and the page."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

from ..whole_file import whole_file
from .cells import cells_csv
from .runs import csv_text

if TYPE_CHECKING:
    from .experiment import ExperimentReport


def write_text(path: Path, text: str) -> None:
    """Write a file whole or not at all."""
    with whole_file(path) as part:
        part.write_text(text, encoding="utf-8")


def write_outputs(report: ExperimentReport) -> None:
    """Write runs.csv, cells.csv, cells.json, claims.json, the charts and index.html.

    The same results make the same bytes: nothing in them tells when or where.
    """
    from . import charts, page

    folder, cells = report.folder, report.table
    write_text(folder / "runs.csv", csv_text(row for task in report.tasks for row in task.rows()))
    rows = cells_csv(cells)
    write_text(folder / "cells.csv", csv_text(rows[1:], rows[0]))
    write_text(folder / "cells.json", _json({**report.about, "cells": cells.records()}))
    claims = {name: claim.as_dict() for name, claim in report.claims.items()}
    write_text(folder / "claims.json", _json({**report.about, "claims": claims}))
    pictures = charts.draw_all(report.tasks, cells, folder)
    write_text(folder / "index.html", page.page_text(report, cells, pictures))


def _json(document: dict) -> str:
    return json.dumps(document, indent=1) + "\n"
