"""Tests for ragdoll.generate, classify, order and resolve."""

import json

import numpy as np
import pytest

import ragdoll
from ragdoll import _core, _method_files
from ragdoll.errors import InputError
from ragdoll.method.generating import generate_forces


def structure(letters, bars):
    """A structure of joints named by letters, at places that no three of which are in line."""
    places = np.random.default_rng(3).normal(size=(len(letters), 3))
    pairs = [[letters.index(p), letters.index(q)] for p, q in bars.split()]
    return _core.Structure(list(letters), places, np.array(pairs, dtype=np.int32))


def test_a_seed_gives_the_same_structure_again_and_another_one_another():
    first, again = (ragdoll.generate("2-cycle", joints=20, seed=5) for _ in range(2))
    other = ragdoll.generate("2-cycle", joints=20, seed=6)
    assert np.array_equal(first.positions, again.positions)
    assert np.array_equal(first.bars, again.bars)
    assert not np.array_equal(first.positions, other.positions)


@pytest.mark.parametrize("class_name, rank", [("tree", 0), ("1-cycle", 1), ("2-cycle", 2)])
def test_a_generated_structure_is_of_its_class(class_name, rank):
    found = ragdoll.classify(ragdoll.generate(class_name, joints=25, seed=1))
    assert (found.class_name, found.cycle_rank, found.joints) == (class_name, rank, 25)


def test_an_unknown_class_is_refused_in_a_sentence():
    with pytest.raises(InputError, match="spiral"):
        ragdoll.generate("spiral")


def test_forces_are_as_large_as_asked_in_mean_bar_lengths():
    tree = ragdoll.generate("tree", joints=20, seed=1)
    forces = generate_forces(tree, 400, scale_bars=(0.5, 1.5), seed=2)
    sizes = np.linalg.norm(forces.forces, axis=1) / np.mean(tree.bar_lengths)
    assert 0.5 <= sizes.min() < 0.55
    assert 1.45 < sizes.max() <= 1.5


def test_classify_names_bridges_and_blocks_by_their_joints():
    # a square with a tail
    found = ragdoll.classify(structure("abcde", "ab bc cd da de")).as_dict()
    assert (found["class"], found["cycle_rank"]) == ("1-cycle", 1)
    assert found["bridges"] == [["d", "e"]]
    assert [block["joints"] for block in found["blocks"]] == [["a", "b", "c", "d"]]
    json.dumps(found)


def test_classify_takes_a_molecule_and_looks_at_its_bond_graph(proteins):
    found = ragdoll.classify(proteins / "1crn.pdb")
    assert found.class_name == "n-cycle"
    assert len(found.components) == 1
    assert found.cycle_rank == sum(block["cycle_rank"] for block in found.blocks)


def test_order_gives_the_thesis_figure_with_its_problem_constraints():
    # Figure 5.2
    bars = "ab ac af bd ce fg de eg"
    found = ragdoll.order(structure("abcdefg", bars), "bfs_cycle", "a").as_dict()
    assert ["".join(bar) for bar in found["bars"]] == bars.split()
    assert [set(bar) for bar in found["problem"]] == [{"d", "e"}, {"e", "g"}]


def test_a_tree_order_is_refused_on_a_structure_with_cycles():
    with pytest.raises(InputError, match="has cycles"):
        ragdoll.order(structure("abc", "ab bc ca"), "bfs_tree")


def test_a_joint_that_is_not_there_is_refused_by_name():
    with pytest.raises(InputError, match="'z'"):
        ragdoll.order(structure("abc", "ab bc"), root="z")


def test_a_tree_takes_one_iteration_with_full_weight_on_the_far_end():
    tree = ragdoll.generate("tree", joints=40, seed=3)
    done = ragdoll.resolve(tree, generate_forces(tree, 30, seed=1), "bfs_tree", "1/0")
    assert done.converged.all()
    assert set(done.iterations) == {1}
    assert set(done.bar_visits) == {39}
    assert (done.residual <= done.tolerance).all()


def test_a_resolved_bar_is_where_a_hand_would_put_it():
    pair = _core.Structure(["a", "b"], np.array([[0.0, 0, 0], [1, 0, 0]]), np.array([[0, 1]], "i4"))
    done = ragdoll.resolve(pair, [("b", (1.0, 0, 0))], weighting=".75/.25", frames=True)
    # b, the root, is pulled to 2; of the error 1, the far end a takes three quarters
    assert np.allclose(done.positions, [[0.75, 0, 0], [1.75, 0, 0]])
    assert np.array_equal(done.frames[-1], done.positions)


def test_records_have_one_entry_a_force_and_statistics_agree_with_them():
    ring = ragdoll.generate("1-cycle", joints=15, seed=2)
    done = ragdoll.resolve(ring, generate_forces(ring, 20, seed=5))
    records = done.records()
    assert len(records) == len(done) == 20
    assert done.statistics().mean == np.mean([record["iterations"] for record in records])
    assert {record["joint"] for record in records} <= set(ring.ids)


def test_an_unresolved_force_counts_as_the_maximum():
    ring = structure("abcdef", "ab bc cd de ef fa ac bd")
    done = ragdoll.resolve(ring, [("a", (2.0, 1, 0))], "random", max_iterations=2, tolerance=1e-9)
    statistics = done.statistics()
    assert not done.converged[0]
    assert (statistics.failed, statistics.mean, statistics.resolved_mean) == (1, 2, None)


def test_an_order_file_is_resolved_as_the_order_it_was_written_from(tmp_path):
    ring = ragdoll.generate("2-cycle", joints=20, seed=4)
    forces = [(ring.ids[3], (0.3, 0.2, -0.4))]
    found = ragdoll.order(ring, "bfs_cycle", ring.ids[3])
    path = tmp_path / "o.xml"
    _method_files.write_order(
        str(path), ring, found.bars, found.closes_cycle, found.root, found.name
    )
    by_name = ragdoll.resolve(ring, forces, "bfs_cycle", ".75/.25")
    by_file = ragdoll.resolve(ring, forces, f"file:{path}", ".75/.25")
    assert np.array_equal(by_name.iterations, by_file.iterations)
    assert np.array_equal(by_name.positions, by_file.positions)


@pytest.mark.parametrize(
    "option, words",
    [
        ({"order": "spiral"}, "spiral"),
        ({"weighting": ".5/.6"}, ".5/.6"),
        ({"solver": "magic"}, "magic"),
        ({"verlet": "some"}, "some"),
        ({"tolerance": -1.0}, "tolerance"),
    ],
)
def test_an_option_that_makes_no_sense_is_refused_in_a_sentence(option, words):
    pair = structure("ab", "ab")
    with pytest.raises(InputError, match=words):
        ragdoll.resolve(pair, [("a", (1, 0, 0))], **option)
