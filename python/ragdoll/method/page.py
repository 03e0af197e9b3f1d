"""The report's page: one file with all charts in it, that needs no network."""

from __future__ import annotations

import base64
import string
from collections.abc import Sequence
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING

from .cells import Cell, Cells
from .charts import OVERVIEW, Pictures
from .claims import VIEWS, Claim

if TYPE_CHECKING:
    from .experiment import ExperimentReport

_COLUMNS = (
    ("mean", "mean"),
    ("mode", "mode"),
    ("stdev", "st. dev."),
    ("p50", "p50"),
    ("p99", "p99"),
    ("failed", "failed"),
    ("bar_visits_mean", "bar visits, mean"),
    ("nothing_broken", "nothing broken"),
    ("resolved_mean", "mean of resolved"),
    ("resolved_mode", "mode of resolved"),
    ("resolved_stdev", "st. dev. of resolved"),
)
#: columns whose lowest number is marked
_BEST = ("mean", "stdev", "p99", "bar_visits_mean")


def page_text(report: ExperimentReport, cells: Cells, pictures: Sequence[Pictures]) -> str:
    """The page as HTML."""
    template = string.Template((files(__package__) / "report.html").read_text(encoding="utf-8"))
    return template.substitute(
        about=escape(_about(report)),
        links="".join(
            f'<a href="#{escape(name)}">{escape(name)}</a>'
            for name in ["overview", "claims", *cells.classes]
        ),
        overview=_image(report.folder / OVERVIEW, "Means of all classes and techniques"),
        claims=_claims_table(report.claims),
        claim_details="".join(_details(claim) for claim in report.claims.values()),
        classes="".join(_class_section(made, cells) for made in pictures),
    )


def _about(report: ExperimentReport) -> str:
    about = report.about
    tolerance = ", ".join(f"{t:g}" for t in about["tolerance"])
    most = ", ".join(str(m) for m in about["max_iterations"])
    runs = sum(len(task.iterations) for task in report.tasks)
    return (
        f"{about['structures']} structures, {about['force_files']} force files, "
        f"{len(about['techniques'])} techniques, {runs} runs. Set of seed {about['set_seed']}, "
        f"orders at random from seed {about['seed']}. Tolerance {tolerance}, at most {most} "
        f"iterations, forces times {about['scale']:g}, Verlet {about['verlet']}. "
        f"ragdoll {about['version']}."
    )


def _verdict(holds: bool | None) -> str:
    if holds is None:
        return '<span class="none">not tried</span>'
    return '<span class="yes">✓ holds</span>' if holds else '<span class="no">✗ fails</span>'


def _claims_table(claims: dict[str, Claim]) -> str:
    heads = "".join(f"<th>{escape(view.name)}</th>" for view in VIEWS)
    rows = []
    for name, claim in claims.items():
        verdicts = "".join(f"<td>{_verdict(variant['holds'])}</td>" for variant in claim.variants)
        rows.append(
            f'<tr><td class="text"><b>{name}</b></td><td class="text">{escape(claim.title)}</td>'
            f"{verdicts}</tr>"
        )
    head = f'<tr><th></th><th class="text">the thesis says</th>{heads}</tr>'
    return f"<table><thead>{head}</thead><tbody>{''.join(rows)}</tbody></table>"


def _details(claim: Claim) -> str:
    tried = [part for part in claim.parts if part.holds is not None]
    holding = sum(bool(part.holds) for part in tried)
    rows = "".join(
        f'<tr><td class="text">{_verdict(part.holds)}</td>'
        f'<td class="text">{escape(part.statement)}</td>'
        f'<td class="text">{escape(part.words)}</td></tr>'
        for part in claim.parts
    )
    return (
        f"<details><summary><b>{claim.name}</b> {_verdict(claim.holds)}: {holding} of {len(tried)} "
        f'parts hold</summary><p class="small">{escape(claim.note)}</p>'
        f"<table>{rows}</table></details>"
    )


def _class_section(made: Pictures, cells: Cells) -> str:
    name = escape(made.class_name)
    return (
        f'<h2 id="{name}">{name}</h2>'
        f"{_image(made.summary, f'Means, modes and deviations on {name}')}"
        f"{_image(made.histograms, f'Histograms of iterations on {name}')}"
        f'<h3>All figures</h3><div class="wide">{_table(cells.of_class(made.class_name))}</div>'
        '<p class="small">Green: the lowest of its column. The mean, mode and deviation are over '
        "all forces, an unresolved one counting as its maximum; the last three columns are over "
        "the resolved ones. Bar visits are those made, of unresolved forces too.</p>"
    )


def _image(path: Path, words: str) -> str:
    data = base64.b64encode(path.read_bytes()).decode()
    return f'<p><img alt="{escape(words)}" src="data:image/png;base64,{data}"></p>'


def _table(cells: list[Cell]) -> str:
    records = [cell.as_dict() for cell in cells]
    least = {
        key: min((r[key] for r in records if r[key] is not None), default=None) for key in _BEST
    }
    heads = "".join(f"<th>{escape(title)}</th>" for _, title in _COLUMNS)
    rows = []
    for cell, record in zip(cells, records, strict=True):
        numbers = "".join(_cell(key, record[key], least) for key, _ in _COLUMNS)
        rows.append(f'<tr><td class="text">{escape(cell.technique.name)}</td>{numbers}</tr>')
    head = f'<tr><th class="text">technique</th>{heads}</tr>'
    return f"<table><thead>{head}</thead><tbody>{''.join(rows)}</tbody></table>"


def _cell(key: str, value: float | None, least: dict) -> str:
    kind = ""
    if key in least and value is not None and value == least[key]:
        kind = ' class="best"'
    elif key == "failed" and value:
        kind = ' class="bad"'
    return f"<td{kind}>{_number(value)}</td>"


def _number(value: float | None) -> str:
    if value is None:
        return "–"
    if isinstance(value, int):
        return str(value)
    return f"{value:.2f}" if value < 100 else f"{value:.0f}"
