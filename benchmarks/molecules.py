"""Molecules that are measured: proteins of RAGDOLL_DATA, or the villin that OpenMM brings along."""

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from openmm import app

import ragdoll

ROOT = Path(__file__).resolve().parent.parent
DATA = Path(os.environ.get("RAGDOLL_DATA", ROOT.parent / "shared" / "data" / "proteins"))

# DHFR (the accepted conformer's protein), lysozyme and ubiquitin: solved by others, not by us
PROTEINS = {"DHFR": "5dfr_minimized.pdb", "lysozyme": "1aki.pdb", "ubiquitin": "1ubq.pdb"}


@dataclass(frozen=True)
class HeavyAtoms:
    """Atoms other than hydrogen, and the bonds between them."""

    name: str
    elements: NDArray[np.int32]
    charges: NDArray[np.int32]
    masses: NDArray[np.float64]
    positions: NDArray[np.float64]  # nm (N, 3)
    bonds: NDArray[np.int32]
    bond_orders: NDArray[np.int32]

    def write(self, path: Path) -> None:
        """Write what the program `benchmark` reads."""
        lines = [f"{len(self.elements)} {len(self.bonds)}"]
        for element, charge, mass, position in zip(
            self.elements, self.charges, self.masses, self.positions, strict=True
        ):
            place = " ".join(repr(float(x)) for x in position)
            lines.append(f"{element} {charge} {float(mass)!r} {place}")
        lines += [
            f"{a} {b} {order}" for (a, b), order in zip(self.bonds, self.bond_orders, strict=True)
        ]
        path.write_text("\n".join(lines) + "\n")


def read(name: str, path: Path) -> HeavyAtoms:
    """What `write` or the program `benchmark` wrote."""
    with path.open() as file:
        atoms, bonds = map(int, file.readline().split())
        rows = np.loadtxt(file, max_rows=atoms, ndmin=2)
        pairs = np.loadtxt(file, max_rows=bonds, dtype=np.int32, ndmin=2)
    return HeavyAtoms(
        name=name,
        elements=rows[:, 0].astype(np.int32),
        charges=rows[:, 1].astype(np.int32),
        masses=rows[:, 2],
        positions=rows[:, 3:],
        bonds=pairs[:, :2],
        bond_orders=pairs[:, 2],
    )


def heavy_atoms(name: str, molecule: ragdoll.Molecule) -> HeavyAtoms:
    """A molecule without its hydrogens."""
    heavy = molecule.elements > 1
    number = np.cumsum(heavy) - 1
    kept = heavy[molecule.bonds].all(axis=1)
    return HeavyAtoms(
        name=name,
        elements=molecule.elements[heavy],
        charges=molecule.charges[heavy],
        masses=molecule.masses[heavy],
        positions=molecule.positions[heavy],
        bonds=number[molecule.bonds[kept]],
        bond_orders=molecule.bond_orders[kept],
    )


def find(file: str) -> Path | None:
    """A file of RAGDOLL_DATA, which may be the folder of the proteins or the one above it."""
    for folder in (DATA, DATA / "proteins"):
        if (folder / file).exists():
            return folder / file
    return None


def villin() -> ragdoll.Molecule:
    """Villin's headpiece from OpenMM's own files; its water is left out."""
    return ragdoll.Molecule.from_file(Path(app.__file__).parent / "data" / "test.pdb")


def load(count: int) -> list[HeavyAtoms]:
    """The first `count` proteins that there are, villin where there are none."""
    found = {name: path for name, file in PROTEINS.items() if (path := find(file))}
    molecules = [
        heavy_atoms(name, ragdoll.Molecule.from_file(path))
        for name, path in list(found.items())[:count]
    ]
    return molecules or [heavy_atoms("villin", villin())]
