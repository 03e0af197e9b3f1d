"""TargetOptions: how to go from one structure to another."""

import math
from dataclasses import dataclass, field

from . import _core
from .constraint_options import ConstraintOptions
from .errors import InputError

_MOST = 2**31 - 1  # of whatever is counted
_VARIANTS = ("least-work", "random")


@dataclass(frozen=True)
class TargetOptions:
    """How to go towards a target. Lengths in angstrom.

    Attributes:
        variant: "least-work", the projections alone; or "random", with random moves of the
            momentum kind in every step, so that each seed has a path of its own.
        step_angstrom: by which the cap on the RMSD is lowered at a time.
        random_angstrom: deviation per coordinate of random moves.
        spacing_angstrom: how far a CA goes from one frame to the next, about; never above 0.5.
        arrive_angstrom: CA RMSD at which the target counts as reached.
        retries: times that random moves free the structure where it is stuck.
        tolerance_angstrom: largest |d - L| of any constraint.
        contact_scale: of the sum of van der Waals radii that atoms keep from each other.
        heavy_allowance_angstrom: how much closer pairs of N, O, F and S may come.
        planarity_degree: how far planar units may turn or bend from the start.
        mend: whether backbone torsions that are implausible, and atoms that are too close in the
            start, are mended on the way; what is implausible in the end is then no target.
        constraints: what holds beside covalent bonds and contacts, as far as both ends have it;
            None: nothing.
        solver, max_iterations: of the resolution.
        seed: decides all random numbers; 0 to 2^31 - 1.
    """

    variant: str = "least-work"
    step_angstrom: float = 0.1
    random_angstrom: float = 0.03
    spacing_angstrom: float = 0.3
    arrive_angstrom: float = 0.2
    retries: int = 12
    tolerance_angstrom: float = 0.01
    contact_scale: float = 0.9
    heavy_allowance_angstrom: float = 0.4
    planarity_degree: float = 20.0
    mend: bool = True
    constraints: ConstraintOptions | None = field(default_factory=ConstraintOptions)
    solver: str = "auto"
    max_iterations: int = 100
    seed: int = 0

    def check(self) -> None:
        """Raise InputError at the first option that makes no sense."""
        if self.variant not in _VARIANTS:
            raise InputError(
                f"variant '{self.variant}' is not known; choose one of: {', '.join(_VARIANTS)}."
            )
        for name, most in (
            ("step_angstrom", 1.0),
            ("random_angstrom", 1.0),
            ("spacing_angstrom", 0.5),
            ("arrive_angstrom", 100.0),
            ("tolerance_angstrom", 1.0),
        ):
            value = getattr(self, name)
            if not (math.isfinite(value) and 0 < value <= most):
                flag = "--" + name.replace("_", "-")
                raise InputError(f"{flag} must be above 0 and at most {most:g}, not {value}.")
        if self.constraints is not None:
            self.constraints.check()
        if not 0 <= self.retries <= _MOST:
            raise InputError(f"--retries must be from 0 to {_MOST}, not {self.retries}.")
        if not 1 <= self.max_iterations <= _MOST:
            raise InputError(f"--max-iterations must be from 1 to {_MOST}.")
        if not 0 <= self.seed <= _MOST:
            raise InputError(f"--seed must be a whole number from 0 to {_MOST}, not {self.seed}.")
        if self.solver not in _core.solver_names():
            known = ", ".join(_core.solver_names())
            raise InputError(f"solver '{self.solver}' is not known; choose one of: {known}.")
