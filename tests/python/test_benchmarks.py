"""Tests for benchmarks/: what becomes of records. Nothing is measured here."""

import json
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).resolve().parents[2] / "benchmarks"
NAMES = [
    "block_iterations",
    "small_cycles_p50",
    "small_cycles_p99",
    "forced_joint_visits",
    "forced_joint_time",
    "protein_1e-3_scalar",
    "protein_1e-3_ensemble",
    "protein_1e-2_scalar",
    "protein_1e-2_ensemble",
    "dhfr_conformer",
    "ccma_single",
    "ccma_ensemble",
    "newton_iterations",
    "newton_linear",
    "setup",
    "inverted",
]
KEYS = ["name", "ours", "baseline", "unit", "ratio", "goal", "sense", "met"]
RATIOS = {name for name in NAMES if name.startswith(("small", "protein", "ccma", "setup"))}


@pytest.fixture
def modules(monkeypatch):
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    import chart
    import printing
    import rows

    return rows, printing, chart


def network(contender, ms, *, converged=4, **fields):
    return {
        "what": "network",
        "network": "molecule",
        "joints": 1000,
        "bars": 2000,
        "tolerance_kind": "angstrom",
        "tolerance": 1e-3,
        "contender": contender,
        "breaks": 4,
        "converged": converged,
        "wrong": 0,
        "inverted": 0,
        "iterations": 4.0,
        "most_iterations": 5,
        "ms": ms,
    } | fields


@pytest.fixture
def records():
    """One record of each kind, with numbers that are easy to divide."""
    block = {"tolerance": 1e-6, "forces": 10, "failed": 0, "wrong": 0, "visits_per_bar": 1.5}
    found = [{"what": "block_iterations", "class": "tree", "most_iterations": 1} | block]
    for class_name, plain in (("1-cycle", 20.0), ("2-cycle", 12.0)):
        for contender, us in (("block", 1.0), ("plain", plain)):
            times = {"contender": contender, "p50_us": us, "p99_us": 2 * us}
            found.append({"what": "small_cycles", "class": class_name} | times)
    for joints, us in ((1000, 2.0), (1_000_000, 6.0)):
        forced = {"what": "forced", "joints": joints, "bars": joints, "failed": 0, "wrong": 0}
        found.append(forced | {"contender": "block", "visits": 30.0, "us": us})
        found.append(forced | {"contender": "plain", "visits": 9.0 * joints, "us": 1e3 * us})
    for tolerance in (1e-3, 1e-2):
        for contender, ms in (("plain", 300.0), ("newton", 1.0), ("newton ensemble single", 0.2)):
            found.append(network(contender, ms, tolerance=tolerance, molecule="protein"))
    for joints, ms in ((1000, 1.0), (10_000, 12.0)):
        found.append(network("newton", ms, joints=joints))
    bonds = {"network": "bonds", "molecule": "protein", "tolerance": 6e-4}
    bonds |= {"tolerance_kind": "relative"}
    found.append(network("ordered", 0.1, **bonds))
    found.append(network("ordered ensemble single", 0.01, **bonds))
    openmm = {"what": "openmm", "joints": 1000, "bars": 1000, "angle_forces": True}
    openmm |= {"network": "bonds", "molecule": "protein", "tolerance": 6e-4}
    found.append(
        openmm | {"sigma_angstrom": 0.1, "ms": 0.4, "worst_relative": 5e-4, "converged": True}
    )
    found.append(
        openmm | {"sigma_angstrom": 0.3, "ms": 0.01, "worst_relative": None, "converged": False}
    )
    conformers = {"what": "conformers", "molecule": "DHFR", "joints": 1268, "solver": "auto"}
    conformers |= {"works": "newton", "precision": "single", "lanes": 16, "instructions": "AVX3"}
    conformers |= {"steps": 10, "accepted": 10, "wrong": 0, "inverted": 0}
    for kind, ms in (("contacts", 0.2), ("molecule", 0.1)):
        found.append(conformers | {"network": kind, "ms_per_accepted": ms, "ms_per_step": ms})
    for part, ms in (("framework", 2.0), ("newton", 3.0), ("openmm", 10_000.0)):
        setup = {"what": "setup", "network": "bonds", "joints": 30_000}
        found.append(setup | {"part": part, "ms": ms})
    return found


def by_name(rows, records):
    return {row["name"]: row for row in rows.rows_of(records)}


def test_rows_have_the_names_and_keys_that_are_asked_for(modules, records):
    rows, _, _ = modules
    for found in (rows.rows_of(records), rows.rows_of([])):
        assert [row["name"] for row in found] == NAMES
        for row in found:
            assert list(row) == [
                "name",
                "ours",
                "baseline",
                "unit",
                "ratio",
                "goal",
                "sense",
                "met",
            ]
            assert row["sense"] == (">=" if row["name"] in RATIOS else "<=")
        json.dumps(found, allow_nan=False)


def test_every_row_is_filled_where_everything_was_measured(modules, records):
    rows, _, _ = modules
    for row in rows.rows_of(records):
        assert row["ours"] is not None and row["met"] is not None, row
        assert (row["ratio"] is not None) == (row["name"] in RATIOS), row


def test_ratios_are_the_baseline_over_ours_and_the_worse_case_counts(modules, records):
    rows, _, _ = modules
    found = by_name(rows, records)
    assert found["small_cycles_p50"]["ratio"] == 12
    assert found["small_cycles_p50"]["met"]
    assert found["protein_1e-3_scalar"]["ratio"] == 300
    assert found["protein_1e-3_ensemble"]["ratio"] == 1500
    assert found["ccma_single"]["ratio"] == pytest.approx(4)
    assert not found["ccma_single"]["met"]
    assert found["ccma_ensemble"]["ratio"] == pytest.approx(40)
    assert found["setup"]["ratio"] == 2000
    assert found["forced_joint_time"]["ours"] == 6
    assert not found["forced_joint_time"]["met"]
    assert found["newton_linear"]["ours"] == pytest.approx(1.2)
    assert found["newton_iterations"]["goal"] == 6


def test_what_fails_or_is_wrong_is_not_fast(modules, records):
    rows, _, _ = modules

    def changed(name, what, **fields):
        others = [r | fields if r["what"] == what else r for r in records]
        return by_name(rows, others)[name]

    assert changed("block_iterations", "block_iterations", failed=1)["met"] is False
    assert changed("block_iterations", "block_iterations", wrong=1)["met"] is False
    assert changed("forced_joint_time", "forced", failed=1)["ours"] is None
    assert changed("protein_1e-3_scalar", "network", wrong=4)["ratio"] is None
    assert changed("protein_1e-3_scalar", "network", converged=2)["ours"] == 2
    assert changed("dhfr_conformer", "conformers", wrong=1)["ours"] is None
    assert changed("ccma_single", "openmm", converged=False)["ratio"] is None
    assert changed("newton_iterations", "network", converged=3)["met"] is False
    assert changed("inverted", "conformers", inverted=1)["met"] is False


def test_tables_and_the_chart_take_all_that_is_measured(modules, records, tmp_path, capsys):
    _, printing, chart = modules
    printing.print_all(records)
    printed = capsys.readouterr().out
    assert all(name in printed for name in NAMES)
    chart.draw(records, tmp_path / "chart.png")
    assert (tmp_path / "chart.png").read_bytes().startswith(b"\x89PNG")
