"""Let one loop move while the rest of the protein stays in place.

    loop.py FILE FIRST LAST [--chain A]

Without a file: the flap of HIV-1 protease, residues 43 to 58 of chain A, from MDAnalysisTests.
"""

import argparse
from pathlib import Path

import matplotlib
import numpy as np

import ragdoll
from ragdoll.user_constraints import UserConstraint

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("file", nargs="?", help="PDB or mmCIF file")
parser.add_argument("first", nargs="?", type=int, default=43, help="residue number")
parser.add_argument("last", nargs="?", type=int, default=58, help="residue number")
parser.add_argument("--chain", default="A")
parser.add_argument("--frames", type=int, default=60)
parser.add_argument("-o", "--output", default=Path(__file__).with_name("loop.png"), type=Path)
given = parser.parse_args()
if given.file is None:
    from importlib.resources import files

    given.file = str(files("MDAnalysisTests") / "data" / "1hvr.pdb")

options = ragdoll.PrepareOptions(chains=(given.chain,), heterogens="drop")
prepared = ragdoll.prepare(given.file, options=options)
print(*prepared.found(), *prepared.done, sep="\n")
molecule = prepared.molecule

# all but the loop is fixed; the loop keeps its own hydrogen bonds, and loses those to the rest
rest = UserConstraint("fix", f"not resid {given.first}:{given.last}")
path = given.output.with_suffix(".h5")
report = ragdoll.sample(
    molecule,
    path,
    ragdoll.SampleOptions(
        frames=given.frames,
        perturbation="momentum",
        seed=1,
        constraints=ragdoll.ConstraintOptions(hbonds=False, hydrophobic=False, user=(rest,)),
    ),
    force=True,
)
print(f"{report.frames} frames, {100 * report.rejected_share:.0f} % of the steps rejected")

residues = list(molecule.topology.residues())
atoms = list(molecule.topology.atoms())
alphas = [atom.index for atom in atoms if atom.name == "CA"]
numbers = np.array([int(atoms[index].residue.id) for index in alphas])
in_loop = (numbers >= given.first) & (numbers <= given.last)
start = 10 * molecule.positions[alphas]
with ragdoll.open_trajectory(path) as trajectory:
    frames = 10 * trajectory.positions[:, alphas].astype(float)  # angstrom
moved = np.linalg.norm(frames - start, axis=2)
print(
    f"the loop moves by up to {moved[:, in_loop].max():.1f} angstrom, the rest by "
    f"{moved[:, ~in_loop].max():.3f}"
)

# look along the axis that the loop moves least in
motion = (frames[:, in_loop] - start[in_loop]).reshape(-1, 3)
axes = np.linalg.svd(motion, full_matrices=False)[2]
figure, (trace, fluctuation) = plt.subplots(
    1, 2, figsize=(9, 4.2), dpi=120, layout="constrained", width_ratios=(3, 2)
)
trace.plot(*(start @ axes[:2].T).T, color="black", linewidth=1.2)
widened = in_loop | np.roll(in_loop, 1) | np.roll(in_loop, -1)
for k, frame in enumerate(frames):
    colour = plt.cm.viridis(k / len(frames))
    trace.plot(*(frame[widened] @ axes[:2].T).T, color=colour, linewidth=0.7)
trace.set_aspect("equal")
trace.set_title("CA trace, black: input", fontsize=10)
trace.set_xlabel("Å")
fluctuation.plot(numbers, np.sqrt((moved**2).mean(axis=0)))
fluctuation.axvspan(given.first, given.last, color="tab:orange", alpha=0.2)
fluctuation.set_xlabel("residue")
fluctuation.set_ylabel("RMS from the input / Å")
figure.savefig(given.output)
