"""Conformers of a drug from its SMILES, laid over each other, and their energies.

    conformers.py [SMILES] [-n COUNT]

Without a SMILES: imatinib.
"""

import argparse
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.collections import LineCollection
from rdkit import Chem
from rdkit.Chem import rdMolAlign

import ragdoll

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402

IMATINIB = "Cc1ccc(NC(=O)c2ccc(CN3CCN(C)CC3)cc2)cc1Nc1nccc(n1)-c1cccnc1"
COLOURS = {"N": "tab:blue", "O": "tab:red", "S": "gold", "F": "tab:green", "Cl": "tab:green"}

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("smiles", nargs="?", default=IMATINIB)
parser.add_argument("-n", "--count", type=int, default=40)
parser.add_argument("--seed", type=int, default=1)
parser.add_argument("-o", "--output", default=Path(__file__).with_name("conformers.png"), type=Path)
given = parser.parse_args()

mol = Chem.MolFromSmiles(given.smiles)
if mol is None:
    raise SystemExit("RDKit cannot read this SMILES.")

# as sampled: bonds and angles of one start; the ring in the middle is what all lie on
sampled = ragdoll.conformers(mol, given.count, seed=given.seed, prune_rmsd=0.05)
rings = Chem.GetSymmSSSR(sampled)
size = sampled.GetNumHeavyAtoms()
distances = Chem.GetDistanceMatrix(sampled)[:size, :size]
core = min(rings, key=lambda ring: distances[list(ring)].max(), default=range(size))
heavy = Chem.RemoveHs(sampled)
rdMolAlign.AlignMolConformers(heavy, atomIds=list(core))

# minimised: the lowest first, none twice
minimised = ragdoll.conformers(
    mol, given.count, seed=given.seed, prune_rmsd=0.05, minimize="mmff94s"
)
energies = np.array([c.GetDoubleProp("energy_kcal_mol") for c in minimised.GetConformers()])
bare = Chem.RemoveHs(minimised)
rmsds = [rdMolAlign.GetBestRMS(bare, bare, k, 0) for k in range(bare.GetNumConformers())]
print(
    f"{sampled.GetNumConformers()} conformers; minimised, {len(energies)} differ, within "
    f"{energies.max() - energies.min():.1f} kcal/mol"
)

figure, (overlay, plot) = plt.subplots(
    1, 2, figsize=(10, 4.6), dpi=120, layout="constrained", width_ratios=(3, 2)
)
places = np.array([c.GetPositions() for c in heavy.GetConformers()])
centre = places[:, list(core)].mean(axis=(0, 1))
axes = np.linalg.svd((places - centre).reshape(-1, 3), full_matrices=False)[2]
for frame in (places - centre) @ axes.T:
    lines, colours = [], []
    for bond in heavy.GetBonds():
        pair = (bond.GetBeginAtom(), bond.GetEndAtom())
        ends = frame[[atom.GetIdx() for atom in pair], :2]
        middle = ends.mean(axis=0)
        for atom, end in zip(pair, ends, strict=True):  # each half in its atom's colour
            lines.append([end, middle])
            colours.append(COLOURS.get(atom.GetSymbol(), "0.25"))
    overlay.add_collection(LineCollection(lines, colors=colours, linewidths=0.9, alpha=0.45))
overlay.autoscale()
overlay.set_aspect("equal")
overlay.set_title(f"{len(places)} conformers on one ring", fontsize=10)
overlay.set_xlabel("Å")
plot.scatter(rmsds, energies - energies.min(), s=18)
plot.set_xlabel("RMSD from the lowest / Å")
plot.set_ylabel("MMFF94s energy over the lowest / kcal/mol")
plot.set_title("minimised", fontsize=10)
figure.savefig(given.output)
