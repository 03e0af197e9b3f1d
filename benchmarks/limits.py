"""What the machine allows, estimated: a number beside each row, and how it comes about.

A core of 3 to 4 GHz with 512-bit vectors is taken. benchmarks/README.md has the sums in words.
"""

from programs import Records
from rows import first_molecule, select

SCALAR_NS = 4.0  # a bar's correction where corrections overlap: root and division, doubles
VECTOR_NS = 0.5  # the same for each of 16 bars, or conformers, in single precision
FLOPS_PER_JOINT = 1000.0  # of a Newton iteration: four 3x3 blocks of factor for each joint
SCALAR_FLOPS_PER_NS = 12.0  # two multiply-adds a cycle
VECTOR_FLOPS_PER_NS = 100.0  # one multiply-add of 16 floats a cycle
NORMAL_NS = 5.0  # a normal number
BYTES_PER_ATOM, BYTES_PER_NS = 200.0, 10.0  # read and written by set-up; of memory


def limits_of(records: Records) -> dict[str, float]:
    """Limits in the units of the rows."""
    name = first_molecule(records, "network")
    molecule = select(records, "network", network="molecule", molecule=name)[:1]
    bonds = select(records, "network", network="bonds", molecule=name)[:1]
    setup = max(
        (r["joints"] for r in select(records, "setup", part="openmm")),
        default=0,
    )
    limits = {
        "block_iterations": 1.0,
        "small_cycles_p50": 0.3,
        "small_cycles_p99": 0.6,
        "forced_joint_visits": 17.0,
        "forced_joint_time": 2.0,
        "newton_iterations": 4.0,
        "newton_linear": 1.0,
        "inverted": 0.0,
    }
    if molecule:
        joints = molecule[0]["joints"]
        for tolerance, iterations in (("1e-3", 4), ("1e-2", 2)):
            flops = joints * iterations * FLOPS_PER_JOINT
            limits[f"protein_{tolerance}_scalar"] = 1e-6 * flops / SCALAR_FLOPS_PER_NS
            limits[f"protein_{tolerance}_ensemble"] = 1e-6 * flops / VECTOR_FLOPS_PER_NS
        perturbation = 1e-6 * 3 * joints * NORMAL_NS
        contacts = 1e-6 * 3 * 9 * joints * VECTOR_NS  # passes, pairs for each joint
        limits["dhfr_conformer"] = limits["protein_1e-2_ensemble"] + perturbation + contacts
    if bonds:
        passes = 8 * bonds[0]["bars"]
        limits["ccma_single"] = 1e-6 * passes * SCALAR_NS
        limits["ccma_ensemble"] = 1e-6 * passes * VECTOR_NS
    if setup:
        limits["setup"] = 1e-6 * setup * BYTES_PER_ATOM / BYTES_PER_NS
    return limits
