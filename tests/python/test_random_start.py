"""Positions from random places, by bonds alone."""

import numpy as np
import pytest
from rdkit import Chem
from rdkit.Chem import rdDistGeom

from ragdoll.errors import InputError
from ragdoll.random_start import random_start

CYCLOSPORIN_A = (
    "CC[C@H]1C(=O)N(CC(=O)N([C@H](C(=O)N[C@H](C(=O)N([C@H](C(=O)N[C@H](C(=O)N[C@@H](C(=O)N([C@H]"
    "(C(=O)N([C@H](C(=O)N([C@H](C(=O)N([C@H](C(=O)N1)[C@@H]([C@H](C)C/C=C/C)O)C)C(C)C)C)CC(C)C)C)"
    "CC(C)C)C)C)C)CC(C)C)C)C(C)C)CC(C)C)C)C"
)
MOLECULES = {
    "alanine": "C[C@H](N)C(=O)O",
    "two halogens": "C[C@H](O)[C@@H](F)Cl",
    "E-alkene": "C/C=C/CC(=O)NC",
    "Z-alkene": "C/C=C\\CC(=O)NC",
    "alkyne": "C[C@@H](O)C#CC",
    "benzylpiperazine": "c1ccccc1CN1CCN(C)CC1",
    "testosterone": "C[C@]12CC[C@H]3[C@H]([C@@H]1CC[C@@H]2O)CCC4=CC(=O)CC[C@]34C",
    "cyclosporin A": CYCLOSPORIN_A,
}


def hydrogenated(smiles):
    return Chem.AddHs(Chem.MolFromSmiles(smiles))


def configuration(mol):
    """SMILES by the positions alone."""
    copy = Chem.Mol(mol)
    for atom in copy.GetAtoms():
        atom.SetChiralTag(Chem.ChiralType.CHI_UNSPECIFIED)
    for bond in copy.GetBonds():
        bond.SetStereo(Chem.BondStereo.STEREONONE)
    Chem.AssignStereochemistryFrom3D(copy)
    return Chem.MolToSmiles(Chem.RemoveHs(copy))


@pytest.mark.parametrize("name", MOLECULES)
def test_configuration_is_what_the_smiles_says(name):
    mol = hydrogenated(MOLECULES[name])
    for seed in range(2):
        found = random_start(mol, seed)
        assert configuration(found) == Chem.MolToSmiles(Chem.RemoveHs(mol))


def test_bonds_have_the_lengths_of_distance_geometry_and_atoms_keep_apart():
    mol = hydrogenated(CYCLOSPORIN_A)
    x = random_start(mol, 3).GetConformer().GetPositions()
    bounds = rdDistGeom.GetMoleculeBoundsMatrix(mol, set15bounds=False)
    for bond in mol.GetBonds():
        i, j = sorted((bond.GetBeginAtomIdx(), bond.GetEndAtomIdx()))
        length = np.linalg.norm(x[i] - x[j])
        assert 0.99 * bounds[j, i] < length < 1.01 * bounds[i, j]
    apart = Chem.GetDistanceMatrix(mol) > 3
    distances = np.linalg.norm(x[:, None] - x[None], axis=-1)
    assert distances[apart].min() > 1.1


def test_the_same_seed_gives_the_same_positions_and_another_seed_others():
    mol = hydrogenated("C[C@H](N)C(=O)NCC(=O)O")
    one, again, other = (random_start(mol, s).GetConformer().GetPositions() for s in (1, 1, 2))
    assert np.array_equal(one, again)
    assert not np.allclose(one, other)


def test_what_has_no_atoms_is_refused():
    with pytest.raises(InputError, match="no atoms"):
        random_start(Chem.Mol())


def test_a_centre_that_cannot_be_is_told():
    # trans across a bicycle so small that the hands of its bridgeheads contradict each other
    mol = hydrogenated("C1C[C@@H]2C[C@@H]1C2")
    twisted = Chem.Mol(mol)
    centre = [a for a in twisted.GetAtoms() if a.GetDegree() == 4 and a.GetTotalNumHs(True) == 1][0]
    centre.InvertChirality()
    if centre.GetChiralTag() == Chem.ChiralType.CHI_UNSPECIFIED:
        pytest.skip("RDKit sees no centre here")
    with pytest.raises(InputError, match="random starts"):
        random_start(twisted)
