"""Heavy atoms and loops that a structure lacks, built by PDBFixer."""

import random
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from openmm.app import Element, Residue, Topology
from openmm.unit import nanometer

from .hydrogens import make_fixer, one_thread, with_standard_names
from .missing_residues import MissingResidues, Place
from .molecule import Molecule
from .residue_match import TemplateMatch, match_residue
from .residues import residue_template

_SELENIUM, _SULFUR = 34, 16
# of methionine, nm
_CG_SD, _SD_CE = 0.1803, 0.1791


def standard_name(residue: Residue, match: TemplateMatch | None) -> str | None:
    """The standard residue that a modified one comes from; None for others.

    Residues that the templates know by another name (HIE, CYX), and D amino acids, are not modified
    ones: the latter would have to be mirrored.
    """
    from pdbfixer.pdbfixer import substitutions

    if residue.name in ("MSE", "SEC", "CSE"):
        return "MET" if residue.name == "MSE" else "CYS"
    name = substitutions.get(residue.name)
    heavy = {atom.name for atom in residue.atoms() if atom.element.atomic_number > 1}
    is_mirrored = residue.name[0] == "D" and name is not None and residue.name != "DHA"
    if match is not None or is_mirrored or not {"N", "CA", "C", "O"} <= heavy:
        return None
    return name


@dataclass(frozen=True)
class Repaired:
    """A structure with its heavy atoms complete.

    Attributes:
        topology: chains, residues and atoms, no bonds.
        positions: (N, 3) in nm.
        origin: (N,) the old atom that each is, -1 for new ones.
        built: indices of residues that were not there.
        completed: indices of residues that got atoms.
    """

    topology: Topology
    positions: NDArray[np.float64]
    origin: NDArray[np.int64]
    built: list[int]
    completed: list[int]


def repair(
    molecule: Molecule,
    keep: NDArray[np.bool_],
    replacements: dict[int, str],
    loops: list[MissingResidues],
    seed: int,
) -> Repaired:
    """Replace residues, and build missing loops and heavy atoms; atoms that stay do not move,
    except that sulfur takes the place of selenium at its own bond length.

    Args:
        molecule: with all its atoms.
        keep: (N,) which atoms stay.
        replacements: names of standard residues, by the index of the residue that they replace.
        loops: missing residues to build.
        seed: of the search for free places.
    """
    residues = list(molecule.topology.residues())
    matches = [match_residue(residue) for residue in residues]
    named = with_standard_names(molecule.topology, matches)
    positions = np.array(molecule.positions)
    keep = keep.copy()
    # residues by place in the file, before others go
    by_place: dict[Place, Residue] = {}
    for residue in named.residues():
        place = (residue.chain.id, int(residue.id), residues[residue.index].insertionCode.strip())
        by_place.setdefault(place, residue)
    beside = {
        by_place[place].index
        for loop in loops
        for place in (loop.before, loop.after)
        if place in by_place
    }
    for residue in named.residues():
        if residue.index in replacements:
            _replace(residue, replacements[residue.index], keep, positions)
        if residue.index in beside:  # its ends are no longer ends
            for atom in residue.atoms():
                if atom.element.atomic_number == 1 or atom.name == "OXT":
                    keep[atom.index] = False
    bare, old_atoms, old_residues = _kept(named, keep, residues)
    fixer = make_fixer(bare, positions[old_atoms])
    fixer.missingResidues = _insertions(bare, old_residues, by_place, loops)
    fixer.nonstandardResidues = []
    fixer.findMissingAtoms()
    state = random.getstate()
    random.seed(1)
    try:
        with one_thread():
            fixer.addMissingAtoms(seed=seed)
    finally:
        random.setstate(state)
    return _collect(fixer, residues, old_atoms, old_residues, positions, replacements)


def _replace(
    residue: Residue, name: str, keep: NDArray[np.bool_], positions: NDArray[np.float64]
) -> None:
    """Rename a residue to a standard one; what that does not have goes."""
    atoms = {atom.name: atom for atom in residue.atoms()}
    selenium = next((a for a in atoms.values() if a.element.atomic_number == _SELENIUM), None)
    residue.name = name
    template = residue_template(name)
    if selenium is not None:
        selenium.name = "SD" if name == "MET" else "SG"
        selenium.element = Element.getByAtomicNumber(_SULFUR)
        before = atoms.get("CG" if name == "MET" else "CB")
        if before is not None:
            old = positions[selenium.index].copy()
            start = positions[before.index]
            length = _CG_SD if name == "MET" else 0.1808
            positions[selenium.index] = start + (old - start) * length / np.linalg.norm(old - start)
            end = atoms.get("CE")
            if end is not None:
                along = positions[end.index] - old
                positions[end.index] = positions[selenium.index] + along * _SD_CE / np.linalg.norm(
                    along
                )
    for atom in residue.atoms():
        if atom.element.atomic_number == 1 or atom.name not in {*template.elements, "OXT"}:
            keep[atom.index] = False


def _kept(
    topology: Topology, keep: NDArray[np.bool_], residues: list[Residue]
) -> tuple[Topology, NDArray[np.int64], list[int]]:
    """The atoms that stay, with their bonds; their old indices, and those of the residues."""
    result = Topology()
    atoms, old_atoms, old_residues = {}, [], []
    for chain in topology.chains():
        new_chain = None
        for residue in chain.residues():
            new_residue = None
            for atom in residue.atoms():
                if not keep[atom.index]:
                    continue
                if new_chain is None:
                    new_chain = result.addChain(chain.id)
                if new_residue is None:
                    code = residues[residue.index].insertionCode
                    new_residue = result.addResidue(residue.name, new_chain, residue.id, code)
                    old_residues.append(residue.index)
                atoms[atom.index] = result.addAtom(atom.name, atom.element, new_residue)
                old_atoms.append(atom.index)
    for one, other in topology.bonds():
        if one.index in atoms and other.index in atoms:
            result.addBond(atoms[one.index], atoms[other.index])
    return result, np.array(old_atoms, dtype=np.int64), old_residues


def _insertions(
    topology: Topology,
    old_residues: list[int],
    by_place: dict[Place, Residue],
    loops: list[MissingResidues],
) -> dict[tuple[int, int], list[str]]:
    """PDBFixer's table of missing residues: (chain, index within it): names."""
    from pdbfixer.pdbfixer import substitutions

    new_index = {old: new for new, old in enumerate(old_residues)}
    residues = list(topology.residues())
    found = {}
    for loop in loops:
        names = [substitutions.get(name, name) for name in loop.names]
        place = loop.after or loop.before
        old = by_place.get(place)
        if old is None or old.index not in new_index:
            continue
        residue = residues[new_index[old.index]]
        within = list(residue.chain.residues()).index(residue)
        found[residue.chain.index, within + (loop.after is None)] = names
    return found


def _collect(
    fixer,
    residues: list[Residue],
    old_atoms: NDArray[np.int64],
    old_residues: list[int],
    positions: NDArray[np.float64],
    replacements: dict[int, str],
) -> Repaired:
    """PDBFixer's result under the names of the file, with ids of their own for new residues."""
    placed = np.array(fixer.positions.value_in_unit(nanometer), dtype=np.float64)
    old_names = {atom.index: atom.name for residue in residues for atom in residue.atoms()}
    index_at = {tuple(positions[atom]): atom for atom in old_atoms.tolist()}
    topology = Topology()
    order: list[int] = []
    origin: list[int] = []
    built: list[int] = []
    completed: list[int] = []
    olds = iter(old_residues)
    for chain in fixer.topology.chains():
        new_chain = topology.addChain(chain.id)
        used = {
            (r.id, r.insertionCode.strip())
            for r in chain.residues()
            if any(tuple(placed[a.index]) in index_at for a in r.atoms())
        }
        last = ""
        for residue in chain.residues():
            known = [index_at.get(tuple(placed[atom.index]), -1) for atom in residue.atoms()]
            is_old = max(known, default=-1) >= 0
            number, code = residue.id, residue.insertionCode
            if is_old:
                old = residues[next(olds)]
                replaced = old.index in replacements
                name = residue.name if replaced else old.name
            else:
                name = residue.name
                number, code = _free_id(number, last, used)
                used.add((number, code))
            last = number
            target = topology.addResidue(name, new_chain, number, code)
            if not is_old:
                built.append(target.index)
            elif any(
                k < 0 and a.element.atomic_number > 1
                for k, a in zip(known, residue.atoms(), strict=True)
            ):
                completed.append(target.index)
            for atom, k in zip(residue.atoms(), known, strict=True):
                if k < 0 and atom.element.atomic_number == 1:
                    continue  # hydrogens come later, all by one hand
                own = old_names.get(k, "") if is_old and not replaced else ""
                # deuterium goes under the names of hydrogen
                deuterium = own[:1] == "D" and atom.element.atomic_number == 1
                topology.addAtom(own if own and not deuterium else atom.name, atom.element, target)
                order.append(atom.index)
                origin.append(k)
    return Repaired(topology, placed[order], np.array(origin, dtype=np.int64), built, completed)


def _free_id(number: str, last: str, used: set[tuple[str, str]]) -> tuple[str, str]:
    """A number of its own; where it is taken, the number before with a letter."""
    if (number, "") not in used and (not last or int(number) > int(last)):
        return number, ""
    for letter in "ABCDEFGHIJKLMNOPQRSTUVWXYZ":
        if (last, letter) not in used:
            return last, letter
    return number, "Z"
