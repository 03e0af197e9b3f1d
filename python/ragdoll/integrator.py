"""RagdollIntegrator and FrameworkForce: ragdoll's objects as OpenMM's Python API knows them.

Both are Python subclasses of OpenMM's own classes around C++ objects of ragdoll's plugin, so that
OpenMM's methods (step, Context, Simulation, copy, pickle, XmlSerializer) are the ones that run.
"""

import numpy as np
import openmm
from openmm import unit

from ragdoll import plugin

_openmm = plugin.load()
_FORCE_UNIT = unit.kilojoule_per_mole / unit.nanometer


def _number(value, in_unit) -> float:
    """A Quantity in a unit, or the plain number."""
    return float(value.value_in_unit(in_unit) if unit.is_quantity(value) else value)


def _view(cls, thing, find):
    """The same C++ object as an object of ragdoll's class; `find` raises TypeError if it is not."""
    find(int(thing.this))
    view = cls.__new__(cls)
    view.this = thing.this
    return view


def _vectors(values, in_unit) -> np.ndarray:
    """Numbers, Quantities or lists of Quantities as an array of doubles."""
    if unit.is_quantity(values):
        values = values.value_in_unit(in_unit)
    elif not isinstance(values, np.ndarray):
        values = [v.value_in_unit(in_unit) if unit.is_quantity(v) else v for v in values]
    return np.ascontiguousarray(values, dtype=float)


class RagdollIntegrator(openmm.Integrator):
    """Moves the joints of a framework geometrically: break, resolve, iterate.

    A step predicts new positions by Verlet (forces of :meth:`setJointForce`, and the System's if
    ``useSystemForces``) and a random perturbation, moves the joints until every constraint of the
    framework is within tolerance, and infers velocities from the displacements. Particles of mass
    0 never move; the System's constraints are resolved as bars. Positions and velocities are the
    Context's, so that checkpoints, states and reporters work as with any integrator.

    An object that :meth:`openmm.CompoundIntegrator.addIntegrator` took over stays usable for as
    long as the CompoundIntegrator lives, and an integrator's copies share nothing with it.

    Parameters
    ----------
    stepSize : time, default 0.001 ps
    framework : ragdoll.Framework, optional
        one joint for each particle of the System; it may be set later, before the first step
    order : str
        which bar is resolved when: "random", "bfs_tree", "dfs_tree", "bfs_cycle", "dfs_cycle",
        "bfs_reverse", "dfs_reverse", "bfs_adapt", "bfs_random", "bfs_active" or "bfs_worst"
    weighting : str
        how an error is shared, the far end first: ".5/.5", ".75/.25", "1/0"
    solver : str
        name of a solver, or "auto"
    tolerance : float
        largest relative violation of a constraint
    absoluteTolerance : length, default 0
        largest violation of a constraint as a length, in the place of ``tolerance``; 0: that one
    precision : str
        of the numbers that solvers "ordered" and "newton" work with: "double" or "single"
    useMassWeights : bool
        whether solver "newton" moves heavy joints less
    maxIterations : int
        iterations after which a step is not converged
    verletScope : str
        which joints Verlet moves: "affected" by a force, or "all"
    useSystemForces : bool
        whether forces of the System act on the joints
    perturbation : str
        "none", "gaussian" or "ball"
    perturbationSize : length, default 0.01 nm
        deviation of the normal distribution, or radius of the ball
    seed : int
        of random numbers; 0 is a seed as any other
    rejectUnresolved : bool
        whether a step that does not converge, or inverts a chirality centre, is taken back

    Raises
    ------
    openmm.OpenMMException
        on wrong values, here and in every setter
    """

    def __init__(
        self,
        stepSize=0.001 * unit.picosecond,
        framework=None,
        *,
        order="bfs_cycle",
        weighting=".5/.5",
        solver="auto",
        tolerance=1e-3,
        absoluteTolerance=0.0 * unit.nanometer,
        precision="double",
        useMassWeights=False,
        maxIterations=10000,
        verletScope="affected",
        useSystemForces=False,
        perturbation="none",
        perturbationSize=0.01 * unit.nanometer,
        seed=0,
        rejectUnresolved=False,
    ):
        step = _number(stepSize, unit.picosecond)
        self.this = openmm.XmlSerializer.deserialize(
            f'<Integrator type="RagdollIntegrator" version="1" stepSize="{step!r}"/>'
        ).this
        self.setFramework(framework)
        self.setOrder(order)
        self.setWeighting(weighting)
        self.setSolver(solver)
        self.setConstraintTolerance(tolerance)
        self.setAbsoluteTolerance(absoluteTolerance)
        self.setPrecision(precision)
        self.setUseMassWeights(useMassWeights)
        self.setMaxIterations(maxIterations)
        self.setVerletScope(verletScope)
        self.setUseSystemForces(useSystemForces)
        self.setPerturbation(perturbation)
        self.setPerturbationSize(perturbationSize)
        self.setRandomNumberSeed(seed)
        self.setRejectUnresolved(rejectUnresolved)

    @property
    def _ragdoll(self):
        """The C++ object, for this call: OpenMM may give ``this`` another one."""
        return _openmm.integrator_at(int(self.this))

    @classmethod
    def cast(cls, integrator):
        """An integrator that OpenMM gave back as a plain Integrator, with ragdoll's methods again.

        Both are the same C++ object, which lives as long as the owner of the one that was given.

        Raises
        ------
        TypeError
            if it is no RagdollIntegrator
        """
        return _view(cls, integrator, _openmm.integrator_at)

    # ---- parameters

    def setFramework(self, framework):
        """Set the framework; the next step uses it. None takes it away."""
        self._ragdoll.setFramework(framework)

    def getFramework(self):
        """The framework, or None."""
        return self._ragdoll.getFramework()

    def setOrder(self, order):
        """Set which bar is resolved when."""
        self._ragdoll.setOrder(order)

    def getOrder(self):
        """Name of the order."""
        return self._ragdoll.getOrder()

    def setWeighting(self, weighting):
        """Set how a bar's error is shared between its ends, the far end first: ".75/.25"."""
        self._ragdoll.setWeighting(weighting)

    def getWeighting(self):
        """The weighting as text."""
        return self._ragdoll.getWeighting()

    def setSolver(self, solver):
        """Set the solver by name, or "auto"."""
        self._ragdoll.setSolver(solver)

    def getSolver(self):
        """Name of the solver, as it was set."""
        return self._ragdoll.getSolver()

    def setMaxIterations(self, iterations):
        """Set the iterations after which a step is not converged: at least 1."""
        self._ragdoll.setMaxIterations(iterations)

    def getMaxIterations(self):
        """Iterations after which a step is not converged."""
        return self._ragdoll.getMaxIterations()

    def setAbsoluteTolerance(self, length):
        """Set how far any constraint may be violated, as a length (nm); 0: relative tolerance."""
        self._ragdoll.setAbsoluteTolerance(_number(length, unit.nanometer))

    def getAbsoluteTolerance(self):
        """How far any constraint may be violated (nm); 0: the relative tolerance holds."""
        return self._ragdoll.getAbsoluteTolerance() * unit.nanometer

    def setPrecision(self, precision):
        """Set the precision that "ordered" and "newton" work in: "double" or "single"."""
        self._ragdoll.setPrecision(precision)

    def getPrecision(self):
        """The precision that "ordered" and "newton" work in."""
        return self._ragdoll.getPrecision()

    def setUseMassWeights(self, use):
        """Set whether solver "newton" moves heavy joints less than light ones."""
        self._ragdoll.setUseMassWeights(use)

    def getUseMassWeights(self):
        """Whether solver "newton" moves heavy joints less than light ones."""
        return self._ragdoll.getUseMassWeights()

    def setVerletScope(self, scope):
        """Set which joints Verlet moves: "affected" or "all"."""
        self._ragdoll.setVerletScope(scope)

    def getVerletScope(self):
        """Which joints Verlet moves: "affected" or "all"."""
        return self._ragdoll.getVerletScope()

    def setUseSystemForces(self, use):
        """Set whether the System's forces, of the integration force groups, act on the joints."""
        self._ragdoll.setUseSystemForces(use)

    def getUseSystemForces(self):
        """Whether the System's forces act on the joints."""
        return self._ragdoll.getUseSystemForces()

    def setPerturbation(self, kind):
        """Set the random displacements: "none", "gaussian" or "ball"."""
        self._ragdoll.setPerturbation(kind)

    def getPerturbation(self):
        """Kind of the random displacements."""
        return self._ragdoll.getPerturbation()

    def setPerturbationSize(self, size):
        """Set the deviation or radius of the random displacements (nm)."""
        self._ragdoll.setPerturbationSize(_number(size, unit.nanometer))

    def getPerturbationSize(self):
        """Deviation or radius of the random displacements (nm)."""
        return self._ragdoll.getPerturbationSize() * unit.nanometer

    def setRandomNumberSeed(self, seed):
        """Set the seed. The same seed, parameters and step number give the same numbers."""
        self._ragdoll.setRandomNumberSeed(seed)

    def getRandomNumberSeed(self):
        """The seed of random numbers."""
        return self._ragdoll.getRandomNumberSeed()

    def setRejectUnresolved(self, reject):
        """Set whether a step that does not converge or inverts a centre is taken back."""
        self._ragdoll.setRejectUnresolved(reject)

    def getRejectUnresolved(self):
        """Whether a step that does not converge or inverts a centre is taken back."""
        return self._ragdoll.getRejectUnresolved()

    # ---- forces for the next step

    def setJointForce(self, joint, force):
        """Set the force on one joint (kJ/mol/nm) for the next step; others that are set stay."""
        self._ragdoll.setJointForce(joint, *_vectors(force, _FORCE_UNIT))

    def setJointForces(self, forces):
        """Set the forces on all joints (njoint, 3; kJ/mol/nm) for the next step."""
        self._ragdoll.setJointForces(_vectors(forces, _FORCE_UNIT))

    def getJointForces(self):
        """Forces that wait for the next step: a Quantity of an array (njoint, 3)."""
        return self._ragdoll.getJointForces() * _FORCE_UNIT

    def clearJointForces(self):
        """Forget the forces that wait for the next step."""
        self._ragdoll.clearJointForces()

    # ---- about the last step

    def getIterations(self):
        """Passes over the order that the last step took."""
        return self._ragdoll.getIterations()

    def getBarVisits(self):
        """Bars that the last step visited in its iterations."""
        return self._ragdoll.getBarVisits()

    def getConverged(self):
        """Whether every constraint was within tolerance after the last step."""
        return self._ragdoll.getConverged()

    def getResidual(self):
        """Largest relative violation of a constraint after the last step."""
        return self._ragdoll.getResidual()

    def getResidualLength(self):
        """Largest violation of a constraint after the last step, as a length (nm)."""
        return self._ragdoll.getResidualLength() * unit.nanometer

    def getChosenSolver(self):
        """The solver that worked in the last step: what "auto" chose."""
        return self._ragdoll.getChosenSolver()

    def getAccepted(self):
        """Whether the last step was kept; see :meth:`setRejectUnresolved`."""
        return self._ragdoll.getAccepted()

    def getInvertedCentres(self):
        """Chirality centres that the last step ended with on the wrong side."""
        return self._ragdoll.getInvertedCentres()

    def getStopReason(self):
        """Why the solver stopped, in words."""
        return self._ragdoll.getStopReason()

    def getWorstConstraint(self):
        """The most violated constraint in words, if the last step did not converge."""
        return self._ragdoll.getWorstConstraint()

    def getAttemptedSteps(self):
        """Steps taken since the Context was created."""
        return self._ragdoll.getAttemptedSteps()

    def getRejectedSteps(self):
        """Steps of these that were taken back."""
        return self._ragdoll.getRejectedSteps()


class FrameworkForce(openmm.Force):
    """Tells OpenMM which particles a framework holds together; it has no force and no energy.

    With it in the System, ``enforcePeriodicBox=True`` moves whole molecules, and the System's XML
    carries the framework. It works on every platform.

    Parameters
    ----------
    framework : ragdoll.Framework, optional
        one joint for each particle of the System; it may be set later, before a Context is created
    usesPeriodicBoundaryConditions : bool
        whether it makes the System periodic, if no other Force does
    """

    def __init__(self, framework=None, usesPeriodicBoundaryConditions=False):
        self.this = openmm.XmlSerializer.deserialize(
            '<Force type="FrameworkForce" version="1"/>'
        ).this
        self.setFramework(framework)
        self.setUsesPeriodicBoundaryConditions(usesPeriodicBoundaryConditions)

    @property
    def _ragdoll(self):
        """The C++ object, for this call: OpenMM may give ``this`` another one."""
        return _openmm.force_at(int(self.this))

    @classmethod
    def cast(cls, force):
        """A force that OpenMM gave back as a plain Force, with ragdoll's methods again.

        Raises
        ------
        TypeError
            if it is no FrameworkForce
        """
        return _view(cls, force, _openmm.force_at)

    def setFramework(self, framework):
        """Set the framework; a Context that exists already keeps the molecules that it has."""
        self._ragdoll.setFramework(framework)

    def getFramework(self):
        """The framework, or None."""
        return self._ragdoll.getFramework()

    def setUsesPeriodicBoundaryConditions(self, periodic):
        """Set whether this Force makes the System periodic, if no other does."""
        self._ragdoll.setUsesPeriodicBoundaryConditions(periodic)
