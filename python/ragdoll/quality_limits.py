"""QualityLimits: below which quality a frame is not written."""

import math
from dataclasses import dataclass, fields

from . import _core
from .errors import InputError
from .quality_terms import QualityTerms

_ANGSTROM = 10.0  # per nm


@dataclass(frozen=True)
class QualityLimits:
    """The most of each that a frame may have to be written; None: not limited.

    What is called growth or loss is against the input's own figure, so that a model with faults can
    be sampled. The measures are those of QualityReport.

    Attributes:
        bond_rms_angstrom, angle_rms_degree: RMS of bonds and angles against the input.
        clash_growth: clashes per 1000 heavy atoms more than in the input.
        outlier_growth_percent: Ramachandran outliers more than in the input.
        core_loss_percent: residues less in the core of the Ramachandran plot.
        omega_growth_percent: peptide bonds more that are off by over 30 degrees.
        inverted_centres: centres of another hand than in the input.
        excess_angstrom: by which any upper bound of the framework is exceeded.
    """

    bond_rms_angstrom: float | None = 0.05
    angle_rms_degree: float | None = 5.0
    clash_growth: float | None = 10.0
    outlier_growth_percent: float | None = 10.0
    core_loss_percent: float | None = None
    omega_growth_percent: float | None = 2.0
    inverted_centres: int | None = 0
    excess_angstrom: float | None = None

    def check(self) -> None:
        """Raise InputError at the first limit that makes no sense."""
        for one in fields(self):
            value = getattr(self, one.name)
            if value is not None and not (math.isfinite(value) and value >= 0):
                flag = "--max-" + one.name.replace("_", "-")
                raise InputError(f"{flag} must be a number from 0 on, not {value}.")

    def judge(self, terms: QualityTerms) -> _core.QualityJudge:
        """What judges frames of a molecule by these limits."""
        limits = {
            "bond_rms": _scaled(self.bond_rms_angstrom, _ANGSTROM),
            "angle_rms": _scaled(self.angle_rms_degree),
            "clash_growth": _scaled(self.clash_growth),
            "outlier_growth": _scaled(self.outlier_growth_percent, 100),
            "core_loss": _scaled(self.core_loss_percent, 100),
            "omega_growth": _scaled(self.omega_growth_percent, 100),
            "inverted_centres": _scaled(self.inverted_centres),
            "excess": _scaled(self.excess_angstrom, _ANGSTROM),
        }
        return _core.QualityJudge(terms.check, **limits)


def _scaled(limit: float | None, unit: float = 1.0) -> float:
    return math.inf if limit is None else limit / unit
