"""The method's XML files from Python: objects in and out, and which exceptions come."""

import resource
import signal
import stat
import sys

import numpy as np
import pytest

from ragdoll import _core, _method_files

TRIANGLE = """\
<structure version="1" length-unit="nm" class="1-cycle">
  <joint id="a" x="0" y="0" z="0" mass="12"/>
  <joint id="b" x="3" y="0" z="0"/>
  <joint id="c" x="0" y="4" z="0" fixed="true"/>
  <bar joints="a b"/>
  <bar joints="b c"/>
  <bar joints="c a" length="3.5"/>
  <tether joints="a b" length="3.25"/>
  <contact joints="b c" length="0.1"/>
</structure>
"""


@pytest.fixture
def triangle(tmp_path):
    path = tmp_path / "triangle.xml"
    path.write_text(TRIANGLE)
    return _method_files.read_structure(path)[0]


def assert_same(a, b):
    assert a.ids == b.ids
    assert (a.length_unit, a.class_name) == (b.length_unit, b.class_name)
    for name in (
        *("positions", "masses", "fixed", "bars", "bar_lengths"),
        *("tethers", "tether_lengths", "contacts", "contact_lengths"),
    ):
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name))


def test_a_structure_is_read(triangle):
    assert triangle.ids == ["a", "b", "c"]
    assert triangle.class_name == "1-cycle"
    assert triangle.length_unit == "nm"
    assert triangle.masses.tolist() == [12, 1, 1]
    assert triangle.fixed.tolist() == [0, 0, 1]
    assert triangle.bars.tolist() == [[0, 1], [1, 2], [2, 0]]
    assert triangle.bar_lengths.tolist() == [3, 5, 3.5]
    assert triangle.tether_lengths.tolist() == [3.25]
    assert triangle.contacts.tolist() == [[1, 2]]


@pytest.mark.parametrize("digits", [None, 17])
def test_structures_come_back_exactly(tmp_path, triangle, digits):
    path = tmp_path / "out.xml"
    moved = triangle.moved(np.random.default_rng(1).normal(size=(3, 3)) * 1e-5)
    _method_files.write_structure(str(path), moved, digits=digits)
    back, warnings = _method_files.read_structure(str(path))
    assert_same(back, moved)
    assert warnings == []


@pytest.mark.parametrize("name", _core.structure_classes())
def test_what_is_generated_comes_back_exactly(tmp_path, name):
    structure = _core.generate_structure(name, joints=60, seed=3)
    _method_files.write_structure(tmp_path / "s.xml", structure)
    assert_same(_method_files.read_structure(tmp_path / "s.xml")[0], structure)


def test_forces_come_back_exactly(tmp_path, triangle):
    forces = _core.ForceSet(
        np.array([2, 0, 2], dtype=np.int32),
        np.random.default_rng(1).normal(size=(3, 3)),
        max_iterations=77,
        tolerance=1 / 3,
        timestep=0.1,
        structure="a & b.xml",
    )
    _method_files.write_forces(tmp_path / "f.xml", triangle, forces)
    back, warnings = _method_files.read_forces(tmp_path / "f.xml", triangle)
    assert back.joints.tolist() == [2, 0, 2]
    np.testing.assert_array_equal(back.forces, forces.forces)
    assert (back.max_iterations, back.tolerance, back.timestep) == (77, 1 / 3, 0.1)
    assert back.structure == "a & b.xml"
    assert warnings == []


def test_an_order_comes_back_and_resolves(tmp_path, triangle):
    joints, problem = _core.order(triangle.framework(), "bfs_cycle", [1])
    _method_files.write_order(tmp_path / "o.xml", triangle, joints, problem, "b", "bfs_cycle")
    back, marks = _method_files.read_order(tmp_path / "o.xml", triangle)
    np.testing.assert_array_equal(back, joints)
    np.testing.assert_array_equal(marks, problem.astype(bool))
    assert back.dtype == np.int32
    assert marks.dtype == bool

    forces = _core.ForceSet(np.array([1], dtype=np.int32), np.array([[0.1, 0.2, 0.3]]))
    one = _core.resolve_forces(triangle, forces, custom_order=back, custom_problem=marks)
    other = _core.resolve_forces(triangle, forces, order="bfs_cycle")
    assert list(one["iterations"]) == list(other["iterations"])


def test_an_order_of_no_bars_has_its_shapes(tmp_path, triangle):
    (tmp_path / "o.xml").write_text('<order version="1" colour="red"/>')
    warnings = []
    joints, problem = _method_files.read_order(tmp_path / "o.xml", triangle, warnings)
    assert joints.shape == (0, 2)
    assert problem.shape == (0,)
    assert len(warnings) == 1


def test_orders_of_bars_that_do_not_exist_are_refused(tmp_path, triangle):
    pairs = np.array([[0, 7]])
    with pytest.raises(ValueError, match="no bar that joins joint 0 and joint 7"):
        _method_files.write_order(tmp_path / "o.xml", triangle, pairs, np.array([False]))
    assert list(tmp_path.glob("o.xml*")) == []


def test_results_come_back(tmp_path):
    results = {
        "seed": 2**64 - 1,
        "structures": [
            {
                "class": "tree",
                "structure": "tree/001/structure.xml",
                "order": "tree/001/order.xml",
                "forces": ["tree/001/forces/01.xml", "tree/001/forces/02.xml"],
                "techniques": [
                    {
                        "folder": "tree/001/techniques/bfs_tree_1-0",
                        "order": "bfs_tree",
                        "weighting": "1/0",
                    }
                ],
            },
            {
                "class": "grid",
                "structure": "grid/001/structure.xml",
                "order": "",
                "forces": [],
                "techniques": [],
            },
        ],
    }
    _method_files.write_results(tmp_path / "results.xml", results)
    assert _method_files.read_results(tmp_path / "results.xml") == (results, [])


@pytest.mark.parametrize("seed", [-1, 2**64, "one"])
def test_a_seed_is_a_whole_number(tmp_path, seed):
    with pytest.raises(ValueError, match="the seed of a set is a whole number"):
        _method_files.write_results(tmp_path / "r.xml", {"seed": seed, "structures": []})


def test_unknown_attributes_come_as_warnings(tmp_path):
    path = tmp_path / "s.xml"
    path.write_text(TRIANGLE.replace("mass", "weight"))
    structure, warnings = _method_files.read_structure(path)
    assert structure.masses.tolist() == [1, 1, 1]
    assert warnings == [
        f"{path}, line 2: <joint> has the unknown attribute weight, which is ignored"
    ]


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ('x="3"', 'x="nan"', 'line 3: <joint> has x="nan", which is not a finite number'),
        ('"b c"', '"b z"', "line 6: the bar names the joint z, which the structure does not have"),
        ('"1-cycle"', '"tree"', "line 1: the class is said to be tree, but the bars make it 1-cyc"),
        ("<structure", "<!DOCTYPE x>\n<structure", "line 1: a DOCTYPE"),
        ("</structure>", "", "line 10: the file ends before </structure>"),
    ],
)
def test_bad_content_is_a_value_error_with_the_line(tmp_path, old, new, sentence):
    path = tmp_path / "s.xml"
    path.write_text(TRIANGLE.replace(old, new))
    with pytest.raises(ValueError) as error:
        _method_files.read_structure(path)
    assert str(error.value).startswith(f"{path}, {sentence}")


def test_a_missing_file_is_a_value_error(tmp_path):
    with pytest.raises(ValueError, match="none.xml cannot be read: No such file or directory"):
        _method_files.read_structure(tmp_path / "none.xml")


def test_files_are_replaced_by_force_only(tmp_path, triangle):
    path = tmp_path / "triangle.xml"
    with pytest.raises(ValueError, match="exists already; give --force to replace it"):
        _method_files.write_structure(path, triangle)
    assert path.read_text() == TRIANGLE
    _method_files.write_structure(path, triangle, force=True)
    assert path.read_text() != TRIANGLE
    assert stat.S_IMODE(path.stat().st_mode) & 0o444


def test_a_failing_disk_is_a_runtime_error_and_leaves_nothing(tmp_path):
    structure = _core.generate_structure("tree", joints=1000, seed=1)
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, before[1]))
    try:
        with pytest.raises(RuntimeError, match="s.xml cannot be written: File too large"):
            _method_files.write_structure(tmp_path / "s.xml", structure)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, handler)
    assert list(tmp_path.iterdir()) == []


def test_memory_is_a_few_times_the_file(tmp_path):
    """Ten million elements that are refused at the first cost no more than their text."""
    path = tmp_path / "s.xml"
    path.write_text('<structure version="1">' + "<a/>" * 10_000_000)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(ValueError, match="line 1: <a> is unknown"):
        _method_files.read_structure(path)
    after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    assert sys.platform != "linux" or (after - before) * 1024 < 3 * path.stat().st_size
