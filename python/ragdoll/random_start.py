"""Positions of a molecule from its bonds alone: random places, resolved by break and resolve."""

import numpy as np
from rdkit import Chem
from rdkit.Chem import rdDistGeom
from rdkit.Geometry import Point3D

from . import _core
from .errors import InputError

_ANGSTROM = 0.1  # nm
_PLANAR_DEGREE = 10.0
_KEPT_SHARE = 0.5  # of an ideal centre's volume
_TETRAHEDRAL = 3.08  # volume of four neighbours over the product of three bond lengths
_PYRAMIDAL = 0.77  # of a centre and three neighbours
_CHIRALITY, _PLANARITY = 0, 1
_TURNED = {
    Chem.ChiralType.CHI_TETRAHEDRAL_CW: 1.0,
    Chem.ChiralType.CHI_TETRAHEDRAL_CCW: -1.0,
}


def random_start(mol: Chem.Mol, seed: int = 0, *, contact_scale: float = 0.75) -> Chem.Mol:
    """A copy of the molecule with one conformer, found from random coordinates.

    Bond lengths, angles and planar units have the bounds of RDKit's distance geometry;
    stereocentres have the hand that their tags say. No embedding is involved.

    Args:
        mol: with all hydrogens; conformers it has are not looked at.
        seed: of the random places.
        contact_scale: contacts are this share of the sum of the van der Waals radii.

    Raises:
        InputError: the molecule has no atoms, or no attempt satisfied all bounds.
    """
    if mol.GetNumAtoms() == 0:
        raise InputError("The molecule has no atoms; give a molecule.")
    framework = ideal_framework(mol, contact_scale=contact_scale)
    positions, attempts = _core.random_start(framework, seed)
    if len(positions) == 0:
        raise InputError(
            f"None of {attempts} random starts satisfied all distances; embed the molecule instead."
        )
    copy = Chem.Mol(mol)
    copy.RemoveAllConformers()
    conformer = Chem.Conformer(mol.GetNumAtoms())
    for atom, place in enumerate(positions / _ANGSTROM):
        conformer.SetAtomPosition(atom, Point3D(*map(float, place)))
    copy.AddConformer(conformer, assignId=True)
    return copy


def ideal_framework(mol: Chem.Mol, *, contact_scale: float = 0.75) -> _core.Framework:
    """The framework of a molecule without positions, by the bounds of RDKit's distance geometry."""
    bounds = rdDistGeom.GetMoleculeBoundsMatrix(mol, set15bounds=False) * _ANGSTROM
    pairs, lower, upper = [], [], []
    distances = Chem.GetDistanceMatrix(mol)
    for i, j in zip(*np.nonzero(np.triu((distances >= 1) & (distances <= 3), 1)), strict=True):
        least, most = bounds[j, i], bounds[i, j]
        if distances[i, j] == 1:
            least = most = (least + most) / 2
        elif distances[i, j] == 3 and most - least > 0.03:
            continue  # a torsion that turns
        pairs.append((i, j))
        lower.append(least)
        upper.append(most)
    corners, volume_lower, volume_upper, scales, kinds = [], [], [], [], []
    for atom in mol.GetAtoms():
        centre = atom.GetIdx()
        around = [bond.GetOtherAtomIdx(centre) for bond in atom.GetBonds()]
        if len(around) not in (3, 4):
            continue
        lengths = [(bounds[i, centre] + bounds[centre, i]) / 2 for i in around[:3]]
        product = float(np.prod(lengths))
        turned = _TURNED.get(atom.GetChiralTag())
        if turned is not None:
            if len(around) == 4:
                corners.append(around)
                ideal = turned * _TETRAHEDRAL * product
            else:
                corners.append([centre, *around])
                ideal = -turned * _PYRAMIDAL * product
            kept = _KEPT_SHARE * ideal
            volume_lower.append(kept if ideal > 0 else -np.inf)
            volume_upper.append(np.inf if ideal > 0 else kept)
            scales.append(abs(ideal))
            kinds.append(_CHIRALITY)
        elif len(around) == 3 and atom.GetHybridization() == Chem.HybridizationType.SP2:
            size = product * np.sin(np.radians(120))
            play = size * np.sin(np.radians(_PLANAR_DEGREE))
            corners.append([centre, *around])
            volume_lower.append(-play)
            volume_upper.append(play)
            scales.append(size)
            kinds.append(_PLANARITY)
    return _core.ideal_framework(
        _bare(mol),
        np.array(pairs, np.int32).reshape(-1, 2),
        np.array(lower),
        np.array(upper),
        np.array(corners, np.int32).reshape(-1, 4),
        np.array(volume_lower),
        np.array(volume_upper),
        np.array(scales),
        np.array(kinds, np.uint8),
        contact_scale,
    )


def _bare(mol: Chem.Mol) -> _core.Molecule:
    """Atoms and bonds; all atoms are at one place, which nothing looks at."""
    atoms, bonds = list(mol.GetAtoms()), list(mol.GetBonds())
    ends = [(bond.GetBeginAtomIdx(), bond.GetEndAtomIdx()) for bond in bonds]
    return _core.Molecule(
        np.array([a.GetAtomicNum() for a in atoms], np.int32),
        np.array([a.GetFormalCharge() for a in atoms], np.int32),
        np.array([a.GetMass() for a in atoms]),
        np.zeros((len(atoms), 3)),
        np.array(ends, np.int32).reshape(-1, 2),
        np.ones(len(bonds), np.uint8),
        [f"{a.GetSymbol()}{a.GetIdx()}" for a in atoms],
    )
