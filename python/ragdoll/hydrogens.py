"""Missing hydrogens, placed by PDBFixer."""

import io
import random
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray
from openmm import Platform, Vec3
from openmm.app import Element, Residue, Topology
from openmm.unit import nanometer

from .ligand_hydrogens import place_ligand_hydrogens
from .residue_match import TemplateMatch, match_residue, residue_label
from .residues import WATERS

# PDBFixer spreads hydrogens by repulsion, which leaves them some 0.02 nm too far out; these are the
# lengths (nm) of force fields.
_BOND_LENGTHS = {6: 0.109, 7: 0.101, 8: 0.096, 16: 0.134, 34: 0.146}

_NO_RESIDUE = "UNL"
_HYDROGEN = Element.getBySymbol("H")

# PDBFixer starts from a file; its atoms are replaced at once.
_ANY_ATOM = "HETATM    1  O   HOH A   1       0.000   0.000   0.000  1.00  0.00           O\nEND\n"

# Protonation states that a residue name states.
_VARIANTS = {
    "HID": "HID", "HSD": "HID", "HIE": "HIE", "HSE": "HIE", "HIP": "HIP", "HSP": "HIP",
    "ASH": "ASH", "GLH": "GLH", "LYN": "LYN", "CYX": "CYX", "CYM": "CYX",
}  # fmt: skip


def add_hydrogens(
    topology: Topology,
    positions: NDArray[np.float64],
    ph: float,
    closed: frozenset[int] = frozenset(),
) -> tuple[Topology, NDArray[np.float64], NDArray[np.int64], list[str]]:
    """Add the hydrogens that standard residues lack; no atom that is there is moved or removed.

    Args:
        topology: with all bonds between its atoms.
        positions: (N, 3) in nm.
        ph: decides the protonation of ASP, GLU, HIS, LYS and CYS by their usual acidities.
        closed: indices of residues that have the hydrogens that they need.

    Returns:
        A topology with the hydrogens, each right after its atom; positions (M, 3) in nm; for
        each atom the index of the old atom that it is or is bonded to (M,); notes.
    """
    residues = list(topology.residues())
    matches = [None if residue.index in closed else match_residue(residue) for residue in residues]
    variants = [_variant(residue, match) for residue, match in zip(residues, matches, strict=True)]
    named = with_standard_names(topology, matches, closed)
    fixed, placed = _run_pdbfixer(named, positions, variants, ph)

    bare = [
        residue
        for residue, match in zip(residues, matches, strict=True)
        if match is None
        and residue.name not in WATERS
        and len(residue) > 1
        and residue.index not in closed
    ]
    of_ligands: dict[int, list[NDArray[np.float64]]] = {}
    left_bare = []
    for residue in bare:
        found = place_ligand_hydrogens(residue, topology, positions, ph)
        if found is None:
            left_bare.append(residue_label(residue))
        else:
            of_ligands |= found

    result = Topology()
    kept: list[int] = []
    origin: list[int] = []
    names: dict[int, int] = {}  # the last number of a ligand's hydrogens
    for residue in bare:
        names[residue.index] = sum(a.element.atomic_number == 1 for a in residue.atoms())
    new_residues = iter(fixed.residues())
    for chain in topology.chains():
        new_chain = result.addChain(chain.id)
        for residue in chain.residues():
            target = result.addResidue(residue.name, new_chain, residue.id, residue.insertionCode)
            old = list(residue.atoms())
            step = 0
            for atom in next(new_residues).atoms():
                # Old atoms stay in order and in place; what stands between them is new.
                known = step < len(old) and np.allclose(
                    placed[atom.index], positions[old[step].index], atol=1e-5
                )
                if known:
                    result.addAtom(old[step].name, old[step].element, target, old[step].id)
                    origin.append(old[step].index)
                    step += 1
                else:
                    result.addAtom(atom.name, atom.element, target)
                    origin.append(old[step - 1].index)
                kept.append(atom.index)
                if known:
                    for place in of_ligands.get(old[step - 1].index, ()):
                        names[residue.index] = names.get(residue.index, 0) + 1
                        result.addAtom(f"H{names[residue.index]}", _HYDROGEN, target)
                        origin.append(old[step - 1].index)
                        kept.append(len(placed))
                        placed = np.vstack([placed, place])
    notes = [f"{len(kept) - len(positions)} hydrogens were added for pH {ph:g}."]
    if left_bare:
        notes.append(
            f"No hydrogens were added to {', '.join(left_bare[:5])}"
            f"{' and others' if len(left_bare) > 5 else ''}: their bonds do not say which they "
            "need."
        )
    placed = placed[kept]
    is_old = np.zeros(len(kept), dtype=bool)
    is_old[np.unique(origin, return_index=True)[1]] = True
    placed[is_old] = positions  # the CPU platform may have rounded them
    numbers = [atom.element.atomic_number for atom in topology.atoms()]
    for index in np.flatnonzero(~is_old):
        parent = positions[origin[index]]
        outward = placed[index] - parent
        length = _BOND_LENGTHS.get(numbers[origin[index]], 0.109)
        placed[index] = parent + outward * (length / np.linalg.norm(outward))
    return result, placed, np.array(origin, dtype=np.int64), notes


def _run_pdbfixer(
    topology: Topology, positions: NDArray[np.float64], variants: list[str | None], ph: float
) -> tuple[Topology, NDArray[np.float64]]:
    """The topology and positions (nm) with PDBFixer's hydrogens, the same on every machine."""
    fixer = make_fixer(topology, positions, variants)
    # PDBFixer draws first places of hydrogens from Python's global generator
    state = random.getstate()
    random.seed(1)
    try:
        with one_thread():
            fixer.addMissingHydrogens(pH=ph)
    finally:
        random.setstate(state)
    return fixer.topology, np.array(fixer.positions.value_in_unit(nanometer), dtype=np.float64)


def make_fixer(
    topology: Topology, positions: NDArray[np.float64], variants: list[str | None] | None = None
):
    """A PDBFixer of these atoms that asks no server.

    Args:
        topology: with the names and bonds that PDBFixer knows.
        positions: (N, 3) in nm.
        variants: protonation state of each residue, or None for what the pH says.
    """
    from pdbfixer import PDBFixer

    class Fixer(PDBFixer):
        def _downloadCCDDefinition(self, residueName):
            return None  # else the result would depend on the network

        def _describeVariant(self, residue, definitions):
            return None if variants is None else variants[residue.index]

    # OpenCL on PoCL has crashed here
    fixer = Fixer(pdbfile=io.StringIO(_ANY_ATOM), platform=Platform.getPlatformByName("CPU"))
    fixer.topology = topology
    fixer.positions = [Vec3(*p) for p in positions.tolist()] * nanometer
    return fixer


@contextmanager
def one_thread() -> Iterator[None]:
    """OpenMM's CPU platform on one thread: several add up forces in any order."""
    platform = Platform.getPlatformByName("CPU")
    threads = platform.getPropertyDefaultValue("Threads")
    platform.setPropertyDefaultValue("Threads", "1")
    try:
        yield
    finally:
        platform.setPropertyDefaultValue("Threads", threads)


def with_standard_names(
    topology: Topology,
    matches: list[TemplateMatch | None],
    closed: frozenset[int] = frozenset(),
) -> Topology:
    """Copy a topology under the names that PDBFixer's table of hydrogens uses; residues that are
    ``closed`` get one that it does not know.
    """
    copy = Topology()
    atoms = []
    for chain in topology.chains():
        new_chain = copy.addChain(chain.id)
        for residue in chain.residues():
            match = matches[residue.index]
            standard = match.template.name if match else residue.name
            if residue.index in closed:
                standard = _NO_RESIDUE
            target = copy.addResidue(
                "HOH" if residue.name in WATERS else standard, new_chain, residue.id
            )
            names = {index: name for name, index in match.indices.items()} if match else {}
            for atom in residue.atoms():
                name = names.get(atom.index, atom.name)
                if residue.name in WATERS and atom.element.atomic_number == 8:
                    name = "O"
                atoms.append(copy.addAtom(name, atom.element, target))
    for bond in topology.bonds():
        copy.addBond(atoms[bond[0].index], atoms[bond[1].index])
    return copy


def _variant(residue: Residue, match: TemplateMatch | None) -> str | None:
    # A stated variant makes PDBFixer remove hydrogens, so it is stated only where there are none.
    if match is None or any(atom.element.atomic_number == 1 for atom in residue.atoms()):
        return None
    if match.template.name == "HIS" and not {"ND1", "NE2"} <= match.indices.keys():
        return "HID"  # PDBFixer cannot choose between the nitrogens of an incomplete ring
    return _VARIANTS.get(residue.name)
