"""Conformers of RDKit molecules by the core's sampler."""

import numpy as np
import pytest
from rdkit import Chem
from rdkit.Chem import rdDistGeom, rdMolTransforms

from ragdoll import _core
from ragdoll.framework import core_molecule
from ragdoll.molecule import Molecule


def embedded(smiles):
    mol = Chem.AddHs(Chem.MolFromSmiles(smiles))
    assert rdDistGeom.EmbedMolecule(mol, randomSeed=42) == 0
    return mol


def sampled(mol, **settings):
    terms = rdDistGeom.GetExperimentalTorsions(mol)
    found = _core.sample_conformers(
        core_molecule(Molecule.from_rdkit(mol)),
        np.array([list(t["atomIndices"]) for t in terms], np.int32).reshape(-1, 4),
        np.array([list(t["V"]) for t in terms], float).reshape(-1, 6),
        np.array([list(t["signs"]) for t in terms], np.int32).reshape(-1, 6),
        **settings,
    )
    result = Chem.Mol(mol)
    result.RemoveAllConformers()
    for frame in found["positions"]:
        conformer = Chem.Conformer(mol.GetNumAtoms())
        conformer.SetPositions(frame * 10)
        result.AddConformer(conformer, assignId=True)
    return result, found


def configuration(mol, conformer):
    copy = Chem.Mol(mol)
    for atom in copy.GetAtoms():
        atom.SetChiralTag(Chem.ChiralType.CHI_UNSPECIFIED)
    for bond in copy.GetBonds():
        bond.SetStereo(Chem.BondStereo.STEREONONE)
    Chem.AssignStereochemistryFrom3D(copy, conformer)
    return Chem.MolToSmiles(Chem.RemoveHs(copy))


@pytest.mark.parametrize(
    "smiles",
    [
        "C[C@H](N)C(=O)N[C@@H](CO)C(=O)O",
        r"C/C=C/CC/C=C\C",
        "C[C@H]1CC[C@@H](O)C[C@H]1CCO",
        r"O=C(/C=C/c1ccccc1)N1CCC[C@H]1C",
    ],
)
def test_every_conformer_keeps_the_configuration(smiles):
    mol = embedded(smiles)
    conformers, found = sampled(mol, count=40)
    assert len(found["positions"]) == 40 and found["reason"] == ""
    wanted = configuration(mol, -1)
    assert {configuration(conformers, c.GetId()) for c in conformers.GetConformers()} == {wanted}


def ring_torsions(conformers):
    """Of the first ring, degrees (nconformer, n)."""
    ring = list(conformers.GetRingInfo().AtomRings()[0])
    quads = [[ring[(k + i) % len(ring)] for i in range(4)] for k in range(len(ring))]
    return np.array(
        [
            [rdMolTransforms.GetDihedralDeg(c, *quad) for quad in quads]
            for c in conformers.GetConformers()
        ]
    )


def shapes(torsions):
    """How many rows differ from all before by more than a degree RMS."""
    kept = []
    for row in torsions:
        apart = [((row - other + 180) % 360 - 180) ** 2 for other in kept]
        if all(one.mean() > 1 for one in apart):
            kept.append(row)
    return len(kept)


def test_a_large_ring_has_another_shape_in_each_conformer():
    conformers, found = sampled(embedded("C1CCCCCCC1"), count=150)
    assert len(found["positions"]) == 150 and found["reason"] == ""
    assert shapes(ring_torsions(conformers)) == 150


def test_a_macrocycle_with_side_chains_takes_many_shapes_of_its_ring():
    conformers, _ = sampled(embedded("CCCOC1CCCCCCCCCCC1"), count=30)
    assert shapes(ring_torsions(conformers)) >= 8


def test_substituents_of_a_ring_are_found_axial_and_equatorial():
    conformers, _ = sampled(embedded("CC(C)C1CCOCC1"), count=40)
    torsions = [
        abs(rdMolTransforms.GetDihedralDeg(c, 1, 3, 4, 5)) for c in conformers.GetConformers()
    ]
    assert max(torsions) > 150 and min(torsions) < 90


def test_a_nitrogen_turns_inside_out():
    mol = embedded("CCN(C)C(C)C")
    conformers, _ = sampled(mol, count=40)
    hands = set()
    for c in conformers.GetConformers():
        x = c.GetPositions()
        a, b, d = x[1] - x[2], x[3] - x[2], x[4] - x[2]
        hands.add(np.sign(np.dot(a, np.cross(b, d))))
    assert hands == {-1.0, 1.0}


def test_tertiary_amides_are_found_on_both_sides_and_secondary_ones_on_their_own():
    for smiles, sides in (("CCC(=O)N(C)CC", {-1.0, 1.0}), ("CCC(=O)NCC", {-1.0})):
        mol = embedded(smiles)
        amide = mol.GetSubstructMatch(Chem.MolFromSmarts("[CH2]C(=O)N[CH2]"))
        quad = (amide[0], amide[1], amide[3], amide[4])
        conformers, _ = sampled(mol, count=60)
        found = {
            np.sign(np.cos(rdMolTransforms.GetDihedralRad(c, *quad)))
            for c in conformers.GetConformers()
        }
        assert found == sides


def test_salts_and_alkynes_have_conformers():
    for smiles in ("[Na+].CCC(=O)[O-]", "CC#CC#CCO", "[Cl-].C[NH3+]"):
        _, found = sampled(embedded(smiles), count=10)
        assert found["positions"].shape[0] == 10


def test_a_term_of_no_atom_is_refused():
    molecule = core_molecule(Molecule.from_rdkit(embedded("CCO")))
    with pytest.raises(ValueError, match="atom 99"):
        _core.sample_conformers(
            molecule,
            np.array([[0, 1, 2, 99]], np.int32),
            np.zeros((1, 6)),
            np.zeros((1, 6), np.int32),
        )
