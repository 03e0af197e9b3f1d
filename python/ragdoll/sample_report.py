"""SampleReport: what a run of sampling did, and the geometry of its frames."""

from dataclasses import asdict, dataclass, field
from typing import Any

_ANGSTROM = 10.0  # per nm


@dataclass
class ReplicaReport:
    """What one replica did."""

    replica: int
    seed: int
    frames: int = 0
    steps: int = 0
    rejected_steps: int = 0
    iterations_mean: float = 0.0
    rmsd_last_angstrom: float | None = None
    last_rejection: str = ""
    low_frames: int = 0


@dataclass
class SampleReport:
    """What a run did; as_dict() is the object that ``ragdoll sample --json`` prints.

    ``geometry`` is measured on the written frames against the input. ``solver_asked`` is the
    option, ``solver`` what worked: with "auto", its choice. ``residual`` and ``residual_angstrom``
    are the largest of the written frames, as the solver saw them before they were rounded to the
    file's precision. ``constraints`` counts bars, tethers, contacts and volumes by kind.
    ``low_frames`` counts the frames that were not written because their quality was below the
    limits, by the measure; ``quality`` is that of the frames that were (see QualityReport).
    ``replicas`` is empty for a run without replicas; the counts are over all.
    """

    atoms: int
    joints: int
    bars: int
    contacts: int
    chirality_centres: int
    class_: str
    cycle_rank: int
    components: int
    constraints: dict[str, Any] = field(default_factory=dict)
    tolerance: float | None = None
    tolerance_angstrom: float | None = None
    precision: str = "double"
    solver_asked: str = "auto"
    solver: str = ""
    frames: int = 0
    frames_asked: int = 0
    steps: int = 0
    rejected_steps: int = 0
    rejected_share: float = 0.0
    iterations_mean: float = 0.0
    iterations_p99: float = 0.0
    residual: float = 0.0
    residual_angstrom: float = 0.0
    seconds: float = 0.0
    frames_per_second: float = 0.0
    geometry: dict[str, Any] = field(default_factory=dict)
    quality: dict[str, Any] = field(default_factory=dict)
    low_frames: dict[str, int] = field(default_factory=dict)
    last_fault: str = ""
    interrupted: bool = False
    last_rejection: str = ""
    replicas: list[ReplicaReport] = field(default_factory=list)
    instructions: str = ""
    lanes: int = 1
    threads: int = 1
    notes: list[str] = field(default_factory=list)
    missing_atoms: dict[str, list[str]] = field(default_factory=dict)
    parameters: dict[str, Any] = field(default_factory=dict)

    def as_dict(self) -> dict[str, Any]:
        """The report as plain values; the key of ``class_`` is ``class``."""
        return {name.removesuffix("_"): value for name, value in asdict(self).items()}


def _lengths(worst: dict[str, float]) -> dict[str, float]:
    """By how much the worst tether or contact of each kind is beyond its bound; 0: none is."""
    return {kind: value * _ANGSTROM for kind, value in worst.items()}


def geometry_dict(measured: dict[str, Any]) -> dict[str, Any]:
    """What GeometryCheck measured, with lengths in angstrom."""
    return {
        "bond_rms_angstrom": measured["bond_rms"] * _ANGSTROM,
        "bond_max_angstrom": measured["bond_max"] * _ANGSTROM,
        "bond_max_relative": measured["bond_max_relative"],
        "bar_max_angstrom": measured["bar_max"] * _ANGSTROM,
        "bar_max_relative": measured["bar_max_relative"],
        "tolerance_violations": measured["tolerance_violations"],
        "angle_rms_degree": measured["angle_rms_degree"],
        "omega_max_deviation_degree": measured["omega_max_deviation_degree"],
        "contact_violations": measured["contact_violations"],
        "contact_worst_angstrom": measured["contact_worst"] * _ANGSTROM,
        "tether_excess_angstrom": _lengths(measured["tether_worst"]),
        "contact_excess_angstrom": _lengths(measured["held_contact_worst"]),
        "chirality_inverted": measured["chirality_inverted"],
        "planar_inverted": measured["planar_inverted"],
        "rmsd_last_angstrom": measured["rmsd_last"] * _ANGSTROM,
        "rmsd_max_angstrom": measured["rmsd_max"] * _ANGSTROM,
    }
