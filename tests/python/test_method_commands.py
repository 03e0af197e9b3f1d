"""Tests for the command line of the method: flags, JSON, files and exit codes."""

import numpy as np
import pytest

import ragdoll
from ragdoll import _method_files


@pytest.fixture(scope="module")
def run(run_ragdoll):
    """Run ragdoll and check the exit code."""

    def checked(*words, code=0):
        ended = run_ragdoll(*words)
        assert ended.code == code, ended.stderr
        return ended

    return checked


@pytest.fixture(scope="module")
def made(run, tmp_path_factory):
    """A structure and forces, made by the commands."""
    folder = tmp_path_factory.mktemp("made")
    structure, forces = folder / "s.xml", folder / "f.xml"
    facts = run(
        "generate", "structure", "--class", "2-cycle", "--type", "theta", "--joints", 18,
        "--seed", 3, "-o", structure,
        "--json",
    ).json  # fmt: skip
    assert {key: facts[key] for key in ("joints", "bars", "cycle_rank", "class", "type")} == {
        "joints": 18, "bars": 19, "cycle_rank": 2, "class": "2-cycle", "type": "theta",
    }  # fmt: skip
    printed = run(
        "generate", "forces", structure, "--count", 12, "--seed", 3, "-o", forces, "--json"
    ).json
    assert printed["forces"] == 12
    return structure, forces


def test_an_output_is_not_replaced_unless_forced(run, made):
    structure, _ = made
    tree = run("generate", "structure", "--class", "tree", "-o", structure, code=2)
    assert "--force" in tree.sentence
    forces = run("generate", "forces", structure, "-o", structure, code=2)
    assert "is the input" in forces.sentence


def test_generate_set_counts_structures_and_force_files(run, tmp_path):
    printed = run(
        "generate", "set", "-o", tmp_path / "set", "--count", 2, "--forces", 3,
        "--classes", "tree,cloth", "--joints", "9:9",
        "--json",
    ).json  # fmt: skip
    assert (printed["structures"], printed["force_files"]) == (4, 12)
    assert len(list((tmp_path / "set").glob("*/*/forces/*.xml"))) == 12


def test_classify_prints_what_generate_promised(run, made):
    printed = run("classify", made[0], "--json").json
    assert (printed["class"], printed["type"], printed["cycle_rank"]) == ("2-cycle", "theta", 2)
    assert len(printed["components"]) == len(printed["blocks"]) == 1
    assert len(printed["bridges"]) == 19 - len(printed["blocks"][0]["bars"])


def test_an_order_can_be_written_and_resolved_with(run, made, tmp_path):
    structure, forces = made
    printed = run(
        "order",
        structure,
        "--order",
        "dfs_cycle",
        "--root",
        "j2",
        "-o",
        tmp_path / "o.xml",
        "--json",
    ).json
    assert len(printed["bars"]) == 19
    assert len(printed["problem"]) == 2
    assert all(bar in printed["bars"] for bar in printed["problem"])
    done = run(
        "resolve", structure, "--forces", forces, "--order", f"file:{tmp_path}/o.xml", "--json"
    ).json
    assert len(done["iterations"]) == 12


def test_resolve_prints_lists_with_an_entry_a_force(run, made, tmp_path):
    structure, forces = made
    final, frames = tmp_path / "x.xml", tmp_path / "x.h5"
    printed = run(
        "resolve", structure, "--forces", forces, "--order", "bfs_reverse", "--weighting",
        ".75/.25", "--verlet", "all", "--final", final, "-o", frames,
        "--json",
    ).json  # fmt: skip
    for key in ("iterations", "bar_visits", "converged", "residual"):
        assert len(printed[key]) == 12
    assert printed["mean"] == np.mean(printed["iterations"])
    assert printed["failed"] == 0
    expected = ragdoll.resolve(structure, forces, "bfs_reverse", ".75/.25", verlet="all")
    moved, _ = _method_files.read_structure(str(final))
    assert np.array_equal(moved.positions, expected.positions)
    before, _ = _method_files.read_structure(str(structure))
    assert np.array_equal(moved.bar_lengths, before.bar_lengths)
    with ragdoll.open_trajectory(frames) as trajectory:
        assert trajectory.observables["iterations"].tolist() == printed["iterations"]
        last = trajectory.frame(-1).positions
    assert np.allclose(last, expected.positions, atol=1e-5)


def test_resolve_ends_with_3_and_a_sentence_if_a_force_is_not_resolved(run, made, tmp_path):
    structure, forces = made
    done = run(
        "resolve", structure, "--forces", forces, "--max-iterations", 1, "--tolerance", 1e-9,
        "--final", tmp_path / "x.xml", "--quiet", code=3,
    )  # fmt: skip
    assert "forces were not resolved" in done.sentence
    assert done.stdout == ""
    assert (tmp_path / "x.xml").is_file()


TRIANGLE = """<structure version="1" length-unit="nm">
  <joint id="a" x="0" y="0" z="0"/>
  <joint id="b" x="2" y="0" z="0"/>
  <joint id="c" x="1" y="1.5" z="0"/>
  <bar joints="a b"/>
  <bar joints="b c"/>
  <bar joints="c a"/>
</structure>
"""
# onto the line through the other two, which no deformation leaves; then out of the plane
FORCES = """<forces version="1">
  <force joint="c" x="0" y="-1.5" z="0"/>
  <force joint="c" x="0.1" y="0.2" z="0.3"/>
</forces>
"""


def test_resolve_tells_how_many_cycle_blocks_were_carried_whole(run, tmp_path):
    structure, forces, final = (tmp_path / name for name in ("s.xml", "f.xml", "x.xml"))
    structure.write_text(TRIANGLE)
    forces.write_text(FORCES)
    words = ("resolve", structure, "--forces", forces, "--solver", "block", "--tolerance", 1e-6)
    printed = run(*words, "--final", final, "--json").json
    assert printed["carried"] == [1, 0]
    assert printed["iterations"] == [1, 1]
    assert printed["failed"] == 0
    moved, _ = _method_files.read_structure(str(final))
    for p, q, length in ((0, 1, 2), (1, 2, 3.25**0.5), (2, 0, 3.25**0.5)):
        apart = np.linalg.norm(moved.positions[q] - moved.positions[p])
        assert abs(apart - length) <= 1e-6 * length
    assert "cycle blocks carried whole" in run(*words).stdout


@pytest.mark.parametrize(
    "words, said",
    [
        (["order", "S", "--root", "nobody"], "'nobody'"),
        (["resolve", "S", "--forces", "S"], "s.xml"),
        (["generate", "forces", "S", "--scale-bars", "2:1", "-o", "T"], "--scale-bars"),
        (["experiment", "missing", "-o", "T"], "missing"),
    ],
)
def test_what_cannot_be_used_ends_with_2_and_one_sentence(run, made, tmp_path, words, said):
    places = {"S": made[0], "F": made[1], "T": tmp_path / "t"}
    ended = run(*[places.get(word, word) for word in words], code=2)
    assert said in ended.sentence
    assert ended.stdout == ""
    assert not (tmp_path / "t").exists()
