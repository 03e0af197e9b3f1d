"""A protein with its ligand: what the ligand holds.

    complex.py FILE LIGAND

Without a file: HIV-1 protease with the cyclic urea XK263 (residue XK2), from MDAnalysisTests.
"""

import argparse
from pathlib import Path

import matplotlib
import numpy as np

import ragdoll

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("file", nargs="?", help="PDB or mmCIF file")
parser.add_argument("ligand", nargs="?", default="XK2", help="name of its residue")
parser.add_argument("--frames", type=int, default=20)
parser.add_argument("-o", "--output", default=Path(__file__).with_name("complex.png"), type=Path)
given = parser.parse_args()
if given.file is None:
    from importlib.resources import files

    given.file = str(files("MDAnalysisTests") / "data" / "1hvr.pdb")


def sampled(heterogens, name):
    """The prepared molecule and its frames, angstrom."""
    prepared = ragdoll.prepare(given.file, options=ragdoll.PrepareOptions(heterogens=heterogens))
    path = given.output.with_name(f"{name}.h5")
    options = ragdoll.SampleOptions(frames=given.frames, perturbation="momentum", seed=1)
    report = ragdoll.sample(prepared.molecule, path, options, force=True)
    with ragdoll.open_trajectory(path) as trajectory:
        frames = 10 * trajectory.positions.astype(float)
    quality = report.quality["mean"]
    print(
        f"{name}: {report.frames} frames, {quality['clashes_per_1000']:.1f} clashes per 1000 atoms"
    )
    return prepared.molecule, frames


def fluctuations(molecule, frames):
    """RMSF of the CA atoms after superposition on their mean, angstrom."""
    alphas = [atom.index for atom in molecule.topology.atoms() if atom.name == "CA"]
    x = frames[:, alphas] - frames[:, alphas].mean(axis=1, keepdims=True)
    mean = x[0]
    for _ in range(5):
        for k in range(len(x)):
            u, _, vt = np.linalg.svd(x[k].T @ mean)
            u[:, 2] *= np.sign(np.linalg.det(u @ vt))
            x[k] = x[k] @ u @ vt
        mean = x.mean(axis=0)
    return np.sqrt(((x - mean) ** 2).sum(axis=2).mean(axis=0))


bound, with_ligand = sampled("keep", "bound")
free, without = sampled("drop", "free")

atoms = list(bound.topology.atoms())
ligand = [atom.index for atom in atoms if atom.residue.name == given.ligand]
if not ligand:
    raise SystemExit(f"{given.file} has no residue {given.ligand}; name the ligand's residue.")
heavy = [index for index in ligand if bound.elements[index] > 1]
alphas = [atom.index for atom in atoms if atom.name == "CA"]
at_ligand = 10 * bound.positions[heavy]


def nearest(residue):
    """How far the ligand is, angstrom."""
    own = 10 * bound.positions[[atom.index for atom in residue.atoms()]]
    return np.linalg.norm(own[:, None] - at_ligand[None], axis=2).min()


near = np.array([nearest(atoms[index].residue) for index in alphas])
one, other = fluctuations(bound, with_ligand), fluctuations(free, without)
touching = near < 4.5
print(
    f"mean RMSF of the {touching.sum()} residues at the ligand: {one[touching].mean():.2f} "
    f"angstrom with it, {other[touching].mean():.2f} without"
)

figure, axis = plt.subplots(figsize=(9, 3.6), dpi=120, layout="constrained")
axis.plot(other, label="free", color="tab:blue")
axis.plot(one, label=f"with {given.ligand}", color="tab:red")
axis.plot(
    np.flatnonzero(touching), np.zeros(touching.sum()), "|", color="black", label="at the ligand"
)
axis.set_xlabel("residue, counted along the chains")
axis.set_ylabel("RMSF / Å")
axis.legend(ncols=3)
figure.savefig(given.output)
