"""Tolerances as lengths: on the command line, in functions and in the integrator."""

import copy
import pickle

import numpy as np
import openmm
import pytest
from openmm import unit

import ragdoll
from ragdoll import _core

h5py = pytest.importorskip("h5py")


def bar_errors(path):
    """|d - L| of all bars in all frames, angstrom, as the file has them."""
    with h5py.File(path) as file:
        x = file["coordinates"][:].astype(float)
        bars, lengths = file["ragdoll/framework/bars"][:], file["ragdoll/framework/bar_lengths"][:]
    return 10 * np.abs(np.linalg.norm(x[:, bars[:, 1]] - x[:, bars[:, 0]], axis=2) - lengths)


@pytest.mark.parametrize("solver", ["ordered", "newton", "auto"])
def test_sampled_bars_keep_an_absolute_tolerance_in_the_file(
    run_ragdoll, dry_villin, tmp_path, solver
):
    path = tmp_path / "a.h5"
    run = run_ragdoll(
        *["sample", dry_villin, "-o", path, "--frames", 2, "--stride", 2, "--json"],
        *["--tolerance-angstrom", 0.01, "--solver", solver],
    )
    assert run.code == 0, run.stderr
    largest = bar_errors(path).max()
    assert 1e-4 < largest <= 0.01
    report = run.json
    assert report["geometry"]["bar_max_angstrom"] == pytest.approx(largest, abs=1e-6)
    assert report["geometry"]["tolerance_violations"] == 0
    assert report["geometry"]["contact_violations"] == 0
    assert report["tolerance"] is None
    assert report["tolerance_angstrom"] == 0.01
    assert report["solver_asked"] == solver
    assert report["solver"].split()[0] in ("ordered", "newton", "block")
    assert 0 < report["residual_angstrom"] <= 0.01
    with h5py.File(path) as file:
        assert '"tolerance_angstrom": 0.01' in file["ragdoll/parameters"].asstr()[()]


def test_a_relative_tolerance_is_the_default(sampled_villin):
    report = sampled_villin.report
    assert report["tolerance"] == 0.01
    assert report["tolerance_angstrom"] is None
    assert report["geometry"]["tolerance_violations"] == 0
    assert report["precision"] == "double"


def test_a_small_absolute_tolerance_is_said_to_be_beyond_the_file(
    run_ragdoll, dry_villin, tmp_path
):
    run = run_ragdoll(
        *["sample", dry_villin, "-o", tmp_path / "a.h5", "--frames", 1, "--stride", 1],
        *["--tolerance-angstrom", 1e-6, "--max-iterations", 5],
    )
    assert run.code == 3
    assert "single precision" in run.stderr


@pytest.fixture(scope="module")
def ring(run_ragdoll, tmp_path_factory):
    """A structure with a cycle and forces on it, as files."""
    folder = tmp_path_factory.mktemp("ring")
    structure, forces = folder / "s.xml", folder / "f.xml"
    asked = ["--class", "1-cycle", "--joints", 20, "--seed", 1, "-o", structure]
    assert run_ragdoll("generate", "structure", *asked).code == 0
    asked = [structure, "--count", 5, "--seed", 1, "-o", forces]
    assert run_ragdoll("generate", "forces", *asked).code == 0
    return structure, forces


@pytest.mark.parametrize("solver", _core.solver_names())
def test_resolve_takes_an_absolute_tolerance_and_every_solver(run_ragdoll, ring, solver):
    structure, forces = ring
    run = run_ragdoll(
        *["resolve", structure, "--forces", forces, "--solver", solver, "--json"],
        *["--tolerance-angstrom", 1e-4],
    )
    assert run.code == 0, run.stderr
    assert run.json["tolerance"] is None
    assert run.json["tolerance_angstrom"] == 1e-4
    assert all(0 < value <= 1e-4 for value in run.json["residual_angstrom"])
    assert run.json["solver"] == solver
    assert run.json["solver_chosen"]


def test_resolve_refuses_two_tolerances_and_unknown_units(run_ragdoll, ring, tmp_path):
    structure, forces = ring
    command = ["resolve", structure, "--forces", forces]
    run = run_ragdoll(*command, "--tolerance", 0.1, "--tolerance-angstrom", 0.1)
    assert run.code == 2
    assert "exclude each other" in run.sentence
    run = run_ragdoll(*command, "--tolerance-angstrom", 0)
    assert run.code == 2
    run = run_ragdoll(*command, "--precision", "half")
    assert run.code == 2
    odd = tmp_path / "odd.xml"
    odd.write_text(structure.read_text().replace('length-unit="none"', 'length-unit="ell"'))
    run = run_ragdoll("resolve", odd, "--forces", forces, "--tolerance-angstrom", 0.1)
    assert run.code == 2
    assert "not in ell" in run.sentence


def test_lengths_of_a_structure_count_in_its_unit():
    x = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]])
    bars = np.array([[0, 1], [1, 2]], dtype=np.int32)
    for name, per_angstrom in (("nm", 0.1), ("none", 0.1), ("angstrom", 1.0)):
        structure = _core.Structure(["a", "b", "c"], x, bars, length_unit=name)
        done = ragdoll.resolve(structure, [("c", (0.5, 0, 0))], tolerance_angstrom=0.02)
        lengths = np.linalg.norm(np.diff(done.positions, axis=0), axis=1)
        error = np.abs(lengths - 1).max()
        assert error <= 0.02 * per_angstrom + 1e-12
        assert done.residual_angstrom[0] == pytest.approx(error / per_angstrom)


def stretched(**options):
    """An integrator after a step that began with a bar of 1 nm stretched to 1.5 nm."""
    framework = ragdoll.Framework(
        masses=np.ones(2), bars=np.array([[0, 1]], dtype=np.int32), bar_lengths=np.ones(1)
    )
    system = openmm.System()
    system.addParticle(1.0)
    system.addParticle(1.0)
    integrator = ragdoll.RagdollIntegrator(framework=framework, **options)
    context = openmm.Context(system, integrator, openmm.Platform.getPlatformByName("Reference"))
    context.setPositions([[0.0, 0.0, 0.0], [1.5, 0.0, 0.0]])
    integrator.step(1)
    x = context.getState(positions=True).getPositions(asNumpy=True)._value
    return integrator, np.linalg.norm(x[1] - x[0])


def test_an_integrator_holds_an_absolute_tolerance():
    integrator, length = stretched(absoluteTolerance=6 * unit.angstrom)
    assert length == 1.5
    assert integrator.getIterations() == 0
    integrator, length = stretched(absoluteTolerance=1e-5)
    assert abs(length - 1) <= 1e-5
    assert integrator.getResidualLength() <= 1e-5 * unit.nanometer
    assert integrator.getChosenSolver() in _core.solver_names()


def test_an_integrators_copies_keep_tolerance_and_precision():
    integrator = ragdoll.RagdollIntegrator(
        absoluteTolerance=0.02 * unit.angstrom, precision="single", useMassWeights=True
    )
    for other in (copy.copy(integrator), pickle.loads(pickle.dumps(integrator))):
        view = ragdoll.RagdollIntegrator.cast(other)
        assert view.getAbsoluteTolerance().value_in_unit(unit.angstrom) == pytest.approx(0.02)
        assert view.getPrecision() == "single"
        assert view.getUseMassWeights()


def test_a_resolver_takes_one_tolerance():
    framework = ragdoll.Framework(
        masses=np.ones(2), bars=np.array([[0, 1]], dtype=np.int32), bar_lengths=np.ones(1)
    )
    with pytest.raises(ValueError, match="not both"):
        _core.Resolver(framework, tolerance=0.1, absolute_tolerance=0.1)
    x = np.array([[0.0, 0, 0], [1.2, 0, 0]])
    relative, what = _core.worst_violation(framework, x)
    length, same = _core.worst_violation(framework, x, absolute=True)
    assert relative == pytest.approx(length) == pytest.approx(0.2)
    assert what == same
