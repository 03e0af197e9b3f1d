"""A flexible ligand in its flexible pocket, the rest of the protein fixed.

    ligand_pocket.py FILE (--smiles NAME=SMILES | --ligand LIGAND.sdf)

Without a file: HIV-1 protease with the cyclic urea XK263 (residue XK2), from MDAnalysisTests.
"""

import argparse
from pathlib import Path

import matplotlib
import numpy as np

import ragdoll

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402
from matplotlib.collections import LineCollection  # noqa: E402

XK2 = (
    "XK2=O=C1N(Cc2ccc3ccccc3c2)[C@H](Cc2ccccc2)[C@H](O)[C@@H](O)[C@@H](Cc2ccccc2)N1Cc1ccc2ccccc2c1"
)

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("file", nargs="?", help="PDB or mmCIF file")
parser.add_argument("--smiles", help="NAME=SMILES of a residue of the file")
parser.add_argument("--ligand", help="posed ligand: .sdf or .mol2")
parser.add_argument("--pocket-angstrom", type=float, default=8.0)
parser.add_argument("--frames", type=int, default=60)
parser.add_argument(
    "-o", "--output", default=Path(__file__).with_name("ligand_pocket.png"), type=Path
)
given = parser.parse_args()
if given.file is None:
    from importlib.resources import files

    given.file = str(files("MDAnalysisTests") / "data" / "1hvr.pdb")
if given.ligand is None and given.smiles is None:
    given.smiles = XK2

# the complex: bonds, orders and charges of the ligand are those of its SMILES or of its file
if given.ligand is not None:
    molecule = ragdoll.Molecule.from_file(given.file, ligands=given.ligand)
    residue = list(molecule.topology.residues())[-1]  # a posed ligand comes last
else:
    name, smiles = given.smiles.split("=", 1)
    molecule = ragdoll.Molecule.from_file(given.file, ligand_smiles={name: smiles})
    residue = next(r for r in molecule.topology.residues() if r.name == name)
ligand = [atom.index for atom in residue.atoms()]

# the pocket moves, all the rest is fixed
itself = f"index {ligand[0]}:{ligand[-1]}"
pocket = ragdoll.UserConstraint(
    "move", f"({itself}) or byres (around {given.pocket_angstrom:g} ({itself}))"
)
options = ragdoll.SampleOptions(
    frames=given.frames,
    stride=5,
    perturbation="momentum",
    seed=1,
    constraints=ragdoll.ConstraintOptions(user=(pocket,)),
)
path = given.output.with_suffix(".h5")
report = ragdoll.sample(molecule, path, options, force=True)
framework = ragdoll.build_framework(molecule, constraints=options.constraints)
with ragdoll.open_trajectory(path) as trajectory:
    frames = 10 * trajectory.positions.astype(float)
start = 10 * molecule.positions
fixed = np.array(framework.fixed, dtype=bool)
moved = np.linalg.norm(frames - start, axis=2)
print(
    f"{len(frames)} frames; {int((~fixed).sum())} of {len(fixed)} atoms move; fixed ones moved by "
    f"{np.abs(frames[:, fixed] - frames[0, fixed]).max():g} angstrom; the ligand by "
    f"{np.sqrt((moved[:, ligand] ** 2).mean(axis=1)).max():.2f} angstrom RMSD"
)

# hydrogen bonds between ligand and protein, and how long they become
own = set(ligand)
held = []
for donor, hydrogen, acceptor in framework.hydrogen_bonds:
    if (donor in own) != (acceptor in own):
        ends = (hydrogen if hydrogen >= 0 else donor, acceptor)
        bound = next(
            10 * length
            for pair, length in zip(framework.tethers, framework.tether_lengths, strict=True)
            if set(pair.tolist()) == {int(end) for end in ends}
        )
        apart = np.linalg.norm(frames[:, ends[0]] - frames[:, ends[1]], axis=1)
        words = [molecule.labels[k] for k in (donor, acceptor)]
        held.append((" - ".join(words), apart, bound))
        print(f"{words[0]} - {words[1]}: {apart.min():.2f} to {apart.max():.2f}, held below "
              f"{bound:.2f} angstrom")  # fmt: skip

figure, places = plt.subplot_mosaic(
    [["left", "top"], ["left", "bottom"]], figsize=(11, 4.8), dpi=120, layout="constrained"
)
left, top, bottom = (places[name] for name in ("left", "top", "bottom"))

# the ligand and what is around it, seen along the ligand's shortest axis
heavy = molecule.elements > 1
centre = start[ligand].mean(axis=0)
axes = np.linalg.svd(start[ligand] - centre)[2][:2]
bonds = molecule.bonds[heavy[molecule.bonds].all(axis=1)]
inside = np.isin(bonds, ligand).all(axis=1)
near = np.linalg.norm(start - centre, axis=1) < 14
around = near[bonds].all(axis=1) & ~inside


def lines(x, chosen):
    """Bonds on the paper."""
    flat = (x - centre) @ axes.T
    return flat[bonds[chosen]]


still = fixed[bonds].all(axis=1)
left.add_collection(
    LineCollection(lines(start, around & still), colors="0.75", lw=0.8, label="fixed")
)
for k, x in enumerate(frames[:: max(1, len(frames) // 12)]):
    words = ("pocket", "ligand") if k == 0 else (None, None)
    left.add_collection(
        LineCollection(lines(x, around & ~still), colors="tab:blue", lw=0.5, alpha=0.25,
                       label=words[0])
    )  # fmt: skip
    left.add_collection(
        LineCollection(lines(x, inside), colors="tab:red", lw=1.0, alpha=0.6, label=words[1])
    )
left.set_xlim(-14, 14)
left.set_ylim(-12, 12)
left.set_aspect("equal")
left.set_xlabel("Å")
left.legend(loc="upper right")

for k, (_, apart, bound) in enumerate(held):
    top.plot(apart, np.full(len(apart), k), "|", color="tab:red", ms=14, alpha=0.5)
    top.plot([bound], [k], marker=4, color="black", ms=9)
top.set_yticks(range(len(held)), [words for words, _, _ in held])
top.set_ylim(-0.6, max(len(held), 1) - 0.4)
top.set_xlabel("hydrogen bonds in the frames, and their bounds / Å")

# how far residues go, against how far they are from the ligand
reach, spread = [], []
for residue in molecule.topology.residues():
    atoms = [atom.index for atom in residue.atoms() if heavy[atom.index]]
    if atoms and not own & set(atoms):
        apart = np.linalg.norm(start[atoms][:, None] - start[ligand][None], axis=2)
        reach.append(apart.min())
        spread.append(np.sqrt((moved[:, atoms] ** 2).mean()))
bottom.plot(reach, spread, ".", color="tab:blue")
bottom.axvline(given.pocket_angstrom, color="0.6", lw=0.8)
bottom.set_xlabel("distance of a residue from the ligand / Å")
bottom.set_ylabel("RMS movement / Å")
figure.savefig(given.output)
