"""Atoms and bonds of RDKit molecules."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from openmm.app import Element, Topology
from rdkit import Chem

from .bond_orders import ORDER_OF_RDKIT
from .errors import InputError
from .residues import AROMATIC, DATIVE, UNKNOWN

# Places are multiples of this: versions of RDKit place hydrogens that differ in their last bits. nm
_GRID = 2.0**-33
_LARGEST_ELEMENT = 116  # of those that OpenMM knows
_DATIVE_TYPES = (
    Chem.BondType.DATIVE,
    Chem.BondType.DATIVEONE,
    Chem.BondType.DATIVEL,
    Chem.BondType.DATIVER,
    Chem.BondType.ZERO,
)


@dataclass(frozen=True)
class RdkitAtoms:
    """What an RDKit molecule says.

    Attributes:
        topology: atoms without bonds; residues as the molecule names them, else one called LIG.
        positions: (N, 3) in nm.
        charges: (N,) formal charges.
        masses: (N,) in dalton, isotopes' own.
        bonds: (B, 2) atom indices, the smaller first, sorted.
        bond_orders: (B,) order codes.
        notes: sentences on what was left out.
        source: the molecule's name for messages.
    """

    topology: Topology
    positions: NDArray[np.float64]
    charges: NDArray[np.int32]
    masses: NDArray[np.float64]
    bonds: NDArray[np.int32]
    bond_orders: NDArray[np.uint8]
    notes: list[str]
    source: str


def read_rdkit(mol: Chem.Mol, conformer: int = -1) -> RdkitAtoms:
    """Take atoms, bonds and one conformer from an RDKit molecule.

    Raises:
        InputError: there is no such conformer, it is flat, or an atom has no element.
    """
    name = mol.GetProp("_Name").strip() if mol.HasProp("_Name") else ""
    source = name or "The RDKit molecule"
    if mol.GetNumAtoms() == 0:
        raise InputError(f"{source} has no atoms; give a molecule.")
    try:
        places = mol.GetConformer(conformer)
    except ValueError:
        wanted = "conformer" if conformer == -1 else f"conformer {conformer}"
        raise InputError(f"{source} has no {wanted}; embed it, or ask for one it has.") from None
    if not places.Is3D():
        raise InputError(f"{source} has a flat conformer; embed it in three dimensions first.")

    topology = Topology()
    residue = None
    described: tuple[str, str, int, str] | None = None
    chains = {}
    counts: dict[str, int] = {}
    for atom in mol.GetAtoms():
        if atom.GetAtomicNum() == 0:
            raise InputError(
                f"{source}: atom {atom.GetIdx()} has no element; replace the dummy atom."
            )
        if atom.GetAtomicNum() > _LARGEST_ELEMENT:
            raise InputError(f"{source}: atom {atom.GetIdx()} is of an element without a mass.")
        info = atom.GetPDBResidueInfo()
        key = ("A", "LIG", 1, "")
        if info is not None:
            key = (
                info.GetChainId(),
                info.GetResidueName().strip() or "LIG",
                info.GetResidueNumber(),
                info.GetInsertionCode().strip(),
            )
        if residue is None or key != described:
            if described is None or key[0] != described[0]:
                chains[key[0]] = topology.addChain(key[0])
            residue = topology.addResidue(key[1], chains[key[0]], str(key[2]), key[3])
            described = key
        symbol = atom.GetSymbol()
        counts[symbol] = counts.get(symbol, 0) + 1
        own_name = info.GetName().strip() if info is not None else ""
        topology.addAtom(
            own_name or f"{symbol}{counts[symbol]}",
            Element.getByAtomicNumber(atom.GetAtomicNum()),
            residue,
        )

    bonds: dict[tuple[int, int], int] = {}
    for bond in mol.GetBonds():
        i, j = sorted((bond.GetBeginAtomIdx(), bond.GetEndAtomIdx()))
        kind = bond.GetBondType()
        if kind == Chem.BondType.HYDROGEN:  # holds nothing
            continue
        if bond.GetIsAromatic():
            bonds[(i, j)] = AROMATIC
        else:
            bonds[(i, j)] = DATIVE if kind in _DATIVE_TYPES else ORDER_OF_RDKIT.get(kind, UNKNOWN)
    bonds = dict(sorted(bonds.items()))
    implicit = sum(atom.GetTotalNumHs() for atom in mol.GetAtoms())
    notes = [f"{implicit} hydrogens without a place were left out."] if implicit else []
    return RdkitAtoms(
        topology,
        np.rint(np.array(places.GetPositions(), dtype=np.float64) * 0.1 / _GRID) * _GRID,
        np.array([atom.GetFormalCharge() for atom in mol.GetAtoms()], dtype=np.int32),
        np.array([atom.GetMass() for atom in mol.GetAtoms()], dtype=np.float64),
        np.array(list(bonds), dtype=np.int32).reshape(-1, 2),
        np.array(list(bonds.values()), dtype=np.uint8),
        notes,
        source,
    )
