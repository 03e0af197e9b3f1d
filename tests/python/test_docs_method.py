"""Tests for docs/method.md: its scripts run, and what the page says shows in a quick run too."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
DATA = Path(os.environ.get("RAGDOLL_DATA", ROOT.parent / "shared" / "data"))
PAGE = ROOT / "docs" / "method.md"
SCRIPTS = ROOT / "docs" / "method"


def run(name, *options, **environment):
    ended = subprocess.run(
        [sys.executable, SCRIPTS / f"{name}.py", *options],
        capture_output=True,
        text=True,
        timeout=300,
        env=os.environ | environment,
    )
    assert ended.returncode == 0, ended.stderr
    return ended.stdout


def quick(name, **environment):
    return json.loads(run(name, "--quick", "--json", **environment))


def by(cells, *keys):
    return {tuple(c[key] for key in keys): c for c in cells}


@pytest.fixture(scope="module")
def inconsistency():
    return quick("inconsistency")


def test_distance_of_the_anchors_after_one_pass_tells_what_fails(inconsistency):
    failures = 0
    for r in inconsistency["rule"]:
        right = r["kept"] + r["caught"]
        total = right + r["missed"] + r["false_alarms"]
        failures += r["caught"] + r["missed"]
        if r["class"] != "n-cycle":
            assert right / total > 0.95
            assert r["caught"] >= 0.8 * (r["caught"] + r["missed"])
        if r["class"] == "1-cycle":
            assert r["false_alarms"] == 0
        assert r["false_final_alarms"] == 0
    assert failures > 50


def test_only_anchors_out_of_range_are_never_resolved(inconsistency):
    impossible, *possible = inconsistency["boundary"]
    assert impossible["unresolved"] == impossible["forces"] > 0
    assert all(r["unresolved_after_100000"] == 0 for r in possible)


def test_an_adaptive_order_wins():
    cells = by(quick("adaptive")["cells"], "class", "order", "weighting")
    for name in ("1-cycle", "2-cycle", "n-cycle"):
        for weighting in (".5/.5", ".75/.25", "1/0"):
            plain = cells[name, "bfs_cycle", weighting]
            active = cells[name, "bfs_active", weighting]
            assert (active["mean"], active["failed"]) == (plain["mean"], plain["failed"])
            assert active["visits"] < plain["visits"]
        worst = cells[name, "bfs_worst", ".75/.25"]
        assert worst["failed"] == 0
        assert worst["visits"] < cells[name, "bfs_cycle", ".75/.25"]["visits"]
        assert worst["mean"] < cells[name, "random", ".5/.5"]["mean"]


def test_visits_of_active_bars_do_not_grow_with_a_tree():
    cells = by(quick("sizes")["cells"], "class", "joints", "order", "weighting")
    for size in (100, 1000):
        assert cells["tree", size, "bfs_cycle", "1/0"]["mean"] == 1
        assert cells["cloth", size, "bfs_cycle", "1/0"]["failed"] > 0
        assert cells["cloth", size, "bfs_cycle", ".5/.5"]["failed"] == 0
    growth = {
        order: cells["tree", 1000, order, ".5/.5"]["visits"]
        / cells["tree", 100, order, ".5/.5"]["visits"]
        for order in ("bfs_cycle", "bfs_active")
    }
    assert growth["bfs_active"] < 3 < 7 < growth["bfs_cycle"]


def test_molecules_stand_beyond_the_thesis_classes():
    if not (DATA / "proteins").is_dir() or not (DATA / "ligands").is_dir():
        pytest.skip("no molecules; set RAGDOLL_DATA to the folder that holds them")
    found = quick("molecules", RAGDOLL_DATA=str(DATA))
    proteins = found["graphs"]["proteins"]
    assert all(g["class"] == "n-cycle" for g in proteins)
    assert all(100 * g["rank"] / g["joints"] < 10 for g in proteins)
    for source in ("ligands", "proteins"):
        cells = by(found["races"][f"{source}, framework"], "order", "weighting")
        assert cells["bfs_cycle", ".5/.5"]["failed"] == 0
        assert cells["bfs_cycle", "1/0"]["failed"] > 0
        least = min(c["mean"] for c in cells.values())
        assert cells["bfs_reverse", ".5/.5"]["mean"] <= 1.2 * least


def test_without_molecules_the_script_says_so_in_one_sentence(tmp_path):
    said = run("molecules", "--quick", RAGDOLL_DATA=str(tmp_path))
    assert said.startswith("No molecules: set RAGDOLL_DATA") and said.count("\n") == 1


def test_claims_under_other_settings():
    settings = quick("claims")["settings"]
    assert len(settings) == 9
    for setting in settings:
        claims = setting["claims"]
        assert all(part["holds"] for part in claims["one"]["T1"])
        # counted in bars, forward and backward is two sweeps
        assert not any(part["holds"] for part in claims["two"]["T6"])


def test_the_page_holds_every_table_and_figure():
    page = PAGE.read_text()
    for script in sorted(SCRIPTS.glob("*.py")):
        assert script.stem == "common" or f"docs/method/{script.name}" in page
    tables = re.findall(r"<!-- (.+?) -->\n(.*?)<!-- end -->", page, re.DOTALL)
    assert len(tables) >= 15
    assert all(text.startswith("|") for _, text in tables)
    for figure in re.findall(r"\]\((method/\S+\.png)\)", page):
        assert (PAGE.parent / figure).is_file()
