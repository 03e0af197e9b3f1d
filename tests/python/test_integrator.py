"""RagdollIntegrator and FrameworkForce through OpenMM's Python API."""

import copy
import io
import math
import pickle
import threading
import time

import mdtraj
import numpy as np
import openmm
import pytest
from openmm import app, unit

from ragdoll import Framework, FrameworkForce, RagdollIntegrator, plugin

PLATFORMS = ["Reference", "CPU"]
BAR = 0.15


def framework_of(count, bars, lengths, fixed=None):
    """The one place that knows how a Framework is made from arrays."""
    return Framework(
        masses=np.full(count, 12.0),
        bars=np.asarray(bars, dtype=np.int32).reshape(-1, 2),
        bar_lengths=np.asarray(lengths, dtype=float),
        fixed=None if fixed is None else np.asarray(fixed, dtype=np.uint8),
    )


def chain(count):
    bars = [(joint - 1, joint) for joint in range(1, count)]
    return framework_of(count, bars, [BAR] * len(bars))


def straight(count):
    positions = np.zeros((count, 3))
    positions[:, 0] = BAR * np.arange(count)
    return positions


def particles(count):
    system = openmm.System()
    for _ in range(count):
        system.addParticle(12.0)
    return system


def topology_of(count):
    topology = app.Topology()
    residue = topology.addResidue("CHN", topology.addChain())
    atoms = [topology.addAtom(f"C{joint}", app.element.carbon, residue) for joint in range(count)]
    for first, second in zip(atoms, atoms[1:], strict=False):
        topology.addBond(first, second)
    return topology


def positions_of(context, **options):
    state = context.getState(positions=True, **options)
    return state.getPositions(asNumpy=True).value_in_unit(unit.nanometer)


def lengths_of(positions):
    return np.linalg.norm(np.diff(positions, axis=0), axis=1)


@pytest.fixture(params=PLATFORMS)
def platform(request):
    try:
        return openmm.Platform.getPlatformByName(request.param)
    except openmm.OpenMMException:
        pytest.skip(f"OpenMM has no {request.param} platform here")


def context_of(integrator, platform, count, system=None):
    context = openmm.Context(system or particles(count), integrator, platform)
    context.setPositions(straight(count))
    return context


# ---- in a simulation


def pulled_simulation(platform, count=10):
    """A chain whose last atom a CustomExternalForce pulls upwards."""
    system = particles(count)
    pull = openmm.CustomExternalForce("-400*y")
    pull.addParticle(count - 1)
    system.addForce(pull)
    integrator = RagdollIntegrator(
        0.002 * unit.picosecond,
        chain(count),
        useSystemForces=True,
        order="random",
        perturbation="gaussian",
        perturbationSize=0.001,
        tolerance=1e-4,
    )
    simulation = app.Simulation(topology_of(count), system, integrator, platform)
    simulation.context.setPositions(straight(count))
    return simulation


def test_a_simulation_with_reporters_pulls_the_chain_and_keeps_its_bars(platform, tmp_path):
    simulation = pulled_simulation(platform)
    table = io.StringIO()
    columns = {"step": True, "time": True, "potentialEnergy": True, "temperature": True}
    simulation.reporters.append(app.StateDataReporter(table, 10, **columns))
    simulation.reporters.append(app.XTCReporter(str(tmp_path / "chain.xtc"), 10))
    simulation.step(50)
    simulation.reporters.clear()

    assert simulation.currentStep == 50
    assert len(table.getvalue().splitlines()) == 6
    frames = mdtraj.load(
        str(tmp_path / "chain.xtc"), top=mdtraj.Topology.from_openmm(simulation.topology)
    )
    assert frames.n_frames == 5
    positions = positions_of(simulation.context)
    assert positions[-1, 1] > 0.02
    assert np.all(np.abs(lengths_of(positions) - BAR) <= 1e-4 * BAR + 1e-12)
    assert simulation.integrator.getConverged()


def test_a_simulations_integrator_is_the_object_that_it_was_given(platform):
    simulation = pulled_simulation(platform)
    assert isinstance(simulation.integrator, RagdollIntegrator)
    assert simulation.context.getIntegrator() is simulation.integrator


def test_a_checkpoint_continues_bit_for_bit(platform, tmp_path):
    simulation = pulled_simulation(platform)
    simulation.step(7)
    simulation.saveCheckpoint(str(tmp_path / "chain.chk"))
    simulation.step(13)
    expected = positions_of(simulation.context)

    restarted = pulled_simulation(platform)
    restarted.loadCheckpoint(str(tmp_path / "chain.chk"))
    assert restarted.integrator.getAttemptedSteps() == 7
    restarted.step(13)
    assert np.array_equal(positions_of(restarted.context), expected)


def test_a_saved_state_continues_bit_for_bit_with_its_joint_forces(platform, tmp_path):
    simulation = pulled_simulation(platform)
    simulation.step(7)
    simulation.integrator.setJointForce(0, (0, 0, 3000))
    simulation.saveState(str(tmp_path / "chain.xml"))
    simulation.step(13)
    expected = positions_of(simulation.context)

    restarted = pulled_simulation(platform)
    restarted.loadState(str(tmp_path / "chain.xml"))
    restarted.step(13)
    assert np.array_equal(positions_of(restarted.context), expected)


def test_reinitializing_with_its_state_kept_continues_bit_for_bit(platform):
    simulation = pulled_simulation(platform)
    simulation.step(3)
    checkpoint = simulation.context.createCheckpoint()
    simulation.step(5)
    expected = positions_of(simulation.context)
    simulation.context.loadCheckpoint(checkpoint)
    simulation.context.reinitialize(preserveState=True)
    simulation.step(5)
    assert np.array_equal(positions_of(simulation.context), expected)


def test_it_steps_within_a_compound_integrator_and_stays_usable(platform):
    ragdoll = RagdollIntegrator(0.002, chain(2))
    compound = openmm.CompoundIntegrator()
    compound.addIntegrator(ragdoll)
    compound.addIntegrator(openmm.VerletIntegrator(0.001))
    context = context_of(compound, platform, 2)
    ragdoll.setJointForce(1, (0, 900, 0))
    compound.step(2)
    assert ragdoll.getAttemptedSteps() == 2
    assert positions_of(context)[1, 1] > 0
    again = RagdollIntegrator.cast(compound.getIntegrator(0))
    assert again.getAttemptedSteps() == 2
    with pytest.raises(TypeError):
        RagdollIntegrator.cast(compound.getIntegrator(1))


def test_a_step_releases_the_interpreter_to_other_threads():
    count = 2000
    bars = [(joint - 1, joint) for joint in range(1, count)] + [(0, count - 1)]
    impossible = framework_of(count, bars, [BAR] * (count - 1) + [BAR * count * 2])
    integrator = RagdollIntegrator(0.002, impossible, maxIterations=10000)
    context = context_of(integrator, openmm.Platform.getPlatformByName("Reference"), count)
    ticks, done = 0, threading.Event()

    def tick():
        nonlocal ticks
        while not done.is_set():
            ticks += 1
            time.sleep(0.001)

    ticker = threading.Thread(target=tick)
    ticker.start()
    before, start = ticks, time.perf_counter()
    integrator.step(1)
    during, seconds = ticks - before, time.perf_counter() - start
    done.set()
    ticker.join()
    assert context.getStepCount() == 1
    assert not integrator.getConverged()
    assert during > 50 * seconds


# ---- copies


def test_copies_pickles_and_xml_keep_parameters_framework_and_class():
    integrator = RagdollIntegrator(
        0.003,
        chain(4),
        order="dfs_reverse",
        weighting="1/0",
        solver="ordered",
        tolerance=1e-5,
        maxIterations=17,
        verletScope="all",
        useSystemForces=True,
        perturbation="ball",
        perturbationSize=0.3 * unit.angstrom,
        seed=-5,
        rejectUnresolved=True,
    )
    integrator.note = "kept"
    from_xml = RagdollIntegrator.cast(
        openmm.XmlSerializer.deserialize(openmm.XmlSerializer.serialize(integrator))
    )
    copies = [copy.copy(integrator), copy.deepcopy(integrator)]
    assert all(other.note == "kept" for other in copies)
    for other in [*copies, pickle.loads(pickle.dumps(integrator)), from_xml]:
        assert type(other) is RagdollIntegrator
        assert other.getStepSize() == 0.003 * unit.picosecond
        assert other.getOrder() == "dfs_reverse"
        assert other.getWeighting() == "1/0"
        assert other.getSolver() == "ordered"
        assert other.getConstraintTolerance() == 1e-5
        assert other.getMaxIterations() == 17
        assert other.getVerletScope() == "all"
        assert other.getUseSystemForces()
        assert other.getPerturbation() == "ball"
        assert math.isclose(other.getPerturbationSize().value_in_unit(unit.nanometer), 0.03)
        assert other.getRandomNumberSeed() == -5
        assert other.getRejectUnresolved()
        assert np.array_equal(other.getFramework().bars, integrator.getFramework().bars)
        assert np.array_equal(other.getFramework().bar_lengths, [BAR] * 3)


def test_a_copy_steps_on_its_own(platform):
    integrator = RagdollIntegrator(0.002, chain(3))
    twin = copy.deepcopy(integrator)
    contexts = [context_of(each, platform, 3) for each in (integrator, twin)]
    twin.setJointForce(2, (0, 5000, 0))
    twin.step(1)
    integrator.step(1)
    assert positions_of(contexts[0])[2, 1] == 0
    assert positions_of(contexts[1])[2, 1] > 0


# ---- parameters and forces


def test_it_can_be_made_without_arguments_and_given_a_framework_later(platform):
    integrator = RagdollIntegrator()
    assert integrator.getStepSize() == 0.001 * unit.picosecond
    assert integrator.getFramework() is None
    context = context_of(integrator, platform, 3)
    framework = chain(3)
    integrator.setFramework(framework)
    integrator.step(1)
    assert context.getStepCount() == 1
    assert integrator.getFramework() is framework
    assert integrator.getStopReason() == "nothing broken"


def test_units_are_taken_and_given(platform):
    integrator = RagdollIntegrator(2 * unit.femtosecond, chain(2))
    assert integrator.getStepSize() == 0.002 * unit.picosecond
    integrator.setPerturbationSize(0.2 * unit.angstrom)
    assert integrator.getPerturbationSize().unit == unit.nanometer
    kilocalories = unit.kilocalorie_per_mole / unit.angstrom
    integrator.setJointForce(1, [0, 1, 0] * kilocalories)
    waiting = integrator.getJointForces().value_in_unit(unit.kilojoule_per_mole / unit.nanometer)
    assert np.allclose(waiting, [[0, 0, 0], [0, 41.84, 0]])
    integrator.setJointForces(np.ones((2, 3)) * kilocalories)
    assert np.allclose(integrator.getJointForces().value_in_unit(kilocalories), 1)


def test_joint_forces_act_for_one_step(platform):
    integrator = RagdollIntegrator(0.01, framework_of(2, [], []))
    context = context_of(integrator, platform, 2)
    forces = np.zeros((2, 3))
    forces[1, 2] = 120
    integrator.setJointForces(forces)
    integrator.step(4)
    assert np.allclose(positions_of(context) - straight(2), [[0, 0, 0], [0, 0, 1e-3]], atol=1e-12)
    assert not integrator.getJointForces().any()


def test_fixed_joints_stay_and_velocities_are_displacements_over_the_step(platform):
    integrator = RagdollIntegrator(0.002, framework_of(2, [(0, 1)], [BAR], fixed=[1, 0]))
    context = context_of(integrator, platform, 2)
    integrator.setJointForce(1, (0, 1e5, 0))
    integrator.step(1)
    moved = positions_of(context) - straight(2)
    velocities = context.getState(velocities=True).getVelocities(asNumpy=True)
    in_unit = unit.nanometer / unit.picosecond
    assert np.array_equal(moved[0], [0, 0, 0])
    assert np.allclose(velocities.value_in_unit(in_unit), moved / 0.002)


@pytest.mark.parametrize(
    ("setter", "value"),
    [
        ("setOrder", "sideways"),
        ("setWeighting", "2/0"),
        ("setSolver", "magic"),
        ("setConstraintTolerance", 0),
        ("setMaxIterations", 0),
        ("setVerletScope", "some"),
        ("setPerturbation", "shake"),
        ("setPerturbationSize", -1),
        ("setJointForces", np.zeros((3, 3))),
    ],
)
def test_wrong_values_are_refused_in_a_sentence(setter, value):
    integrator = RagdollIntegrator(0.001, chain(2))
    with pytest.raises(openmm.OpenMMException, match=r"\w+ \w+"):
        getattr(integrator, setter)(value)


def test_wrong_shapes_and_types_are_refused():
    integrator = RagdollIntegrator(0.001, chain(2))
    with pytest.raises(TypeError):
        integrator.setFramework("chain")
    with pytest.raises((TypeError, ValueError)):
        integrator.setJointForces(np.zeros((2, 2)))
    with pytest.raises((TypeError, ValueError)):
        integrator.setJointForce(0, (1, 2))


def test_a_step_without_positions_or_framework_or_of_the_wrong_size_is_refused(platform):
    integrator = RagdollIntegrator()
    context = openmm.Context(particles(3), integrator, platform)
    with pytest.raises(openmm.OpenMMException, match="positions have not been set"):
        integrator.step(1)
    context.setPositions(straight(3))
    with pytest.raises(openmm.OpenMMException, match="no framework"):
        integrator.step(1)
    integrator.setFramework(chain(2))
    with pytest.raises(openmm.OpenMMException, match="2 joints, but the System has 3 particles"):
        integrator.step(1)


# ---- FrameworkForce


def periodic_chain_system(with_force):
    """Three atoms across the face of a 2 nm box."""
    system = particles(3)
    system.setDefaultPeriodicBoxVectors((2, 0, 0), (0, 2, 0), (0, 0, 2))
    if with_force:
        system.addForce(FrameworkForce(chain(3), usesPeriodicBoundaryConditions=True))
    return system


@pytest.mark.parametrize("with_force", [True, False])
def test_molecules_are_wrapped_as_a_whole_with_a_framework_force(platform, with_force):
    system = periodic_chain_system(with_force)
    assert system.usesPeriodicBoundaryConditions() == with_force
    integrator = RagdollIntegrator(0.001, chain(3))
    context = openmm.Context(system, integrator, platform)
    context.setPositions(straight(3) + [3.8, 0.5, 0.5])
    integrator.step(1)
    wrapped = positions_of(context, enforcePeriodicBox=True)
    assert np.allclose(lengths_of(wrapped), BAR, atol=1e-3) == with_force
    assert 0 <= wrapped[:, 0].mean() < 2


def test_a_simulation_reports_whole_molecules_with_a_framework_force(tmp_path):
    system = periodic_chain_system(with_force=True)
    integrator = RagdollIntegrator(0.001, chain(3))
    reference = openmm.Platform.getPlatformByName("Reference")
    topology = topology_of(3)
    simulation = app.Simulation(topology, system, integrator, reference)
    simulation.context.setPositions(straight(3) + [3.8, 0.5, 0.5])
    simulation.reporters.append(app.DCDReporter(str(tmp_path / "chain.dcd"), 1))
    simulation.step(1)
    simulation.reporters.clear()
    frames = mdtraj.load(str(tmp_path / "chain.dcd"), top=mdtraj.Topology.from_openmm(topology))
    assert np.allclose(lengths_of(frames.xyz[0]), BAR, atol=1e-3)
    assert frames.xyz[0, 0, 0] < 2


def test_a_system_and_its_copies_carry_the_framework():
    system = periodic_chain_system(with_force=True)
    xml = openmm.XmlSerializer.serialize(system)
    for other in (copy.deepcopy(system), openmm.XmlSerializer.deserialize(xml)):
        force = FrameworkForce.cast(other.getForce(0))
        assert force.usesPeriodicBoundaryConditions()
        assert np.array_equal(force.getFramework().bars, chain(3).bars)
    with pytest.raises(TypeError):
        other.addForce(openmm.CMMotionRemover())
        FrameworkForce.cast(other.getForce(1))


def test_a_framework_force_belongs_to_its_system_and_copies_keep_its_class():
    force = FrameworkForce(chain(3))
    twin = copy.deepcopy(force)
    assert type(twin) is FrameworkForce
    assert twin.getFramework().joint_count == 3
    system = particles(3)
    system.addForce(force)
    with pytest.raises(Exception, match="does not own"):
        system.addForce(force)
    force.setFramework(None)
    reference = openmm.Platform.getPlatformByName("Reference")
    with pytest.raises(openmm.OpenMMException, match="no framework"):
        openmm.Context(system, openmm.VerletIntegrator(0.001), reference)


# ---- the plugin


def test_loading_the_plugin_again_changes_nothing():
    before = plugin.loaded_libraries()
    plugin.load()
    assert plugin.loaded_libraries() == before
    assert any("libOpenMMRagdollReference" in path for path in before)
    assert all(isinstance(failure, str) for failure in plugin.load_failures())


def test_another_version_of_openmm_is_refused_in_a_sentence(monkeypatch):
    monkeypatch.setattr(openmm.Platform, "getOpenMMVersion", staticmethod(lambda: "9.0"))
    with pytest.raises(ImportError, match="OpenMM 9.0 is installed"):
        plugin.load()
