"""A structure and its ligands as one: what the ligands' chemistry is, and where they are bonded."""

import string
from dataclasses import dataclass, field

import gemmi
import numpy as np
from numpy.typing import NDArray
from openmm.app import Element, Residue, Topology
from rdkit import Chem
from rdkit.rdBase import BlockLogs

from .atom_address import two_atoms
from .bond_orders import ORDER_OF_RDKIT
from .covalent_links import LONGEST_LINK, is_link, is_reactive, link_order, make_room
from .elements import IS_METAL
from .errors import InputError
from .ligand_file import PosedLigand
from .ligand_template import lay_template
from .ligands import Ligands
from .neighbors import close_pairs
from .residue_match import residue_label
from .residues import AROMATIC, DATIVE, UNKNOWN, WATERS, residue_template

# All lengths in this file are in angstrom but the positions in nm of what comes and goes.
_ANGSTROM = 10.0  # per nm
_LONGEST_CHAIN_BOND = 2.0
_SAME_PLACE = 1.5  # atoms of a ligand and of what it replaces are so near to each other,
_SAME_SHARE = 0.3  # at least this share of the smaller one's
_WATER_REACH = 2.2  # a water so near to a ligand's atom is not there
_OVERLAP = 0.55  # of the sum of van der Waals radii; no two atoms that are not bonded are nearer
_FAR = 8.0  # a ligand further from everything was hardly meant to be there
_MOST_LINKS = 2  # of one ligand that are told by distance
_H_BOND_LENGTHS = {6: 1.09, 7: 1.01, 8: 0.96, 16: 1.34, 34: 1.46}
_VDW = np.array([gemmi.Element(number).vdw_r for number in range(119)])


@dataclass(frozen=True)
class AtomTable:
    """Atoms of a structure before their bonds are known.

    Attributes:
        topology: chains, residues and atoms; its bonds are not looked at.
        positions: (N, 3) in nm.
        charges: (N,) formal charges that are stated, else 0.
        recorded: (R, 2) bonds that a file records.
        hetero: (N,) whether a file says that the atom is no part of a polymer.
        b_factors: (N,) in square angstrom, or None.
        given: bonds that are known, with their order codes, the smaller index first.
        settled: (N,) atoms of residues whose bonds, charges and hydrogens are known.
        new: (N,) hydrogens that were placed here and may be turned.
        links: (L, 2) bonds between residues that a ligand brought.
        notes: sentences on what was done.
    """

    topology: Topology
    positions: NDArray[np.float64]
    charges: NDArray[np.int32]
    recorded: NDArray[np.int64]
    hetero: NDArray[np.bool_]
    b_factors: NDArray[np.float64] | None = None
    given: dict[tuple[int, int], int] = field(default_factory=dict)
    settled: NDArray[np.bool_] | None = None
    new: NDArray[np.bool_] | None = None
    links: list[tuple[int, int]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


def join_ligands(table: AtomTable, ligands: Ligands, source: str, add_hydrogens: bool) -> AtomTable:
    """A structure with its ligands.

    Args:
        table: the structure.
        ligands: what is asked for.
        source: what messages call the structure.
        add_hydrogens: ligands get the hydrogens that they lack; by default they do where the
            structure has hydrogens, polar ones alone where it has no others.

    Raises:
        InputError: a ligand does not fit; the message says which and why.
    """
    return _Complex(table, ligands, source, add_hydrogens).joined()


class _Piece:
    """One ligand: RDKit's molecule, and the numbers of its atoms."""

    def __init__(
        self,
        mol: Chem.RWMol,
        atoms: list[int],
        residue: int,
        name: str,
        names: list[str],
        origin: str,
        posed: bool,
    ):
        self.mol = mol
        self.atoms = atoms  # number of each of mol's atoms
        self.residue = residue
        self.name = name
        self.names = names
        self.origin = origin  # what messages call it
        self.posed = posed
        self.chain_id = self.residue_id = self.insertion_code = ""
        self.lacking = 0  # heavy atoms of its SMILES that are not there
        self.left: set[int] = set()  # hydrogens that left, mol's indices
        self.hydrogens: list[tuple[int, NDArray[np.float64]]] = []  # holder, mol's, and place


class _Complex:
    def __init__(self, table: AtomTable, ligands: Ligands, source: str, add_hydrogens: bool):
        self.table = table
        self.ligands = ligands
        self.source = source
        self.residues = list(table.topology.residues())
        atoms = list(table.topology.atoms())
        self.elements = np.array([a.element.atomic_number for a in atoms], dtype=np.int32)
        self.places = table.positions * _ANGSTROM
        self.residue_of = np.array([a.residue.index for a in atoms], dtype=np.int64)
        self.names = [a.name for a in atoms]
        self.dropped = np.zeros(len(atoms), dtype=bool)
        self.pieces: list[_Piece] = []
        self.links: dict[tuple[int, int], int] = {}
        self.notes: list[str] = []
        heavy = int((self.elements > 1).sum())
        light = int((self.elements == 1).sum())
        self.hydrogens = "none"
        if add_hydrogens or light > 0.4 * heavy:
            self.hydrogens = "all"
        elif light:
            self.hydrogens = "polar"

    def joined(self) -> AtomTable:
        for name, template in self.ligands.templates:
            self._lay(name, template)
        for posed in self.ligands.posed:
            self._pose(posed)
        for text in self.ligands.covalent_bonds:
            self._bond_as_asked(text)
        for piece in self.pieces:
            self._link(piece)
        for piece in self.pieces:
            if piece.posed:
                self._refuse_overlaps(piece)
        for piece in self.pieces:
            self._complete(piece)
            self._note_lacking(piece)
        return self._assembled()

    # === Where ligands are

    def _lay(self, name: str, template: Chem.Mol) -> None:
        """Lay a SMILES over every residue of this name."""
        named = [residue for residue in self.residues if residue.name.upper() == name]
        free = [residue for residue in named if not self._in_chain(residue)]
        if not free:
            if named:
                raise InputError(
                    f"{name} of {self.source} is part of a chain, {residue_label(named[0])}; a "
                    "SMILES is for residues that stand alone."
                )
            others = dict.fromkeys(
                residue.name
                for residue in self.residues
                if residue_template(residue.name) is None and residue.name not in WATERS
            )
            raise InputError(
                f"{self.source} has no residue {name}"
                + (f"; its ligands are {', '.join(others)}." if others else ", nor another ligand.")
            )
        for residue in free:
            atoms = [atom.index for atom in residue.atoms()]
            laid = lay_template(
                template, self.elements[atoms], self.places[atoms], residue_label(residue)
            )
            self.notes += laid.notes
            self.pieces.append(
                _Piece(
                    laid.mol,
                    atoms,
                    residue.index,
                    residue.name,
                    [self.names[index] for index in atoms],
                    residue_label(residue),
                    False,
                )
            )
            self.pieces[-1].lacking = laid.lacking

    def _pose(self, posed: PosedLigand) -> None:
        """Add a ligand, in the place of what is there."""
        mol = _countable(posed.mol)
        places = mol.GetConformer().GetPositions()
        elements = np.array([atom.GetAtomicNum() for atom in mol.GetAtoms()], dtype=np.int32)
        if (elements == 0).any():
            raise InputError(f"{posed.origin} has a dummy atom; replace it by an element.")
        self.notes += posed.notes
        name = posed.name
        chain_id, number, code = self._free_chain(), "1", ""
        for residue in self._replaced(places[elements > 1]):
            atoms = [atom.index for atom in residue.atoms()]
            self.dropped[atoms] = True
            self.pieces = [piece for piece in self.pieces if piece.residue != residue.index]
            if residue.name in WATERS:
                self.notes.append(
                    f"{residue_label(residue)} was left out: {posed.origin} is there."
                )
                continue
            self.notes.append(f"{posed.origin} takes the place of {residue_label(residue)}.")
            chain_id, number = residue.chain.id, residue.id
            code = residue.insertionCode
            same = sorted(elements[elements > 1]) == sorted(
                number for number in self.elements[atoms] if number > 1
            )
            if posed.name == "LIG" and same and residue_template(residue.name) is None:
                name = residue.name
        first = len(self.elements)
        atoms = list(range(first, first + len(elements)))
        residue_index = int(self.residue_of.max(initial=-1)) + 1
        residue_index = max(residue_index, len(self.residues))
        self.elements = np.concatenate([self.elements, elements])
        self.places = np.concatenate([self.places, places])
        self.residue_of = np.concatenate([self.residue_of, np.full(len(atoms), residue_index)])
        self.dropped = np.concatenate([self.dropped, np.zeros(len(atoms), dtype=bool)])
        names = _atom_names(mol)
        self.names += names
        piece = _Piece(mol, atoms, residue_index, name, names, posed.origin, True)
        piece.chain_id, piece.residue_id, piece.insertion_code = chain_id, number, code
        self.pieces.append(piece)

    def _free_chain(self) -> str:
        used = {chain.id for chain in self.table.topology.chains()}
        used |= {piece.chain_id for piece in self.pieces}
        letters = "L" + string.ascii_uppercase + string.digits + string.ascii_lowercase
        return next((letter for letter in letters if letter not in used), "L")

    def _in_chain(self, residue: Residue) -> bool:
        """Whether a polymer's bond joins it to the residue before or after it."""
        for other, ends in (
            (residue.index - 1, (("C", "N"), ("O3'", "P"))),
            (residue.index + 1, (("N", "C"), ("P", "O3'"))),
        ):
            if not 0 <= other < len(self.residues):
                continue
            if self.residues[other].chain is not residue.chain:
                continue
            theirs = {atom.name: atom.index for atom in self.residues[other].atoms()}
            own = {atom.name: atom.index for atom in residue.atoms()}
            for outer, inner in ends:
                if outer in theirs and inner in own:
                    line = self.places[theirs[outer]] - self.places[own[inner]]
                    if np.linalg.norm(line) < _LONGEST_CHAIN_BOND:
                        return True
        return False

    def _replaced(self, ligand: NDArray[np.float64]) -> list[Residue]:
        """Residues that stand alone and are where these heavy atoms are."""
        old = len(self.table.positions)
        heavy = np.flatnonzero((self.elements[:old] > 1) & ~self.dropped[:old])
        near = _close_between(self.places[heavy], ligand, _WATER_REACH)
        found = []
        for index in dict.fromkeys(self.residue_of[heavy[near[:, 0]]].tolist()):
            residue = self.residues[index]
            if residue.name in WATERS:
                found.append(residue)
                continue
            standard = residue_template(residue.name) is not None
            hetero = bool(self.table.hetero[next(residue.atoms()).index])
            if (standard and not hetero) or self._in_chain(residue):
                continue
            own = [a.index for a in residue.atoms() if a.element.atomic_number > 1]
            close = _close_between(self.places[own], ligand, _SAME_PLACE)
            share = max(
                len(set(close[:, 0].tolist())) / len(own),
                len(set(close[:, 1].tolist())) / len(ligand),
            )
            if share >= _SAME_SHARE:
                found.append(residue)
        return found

    # === What they are bonded to

    def _label(self, index: int) -> str:
        residue = int(self.residue_of[index])
        for piece in self.pieces:
            if piece.residue == residue and piece.posed:
                chain = f" {piece.chain_id}".rstrip()
                return f"{self.names[index]} of {piece.name}{piece.residue_id}{chain}"
        return f"{self.names[index]} of {residue_label(self.residues[residue])}"

    def _distance(self, i: int, j: int) -> float:
        return float(np.linalg.norm(self.places[i] - self.places[j]))

    def _bond_as_asked(self, text: str) -> None:
        """A bond that the user names."""
        old = len(self.table.positions)
        rows = []
        for index in np.flatnonzero(~self.dropped).tolist():
            residue = int(self.residue_of[index])
            if index < old:
                own = self.residues[residue]
                key = (own.chain.id, own.name, own.id + own.insertionCode.strip())
            else:
                piece = next(piece for piece in self.pieces if piece.residue == residue)
                key = (piece.chain_id, piece.name, piece.residue_id)
            rows.append((index, *key, self.names[index]))
        i, j = two_atoms(text, rows, self.elements, self.places)
        if self.residue_of[i] == self.residue_of[j]:
            raise InputError(
                f"--covalent-bond '{text}' joins two atoms of one residue; name atoms of two."
            )
        distance = self._distance(i, j)
        if distance > LONGEST_LINK:
            raise InputError(
                f"--covalent-bond '{text}': {self._label(i)} and {self._label(j)} are "
                f"{distance:.1f} angstrom apart, which is no bond; pose the ligand within "
                f"{LONGEST_LINK:g} angstrom."
            )
        self._add_link(i, j, "as asked")

    def _link(self, piece: _Piece) -> None:
        """Bonds of a ligand that the file records, or that distances tell."""
        own = [atom for atom in piece.atoms if self.elements[atom] > 1]
        inside = set(piece.atoms)
        recorded = {
            tuple(sorted(pair)) for pair in self.table.recorded.tolist() if len(inside & {*pair})
        }
        outer = np.flatnonzero(
            (self.elements > 1) & ~self.dropped & (self.residue_of != piece.residue)
        )
        near = _close_between(self.places[own], self.places[outer], 3.0)
        pairs = sorted(
            ((own[a], int(outer[b])) for a, b in near.tolist()),
            key=lambda pair: self._distance(*pair),
        )
        told = 0
        for i, j in pairs:
            if (min(i, j), max(i, j)) in self.links:
                continue
            is_recorded = (min(i, j), max(i, j)) in recorded
            if not is_link(
                int(self.elements[i]), int(self.elements[j]), self._distance(i, j),
                recorded=is_recorded,
            ):  # fmt: skip
                continue
            if not is_recorded and (told == _MOST_LINKS or not self._may_bind(j)):
                continue
            told += not is_recorded
            self._add_link(i, j, "as the file records" if is_recorded else "by distance")

    def _may_bind(self, index: int) -> bool:
        residue = int(self.residue_of[index])
        if residue >= len(self.residues) or any(p.residue == residue for p in self.pieces):
            return True
        own = self.residues[residue]
        if own.name in WATERS or len(own) == 1:
            return False
        template = residue_template(own.name, frozenset(a.name for a in own.atoms()))
        return is_reactive(template, self.names[index], int(self.elements[index]))

    def _add_link(self, i: int, j: int, why: str) -> None:
        distance = self._distance(i, j)
        order, phrases = 1, []
        ends = ((i, j), (j, i))
        for end, partner in ends:
            piece = self._piece_of(end)
            if piece is None:
                continue
            local = piece.atoms.index(end)
            order = link_order(piece.mol, local, int(self.elements[partner]), distance)
            room, done, left = make_room(piece.mol, local, self.places[partner], order)
            if not room:
                if why == "by distance":
                    return
                raise InputError(
                    f"{self._label(end)} has no room for a bond to {self._label(partner)}: all its "
                    "valences are taken; give the ligand as it is after the reaction."
                )
            piece.left |= set(left)
            if done:
                phrases.append(done)
        self.links[(min(i, j), max(i, j))] = order
        note = f"Covalent bond {why}: {self._label(i)} - {self._label(j)}, {distance:.2f} Å"
        self.notes.append("; ".join([note, *phrases]) + ".")

    def _piece_of(self, index: int) -> _Piece | None:
        residue = self.residue_of[index]
        return next((piece for piece in self.pieces if piece.residue == residue), None)

    def _refuse_overlaps(self, piece: _Piece) -> None:
        """A posed ligand must not lie in what else is there."""
        own = np.array([atom for atom in piece.atoms if self.elements[atom] > 1])
        outer = np.flatnonzero(
            (self.elements > 1) & ~self.dropped & (self.residue_of != piece.residue)
        )
        if not len(outer):
            return
        near = _close_between(self.places[own], self.places[outer], 2.6)
        bonded = self._near_links(piece)
        clashes = []
        for i, j in ((int(own[a]), int(outer[b])) for a, b in near.tolist()):
            if (i, j) in bonded or IS_METAL[self.elements[i]] or IS_METAL[self.elements[j]]:
                continue
            distance = self._distance(i, j)
            if distance < _OVERLAP * float(_VDW[self.elements[i]] + _VDW[self.elements[j]]):
                clashes.append((distance, i, j))
        if clashes:
            distance, i, j = min(clashes)
            more = f", and {len(clashes) - 1} more pairs are too close" if clashes[1:] else ""
            raise InputError(
                f"{piece.origin} overlaps {self.source}: {self._label(i)} and {self._label(j)} are "
                f"{distance:.2f} angstrom apart{more}; give a pose that fits this structure, or "
                "leave out what is in its place."
            )
        nearest = min(
            float(np.linalg.norm(self.places[outer] - place, axis=1).min())
            for place in self.places[own]
        )
        if nearest > _FAR:
            self.notes.append(
                f"{piece.origin} is {nearest:.0f} Å from everything else; was it posed in this "
                "structure?"
            )

    def _near_links(self, piece: _Piece) -> set[tuple[int, int]]:
        """Pairs across a bond of a ligand, up to three bonds apart."""
        found = set()
        inside = set(piece.atoms)
        for pair in self.links:
            for i, j in (pair, pair[::-1]):
                if i not in inside or j in inside:
                    continue
                ours = self._shells(i, piece.residue)
                theirs = self._shells(j, int(self.residue_of[j]))
                for a, one in ours.items():
                    for b, other in theirs.items():
                        if one + other <= 2:
                            found.add((a, b))
        return found

    def _shells(self, start: int, residue: int) -> dict[int, int]:
        """Bonds from an atom to others of its residue, up to two, by distance."""
        atoms = [int(k) for k in np.flatnonzero(self.residue_of == residue) if self.elements[k] > 1]
        bonds = {start: 0}
        for step in (1, 2):
            for a in [atom for atom, count in bonds.items() if count == step - 1]:
                for b in atoms:
                    if b not in bonds and is_link(
                        int(self.elements[a]), int(self.elements[b]), self._distance(a, b)
                    ):
                        bonds[b] = step
        return bonds

    # === Hydrogens

    def _complete(self, piece: _Piece) -> None:
        """Place the hydrogens that a ligand lacks."""
        mol = piece.mol
        count = mol.GetNumAtoms()
        wanted = Chem.RWMol(mol)
        lacking = 0
        for atom in wanted.GetAtoms():
            carbon = atom.GetAtomicNum() == 6
            if self.hydrogens == "none" or (self.hydrogens == "polar" and carbon):
                atom.SetNumExplicitHs(0)
            atom.SetNoImplicit(True)
            lacking += atom.GetNumExplicitHs()
        if not lacking:
            return
        # partners show where there is no room for a hydrogen
        for i, j in self.links:
            for end, partner in ((i, j), (j, i)):
                if end in piece.atoms and partner not in piece.atoms:
                    dummy = wanted.AddAtom(Chem.Atom(0))
                    wanted.GetConformer().SetAtomPosition(dummy, self.places[partner].tolist())
                    wanted.AddBond(piece.atoms.index(end), dummy, Chem.BondType.SINGLE)
        with BlockLogs():
            try:
                operations = (
                    Chem.SANITIZE_ALL
                    ^ Chem.SANITIZE_PROPERTIES
                    ^ Chem.SANITIZE_KEKULIZE
                    ^ Chem.SANITIZE_SETAROMATICITY
                )
                wanted.UpdatePropertyCache(strict=False)
                Chem.SanitizeMol(wanted, operations)
                full = Chem.AddHs(wanted, addCoords=True)
            except (Chem.MolSanitizeException, ValueError, RuntimeError):
                self.notes.append(f"{piece.origin}: its hydrogens could not be placed.")
                return
        places = full.GetConformer().GetPositions()
        for atom in list(full.GetAtoms())[wanted.GetNumAtoms() :]:
            holder = atom.GetNeighbors()[0].GetIdx()
            line = places[atom.GetIdx()] - places[holder]
            number = mol.GetAtomWithIdx(holder).GetAtomicNum()
            length = _H_BOND_LENGTHS.get(number, 1.09)
            norm = float(np.linalg.norm(line))
            if holder < count and norm > 0:
                piece.hydrogens.append((holder, places[holder] + line * (length / norm)))
        if piece.hydrogens:
            self.notes.append(
                f"{len(piece.hydrogens)} hydrogens were placed on {piece.name} ({piece.origin})."
                if piece.posed
                else f"{len(piece.hydrogens)} hydrogens were placed on {piece.origin}."
            )

    def _note_lacking(self, piece: _Piece) -> None:
        """Atoms that are missing, unless they left for a bond."""
        bonds = sum(i in piece.atoms or j in piece.atoms for i, j in self.links)
        if piece.lacking > bonds:
            heavy = sum(self.elements[piece.atoms] > 1)
            self.notes.append(
                f"{piece.origin} lacks {piece.lacking} of the {heavy + piece.lacking} heavy atoms "
                "of its SMILES."
            )

    # === All together

    def _assembled(self) -> AtomTable:
        table = self.table
        topology = Topology()
        topology.setPeriodicBoxVectors(table.topology.getPeriodicBoxVectors())
        number = np.full(len(self.elements), -1, dtype=np.int64)
        rows: list[tuple[NDArray[np.float64], int, float, bool, bool, bool]] = []
        of_residue = {piece.residue: piece for piece in self.pieces}
        for piece in self.pieces:
            for local in piece.left:
                self.dropped[piece.atoms[local]] = True

        holders: dict[int, int] = {}  # of new hydrogens

        def add(target, piece, index, name, element, old=None) -> None:
            number[index] = len(rows)
            charge, b_factor = 0, 0.0
            if old is not None:
                charge = int(table.charges[index])
                b_factor = 0.0 if table.b_factors is None else float(table.b_factors[index])
            if piece is not None:
                local = piece.atoms.index(index)
                charge = piece.mol.GetAtomWithIdx(local).GetFormalCharge()
            hetero = piece is not None or bool(table.hetero[index])
            place = self.places[index] / _ANGSTROM if old is None else table.positions[index]
            rows.append((place, charge, b_factor, piece is not None, False, hetero))
            topology.addAtom(name, element, target, old)

        def add_hydrogens(target, piece) -> None:
            used = set(piece.names)
            last = 0
            for holder, place in piece.hydrogens:
                last += 1
                while f"H{last}" in used:
                    last += 1
                holders[len(rows)] = int(number[piece.atoms[holder]])
                rows.append((place / _ANGSTROM, 0, 0.0, True, True, True))
                topology.addAtom(f"H{last}", Element.getBySymbol("H"), target)

        for chain in table.topology.chains():
            new_chain = None
            for residue in chain.residues():
                atoms = [atom for atom in residue.atoms() if not self.dropped[atom.index]]
                if not atoms:
                    continue
                new_chain = new_chain or topology.addChain(chain.id)
                target = topology.addResidue(
                    residue.name, new_chain, residue.id, residue.insertionCode
                )
                piece = of_residue.get(residue.index)
                for atom in atoms:
                    add(target, piece, atom.index, atom.name, atom.element, atom.id)
                if piece is not None:
                    add_hydrogens(target, piece)
        for piece in self.pieces:
            if not piece.posed:
                continue
            chain = topology.addChain(piece.chain_id)
            target = topology.addResidue(piece.name, chain, piece.residue_id, piece.insertion_code)
            for index, name in zip(piece.atoms, piece.names, strict=True):
                if not self.dropped[index]:
                    element = Element.getByAtomicNumber(int(self.elements[index]))
                    add(target, piece, index, name, element)
            add_hydrogens(target, piece)

        given = {
            tuple(sorted((int(number[i]), int(number[j])))): order
            for (i, j), order in {**table.given, **self.links}.items()
            if number[i] >= 0 and number[j] >= 0
        }
        for piece in self.pieces:
            for bond in piece.mol.GetBonds():
                ends = [piece.atoms[k] for k in (bond.GetBeginAtomIdx(), bond.GetEndAtomIdx())]
                i, j = sorted(int(number[end]) for end in ends)
                given[(i, j)] = _order_code(bond)
        given |= {(holder, hydrogen): 1 for hydrogen, holder in holders.items()}
        recorded = number[table.recorded].reshape(-1, 2)
        settled = np.array([row[3] for row in rows], dtype=bool)
        if table.settled is not None:
            settled[number[: len(table.settled)][~self.dropped[: len(table.settled)]]] |= (
                table.settled[~self.dropped[: len(table.settled)]]
            )
        return AtomTable(
            topology=topology,
            positions=np.array([row[0] for row in rows]),
            charges=np.array([row[1] for row in rows], dtype=np.int32),
            recorded=recorded[(recorded >= 0).all(axis=1)],
            hetero=np.array([row[5] for row in rows], dtype=bool),
            b_factors=None if table.b_factors is None else np.array([row[2] for row in rows]),
            given=given,
            settled=settled,
            new=np.array([row[4] for row in rows], dtype=bool),
            links=[tuple(sorted((int(number[i]), int(number[j])))) for i, j in self.links],
            notes=[*table.notes, *self.notes],
        )


def _countable(mol: Chem.Mol) -> Chem.RWMol:
    """A copy whose hydrogens without a place are counted as explicit ones."""
    copy = Chem.RWMol(mol)
    if copy.GetNumConformers() > 1:
        first = Chem.Conformer(copy.GetConformer())
        copy.RemoveAllConformers()
        copy.AddConformer(first, assignId=True)
    copy.UpdatePropertyCache(strict=False)
    for atom in copy.GetAtoms():
        atom.SetNumExplicitHs(atom.GetTotalNumHs())
        atom.SetNoImplicit(True)
    return copy


def _order_code(bond: Chem.Bond) -> int:
    kind = bond.GetBondType()
    if bond.GetIsAromatic():
        return AROMATIC
    if kind in ORDER_OF_RDKIT:
        return ORDER_OF_RDKIT[kind]
    dative = (Chem.BondType.DATIVE, Chem.BondType.DATIVEL, Chem.BondType.DATIVER)
    return DATIVE if kind in (*dative, Chem.BondType.ZERO) else UNKNOWN


def _atom_names(mol: Chem.RWMol) -> list[str]:
    """The file's names where they tell atoms apart, else element and number."""
    given = []
    for atom in mol.GetAtoms():
        info = atom.GetPDBResidueInfo()
        name = atom.GetProp("_TriposAtomName") if atom.HasProp("_TriposAtomName") else ""
        given.append((name or (info.GetName() if info is not None else "")).strip())
    if all(given) and len(set(given)) == len(given) and max(map(len, given)) <= 4:
        return given
    counts: dict[str, int] = {}
    names = []
    for atom in mol.GetAtoms():
        symbol = atom.GetSymbol()
        counts[symbol] = counts.get(symbol, 0) + 1
        names.append(f"{symbol}{counts[symbol]}")
    return names


def _close_between(
    ours: NDArray[np.float64], theirs: NDArray[np.float64], cutoff: float
) -> NDArray[np.int64]:
    """(P, 2) indices of points of two sets that are nearer than the cutoff."""
    pairs = close_pairs(np.concatenate([ours, theirs]), cutoff)
    across = (pairs[:, 0] < len(ours)) & (pairs[:, 1] >= len(ours))
    return pairs[across] - np.array([0, len(ours)])
