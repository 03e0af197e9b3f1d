"""Sites: one atom for each residue, by which conformations are compared and networks are made."""

import numpy as np
from numpy.typing import NDArray
from openmm.app import Residue, Topology

from .residues import WATERS, residue_template

# the first name that a residue has; "CA" of an amino acid only, not calcium
_AMINO_ACID = ("CA",)
_NUCLEOTIDE = ("P", "C1'", "C4'")
_NUCLEOTIDE_SUGAR = {"C1'", "C3'", "C4'"}


def site_of(residue: Residue) -> int | None:
    """The atom that stands for a residue: CA, or P (else C1') of a nucleotide; None: no polymer."""
    atoms = {atom.name: atom for atom in residue.atoms()}
    names = atoms.keys()
    if {"N", "CA", "C"} <= names:
        order = _AMINO_ACID
    elif names >= _NUCLEOTIDE_SUGAR:
        order = _NUCLEOTIDE
    else:
        return None
    return next((atoms[name].index for name in order if name in names), None)


def ligands_of(topology: Topology) -> list[Residue]:
    """Residues that are no part of a polymer, waters and single atoms left out."""
    return [
        residue
        for residue in topology.residues()
        if site_of(residue) is None
        and residue.name not in WATERS
        and len(residue) > 1
        and residue_template(residue.name) is None
    ]


def is_nucleotide(residue: Residue) -> bool:
    """Whether it has the sugar of a nucleotide."""
    return {atom.name for atom in residue.atoms()} >= _NUCLEOTIDE_SUGAR


def sites_of(
    topology: Topology, positions: NDArray[np.float64]
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """The sites of a structure, and the site whose way each atom goes.

    Ligands and other residues without a site go with the site nearest to their centroid. Without
    any site, each heavy atom is one.

    Args:
        topology: the atoms.
        positions: (N, 3), nm.

    Returns:
        (S,) atoms that are sites, and (N,) an index of these for each atom.
    """
    sites: list[int] = []
    of_atom = np.full(topology.getNumAtoms(), -1, dtype=np.int32)
    others = []
    for residue in topology.residues():
        site = site_of(residue)
        atoms = [atom.index for atom in residue.atoms()]
        if site is None:
            others.append(atoms)
            continue
        of_atom[atoms] = len(sites)
        sites.append(site)
    if len(sites) < 3:
        return _heavy_sites(topology, positions)
    places = positions[sites]
    for atoms in others:
        centre = positions[atoms].mean(axis=0)
        of_atom[atoms] = int(np.argmin(((places - centre) ** 2).sum(axis=1)))
    return np.array(sites, dtype=np.int32), of_atom


def _heavy_sites(
    topology: Topology, positions: NDArray[np.float64]
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    heavy = [atom.index for atom in topology.atoms() if atom.element.atomic_number > 1]
    sites = np.array(heavy or range(topology.getNumAtoms()), dtype=np.int32)
    places = positions[sites]
    nearest = [int(np.argmin(((places - place) ** 2).sum(axis=1))) for place in positions]
    return sites, np.array(nearest, dtype=np.int32)
