"""Tests for sets and experiments: the same numbers however they come about."""

import csv
import json
import re
import time
from html.parser import HTMLParser

import numpy as np
import pytest

import ragdoll
from ragdoll.errors import InputError
from ragdoll.method.generating import generate_set
from ragdoll.method.result_set import read_set

#: few enough to be quick, with an order of each kind
TECHNIQUES = {
    "orders": ["bfs_tree", "bfs_cycle", "bfs_reverse", "random"],
    "weightings": [".5/.5", "1/0"],
}

RESULTS = ("runs.csv", "cells.csv", "cells.json", "claims.json", "index.html", "overview.png")


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """A set of two trees and two 1-cycles with four forces each."""
    folder = tmp_path_factory.mktemp("sets") / "small"
    classes = ["tree", "1-cycle"]
    generate_set(folder, classes=classes, count=2, forces=4, joints=(8, 12), seed=1)
    return folder


@pytest.fixture(scope="module")
def report(small, tmp_path_factory):
    """Its experiment."""
    folder = tmp_path_factory.mktemp("reports") / "whole"
    return ragdoll.experiment(small, folder, threads=2, **TECHNIQUES)


def contents(folder):
    return {name: (folder / name).read_bytes() for name in RESULTS}


def test_a_set_has_the_folders_of_test_mode_and_results_name_them_all(small):
    results = read_set(small)
    assert results.seed == 1
    assert [entry.structure.as_posix() for entry in results.entries] == [
        f"{name}/{number:03d}/structure.xml" for name in ("tree", "1-cycle") for number in (1, 2)
    ]
    for entry in results.entries:
        assert [path.name for path in entry.forces] == ["01.xml", "02.xml", "03.xml", "04.xml"]
        for path in (entry.structure, entry.order, *entry.forces):
            assert (small / path).is_file()


def test_a_set_comes_out_the_same_again_and_a_class_does_not_depend_on_the_others(small, tmp_path):
    generate_set(tmp_path / "again", classes=["1-cycle"], count=2, forces=4, joints=(8, 12), seed=1)
    for number in ("001", "002"):
        for name in ("structure.xml", "order.xml", "forces/03.xml"):
            again = tmp_path / "again" / "1-cycle" / number / name
            assert again.read_bytes() == (small / "1-cycle" / number / name).read_bytes()


def test_a_folder_in_use_is_not_written_into(small, tmp_path):
    (tmp_path / "mine.txt").write_text("a diary")
    with pytest.raises(InputError, match="not empty"):
        generate_set(tmp_path)
    with pytest.raises(InputError, match="holds no experiment"):
        ragdoll.experiment(small, tmp_path)
    assert (tmp_path / "mine.txt").read_text() == "a diary"


def test_a_set_that_cannot_be_drawn_is_refused_before_anything_is_written(tmp_path):
    with pytest.raises(InputError, match="2-cycle"):
        generate_set(tmp_path / "set", classes=["tree", "2-cycle"], joints=(3, 9))
    assert not (tmp_path / "set").exists()


def test_given_structures_make_a_set_under_their_classes(tmp_path):
    ring, tree = (ragdoll.generate(name, joints=9, seed=1) for name in ("1-cycle", "tree"))
    generate_set(tmp_path / "set", given=[ring, tree, ring], forces=2)
    entries = read_set(tmp_path / "set").entries
    assert [entry.folder.as_posix() for entry in entries] == [
        "1-cycle/001",
        "tree/001",
        "1-cycle/002",
    ]


def test_every_technique_runs_on_every_force_but_tree_orders_on_cycles(report):
    cells = {(c["class"], c["order"], c["weighting"]): c for c in report.cells}
    counts = {name: len([k for k in cells if k[0] == name]) for name in ("tree", "1-cycle")}
    assert counts == {"tree": 8, "1-cycle": 6}
    assert ("1-cycle", "bfs_tree", "1/0") not in cells
    assert all(cell["forces"] == 8 for cell in cells.values())
    assert len(report.records()) == sum(cell["forces"] for cell in cells.values())


def test_the_runs_are_those_of_resolve(report, small):
    entry = read_set(small).entries[2]
    records = [
        record
        for record in report.records()
        if (record["class"], record["structure"]) == ("1-cycle", "001")
        and (record["order"], record["weighting"]) == ("bfs_reverse", "1/0")
    ]
    for path, record in zip(entry.forces, records, strict=True):
        done = ragdoll.resolve(
            small / entry.structure, small / path, "bfs_reverse", weighting="1/0"
        )
        assert done.iterations.tolist() == [record["iterations"]]
        assert done.bar_visits.tolist() == [record["bar_visits"]]


def test_the_files_agree_with_each_other(report, small):
    rows = list(csv.DictReader((report.folder / "runs.csv").open()))
    cells = json.loads((report.folder / "cells.json").read_text())["cells"]
    cell = cells[4]
    chosen = [
        int(row["iterations"])
        for row in rows
        if all(row[key] == cell[key] for key in ("class", "order", "weighting", "solver"))
    ]
    assert np.mean(chosen) == cell["mean"]
    folder = small / "tree" / "001" / "techniques" / "bfs_cycle_.5-.5"
    of_folder = [
        int(row["iterations"]) for row in csv.DictReader((folder / "iterations.csv").open())
    ]
    assert of_folder == [
        int(row["iterations"])
        for row in rows
        if (row["class"], row["structure"], row["order"], row["weighting"])
        == ("tree", "001", "bfs_cycle", ".5/.5")
    ]
    named = {path for entry in read_set(small).entries for path in entry.techniques.values()}
    assert folder.relative_to(small) in named


def test_trees_take_one_iteration_in_tree_orders(report):
    part = report.claims["T1"].parts[0]
    assert part.holds
    assert part.figures["forces"] == 8


def test_the_page_needs_no_network_and_shows_every_chart(report):
    text = (report.folder / "index.html").read_text()
    sources = re.findall(r'(?:src|href)="([^"]*)"', text)
    assert all(source.startswith(("data:image/png;base64,", "#")) for source in sources)
    assert len([s for s in sources if s.startswith("data:")]) == 1 + 2 * 2
    assert "url(" not in text and "@import" not in text and "<script" not in text
    HTMLParser().feed(text)


def test_the_number_of_threads_does_not_show(report, small, tmp_path):
    other = ragdoll.experiment(small, tmp_path / "r", threads=1, **TECHNIQUES)
    assert contents(other.folder) == contents(report.folder)


def test_a_torn_journal_goes_on_to_the_same_result(report, small, tmp_path):
    folder = tmp_path / "r"
    folder.mkdir()
    journal = (report.folder / "journal.jsonl").read_bytes()
    (folder / "journal.jsonl").write_bytes(journal[: len(journal) // 2])
    again = ragdoll.experiment(small, folder, **TECHNIQUES)
    assert 0 < again.done_before < len(again.tasks)
    assert contents(folder) == contents(report.folder)


def test_what_is_finished_is_not_done_again(report, small):
    journal = (report.folder / "journal.jsonl").read_bytes()
    again = ragdoll.experiment(small, report.folder, **TECHNIQUES)
    assert again.done_before == len(again.tasks)
    assert (report.folder / "journal.jsonl").read_bytes() == journal


def test_another_set_or_other_parameters_are_refused_in_the_same_folder(report, small, tmp_path):
    generate_set(tmp_path / "other", classes=["tree"], count=1, forces=1, seed=2)
    with pytest.raises(InputError, match="another experiment"):
        ragdoll.experiment(tmp_path / "other", report.folder, **TECHNIQUES)
    with pytest.raises(InputError, match="another experiment"):
        ragdoll.experiment(small, report.folder, tolerance=0.1, **TECHNIQUES)


def test_a_tighter_tolerance_takes_more_iterations_and_smaller_forces_fewer(
    report, small, tmp_path
):
    def total(cells):
        return sum(
            cell["mean"]
            for cell in cells
            if (cell["order"], cell["weighting"]) == ("bfs_cycle", ".5/.5")
        )

    one = {"orders": ["bfs_cycle"], "weightings": [".5/.5"]}
    tight = ragdoll.experiment(small, tmp_path / "tight", tolerance=1e-6, **one)
    weak = ragdoll.experiment(small, tmp_path / "weak", scale=0.1, **one)
    assert total(weak.cells) < total(report.cells) < total(tight.cells)


def test_frames_are_kept_where_they_are_asked_for(small, tmp_path):
    one = ["bfs_cycle"], [".5/.5"]
    ragdoll.experiment(small, tmp_path / "r", orders=one[0], weightings=one[1], frames=True)
    path = small / "tree" / "001" / "techniques" / "bfs_cycle_.5-.5" / "frames.h5"
    with ragdoll.open_trajectory(path) as trajectory:
        assert len(trajectory) == 4


def test_a_killed_experiment_goes_on_and_ends_as_if_nothing_had_been(start_ragdoll, tmp_path):
    generate_set(tmp_path / "set", classes=["n-cycle"], count=3, forces=40, joints=(60, 80), seed=4)
    killed, journal = tmp_path / "killed", tmp_path / "killed" / "journal.jsonl"
    process = start_ragdoll("experiment", tmp_path / "set", "-o", killed, "--threads", 1)
    while process.poll() is None and (not journal.exists() or journal.stat().st_size < 4000):
        time.sleep(0.005)
    process.kill()
    process.wait()
    before = journal.read_bytes()
    assert not (killed / "index.html").exists()

    ragdoll.experiment(tmp_path / "set", killed)
    after = journal.read_bytes()
    assert after.startswith(before[: before.rfind(b"\n") + 1])
    tasks = [json.loads(line)["task"] for line in after.splitlines()[1:]]
    assert len(tasks) == len(set(tasks))
    ragdoll.experiment(tmp_path / "set", tmp_path / "whole")
    assert contents(killed) == contents(tmp_path / "whole")


def test_experiment_prints_cells_and_claims_as_one_object(run_ragdoll, small, tmp_path):
    ended = run_ragdoll(
        "experiment", small, "-o", tmp_path / "r", "--orders", "bfs_tree,random",
        "--weightings", "1/0,.5/.5", "--json",
    )  # fmt: skip
    assert ended.code == 0
    asked = {"class", "order", "weighting", "solver", "mean", "mode", "stdev", "p50", "p99",
             "failed", "bar_visits_mean"}  # fmt: skip
    assert all(asked <= set(cell) for cell in ended.json["cells"])
    assert list(ended.json["claims"]) == ["T1", "T2", "T3", "T4", "T5", "T6", "T7"]
    assert ended.json["claims"]["T1"]["holds"] in (True, False)
