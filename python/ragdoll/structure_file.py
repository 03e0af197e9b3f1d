"""Proteins and nucleic acids from PDB and mmCIF files."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import gemmi
import numpy as np
from numpy.typing import NDArray
from openmm.app import Element, Topology
from openmm.app.internal.unitcell import computePeriodicBoxVectors
from openmm.unit import nanometer

from .errors import InputError
from .residues import residue_template
from .structure_text import read_structure_text

_ION_NAMES = {"SOD": "NA", "POT": "K", "CES": "CS", "CLA": "CL", "CAL": "CA"}  # CHARMM's


@dataclass(frozen=True)
class StructureFile:
    """The kept atoms of one model of a structure file, in the file's order.

    Attributes:
        topology: chains, residues and atoms; no bonds.
        positions: (N, 3) in nm.
        b_factors: (N,) in square angstrom.
        charges: (N,) formal charges that the file states, else 0.
        hetero: (N,) whether the file says that the atom is no part of a polymer (HETATM).
        recorded_bonds: (R, 2) pairs of atoms that the file says are linked (CONECT, LINK, SSBOND,
            struct_conn).
        box_vectors: (3, 3) in nm, or None if the file has no unit cell.
        source_hash: SHA-256 of the file's bytes, hexadecimal.
        notes: sentences on what was left out.
    """

    topology: Topology
    positions: NDArray[np.float64]
    b_factors: NDArray[np.float64]
    charges: NDArray[np.int32]
    hetero: NDArray[np.bool_]
    recorded_bonds: NDArray[np.int64]
    box_vectors: NDArray[np.float64] | None
    source_hash: str
    notes: list[str]


def read_structure_file(
    path: str | Path,
    *,
    model: int = 1,
    altloc: str | None = None,
    chains: Sequence[str] | None = None,
) -> StructureFile:
    """Read one model of a PDB or mmCIF file, plain or gzipped.

    Args:
        path: the file.
        model: which model, counted from 1.
        altloc: letter of the alternate location to keep where a residue has it; elsewhere, and by
            default, the first in the file, one for each residue.
        chains: ids of the chains to keep (a single text is one id); all by default.

    Raises:
        InputError: the file cannot be used, or has no such model, chain or alternate location.
    """
    text = read_structure_text(path)
    structure, notes = text.structure, list(text.notes)
    if not 1 <= model <= len(structure):
        raise InputError(
            f"{path} has {len(structure)} model(s) and no model {model}; ask for one of them."
        )
    if len(structure) > 1:
        notes.append(f"Model {model} of {len(structure)} was read.")
    parts = _chosen_chains(structure[model - 1], chains, path)
    if altloc is not None and not any(
        atom.altloc == altloc for part in parts for residue in part for atom in residue
    ):
        raise InputError(
            f"{path} has no alternate location {altloc} in the chosen model and chains; "
            "ask for another or none."
        )

    topology = Topology()
    positions: list[list[float]] = []
    b_factors: list[float] = []
    charges: list[int] = []
    hetero: list[bool] = []
    index_of_serial: dict[int, int] = {}
    index_of_address: dict[tuple[str, str, str], int] = {}
    doubtful_serials: set[int] = set()
    dropped_alternates = unknown_elements = 0
    for part in parts:
        chain = topology.addChain(part.name)
        subchain = part[0].subchain
        for residues in _same_number(part):
            # mmCIF calls a polymer and its ligands one chain; its subchains are what TER parts in
            # PDB files.
            if residues[0].subchain != subchain:
                subchain = residues[0].subchain
                chain = topology.addChain(part.name)
            kept, dropped = _one_alternate(residues, altloc)
            dropped_alternates += dropped
            current = None
            for residue, atom in kept:
                element = _element(residue, atom)
                if element is None:
                    unknown_elements += 1
                    continue
                if current is None or current.name != residue.name:
                    icode = residue.seqid.icode.strip()
                    current = topology.addResidue(
                        residue.name, chain, str(residue.seqid.num), icode
                    )
                index = topology.getNumAtoms()
                topology.addAtom(atom.name, element, current, str(atom.serial))
                positions.append(atom.pos.tolist())
                b_factors.append(atom.b_iso)
                charges.append(atom.charge)
                hetero.append(residue.het_flag == "H")
                if atom.serial in index_of_serial:
                    doubtful_serials.add(atom.serial)
                index_of_serial[atom.serial] = index
                index_of_address[(part.name, str(residue.seqid), atom.name)] = index
    serials = list(index_of_serial)
    if not doubtful_serials and serials != sorted(serials):
        # gemmi brings atoms of a residue together that stand apart in the file.
        notes.append("The atoms are ordered by residue, which is not the order of their serials.")
    if dropped_alternates:
        notes.append(f"{dropped_alternates} atoms of other alternate locations were left out.")
    if unknown_elements:
        notes.append(f"{unknown_elements} atoms of unknown element were left out.")

    recorded = {
        (min(i, j), max(i, j))
        for i, j in _recorded_bonds(structure, index_of_serial, index_of_address, doubtful_serials)
        if i != j
    }
    return StructureFile(
        topology,
        np.array(positions, dtype=np.float64).reshape(-1, 3) * 0.1,
        np.array(b_factors, dtype=np.float64),
        np.array(charges, dtype=np.int32),
        np.array(hetero, dtype=bool),
        np.array(sorted(recorded), dtype=np.int64).reshape(-1, 2),
        _box_vectors(structure.cell),
        text.source_hash,
        notes,
    )


def _chosen_chains(
    model: gemmi.Model, chains: Sequence[str] | None, path: str | Path
) -> list[gemmi.Chain]:
    if chains is None:
        return list(model)
    wanted = [chains] if isinstance(chains, str) else list(chains)
    present = list(dict.fromkeys(part.name for part in model))
    for name in wanted:
        if name not in present:
            ids = ", ".join(f'"{known}"' for known in present)
            raise InputError(f'{path} has no chain "{name}"; its chains are {ids}.')
    return [part for part in model if part.name in wanted]


def _same_number(part: gemmi.Chain) -> list[list[gemmi.Residue]]:
    """Group residues with altlocs that share a number: alternatives of one place in the chain."""
    groups: list[list[gemmi.Residue]] = []
    for residue in part:
        if groups and groups[-1][0].seqid == residue.seqid and _is_alternate(residue):
            groups[-1].append(residue)
        else:
            groups.append([residue])
    return groups


def _is_alternate(residue: gemmi.Residue) -> bool:
    return all(atom.has_altloc() for atom in residue)


def _one_alternate(
    residues: list[gemmi.Residue], altloc: str | None
) -> tuple[list[tuple[gemmi.Residue, gemmi.Atom]], int]:
    atoms = [(residue, atom) for residue in residues for atom in residue]
    present = list(dict.fromkeys(atom.altloc for _, atom in atoms if atom.has_altloc()))
    if not present:
        return atoms, 0
    chosen = altloc if altloc in present else present[0]
    kept = [
        (residue, atom) for residue, atom in atoms if not atom.has_altloc() or atom.altloc == chosen
    ]
    return kept, len(atoms) - len(kept)


def _element(residue: gemmi.Residue, atom: gemmi.Atom) -> Element | None:
    template = residue_template(residue.name)
    if template is not None:
        # Without columns 77-78 the name "CA" may pass for calcium; here it is carbon.
        symbol = template.elements.get(template.atom_name(atom.name))
        if symbol is not None:
            return Element.getBySymbol(symbol)
    name = atom.name.strip("+-0123456789").upper()
    if len(residue) == 1 and name == residue.name.strip("+-0123456789").upper():
        # An ion named after its element, whatever column the name begins in.
        ion = gemmi.Element(_ION_NAMES.get(name, name))
        if ion.atomic_number > 0:
            return Element.getByAtomicNumber(ion.atomic_number)
    if atom.element.is_hydrogen:
        return Element.getBySymbol("H")
    if atom.element.atomic_number == 0:
        return None
    return Element.getByAtomicNumber(atom.element.atomic_number)


def _recorded_bonds(
    structure: gemmi.Structure,
    index_of_serial: dict[int, int],
    index_of_address: dict[tuple[str, str, str], int],
    doubtful_serials: set[int],
) -> list[tuple[int, int]]:
    bonds = []
    for connection in structure.connections:
        # A link to a neighbour in the crystal is no bond of this molecule.
        if connection.type == gemmi.ConnectionType.Hydrog or connection.asu == gemmi.Asu.Different:
            continue
        ends = [
            index_of_address.get((end.chain_name, str(end.res_id.seqid), end.atom_name))
            for end in (connection.partner1, connection.partner2)
        ]
        if ends[0] is not None and ends[1] is not None:
            bonds.append((ends[0], ends[1]))
    for serial, partners in structure.conect_map.items():
        for partner in partners:
            # Large files start again at 1: a serial that occurs twice names no atom.
            if serial in doubtful_serials or partner in doubtful_serials:
                continue
            if serial in index_of_serial and partner in index_of_serial:
                bonds.append((index_of_serial[serial], index_of_serial[partner]))
    return bonds


def _box_vectors(cell: gemmi.UnitCell) -> NDArray[np.float64] | None:
    # A cell of 1 x 1 x 1 angstrom is what writers put down for "none".
    if not cell.is_crystal() or min(cell.a, cell.b, cell.c) <= 1.0:
        return None
    lengths = (cell.a * 0.1, cell.b * 0.1, cell.c * 0.1)
    angles = tuple(np.radians((cell.alpha, cell.beta, cell.gamma)))
    vectors = computePeriodicBoxVectors(*lengths, *angles)
    return np.array(vectors.value_in_unit(nanometer), dtype=np.float64)
