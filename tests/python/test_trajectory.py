"""Tests for ragdoll.trajectory and ragdoll.reporter: other programs read what we write."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
import warnings

import numpy as np
import openmm
import pytest
from openmm import app, unit

from ragdoll.reporter import TrajectoryReporter
from ragdoll.trajectory import (
    TrajectoryError,
    TrajectoryUsageError,
    TrajectoryWriter,
    check_output,
    joints_topology_json,
    open_trajectory,
)

mdtraj = pytest.importorskip("mdtraj")
VILLIN = os.path.join(os.path.dirname(app.__file__), "data", "test.pdb")


@pytest.fixture(scope="module")
def villin():
    return app.PDBFile(VILLIN)


@pytest.fixture(scope="module")
def frames(villin):
    """Five frames of villin in water, (5, N, 3) float32 in nm."""
    start = villin.getPositions(asNumpy=True).value_in_unit(unit.nanometer)
    wiggle = np.random.default_rng(1).normal(0, 0.01, (5, *start.shape))
    return (start + wiggle).astype(np.float32)


def write(path, topology, frames, **options):
    with TrajectoryWriter(
        path, topology, observables={"iterations": int, "rmsd": float}, **options
    ) as writer:
        for i, positions in enumerate(frames):
            writer.append(positions, 0.002 * i, 10 * i, {"iterations": i, "rmsd": 0.5 * i})
    return path


@pytest.fixture(scope="module")
def written(tmp_path_factory, villin, frames):
    """A file with all that a file can have, except a box."""
    return write(
        tmp_path_factory.mktemp("trajectory") / "villin.h5",
        villin.topology,
        frames,
        parameters={"tolerance": 1e-3, "solver": "block", "axis": np.arange(3)},
        attributes={"seed": np.int64(5), "input_hash": "ab12"},
        framework={"bars": [[0, 1], [1, 2]], "bar_lengths": [0.1, 0.15], "rigid": [True, False]},
        texts={"log": "läuft"},
        author="Ada",
        version="0.1",
    )


def test_what_is_written_is_read(written, villin, frames):
    with open_trajectory(written) as trajectory:
        assert len(trajectory) == 5 and trajectory.atom_count == frames.shape[1]
        np.testing.assert_array_equal(trajectory.positions, frames)
        np.testing.assert_allclose(trajectory.time, 0.002 * np.arange(5), rtol=1e-6)
        assert trajectory.step.tolist() == [0, 10, 20, 30, 40]
        assert trajectory.observables["iterations"].tolist() == [0, 1, 2, 3, 4]
        assert trajectory.observables["iterations"].dtype == np.int64
        assert trajectory.observables["rmsd"].tolist() == [0, 0.5, 1, 1.5, 2]
        assert trajectory.parameters == {"tolerance": 1e-3, "solver": "block", "axis": [0, 1, 2]}
        assert trajectory.attributes == {"seed": 5, "input_hash": "ab12"}
        assert trajectory.texts["log"] == "läuft"
        assert trajectory.framework["bars"].tolist() == [[0, 1], [1, 2]]
        assert trajectory.framework["bar_lengths"].tolist() == [0.1, 0.15]
        assert trajectory.framework["rigid"].tolist() == [1, 0]
        assert trajectory.boxes is None and trajectory.velocities is None
        bonds = [(a.index, b.index) for a, b in villin.topology.bonds()]
        np.testing.assert_array_equal(trajectory.bonds, bonds)


def test_frames_are_read_one_by_one(written, frames):
    trajectory = open_trajectory(written)
    for i, frame in enumerate(trajectory):
        np.testing.assert_array_equal(frame.positions, frames[i])
        assert frame.step == 10 * i
        assert frame.observables == {"iterations": i, "rmsd": 0.5 * i}
    np.testing.assert_array_equal(trajectory[-1].positions, frames[4])
    with pytest.raises(IndexError, match="has 5 frames, frame 5 is not among them"):
        trajectory.frame(5)


def test_openmm_topology_comes_back(written, villin):
    topology = open_trajectory(written).topology
    for ours, theirs in zip(topology.atoms(), villin.topology.atoms(), strict=True):
        assert (ours.name, ours.element) == (theirs.name, theirs.element)
        assert (ours.residue.name, ours.residue.id) == (theirs.residue.name, theirs.residue.id)
        assert ours.residue.chain.id == theirs.residue.chain.id
    assert topology.getNumBonds() == villin.topology.getNumBonds()


def test_bond_orders_and_charges_come_back(tmp_path):
    topology = app.Topology()
    residue = topology.addResidue("FOR", topology.addChain("B"), "12", "A")
    carbon = topology.addAtom("C", app.element.carbon, residue)
    oxygen = topology.addAtom("O", app.element.oxygen, residue, formalCharge=-1)
    site = topology.addAtom("M", None, residue)
    topology.addBond(carbon, oxygen, app.Double, 2)
    topology.addBond(carbon, site)
    path = write(tmp_path / "a.h5", topology, np.zeros((1, 3, 3)))

    read = open_trajectory(path).topology
    first, second = read.bonds()
    assert (first.type, first.order, second.type, second.order) == (app.Double, 2, None, None)
    assert [atom.formalCharge for atom in read.atoms()] == [None, -1, None]
    assert [atom.element for atom in read.atoms()][2] is None
    assert next(read.residues()).insertionCode == "A"
    assert mdtraj.load(path).topology == mdtraj.Topology.from_openmm(topology)


def test_mdtraj_loads_topology_and_coordinates(written, villin, frames):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        loaded = mdtraj.load(written)
    assert loaded.topology == mdtraj.Topology.from_openmm(villin.topology)
    residues = zip(loaded.topology.residues, villin.topology.residues(), strict=True)
    assert all(str(ours.resSeq) == theirs.id for ours, theirs in residues)
    np.testing.assert_array_equal(loaded.xyz, frames)
    np.testing.assert_allclose(loaded.time, 0.002 * np.arange(5), rtol=1e-6)
    assert loaded.unitcell_lengths is None


def test_mdanalysis_reads_the_same_coordinates(written, frames):
    analysis = pytest.importorskip("MDAnalysis")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        universe = analysis.Universe(VILLIN, str(written), format="H5MD")
    assert universe.trajectory.n_frames == 5
    for i, step in enumerate(universe.trajectory):
        np.testing.assert_allclose(step.positions / 10, frames[i], atol=1e-5)
        assert step.time == pytest.approx(0.002 * i)
        assert (step.data["step"], step.data["iterations"]) == (10 * i, i)
        assert step.data["rmsd"] == 0.5 * i


def test_file_is_mdtraj_and_h5md_without_data_twice(written):
    h5py = pytest.importorskip("h5py")
    with h5py.File(written) as file:
        assert file["coordinates"].chunks == (1, file["coordinates"].shape[1], 3)
        assert dict(file.attrs)["conventions"] == "Pande"
        assert file["h5md"].attrs["version"].tolist() == [1, 1]
        assert file["h5md/author"].attrs["name"] == "Ada"
        assert dict(file["h5md/creator"].attrs) == {"name": "ragdoll", "version": "0.1"}
        position = file["particles/trajectory/position"]
        assert position["value"] == file["coordinates"] and position["time"] == file["time"]
        assert file["observables/rmsd/step"] == position["step"]
        assert file["coordinates"].attrs["unit"] == "nm"
        assert list(file["particles/trajectory/box"].attrs["boundary"]) == ["none"] * 3
        group = file["connectivity/bonds"].attrs["particles_group"]
        assert file[group] == file["particles/trajectory"]
        assert file["parameters/vmd_structure/bond_from"][0] == file["connectivity/bonds"][0, 0] + 1


@pytest.mark.skipif(shutil.which("h5dump") is None, reason="h5dump is not installed")
def test_h5dump_reads_the_whole_file(written):
    dumped = subprocess.run(["h5dump", written], capture_output=True, text=True, check=True)
    assert dumped.stderr == "" and 'GROUP "ragdoll"' in dumped.stdout


def test_periodic_files_with_velocities_are_read_by_all(tmp_path, villin, frames):
    box = np.array([[5, 0, 0], [1, 6, 0], [0.5, 1, 7]], dtype=float)
    path = tmp_path / "box.h5"
    with TrajectoryWriter(path, villin.topology, periodic=True, velocities=True) as writer:
        for i, positions in enumerate(frames):
            writer.append(positions, i, i, box=box, velocities=2 * positions)

    trajectory = open_trajectory(path)
    np.testing.assert_allclose(trajectory.boxes, [box] * 5)
    np.testing.assert_array_equal(trajectory.velocities, 2 * frames)
    np.testing.assert_array_equal(trajectory.frame(3).velocities, 2 * frames[3])
    vectors = trajectory.topology.getPeriodicBoxVectors().value_in_unit(unit.nanometer)
    np.testing.assert_allclose(np.array(vectors), box)

    loaded = mdtraj.load(path)
    np.testing.assert_allclose(loaded.unitcell_vectors, [box] * 5, atol=1e-5)
    analysis = pytest.importorskip("MDAnalysis")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        universe = analysis.Universe(VILLIN, str(path), format="H5MD")
    np.testing.assert_allclose(
        universe.trajectory[2].dimensions,
        [*(10 * loaded.unitcell_lengths[2]), *loaded.unitcell_angles[2]],
        rtol=1e-5,
    )
    np.testing.assert_allclose(universe.trajectory[2].velocities / 10, 2 * frames[2], atol=1e-5)


def test_precision_makes_smaller_files_that_err_no_more(tmp_path, frames):
    for name, precision in (("exact.h5", None), ("rounded.h5", 1e-4)):
        count = frames.shape[1]
        with TrajectoryWriter(tmp_path / name, atom_count=count, precision=precision) as writer:
            for i, positions in enumerate(frames):
                writer.append(positions, i, i)
    rounded = open_trajectory(tmp_path / "rounded.h5").positions
    np.testing.assert_allclose(rounded, frames, rtol=0, atol=1e-4)
    assert (tmp_path / "rounded.h5").stat().st_size < 0.8 * (tmp_path / "exact.h5").stat().st_size


def test_structures_that_are_no_molecules_have_joints(tmp_path):
    text = joints_topology_json(["a", "b", "c"], [(0, 1), (1, 2)])
    path = write(tmp_path / "joints.h5", text, np.zeros((2, 3, 3)))
    loaded = mdtraj.load(path)
    assert [atom.name for atom in loaded.topology.atoms] == ["a", "b", "c"]
    assert open_trajectory(path).bonds.tolist() == [[0, 1], [1, 2]]

    # or no topology at all
    with TrajectoryWriter(tmp_path / "bare.h5", atom_count=2, bonds=[(0, 1)]) as writer:
        writer.append(np.zeros((2, 3)), 0, 0)
    bare = open_trajectory(tmp_path / "bare.h5")
    assert bare.topology is None and bare.bonds.tolist() == [[0, 1]]


def test_files_of_mdtraj_are_read(tmp_path, frames):
    whole = mdtraj.load(VILLIN)
    whole.xyz, whole.time = frames[:1], np.array([3.0])
    whole.save_hdf5(str(tmp_path / "theirs.h5"))
    trajectory = open_trajectory(tmp_path / "theirs.h5")
    np.testing.assert_array_equal(trajectory.positions, frames[:1])
    assert trajectory.time.tolist() == [3.0] and trajectory.step.tolist() == [0]
    assert trajectory.topology.getNumAtoms() == frames.shape[1] and trajectory.parameters == {}
    assert len(trajectory.bonds) == whole.topology.n_bonds


# ------------------------------------------------------------------------------------- refusals


def test_refusals_are_usage_errors_of_one_sentence(tmp_path, written):
    with pytest.raises(TrajectoryUsageError) as caught:
        check_output(written)
    assert str(caught.value) == f"{written} exists already; give --force to replace it"
    assert isinstance(caught.value, ValueError) and isinstance(caught.value, TrajectoryError)
    check_output(written, force=True)
    with pytest.raises(TrajectoryUsageError, match="there is no folder .*none; make it first"):
        TrajectoryWriter(tmp_path / "none" / "a.h5", atom_count=1)
    with pytest.raises(TrajectoryUsageError, match="is a folder; give the name of a file in it"):
        check_output(tmp_path)
    with pytest.raises(TrajectoryUsageError, match="there is no file"):
        open_trajectory(tmp_path / "none.h5")
    (tmp_path / "text.h5").write_text("no HDF5")
    with pytest.raises(TrajectoryError, match="text.h5 cannot be read: it is not an HDF5 file"):
        open_trajectory(tmp_path / "text.h5")


def test_frames_that_do_not_fit_are_refused(tmp_path):
    writer = TrajectoryWriter(tmp_path / "a.h5", atom_count=2, observables=["rmsd"])
    with pytest.raises(TrajectoryUsageError, match=r"needs the observables \['rmsd'\]"):
        writer.append(np.zeros((2, 3)), 0, 0)
    with pytest.raises(TrajectoryUsageError, match="has 9 coordinates instead of 6"):
        writer.append(np.zeros((3, 3)), 0, 0, {"rmsd": 1})
    with pytest.raises(TrajectoryUsageError, match="holds <U1, not numbers"):
        TrajectoryWriter(tmp_path / "b.h5", atom_count=2, arrays={"names": ["a", "b"]})
    writer.close()
    assert list(tmp_path.iterdir()) == []


def test_an_error_in_the_run_keeps_what_is_done(tmp_path, frames):
    writer = TrajectoryWriter(tmp_path / "a.h5", atom_count=frames.shape[1])
    with pytest.raises(KeyboardInterrupt), writer:
        writer.append(frames[0], 0, 0)
        raise KeyboardInterrupt
    np.testing.assert_array_equal(open_trajectory(tmp_path / "a.h5").positions, frames[:1])


# ---------------------------------------------------------------------------------- crash safety

CHILD = """
import os, sys, time
import numpy as np
from ragdoll.trajectory import TrajectoryWriter
writer = TrajectoryWriter(sys.argv[1], {topology!r}, segment_seconds=0.05)
for i in range(1000):
    writer.append(np.full((2, 3), i), i, i)
    time.sleep(0.01)
"""


def test_segments_of_a_killed_run_open_in_mdtraj(tmp_path):
    code = CHILD.format(topology=joints_topology_json(["a", "b"], [(0, 1)]))
    child = subprocess.Popen([sys.executable, "-c", code, str(tmp_path / "a.h5")])
    deadline = time.monotonic() + 60
    while len(list(tmp_path.glob("a.*.h5"))) < 3 and time.monotonic() < deadline:
        time.sleep(0.02)
    child.send_signal(signal.SIGKILL)
    child.wait()

    segments = sorted(tmp_path.glob("a.*.h5"))
    assert len(segments) >= 3
    loaded = mdtraj.load([str(name) for name in segments])
    assert loaded.xyz[:, 0, 0].tolist() == list(range(len(loaded)))
    with pytest.raises(TrajectoryUsageError, match="is left from an interrupted run"):
        check_output(tmp_path / "a.h5")
    check_output(tmp_path / "a.h5", force=True)


LIMITED = """
import resource, sys
import numpy as np
from ragdoll.trajectory import TrajectoryError, TrajectoryWriter
writer = TrajectoryWriter(sys.argv[1], atom_count=20000)
writer.append(np.random.default_rng(1).normal(size=(20000, 3)), 0, 0)
resource.setrlimit(resource.RLIMIT_FSIZE, (100000, 100000))
try:
    writer.close()
except TrajectoryError as error:
    print(error)
"""


def test_a_file_size_limit_gives_a_sentence_and_no_stray_file(tmp_path):
    path = str(tmp_path / "a.h5")
    command = [sys.executable, "-c", LIMITED, path]
    child = subprocess.run(command, capture_output=True, text=True, check=True)
    assert child.stdout == f"{path} cannot be written: File too large\n"
    assert child.stderr == "" and list(tmp_path.iterdir()) == []


def test_other_hdf5_libraries_live_in_the_same_process(written):
    path = repr(str(written))
    ours = ["import ragdoll.trajectory", f"ragdoll.trajectory.open_trajectory({path}).positions"]
    h5py = ["import h5py", f"h5py.File({path})['coordinates'][:]"]
    tables = ["import tables", f"tables.open_file({path}).root.coordinates[:]"]
    for code in (ours + h5py + tables + ours, h5py + tables + ours + h5py + tables):
        subprocess.run([sys.executable, "-c", "\n".join(code)], check=True)


# -------------------------------------------------------------------------------------- reporter


class CountingIntegrator(openmm.VerletIntegrator):
    """Stands in for an integrator that resolves constraints."""

    def getIterations(self):
        return 3

    def getBarVisits(self):
        return 12

    def getConverged(self):
        return True

    def getResidual(self):
        return 2.5e-4


def simulation_of(integrator, periodic=False):
    topology = app.Topology()
    residue = topology.addResidue("ARG", topology.addChain())
    system = openmm.System()
    force = openmm.HarmonicBondForce()
    atoms = []
    for i in range(3):
        atoms.append(topology.addAtom(f"A{i}", app.element.argon, residue))
        system.addParticle(40)
    for i in range(2):
        topology.addBond(atoms[i], atoms[i + 1])
        force.addBond(i, i + 1, 0.2, 1000)
    force.setUsesPeriodicBoundaryConditions(periodic)
    system.addForce(force)
    platform = openmm.Platform.getPlatformByName("Reference")
    simulation = app.Simulation(topology, system, integrator, platform)
    simulation.context.setPositions(0.22 * np.arange(9).reshape(3, 3))
    simulation.context.setVelocitiesToTemperature(300, 1)
    return simulation


def test_reporter_works_with_any_integrator(tmp_path):
    simulation = simulation_of(openmm.LangevinMiddleIntegrator(300, 1, 0.002))
    with TrajectoryReporter(tmp_path / "a.h5", 5) as reporter:
        simulation.reporters.append(reporter)
        simulation.step(20)
        last = simulation.context.getState(positions=True).getPositions(asNumpy=True)

    trajectory = open_trajectory(tmp_path / "a.h5")
    assert trajectory.step.tolist() == [5, 10, 15, 20]
    np.testing.assert_allclose(trajectory.time, [0.01, 0.02, 0.03, 0.04], rtol=1e-6)
    np.testing.assert_allclose(
        trajectory.positions[-1], last.value_in_unit(unit.nanometer), atol=1e-6
    )
    assert trajectory.observables == {}
    assert trajectory.parameters["integrator"] == "LangevinMiddleIntegrator"
    assert trajectory.parameters["step_size_ps"] == pytest.approx(0.002)
    assert "LangevinMiddleIntegrator" in trajectory.parameters["integrator_xml"]


def test_reporter_writes_observables_velocities_and_boxes(tmp_path):
    simulation = simulation_of(CountingIntegrator(0.001), periodic=True)
    reporter = TrajectoryReporter(
        tmp_path / "a.h5", 2, velocities=True, parameters={"note": "mine"}, attributes={"seed": 4}
    )
    simulation.reporters.append(reporter)
    simulation.step(4)
    reporter.close()
    reporter.close()

    trajectory = open_trajectory(tmp_path / "a.h5")
    values = {name: all_.tolist() for name, all_ in trajectory.observables.items()}
    assert values == {
        "iterations": [3, 3],
        "bar_visits": [12, 12],
        "converged": [1, 1],
        "residual": [2.5e-4, 2.5e-4],
    }
    assert trajectory.observables["bar_visits"].dtype == np.int64
    assert trajectory.parameters["note"] == "mine" and trajectory.attributes == {"seed": 4}
    np.testing.assert_allclose(trajectory.boxes, [2 * np.eye(3)] * 2)
    velocities = simulation.context.getState(velocities=True).getVelocities(asNumpy=True)
    np.testing.assert_allclose(trajectory.velocities[-1], np.array(velocities), atol=1e-5)


def test_reporter_refuses_before_the_simulation_starts(tmp_path, written):
    with pytest.raises(TrajectoryUsageError, match="exists already"):
        TrajectoryReporter(written, 10)
    with pytest.raises(TrajectoryUsageError, match="must be at least 1"):
        TrajectoryReporter(tmp_path / "a.h5", 0)


def test_reporter_closes_when_it_is_collected(tmp_path):
    simulation = simulation_of(openmm.VerletIntegrator(0.001))
    simulation.reporters.append(TrajectoryReporter(tmp_path / "a.h5", 1))
    simulation.step(3)
    simulation.reporters.clear()
    assert len(open_trajectory(tmp_path / "a.h5")) == 3
    assert json.loads(open_trajectory(tmp_path / "a.h5").topology_json)["bonds"] == [[0, 1], [1, 2]]
