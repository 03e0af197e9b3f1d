"""Close a hinge protein: a path from one conformation to another within the constraints.

    hinge.py START END [--chain A] [--target-chain A]

Without files: adenylate kinase, open and closed, which MDAnalysisTests brings.
"""

import argparse
from pathlib import Path

import matplotlib
import numpy as np

import ragdoll

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("start", nargs="?", help="PDB or mmCIF file")
parser.add_argument("end", nargs="?", help="PDB or mmCIF file")
parser.add_argument("--chain", action="append", help="of the start")
parser.add_argument("--target-chain", action="append", help="of the end")
parser.add_argument("-o", "--output", default=Path(__file__).with_name("hinge.png"), type=Path)
given = parser.parse_args()
if given.end is None:
    from MDAnalysisTests.datafiles import PDB_closed, PDB_small

    given.start, given.end = PDB_small, PDB_closed

start = ragdoll.Molecule.from_file(given.start, chains=given.chain)
end = ragdoll.Molecule.from_file(given.end, chains=given.target_chain)
path = given.output.with_suffix(".h5")
report = ragdoll.target(start, end, path, force=True)
print(
    f"{report.frames} frames in {report.cpu_seconds:.0f} s: the RMSD from the end went from "
    f"{report.rmsd_start_angstrom:.2f} to {report.rmsd_end_angstrom:.2f} angstrom"
)
quality = ragdoll.quality(path)
core = quality.frames["ramachandran_core_percent"]
print(
    f"Ramachandran core {core.mean():.1f} %, outliers "
    f"{quality.mean['ramachandran_outlier_percent']:.1f} %, bonds within "
    f"{quality.worst['bond_max_angstrom']:.3f} angstrom"
)


def superposed(moving, fixed, chosen=slice(None)):
    """The moving points laid over the fixed ones by those chosen."""
    a, b = moving[chosen].mean(axis=0), fixed[chosen].mean(axis=0)
    u, _, vt = np.linalg.svd((moving[chosen] - a).T @ (fixed[chosen] - b))
    u[:, 2] *= np.sign(np.linalg.det(u @ vt))
    return (moving - a) @ u @ vt + b


with ragdoll.open_trajectory(path) as trajectory:
    alphas = [atom.index for atom in trajectory.topology.atoms() if atom.name == "CA"]
    frames = 10 * trajectory.positions[:, alphas].astype(float)  # angstrom
    to_end = 10 * trajectory.observables["rmsd"]
off = np.array([superposed(frame, frames[0]) - frames[0] for frame in frames])
to_start = np.sqrt((off**2).sum(axis=2).mean(axis=1))

# lay all frames over the part that moves least: the better half, found again and again
still = np.ones(len(alphas), dtype=bool)
for _ in range(10):
    last = superposed(frames[-1], frames[0], still)
    moved = np.linalg.norm(last - frames[0], axis=1)
    still = moved <= np.median(moved)
frames = np.array([superposed(frame, frames[0], still) for frame in frames])

# look along the axis that shows most of the motion
motion = frames[-1] - frames[0]
_, _, axes = np.linalg.svd(motion - motion.mean(axis=0), full_matrices=False)
body = frames[0] - frames[0].mean(axis=0)
across = np.linalg.svd(body - np.outer(body @ axes[0], axes[0]), full_matrices=False)[2][0]
x, y = frames @ across, frames @ axes[0]

figure = plt.figure(figsize=(9, 4.5), dpi=120, layout="constrained")
grid = figure.add_gridspec(2, 2, width_ratios=(3, 2))
trace = figure.add_subplot(grid[:, 0], aspect="equal")
shown = np.linspace(0, len(frames) - 1, 12).astype(int)
for k in shown:
    trace.plot(x[k], y[k], color=plt.cm.viridis(k / len(frames)), linewidth=1)
trace.set_title("CA trace, violet: start, yellow: end", fontsize=10)
trace.set_xlabel("Å")
distance = figure.add_subplot(grid[0, 1])
distance.plot(to_start, label="from the start")
distance.plot(to_end, label="from the end")
distance.set_ylabel("RMSD / Å")
distance.legend()
plausible = figure.add_subplot(grid[1, 1], sharex=distance)
plausible.plot(core, label="core")
plausible.plot(quality.frames["ramachandran_outlier_percent"], label="outliers")
plausible.set_ylabel("residues / %")
plausible.set_xlabel("frame")
plausible.legend()
figure.savefig(given.output)
