"""What the torsions of a molecule prefer, by RDKit's tables from crystal structures."""

import numpy as np
from numpy.typing import NDArray
from rdkit import Chem
from rdkit.Chem import rdDistGeom

_KILOJOULES = 4.184  # per kcal
_TABLE_VERSION = 2  # that of ETKDGv2 and v3
_MACROCYCLE = 9  # atoms in a ring, at least


def torsion_terms(
    mol: Chem.Mol, *, small_rings: bool = False, macrocycles: bool = True
) -> tuple[NDArray[np.int32], NDArray[np.float64], NDArray[np.int32]]:
    """Terms E(phi) = sum over k = 1..6 of amplitude_k (1 + sign_k cos(k phi)).

    They are those that ETKDGv3 embeds with: at most one a bond, in the tables' order. Riniker and
    Landrum, J. Chem. Inf. Model. 55, 2562 (2015); Wang et al., ibid. 60, 2044 (2020). The C++
    function of this name gives the same, whatever RDKit it has: a macrocycle's bond to an atom that
    is also in a smaller ring has no term, since versions of the tables differ there (2022.09 has
    none, 2026.09 has some for amides).

    Args:
        mol: sanitized, hydrogens explicit.
        small_rings: also bonds in rings of up to eight atoms.
        macrocycles: also bonds in rings of nine atoms and more.

    Returns:
        Atoms a, b, c, d of each term (n, 4) int32; amplitudes (n, 6) float64 in kJ/mol;
        signs (n, 6) int32, 1 or -1.
    """
    found = rdDistGeom.GetExperimentalTorsions(
        mol,
        useExpTorsionAnglePrefs=True,
        useSmallRingTorsions=small_rings,
        useMacrocycleTorsions=macrocycles,
        useBasicKnowledge=False,
        ETversion=_TABLE_VERSION,
    )
    found = [term for term in found if not _differs_by_version(mol, term["bondIndex"])]
    atoms = np.array([list(term["atomIndices"]) for term in found], dtype=np.int32)
    amplitudes = np.array([list(term["V"]) for term in found], dtype=np.float64)
    signs = np.array([list(term["signs"]) for term in found], dtype=np.int32)
    return (
        atoms.reshape(-1, 4),
        amplitudes.reshape(-1, 6) * _KILOJOULES,
        signs.reshape(-1, 6),
    )


def _differs_by_version(mol: Chem.Mol, index: int) -> bool:
    rings = mol.GetRingInfo()
    if rings.MinBondRingSize(index) < _MACROCYCLE:  # 0 out of rings
        return False
    bond = mol.GetBondWithIdx(index)
    ends = (bond.GetBeginAtomIdx(), bond.GetEndAtomIdx())
    return any(rings.MinAtomRingSize(end) < _MACROCYCLE for end in ends)
