"""Which atoms are bonded: by residue templates, by a file's records, else by distance."""

import math

import numpy as np
from numpy.typing import NDArray
from openmm.app import Residue, Topology

from .elements import COVALENT_RADII, IS_METAL, MOST_NEIGHBORS
from .neighbors import close_pairs, connects
from .residue_match import TemplateMatch, match_residue, residue_label
from .residues import DATIVE, SINGLE, UNKNOWN, WATERS

# All lengths in this file are in angstrom.
_LONGEST_LINK = 2.0  # peptide and phosphodiester bonds; a longer distance is a gap in the chain
_LONGEST_DISULFIDE = 3.0
_BOND_SLACK = 0.4  # above the sum of covalent radii, within a residue
_LINK_SLACK = 0.25  # the same between residues, where a clash must not become a bond
_RECORD_SLACK = 0.8  # the same for bonds that the file records: beyond it the record is wrong
_STRETCHED = 3.0  # no bond is that long; a molecule cut by a periodic box looks so
_LARGEST_REACH = 2.5  # of any hydrogen
_HYDROGEN_REACH = 1.3  # times the sum of covalent radii


class BondFinder:
    """Finds the bonds of one structure.

    Args:
        topology: chains, residues and atoms; its bonds are not looked at.
        positions: (N, 3) in angstrom.
        given: bonds known beforehand with their order codes, the smaller index first.
        recorded: (R, 2) bonds that a file records.
        closed: indices of residues that have no other bonds than those given.

    Attributes:
        residues: the residues in order.
        matches: each residue laid over its template, None where it has none.
        elements: (N,) atomic numbers.
        bonds: the bonds found so far with their order codes, 0 for those of ligands.
        coordination: bonds between residues that the file records for metals.
        links: bonds of ligands with other residues, each with what told it.
        notes: sentences on what is odd.

    Raises:
        InputError: a standard residue has two heavy atoms of one name.
    """

    def __init__(
        self,
        topology: Topology,
        positions: NDArray[np.float64],
        given: dict[tuple[int, int], int],
        recorded: NDArray[np.int64],
        closed: frozenset[int] = frozenset(),
    ) -> None:
        self.residues = list(topology.residues())
        self.chain_of = [residue.chain.index for residue in self.residues]
        self.atoms = list(topology.atoms())
        self.elements = np.array(
            [atom.element.atomic_number for atom in self.atoms], dtype=np.int32
        )
        self.residue_of = np.array([atom.residue.index for atom in self.atoms], dtype=np.int64)
        self.positions = positions
        self.points = positions.tolist()
        self.recorded_within: dict[int, list[tuple[int, int]]] = {}
        self.recorded_between: list[tuple[int, int]] = []
        for i, j in recorded.tolist():
            if self.residue_of[i] == self.residue_of[j]:
                self.recorded_within.setdefault(int(self.residue_of[i]), []).append((i, j))
            else:
                self.recorded_between.append((i, j))
        self.bonds: dict[tuple[int, int], int] = {}
        self.degree = [0] * len(self.atoms)
        self.notes: list[str] = []
        self.coordination: list[tuple[int, int]] = []
        self.links: dict[tuple[int, int], str] = {}
        self.given = given
        self.has_given = [False] * len(self.residues)
        for i, j in given:
            if self.residue_of[i] == self.residue_of[j]:
                self.has_given[self.residue_of[i]] = True
        self.closed = closed
        for residue in closed:
            self.has_given[residue] = True
        self.matches = [
            None if residue.index in closed else match_residue(residue) for residue in self.residues
        ]

    def find(self) -> None:
        """Fill `bonds` and `notes`."""
        # Shortest first: rigid waters come with a bond between their hydrogens, which is none.
        for i, j in sorted(self.given, key=lambda pair: self._distance(*pair)):
            if not any(self.elements[k] == 1 and self.degree[k] for k in (i, j)):
                self._add(i, j, self.given[(i, j)] or self._template_order(i, j))
        for residue, match in zip(self.residues, self.matches, strict=True):
            if not self.has_given[residue.index]:
                self._bond_residue(residue, match)
        self._bond_chain_neighbors()
        self._bond_disulfides()
        self._bond_recorded_links()
        self._bond_touching_residues()
        self._note_links()
        self._note_oddities()

    def _note_oddities(self) -> None:
        alone = [
            a for a in self.atoms if a.element.atomic_number == 1 and self.degree[a.index] == 0
        ]
        if alone:
            self.notes.append(
                f"{len(alone)} hydrogens have no atom near enough to be bonded to, "
                f"the first is {alone[0].name} of {residue_label(alone[0].residue)}."
            )
        stretched = [pair for pair in self.bonds if self._distance(*pair) > _STRETCHED]
        if stretched:
            i, j = (self.atoms[index] for index in stretched[0])
            self.notes.append(
                f"{len(stretched)} bonds are longer than {_STRETCHED:g} angstrom, the first is "
                f"{i.name}-{j.name} of {residue_label(i.residue)}, "
                f"{self._distance(*stretched[0]):.1f} angstrom."
            )

    def _template_order(self, i: int, j: int) -> int:
        residue = self.residue_of[i]
        if residue != self.residue_of[j]:
            return SINGLE
        if IS_METAL[self.elements[i]] or IS_METAL[self.elements[j]]:
            return DATIVE
        match = self.matches[residue]
        if match is None:
            return UNKNOWN
        names = [match.template.atom_name(self.atoms[k].name) for k in (i, j)]
        return match.template.bonds.get((names[0], names[1])) or match.template.bonds.get(
            (names[1], names[0]), UNKNOWN
        )

    def _add(self, i: int, j: int, order: int) -> None:
        pair = (i, j) if i < j else (j, i)
        if pair not in self.bonds:
            self.degree[i] += 1
            self.degree[j] += 1
            self.bonds[pair] = order

    def _distance(self, i: int, j: int) -> float:
        return math.dist(self.points[i], self.points[j])

    def _within(self, i: int, j: int, slack: float) -> bool:
        reach = COVALENT_RADII[self.elements[i]] + COVALENT_RADII[self.elements[j]] + slack
        return self._distance(i, j) < reach

    def _in_reach(self, hydrogen: int, heavy: int) -> bool:
        radii = COVALENT_RADII[1] + COVALENT_RADII[self.elements[heavy]]
        return self._distance(hydrogen, heavy) < _HYDROGEN_REACH * radii

    def _bond_residue(self, residue: Residue, match: TemplateMatch | None) -> None:
        indices = [atom.index for atom in residue.atoms()]
        if residue.name in WATERS:
            oxygens = [i for i in indices if self.elements[i] == 8]
            for i in indices:
                if self.elements[i] == 1 and oxygens:
                    self._add(oxygens[0], i, SINGLE)
            return
        if match is None:
            self._bond_unknown_residue(indices)
            return
        strange = list(match.unmatched)
        for (name_1, name_2), order in match.template.bonds.items():
            i, j = match.indices.get(name_1), match.indices.get(name_2)
            if i is None or j is None:
                continue
            hydrogen, heavy = (i, j) if self.elements[i] == 1 else (j, i)
            if self.elements[hydrogen] == 1 and not self._in_reach(hydrogen, heavy):
                strange.append(hydrogen)  # named by another convention than ours
                continue
            self._add(i, j, order)
        heavy = [i for i in indices if self.elements[i] > 1]
        self._bond_hydrogens([i for i in strange if self.elements[i] == 1], heavy)
        for i in strange:
            for j in heavy:
                if self.elements[i] > 1 and i != j and self._within(i, j, _BOND_SLACK):
                    self._add(i, j, self._unknown_or_dative(i, j))

    def _bond_unknown_residue(self, indices: list[int]) -> None:
        heavy = [i for i in indices if self.elements[i] > 1]
        if not heavy:
            return
        recorded = self.recorded_within.get(int(self.residue_of[heavy[0]]), [])
        recorded = [(i, j) for i, j in recorded if self._within(i, j, _RECORD_SLACK)]
        if connects(recorded, heavy):
            pairs = [(i, j) for i, j in recorded if self.elements[i] > 1 and self.elements[j] > 1]
        else:
            pairs = []
            near = close_pairs(
                self.positions[heavy], 2 * COVALENT_RADII[self.elements[heavy]].max() + 0.5
            )
            for i, j in ((heavy[a], heavy[b]) for a, b in near):
                if self._within(i, j, _BOND_SLACK):
                    pairs.append((i, j))
        # Shortest first, so that an atom with too many neighbours loses the farthest.
        for i, j in sorted(pairs, key=lambda pair: self._distance(*pair)):
            metal = IS_METAL[self.elements[i]] or IS_METAL[self.elements[j]]
            if metal or (self._has_room(i) and self._has_room(j)):
                self._add(i, j, self._unknown_or_dative(i, j))
        self._bond_hydrogens([i for i in indices if self.elements[i] == 1], heavy)

    def _bond_hydrogens(self, hydrogens: list[int], heavy: list[int]) -> None:
        hydrogens = [i for i in hydrogens if self.degree[i] == 0]
        both = hydrogens + [i for i in heavy if not IS_METAL[self.elements[i]]]
        parents: dict[int, int] = {}
        for a, b in close_pairs(self.positions[both], _LARGEST_REACH).tolist():
            hydrogen, parent = both[a], both[b]
            if not a < len(hydrogens) <= b or not self._in_reach(hydrogen, parent):
                continue
            known = parents.setdefault(hydrogen, parent)
            if self._distance(hydrogen, parent) < self._distance(hydrogen, known):
                parents[hydrogen] = parent
        for hydrogen, parent in parents.items():
            self._add(hydrogen, parent, SINGLE)

    def _unknown_or_dative(self, i: int, j: int) -> int:
        return DATIVE if IS_METAL[self.elements[i]] or IS_METAL[self.elements[j]] else UNKNOWN

    def _has_room(self, i: int) -> bool:
        return self.degree[i] < MOST_NEIGHBORS[self.elements[i]]

    def _trusted(self, residue_1: int, residue_2: int) -> bool:
        """Whether the caller gave the bonds of both residues, or all of one: then none are sought
        between them.
        """
        if residue_1 in self.closed or residue_2 in self.closed:
            return True
        return self.has_given[residue_1] and self.has_given[residue_2]

    def _atom_named(self, residue: int, name: str) -> int | None:
        match = self.matches[residue]
        if match is not None:
            return match.indices.get(name)
        return next((a.index for a in self.residues[residue].atoms() if a.name == name), None)

    def _bond_chain_neighbors(self) -> None:
        for residue in range(1, len(self.residues)):
            one_chain = self.chain_of[residue] == self.chain_of[residue - 1]
            if not one_chain or self._trusted(residue - 1, residue):
                continue
            for end, begin in (("C", "N"), ("O3'", "P")):
                i, j = self._atom_named(residue - 1, end), self._atom_named(residue, begin)
                if i is not None and j is not None and self._distance(i, j) < _LONGEST_LINK:
                    self._add(i, j, SINGLE)

    def _bond_disulfides(self) -> None:
        sulfurs = []
        for match in self.matches:
            if match is None or match.template.name != "CYS" or "HG" in match.indices:
                continue
            # A recorded disulfide is also found here, unless the record is wrong.
            if "SG" in match.indices:
                sulfurs.append(match.indices["SG"])
        pairs = [
            (sulfurs[a], sulfurs[b])
            for a, b in close_pairs(self.positions[sulfurs], _LONGEST_DISULFIDE)
        ]
        taken: set[int] = set()
        for i, j in sorted(pairs, key=lambda pair: self._distance(*pair)):
            if not {i, j} & taken and not self._trusted(self.residue_of[i], self.residue_of[j]):
                self._add(i, j, SINGLE)
                taken |= {i, j}

    def _bond_recorded_links(self) -> None:
        for i, j in self.recorded_between:
            if min(self.elements[[i, j]]) == 1:
                continue
            metal = IS_METAL[self.elements[i]] or IS_METAL[self.elements[j]]
            if any(self.atoms[k].residue.name in WATERS for k in (i, j)):
                continue  # waters come and go
            if metal and self._within(i, j, _RECORD_SLACK):
                # it holds a distance but no angles, so it is no bond of the molecule
                self.coordination.append((i, j))
                continue
            if metal or self._trusted(self.residue_of[i], self.residue_of[j]):
                continue
            if self._within(i, j, _RECORD_SLACK):
                self._add_link(i, j, "recorded")
            else:
                one, other = self.atoms[i], self.atoms[j]
                self.notes.append(
                    f"The file records a bond of {self._distance(i, j):.1f} angstrom from "
                    f"{one.name} of {residue_label(one.residue)} to {other.name} of "
                    f"{residue_label(other.residue)}; it was left out."
                )

    def _bond_touching_residues(self) -> None:
        """Bond ligands, glycans and modified residues to what they touch."""
        single = np.array([len(residue) == 1 for residue in self.residues], dtype=bool)
        open_residue = np.array([m is None for m in self.matches], dtype=bool) & ~single
        open_residue &= [residue.name not in WATERS for residue in self.residues]
        if not open_residue.any():
            return
        candidates = np.flatnonzero(
            (self.elements > 1) & ~IS_METAL[self.elements] & ~single[self.residue_of]
        )
        pairs = candidates[close_pairs(self.positions[candidates], 2.3)]
        pairs = pairs[self.residue_of[pairs[:, 0]] != self.residue_of[pairs[:, 1]]]
        pairs = pairs[open_residue[self.residue_of[pairs]].any(axis=1)]
        for i, j in sorted(pairs.tolist(), key=lambda pair: self._distance(*pair)):
            if self._trusted(self.residue_of[i], self.residue_of[j]):
                continue
            if self._within(i, j, _LINK_SLACK) and self._has_room(i) and self._has_room(j):
                self._add_link(i, j, "by distance")

    def _add_link(self, i: int, j: int, why: str) -> None:
        pair = (i, j) if i < j else (j, i)
        standard = [self.matches[self.residue_of[k]] is not None for k in pair]
        if pair not in self.bonds and not all(standard):
            self.links[pair] = why
        self._add(i, j, SINGLE)

    def _note_links(self) -> None:
        if not self.links:
            return
        words = []
        for (i, j), why in list(self.links.items())[:3]:
            one, other = self.atoms[i], self.atoms[j]
            words.append(
                f"{one.name} of {residue_label(one.residue)} - {other.name} of "
                f"{residue_label(other.residue)} ({why}, {self._distance(i, j):.2f} Å)"
            )
        more = f" and {len(self.links) - 3} more" if len(self.links) > 3 else ""
        self.notes.append(f"Covalent bonds of ligands: {', '.join(words)}{more}.")
