"""SampleOptions: how to sample, and what of it makes no sense."""

import math
from dataclasses import dataclass, field, replace

from . import _core
from .constraint_options import ConstraintOptions
from .errors import InputError
from .molecule import Molecule
from .motion_options import PLAIN, MotionOptions
from .quality_limits import QualityLimits
from .thermal_network import FEWEST_RESIDUES, has_fluctuations

_MOST = 2**31 - 1  # of whatever is counted
_LARGEST_STEP = 100.0  # angstrom; larger than that, nothing is ever resolved
_TOLERANCE = 0.01  # relative, unless one is given
#: stride and size of random moves, where they are not given: of "thermal", and of all others
_THERMAL_STRIDE, _STRIDE = 1, 10
_THERMAL_STEP, _STEP = 0.05, 0.1


@dataclass(frozen=True)
class SampleOptions:
    """How to sample. Lengths in the units that the names say.

    Attributes:
        frames: how many frames to write; with ``replicas``, of each.
        stride: accepted steps from one frame to the next; None: 1 of "thermal", else 10.
        step_angstrom: deviation per coordinate, or radius (ball), of the random part of moves;
            None: 0.05 of "thermal", else 0.1.
        perturbation: None: "thermal", or "gaussian" for molecules of fewer than ten residues and
            for a ``platform`` other than "Reference"; "thermal", "gaussian", "ball" (also "random", FRODA's), "momentum", "hinge", "modes",
            "steer" or "away".
        motion: what belongs to one perturbation or the other.
        order, weighting, solver, max_iterations: of the resolution.
        tolerance: how far a constraint may be violated, relative to its length; 0.01 unless
            ``tolerance_angstrom`` is given.
        tolerance_angstrom: in its place, largest |d - L| of any constraint.
        precision: of the numbers that solvers work with, "double" or "single".
        contacts: whether atoms keep apart.
        contact_scale: of the sum of van der Waals radii; at 0.89 heavy atoms overlap by less than
            0.4 angstrom, which is what measures of quality call a clash.
        planarity_degree: how far planar units may turn or bend from the input.
        constraints: what holds beside covalent bonds and contacts; None: nothing.
        seed: decides all random numbers; 0 to 2^31 - 1.
        platform: OpenMM platform, "Reference" or "CPU"; without a meaning for replicas.
        replicas: independent walkers, side by side in core; replica k does what a run with
            ``seed`` + k does. None: one run by RagdollIntegrator.
        threads: at most so many work on replicas; None: as many as there are cores. The results do
            not depend on it.
        limits: frames below this quality are counted and not written.
        allow_low_quality: write them all the same.
    """

    frames: int = 20
    stride: int | None = None
    step_angstrom: float | None = None
    perturbation: str | None = None
    order: str = "bfs_cycle"
    weighting: str = ".5/.5"
    solver: str = "auto"
    tolerance: float | None = None
    max_iterations: int = 10000
    contacts: bool = True
    contact_scale: float = 0.89
    planarity_degree: float = 10.0
    seed: int = 0
    platform: str = "Reference"
    tolerance_angstrom: float | None = None
    precision: str = "double"
    replicas: int | None = None
    threads: int | None = None
    motion: MotionOptions = MotionOptions()
    limits: QualityLimits = QualityLimits()
    allow_low_quality: bool = False
    constraints: ConstraintOptions | None = field(default_factory=ConstraintOptions)

    def __post_init__(self) -> None:
        """Give the tolerance its default, and FRODA's moves their name."""
        if self.perturbation == "random":
            object.__setattr__(self, "perturbation", "ball")
        if self.tolerance is None and self.tolerance_angstrom is None:
            object.__setattr__(self, "tolerance", _TOLERANCE)

    def settled(self, molecule: Molecule) -> tuple["SampleOptions", list[str]]:
        """These with what was left open decided for a molecule, and what there is to say of it."""
        perturbation, notes = self.perturbation, []
        if perturbation is None:
            few = not has_fluctuations(molecule)
            plain = few or self.platform != SampleOptions.platform
            perturbation = "gaussian" if plain else "thermal"
            if few:
                notes.append(
                    f"Fewer than {FEWEST_RESIDUES} residues of a polymer: atoms move at random "
                    "(--perturbation gaussian), not by thermal modes."
                )
        thermal = perturbation == "thermal"
        stride = (_THERMAL_STRIDE if thermal else _STRIDE) if self.stride is None else self.stride
        step = (_THERMAL_STEP if thermal else _STEP) if self.step_angstrom is None else None
        decided = {
            "perturbation": perturbation,
            "stride": stride,
            "step_angstrom": self.step_angstrom if step is None else step,
        }
        return replace(self, **decided), notes

    def check(self) -> None:
        """Raise InputError at the first option that makes no sense."""
        self._check_numbers()
        if self.perturbation == "none":
            raise InputError("Sampling needs a --perturbation: thermal, gaussian or ball, say.")
        try:
            _core.check_order(self.order)
            _core.check_weighting(self.weighting)
            _core.check_motion(self._perturbation)
            _core.check_precision(self.precision)
        except ValueError as error:
            raise InputError(f"{error}.") from None
        if self.solver not in _core.solver_names():
            known = ", ".join(_core.solver_names())
            raise InputError(f"solver '{self.solver}' is not known; choose one of: {known}.")
        if self.platform not in ("Reference", "CPU"):
            raise InputError(
                f"platform '{self.platform}' has no kernels of ragdoll; choose Reference or CPU."
            )
        self.motion.check(self._perturbation)
        self.limits.check()
        self._check_replicas()
        if self.constraints is not None:
            self.constraints.check()

    def _check_numbers(self) -> None:
        for name in ("frames", "stride", "max_iterations", "replicas", "threads"):
            value = getattr(self, name)
            if value is not None and not 1 <= value <= _MOST:
                raise InputError(f"{_flag(name)} must be from 1 to {_MOST}, not {value}.")
        if self.tolerance is not None and self.tolerance_angstrom is not None:
            raise InputError("--tolerance and --tolerance-angstrom exclude each other; give one.")
        for name in ("step_angstrom", "tolerance", "tolerance_angstrom"):
            value = getattr(self, name)
            if value is not None and not (math.isfinite(value) and value > 0):
                raise InputError(f"{_flag(name)} must be a positive number, not {value}.")
        if self.step_angstrom is not None and self.step_angstrom > _LARGEST_STEP:
            raise InputError(
                f"--step-angstrom must be at most {_LARGEST_STEP:g}, not {self.step_angstrom:g}."
            )
        if not 0 <= self.seed <= _MOST:
            raise InputError(f"--seed must be a whole number from 0 to {_MOST}, not {self.seed}.")

    @property
    def _perturbation(self) -> str:
        """The one that was asked for, or what it is for most molecules."""
        if self.perturbation is not None:
            return self.perturbation
        return "thermal" if self.platform == SampleOptions.platform else "gaussian"

    @property
    def by_walkers(self) -> bool:
        """Whether core's walkers do the run, not RagdollIntegrator."""
        return (
            self.replicas is not None
            or self._perturbation not in PLAIN
            or bool(self.motion.symmetric)
        )

    def _check_replicas(self) -> None:
        if self.replicas is None and self.threads is not None:
            raise InputError("--threads is for --replicas; one run has one thread.")
        if not self.by_walkers:
            return
        if self.platform != SampleOptions.platform:
            what = "Replicas walk" if self.replicas else f"Perturbation {self._perturbation} works"
            raise InputError(f"{what} without a platform of OpenMM; leave out --platform.")
        if self.replicas is None:
            return
        if self.seed + self.replicas - 1 > _MOST:
            raise InputError(
                f"The seed of the last replica would be {self.seed + self.replicas - 1}, beyond "
                f"{_MOST}; give a smaller --seed or fewer --replicas."
            )


def _flag(name: str) -> str:
    return "--" + name.replace("_", "-")
