"""Tests for the statistics of cells and for the claims, on numbers made by hand."""

from pathlib import Path

import numpy as np
import pytest

from ragdoll.errors import InputError
from ragdoll.method.cells import View, make_cells
from ragdoll.method.claims import judge, judge_cells
from ragdoll.method.result_set import SetEntry, read_set, write_results
from ragdoll.method.runs import ForceTable, TaskRuns
from ragdoll.method.technique import Technique, all_techniques

MOST = 100


def runs(class_name, order, weighting, iterations, sizes=None):
    """One task; None among the iterations is a force that was not resolved."""
    count = len(iterations)
    converged = np.array([n is not None for n in iterations])
    made = np.array([7 if n is None else n for n in iterations])
    return TaskRuns(
        SetEntry(class_name, Path(class_name, "001", "structure.xml")),
        Technique(order, weighting),
        ForceTable(
            ["f.xml"] * count,
            ["a"] * count,
            np.ones(count) if sizes is None else np.array(sizes),
            np.full(count, MOST),
        ),
        made,
        made * 10,
        converged,
        np.zeros(count),
    )


def test_an_unresolved_force_counts_as_its_maximum_and_stands_apart_as_well():
    (cell,) = make_cells([runs("1-cycle", "random", ".5/.5", [3, 3, 5, None])]).records()
    assert (cell["mean"], cell["mode"], cell["failed"]) == ((3 + 3 + 5 + MOST) / 4, 3, 1)
    assert (cell["resolved_mean"], cell["resolved_mode"]) == (11 / 3, 3)
    assert cell["stdev"] == pytest.approx(np.std([3, 3, 5, MOST]))
    assert (cell["p50"], cell["p99"]) == (3, MOST)
    assert cell["bar_visits_mean"] == (30 + 30 + 50 + 70) / 4


def test_structures_of_a_class_share_a_cell():
    one = runs("tree", "random", "1/0", [1, 2])
    two = runs("tree", "random", "1/0", [3])
    (cell,) = make_cells([one, two])
    assert (cell.structures, cell.statistics.forces, cell.statistics.mean) == (2, 3, 2)


def test_a_view_counts_a_reverse_pass_twice_and_others_once():
    tasks = [runs("tree", order, ".5/.5", [4]) for order in ("bfs_reverse", "bfs_cycle")]
    cells = make_cells(tasks, View(sweeps=2))
    assert [cell.statistics.mean for cell in cells] == [8, 4]


def test_a_view_counts_forces_of_its_sizes_only():
    task = runs("tree", "random", ".5/.5", [1, 2, 3], sizes=[0.2, 0.7, 1.5])
    (cell,) = make_cells([task], View(sizes=(0.5, 1.0)))
    assert (cell.statistics.forces, cell.statistics.mean) == (1, 2)


def tree(bfs, dfs, random):
    orders = {"bfs_tree": bfs, "dfs_tree": dfs, "random": random}
    return [runs("tree", order, "1/0", numbers) for order, numbers in orders.items()]


def test_trees_hold_if_each_force_that_breaks_a_bar_takes_one_iteration():
    claim = judge(tree([1, 1, 0], [1, 1, 0], [1, 2, 1]))["T1"]
    assert claim.holds
    assert "1 of 3 forces broke nothing" in claim.note


@pytest.mark.parametrize(
    "bfs, random", [([1, 2, 0], [1, 2, 1]), ([1, None, 1], [1, 2, 1]), ([1, 1, 1], [1, 1, 1])]
)
def test_trees_fail_on_a_second_iteration_a_failure_or_a_random_order_that_is_as_good(bfs, random):
    assert judge(tree(bfs, [1, 1, 1], random))["T1"].holds is False


def test_a_claim_that_cannot_be_tried_is_neither_true_nor_false():
    claims = judge(tree([1], [1], [1, 2]))
    assert claims["T6"].holds is None
    assert "nothing to try it on" in claims["T6"].note


def reverse(best, other):
    tasks = []
    for class_name in ("1-cycle", "2-cycle"):
        tasks.append(runs(class_name, "bfs_reverse", ".5/.5", best))
        tasks.append(runs(class_name, "bfs_cycle", ".5/.5", other))
    return tasks


def test_the_best_order_may_lose_when_its_passes_count_as_two():
    claim = judge(reverse([2, 3], [3, 5]))["T6"]
    verdicts = {variant["view"]: variant["holds"] for variant in claim.variants}
    assert claim.holds is True
    assert verdicts["a reverse pass counts as two"] is False
    assert "a reverse pass counts as two" in claim.note


def test_orders_that_the_thesis_does_not_have_leave_its_claims_alone():
    tasks = reverse([2, 3], [3, 5])
    tasks += [runs("1-cycle", "bfs_reverse", ".6/.4", [1, 1])]
    assert judge_cells(make_cells(tasks))["T6"] is True


def test_even_shares_fail_for_the_order_where_another_weighting_is_better():
    weightings = {".5/.5": [4, 5], ".75/.25": [3, 4], "1/0": [90, 9]}
    tasks = [runs("1-cycle", "bfs_cycle", w, numbers) for w, numbers in weightings.items()]
    claim = judge(tasks)["T2"]
    assert claim.holds is False
    (failing,) = [part for part in claim.parts if part.holds is False]
    assert failing.statement == "1-cycle: .5/.5 has the lowest mean of bfs_cycle"
    assert failing.figures == {".5/.5": 4.5, ".75/.25": 3.5, "1/0": 49.5}


def test_techniques_are_all_combinations_each_once():
    names = [t.name for t in all_techniques(["random", "bfs_cycle"], [".5/.5", "0.5/0.5", "1/0"])]
    assert names == ["random .5/.5", "random 1/0", "bfs_cycle .5/.5", "bfs_cycle 1/0"]


def test_a_technique_is_known_again_by_its_folder(tmp_path):
    techniques = [Technique("random", "1/0"), Technique("random", "1/0", "block")]
    path = Path("tree", "001", "structure.xml")
    entry = SetEntry("tree", path, forces=[path.with_name("f.xml")])
    for technique in techniques:
        entry.techniques[technique] = entry.technique_folder(technique)
    write_results(tmp_path, [entry], seed=1)
    (again,) = read_set(tmp_path).entries
    assert again.techniques == entry.techniques


def test_a_technique_that_is_not_known_is_refused_by_name():
    with pytest.raises(InputError, match="spiral"):
        all_techniques(["spiral"])
