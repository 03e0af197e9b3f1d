"""A SMILES laid over the atoms of a residue: which atom is which, by elements and bonds alone."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from rdkit import Chem
from rdkit.Geometry import Point3D
from rdkit.rdBase import BlockLogs

from .elements import COVALENT_RADII, IS_METAL
from .errors import InputError
from .neighbors import close_pairs

# All lengths in this file are in angstrom.
_BOND_SLACK = 0.4  # above the sum of covalent radii; what is a bond
_LOOSE_SLACK = 0.65  # what may be one if the SMILES says so
_HYDROGEN_REACH = 1.3  # times the sum of covalent radii
_MOST_MATCHES = 2000
_LEAST_SHARE = 0.5  # of the SMILES' atoms that a residue has at least
# lengths of bonds as shares of the sum of covalent radii
_SHARES = {
    Chem.BondType.SINGLE: 1.0,
    Chem.BondType.AROMATIC: 0.915,
    Chem.BondType.DOUBLE: 0.875,
    Chem.BondType.TRIPLE: 0.79,
}


@dataclass(frozen=True)
class LaidTemplate:
    """A residue as an RDKit molecule.

    Attributes:
        mol: its atoms in the residue's order with their places, the bonds, orders and charges of
            the SMILES; hydrogens that the residue lacks are counted as explicit ones of their
            atoms.
        lacking: heavy atoms of the SMILES that the residue does not have.
        notes: sentences on what does not agree.
    """

    mol: Chem.RWMol
    lacking: int
    notes: tuple[str, ...]


def read_smiles(name: str, smiles: str) -> Chem.Mol:
    """The molecule of a SMILES, without hydrogens.

    Raises:
        InputError: it is no SMILES, or has dummy atoms.
    """
    with BlockLogs():
        raw = Chem.MolFromSmiles(smiles, sanitize=False)
        if raw is None or raw.GetNumAtoms() == 0:
            raise InputError(f"The SMILES of {name}, '{smiles}', cannot be parsed; write it anew.")
        try:
            Chem.SanitizeMol(raw)
        except (Chem.MolSanitizeException, ValueError, RuntimeError) as error:
            reason = str(error).strip().split("\n")[0].rstrip(".")
            raise InputError(
                f"The SMILES of {name}, '{smiles}', is no molecule that makes sense: {reason}."
            ) from None
        mol = Chem.MolFromSmiles(smiles)
    if any(atom.GetAtomicNum() == 0 for atom in mol.GetAtoms()):
        raise InputError(f"The SMILES of {name}, '{smiles}', has a dummy atom; replace it.")
    return mol


def ideal_length(first: int, second: int, kind: Chem.BondType) -> float:
    """About how long a bond between two elements is, angstrom."""
    return _SHARES.get(kind, 1.0) * float(COVALENT_RADII[first] + COVALENT_RADII[second])


def lay_template(
    template: Chem.Mol,
    elements: NDArray[np.int32],
    positions: NDArray[np.float64],
    label: str,
) -> LaidTemplate:
    """Lay a SMILES over a residue.

    Heavy atoms are matched by elements and bonds; among matches that symmetry leaves, the one is
    taken whose bond orders fit the lengths best. Hydrogens of the residue stay, and say how acids
    and bases are protonated.

    Args:
        template: of read_smiles.
        elements: (n,) of the residue's atoms.
        positions: (n, 3), angstrom.
        label: what messages call the residue.

    Raises:
        InputError: they do not match; the message tells the counts of atoms.
    """
    heavy = np.flatnonzero(elements > 1)
    numbers = elements[heavy]
    places = positions[heavy]
    own = template.GetNumAtoms()
    found = _matches(template, numbers, places)
    if not found:
        raise InputError(
            f"The SMILES '{Chem.MolToSmiles(template)}' does not match {label}: it has "
            f"{own} heavy atoms ({_formula([a.GetAtomicNum() for a in template.GetAtoms()])}), the "
            f"residue {len(heavy)} ({_formula(numbers.tolist())}); give the SMILES of what is in "
            "the file."
        )
    match = min(found, key=lambda match: _misfit(template, numbers, places, match))
    mol, notes = _built(template, match, heavy, elements, positions, label)
    return LaidTemplate(mol, own - len(heavy), tuple(notes))


def _formula(numbers: list[int]) -> str:
    counts: dict[str, int] = {}
    for number in sorted(numbers, key=lambda number: (number != 6, number)):
        symbol = Chem.GetPeriodicTable().GetElementSymbol(number)
        counts[symbol] = counts.get(symbol, 0) + 1
    return "".join(f"{symbol}{count if count > 1 else ''}" for symbol, count in counts.items())


def _skeleton(numbers: list[int], pairs: list[tuple[int, int]]) -> Chem.RWMol:
    """Atoms and bonds without orders, charges and hydrogens."""
    mol = Chem.RWMol()
    for number in numbers:
        atom = Chem.Atom(int(number))
        atom.SetNoImplicit(True)
        mol.AddAtom(atom)
    for i, j in pairs:
        mol.AddBond(int(i), int(j), Chem.BondType.SINGLE)
    mol.UpdatePropertyCache(strict=False)
    Chem.FastFindRings(mol)
    return mol


def _near(numbers: NDArray[np.int32], places: NDArray[np.float64], slack: float):
    radii = COVALENT_RADII[numbers]
    pairs = close_pairs(places, 2 * radii.max() + slack)
    if not len(pairs):
        return []
    distances = np.linalg.norm(places[pairs[:, 0]] - places[pairs[:, 1]], axis=1)
    reach = radii[pairs].sum(axis=1) + slack
    return [tuple(pair) for pair in pairs[distances < reach].tolist()]


def _matches(
    template: Chem.Mol, numbers: NDArray[np.int32], places: NDArray[np.float64]
) -> list[tuple[int, ...]]:
    """For each heavy atom of the residue the atom of the template, every way that there is."""
    count, own = len(numbers), template.GetNumAtoms()
    if count == 0 or count > own or count < _LEAST_SHARE * own:
        return []
    skeleton = _skeleton(
        [atom.GetAtomicNum() for atom in template.GetAtoms()],
        [(bond.GetBeginAtomIdx(), bond.GetEndAtomIdx()) for bond in template.GetBonds()],
    )
    settings = Chem.SubstructMatchParameters()
    settings.uniquify = False
    settings.maxMatches = _MOST_MATCHES
    if count == own:
        # bonds that the SMILES does not have may be there: atoms of poor structures touch
        for slack in (_BOND_SLACK, _LOOSE_SLACK):
            residue = _skeleton(numbers.tolist(), _near(numbers, places, slack))
            found = residue.GetSubstructMatches(skeleton, settings)
            if found:
                return [tuple(np.argsort(match).tolist()) for match in found]
        return []
    residue = _skeleton(numbers.tolist(), _near(numbers, places, _BOND_SLACK))
    return [tuple(match) for match in skeleton.GetSubstructMatches(residue, settings)]


def _misfit(
    template: Chem.Mol,
    numbers: NDArray[np.int32],
    places: NDArray[np.float64],
    match: tuple[int, ...],
) -> float:
    """Squares of what bonds are off their usual lengths."""
    where = {atom: k for k, atom in enumerate(match)}
    total = 0.0
    for bond in template.GetBonds():
        i, j = where.get(bond.GetBeginAtomIdx()), where.get(bond.GetEndAtomIdx())
        if i is None or j is None or IS_METAL[numbers[i]] or IS_METAL[numbers[j]]:
            continue
        length = float(np.linalg.norm(places[i] - places[j]))
        total += (length - ideal_length(numbers[i], numbers[j], bond.GetBondType())) ** 2
    return total


def _built(
    template: Chem.Mol,
    match: tuple[int, ...],
    heavy: NDArray[np.int64],
    elements: NDArray[np.int32],
    positions: NDArray[np.float64],
    label: str,
) -> tuple[Chem.RWMol, list[str]]:
    """The residue's atoms with the template's bonds."""
    mol = Chem.RWMol()
    source: dict[int, int] = {int(heavy[k]): atom for k, atom in enumerate(match)}
    for index, element in enumerate(elements.tolist()):
        atom = Chem.Atom(int(element))
        atom.SetNoImplicit(True)
        if index in source:
            theirs = template.GetAtomWithIdx(source[index])
            atom.SetFormalCharge(theirs.GetFormalCharge())
            atom.SetIsAromatic(theirs.GetIsAromatic())
            atom.SetNumExplicitHs(theirs.GetTotalNumHs())
        mol.AddAtom(atom)
    where = {atom: index for index, atom in source.items()}
    for bond in template.GetBonds():
        i, j = where.get(bond.GetBeginAtomIdx()), where.get(bond.GetEndAtomIdx())
        if i is not None and j is not None:
            mol.AddBond(i, j, bond.GetBondType())
            mol.GetBondBetweenAtoms(i, j).SetIsAromatic(bond.GetIsAromatic())
    notes = _take_hydrogens(mol, heavy, elements, positions, label)
    conformer = Chem.Conformer(len(elements))
    conformer.Set3D(True)
    for index, place in enumerate(positions.tolist()):
        conformer.SetAtomPosition(index, Point3D(*place))
    mol.AddConformer(conformer, assignId=True)
    notes += _stereo_notes(template, mol, source, label)
    return mol, notes


def _take_hydrogens(
    mol: Chem.RWMol,
    heavy: NDArray[np.int64],
    elements: NDArray[np.int32],
    positions: NDArray[np.float64],
    label: str,
) -> list[str]:
    """Bond the residue's own hydrogens; where these say so, acids and bases change their charge."""
    own = np.flatnonzero(elements == 1)
    if not len(own):
        return []
    borne: dict[int, int] = {}
    lost = 0
    for hydrogen in own.tolist():
        distances = np.linalg.norm(positions[heavy] - positions[hydrogen], axis=1)
        nearest = int(distances.argmin())
        parent = int(heavy[nearest])
        reach = _HYDROGEN_REACH * (COVALENT_RADII[1] + COVALENT_RADII[elements[parent]])
        if distances[nearest] > reach:
            lost += 1
            continue
        mol.AddBond(parent, hydrogen, Chem.BondType.SINGLE)
        borne[parent] = borne.get(parent, 0) + 1
    polar = any(elements[parent] in (7, 8, 16) for parent in borne)
    changed = []
    for atom in mol.GetAtoms():
        index = atom.GetIdx()
        if atom.GetAtomicNum() == 1:
            continue
        told, have = atom.GetNumExplicitHs(), borne.get(index, 0)
        atom.SetNumExplicitHs(max(0, told - have))
        number, charge = atom.GetAtomicNum(), atom.GetFormalCharge()
        if have > told and number in (7, 8, 16):
            atom.SetFormalCharge(charge + have - told)
            changed.append(index)
        elif have < told and polar and (number in (8, 16) or (number == 7 and charge > 0)):
            # hydrogens on N, O and S are what the file tells; this one is not there
            less = told - have if number != 7 else min(told - have, charge)
            atom.SetFormalCharge(charge - less)
            atom.SetNumExplicitHs(told - have - less)
            changed.append(index)
    notes = []
    if changed:
        notes.append(
            f"{label}: {len(changed)} atoms have other charges than in the SMILES, as the file's "
            "hydrogens say."
        )
    if lost:
        notes.append(f"{label}: {lost} hydrogens have no atom near enough to be bonded to.")
    return notes


def _stereo_notes(
    template: Chem.Mol, mol: Chem.RWMol, source: dict[int, int], label: str
) -> list[str]:
    """A note where the coordinates have another hand than the SMILES."""
    if len(source) < template.GetNumAtoms():
        return []
    stated = dict(Chem.FindMolChiralCenters(template, useLegacyImplementation=True))
    if not stated:
        return []
    copy = Chem.Mol(mol)
    with BlockLogs():
        try:
            Chem.SanitizeMol(copy)
            copy = Chem.RemoveHs(copy)
            Chem.AssignStereochemistryFrom3D(copy)
        except (Chem.MolSanitizeException, ValueError, RuntimeError):
            return []
    found = dict(Chem.FindMolChiralCenters(copy, useLegacyImplementation=True))
    heavy = sorted(source)  # RemoveHs keeps the order of heavy atoms
    other = [
        k
        for k, index in enumerate(heavy)
        if k in found and source[index] in stated and found[k] != stated[source[index]]
    ]
    if not other:
        return []
    return [
        f"{label}: {len(other)} of {len(stated)} centres have the other hand than in the SMILES; "
        "the coordinates are kept."
    ]
