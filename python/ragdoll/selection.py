"""Which atoms of a structure take part, and whether they can."""

from collections import Counter

import numpy as np
from numpy.typing import NDArray
from openmm.app import Residue, Topology

from .elements import IS_METAL
from .errors import InputError
from .neighbors import close_pairs
from .residue_match import residue_label
from .residues import WATERS, residue_template
from .structure_text import LARGEST_COORDINATE

_SAME_PLACE = 0.001  # nm
_HALOGENS = (9, 17, 35, 53)


def atoms_to_keep(
    topology: Topology, keep_solvent: bool, source: str
) -> tuple[NDArray[np.bool_], list[str]]:
    """Tell which atoms stay when waters and single ions go.

    Returns:
        (N,) true for atoms that stay, and notes on the rest.

    Raises:
        InputError: nothing is left.
    """
    keep = np.ones(topology.getNumAtoms(), dtype=bool)
    left_out: Counter[str] = Counter()
    massless = 0
    for residue in topology.residues():
        solvent = not keep_solvent and is_solvent(residue)
        if solvent:
            left_out["water" if residue.name in WATERS else residue.name] += 1
        for atom in residue.atoms():
            if atom.element is None:
                massless += not solvent
                keep[atom.index] = False
            elif solvent:
                keep[atom.index] = False
    if not keep.any():
        what = "only water and single ions" if left_out else "no atoms"
        raise InputError(f"{source} contains {what}; give a molecule, or keep the solvent.")
    notes = []
    if left_out:
        parts = ", ".join(f"{count} {name}" for name, count in left_out.items())
        notes.append(f"Water and single ions were left out: {parts}.")
    if massless:
        notes.append(f"{massless} particles that are no atoms were left out.")
    return keep, notes


def is_solvent(residue: Residue) -> bool:
    """Whether a residue is water or an ion of one atom."""
    if residue.name in WATERS:
        return True
    atoms = [atom for atom in residue.atoms() if atom.element is not None]
    if len(atoms) != 1 or residue_template(residue.name) is not None:
        return False
    number = atoms[0].element.atomic_number
    return bool(IS_METAL[number]) or number in _HALOGENS


def copy_topology(topology: Topology, keep: NDArray[np.bool_]) -> Topology:
    """Copy the kept atoms, without bonds; chains and residues that lose all atoms go."""
    copy = Topology()
    copy.setPeriodicBoxVectors(topology.getPeriodicBoxVectors())
    for chain in topology.chains():
        new_chain = None
        for residue in chain.residues():
            new_residue = None
            for atom in residue.atoms():
                if not keep[atom.index]:
                    continue
                if new_chain is None:
                    new_chain = copy.addChain(chain.id)
                if new_residue is None:
                    new_residue = copy.addResidue(
                        residue.name, new_chain, residue.id, residue.insertionCode
                    )
                copy.addAtom(atom.name, atom.element, new_residue, atom.id)
    return copy


def check_atoms(topology: Topology, positions: NDArray[np.float64], source: str) -> None:
    """Refuse atoms that no framework can be built on.

    Args:
        topology: the atoms.
        positions: (N, 3) in nm.
        source: what the message names.

    Raises:
        InputError: a place is no finite number, two atoms share one, or residues are CA atoms only.
    """
    atoms = list(topology.atoms())
    wrong = ~np.isfinite(positions).all(axis=1) | (
        np.abs(positions) >= 0.1 * LARGEST_COORDINATE
    ).any(axis=1)
    if wrong.any():
        atom = atoms[int(np.argmax(wrong))]
        raise InputError(
            f"{source}: atom {atom.name} of {residue_label(atom.residue)} has no usable place, "
            f"{positions[atom.index].tolist()} nm; give it finite coordinates."
        )
    amino_acids = only_ca = 0
    for residue in topology.residues():
        template = residue_template(residue.name)
        if template is None or not template.is_amino_acid:
            continue
        amino_acids += 1
        heavy = [atom.name for atom in residue.atoms() if atom.element.atomic_number > 1]
        only_ca += heavy == ["CA"]
    if 2 * only_ca > amino_acids:
        raise InputError(
            f"{source} has only the CA atom in {only_ca} of {amino_acids} amino acids, "
            "but a framework of bars needs all heavy atoms; give the full structure."
        )
    same = close_pairs(positions, _SAME_PLACE)
    if len(same):
        first, second = (atoms[int(index)] for index in same[0])
        raise InputError(
            f"{source}: atoms {first.name} of {residue_label(first.residue)} and {second.name} of "
            f"{residue_label(second.residue)} lie at one place; remove one of them."
        )
