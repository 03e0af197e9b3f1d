"""Hydrogens of residues without a template, such as ligands: by RDKit, from bond orders."""

import numpy as np
from numpy.typing import NDArray
from openmm.app import Residue, Topology
from rdkit import Chem
from rdkit.Geometry import Point3D
from rdkit.rdBase import BlockLogs

_ANGSTROM = 10.0  # per nm
_ORDERS = {1: Chem.BondType.SINGLE, 2: Chem.BondType.DOUBLE, 3: Chem.BondType.TRIPLE}
_ACIDS = 4.5  # their usual pK
_AMINES = 9.5


def place_ligand_hydrogens(
    residue: Residue, topology: Topology, positions: NDArray[np.float64], ph: float
) -> dict[int, list[NDArray[np.float64]]] | None:
    """Places of the hydrogens that a residue lacks, by the index of the atom that holds them, nm.

    Acids (carboxylic, phosphoric, sulfuric) have none above a pH of 4.5, amines one more below 9.5.

    Args:
        residue: of the topology.
        topology: with all bonds and their orders.
        positions: (N, 3) in nm.
        ph: decides protonation.

    Returns:
        None where the bonds do not make a molecule that RDKit takes.
    """
    mol, own = _molecule(residue, topology, positions)
    if mol is None:
        return None
    with BlockLogs():
        try:
            _set_charges(mol, ph)
            Chem.SanitizeMol(mol)
            full = Chem.AddHs(mol, addCoords=True)
        except (Chem.MolSanitizeException, ValueError, RuntimeError):
            return None
    found: dict[int, list[NDArray[np.float64]]] = {}
    places = full.GetConformer().GetPositions()
    for atom in list(full.GetAtoms())[mol.GetNumAtoms() :]:
        holder = atom.GetNeighbors()[0].GetIdx()
        found.setdefault(own[holder], []).append(places[atom.GetIdx()] / _ANGSTROM)
    return found


def _molecule(
    residue: Residue, topology: Topology, positions: NDArray[np.float64]
) -> tuple[Chem.RWMol | None, dict[int, int]]:
    """The residue in RDKit, neighbours in other residues as dummies; atoms by RDKit's indices."""
    mol = Chem.RWMol()
    index: dict[int, int] = {}
    places: list[NDArray[np.float64]] = []
    for atom in residue.atoms():
        new = Chem.Atom(atom.element.atomic_number)
        index[atom.index] = mol.AddAtom(new)
        places.append(positions[atom.index])
    own = {new: old for old, new in index.items()}
    aromatic = False
    for bond in topology.bonds():
        ends = [atom.index for atom in (bond[0], bond[1])]
        inside = [end in index for end in ends]
        if not any(inside):
            continue
        if all(inside):
            kind = str(bond.type) if bond.type is not None else ""
            is_aromatic = "Aromatic" in kind
            aromatic |= is_aromatic
            order = Chem.BondType.AROMATIC if is_aromatic else _ORDERS.get(bond.order or 1)
            mol.AddBond(index[ends[0]], index[ends[1]], order or Chem.BondType.SINGLE)
            if is_aromatic:
                for end in ends:
                    mol.GetAtomWithIdx(index[end]).SetIsAromatic(True)
            continue
        outer = ends[inside.index(False)]
        dummy = mol.AddAtom(Chem.Atom(0))
        places.append(positions[outer])
        mol.AddBond(index[ends[inside.index(True)]], dummy, Chem.BondType.SINGLE)
    conformer = Chem.Conformer(mol.GetNumAtoms())
    conformer.Set3D(True)
    for k, place in enumerate(places):
        conformer.SetAtomPosition(k, Point3D(*(place * _ANGSTROM)))
    mol.AddConformer(conformer)
    return mol, own


def _set_charges(mol: Chem.RWMol, ph: float) -> None:
    """Formal charges of acids, amines and of nitrogen with four bonds."""
    mol.UpdatePropertyCache(strict=False)
    for atom in mol.GetAtoms():
        number, degree = atom.GetAtomicNum(), atom.GetDegree()
        bonds = atom.GetBonds()
        orders = sum(bond.GetBondTypeAsDouble() for bond in bonds)
        heavy = [other for other in atom.GetNeighbors() if other.GetAtomicNum() != 1]
        if number == 7 and orders > 3.5:
            atom.SetFormalCharge(1)
        elif number == 7 and not atom.GetIsAromatic() and orders == degree and ph < _AMINES:
            if heavy and all(_is_saturated_carbon(other) for other in heavy):
                atom.SetFormalCharge(1)
        elif number == 8 and degree == 1 and orders == 1:
            holder = heavy[0] if heavy else None
            if holder is None:
                continue
            nitro = holder.GetAtomicNum() == 7 and holder.GetDegree() == 3
            if nitro or (ph > _ACIDS and _is_acid(holder, atom)):
                atom.SetFormalCharge(-1)


def _is_saturated_carbon(atom: Chem.Atom) -> bool:
    single = all(bond.GetBondType() == Chem.BondType.SINGLE for bond in atom.GetBonds())
    return atom.GetAtomicNum() == 6 and single


def _is_acid(holder: Chem.Atom, oxygen: Chem.Atom) -> bool:
    """Whether a hydroxyl there is that of an acid."""
    if holder.GetAtomicNum() not in (6, 15, 16):
        return False
    return any(
        bond.GetBondType() == Chem.BondType.DOUBLE
        and bond.GetOtherAtom(holder).GetAtomicNum() == 8
        and bond.GetOtherAtomIdx(holder.GetIdx()) != oxygen.GetIdx()
        for bond in holder.GetBonds()
    )
