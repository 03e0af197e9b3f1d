"""Molecules that are not run of the mill keep their configuration, as RDKit sees it in 3-D."""

import warnings

import numpy as np
import pytest
from rdkit import Chem, rdBase
from rdkit.Chem import rdDistGeom, rdmolops

import ragdoll
from ragdoll import _core

# SMILES whose configuration the coordinates alone tell
SMILES = {
    "oxime": "C/C(CC)=N/O",
    "hydrazone": "C/C=N\\NC",
    "iminium": "C/C=[N+](/C)CC",
    "amidine": "C/C(N)=N\\C",
    "enamide": "C/C=C/NC(C)=O",
    "trans-cyclononene": "C1CCC/C=C/CCC1",
    "cis double bond in a macrocycle": "O=C1CCCC/C=C\\CCCCO1",
    "trans double bond in a macrocycle": "O=C1CCCC/C=C/CCCCO1",
    "macrolactam": "C[C@H]1CCCCCCC[C@@H](O)CC(=O)N1",
    "bridged": "C[C@@]12CC[C@@H](CC1=O)C2(C)C",
    "spiro": "C[C@H]1CC[C@@]2(CCCN2)C1",
    "fused": "C[C@]12CC[C@H]3[C@@H](CCC4=CC(=O)CC[C@@]34C)[C@@H]1CC[C@@H]2O",
    "sulfoxide": "C[S@](=O)c1ccccc1",
    "sulfoximine": "C[S@](=N)(=O)CC",
    "phosphine oxide": "C[P@](=O)(CC)c1ccccc1",
    "phosphonate": "CO[P@@](C)(=O)OCC",
    "ammonium": "C[N@+](CC)(CCC)Cc1ccccc1",
    "silane": "C[Si@](F)(CC)c1ccccc1",
    "borate": "C[B@-](F)(CC)c1ccccc1",
    "sugar": "OC[C@H]1O[C@@H](O)[C@H](O)[C@@H](O)[C@@H]1O",
    "deuterium": "[2H][C@H](C)O",
    "aziridine": "C[C@H]1C[N@]1C",
    "cubane": "OC(=O)C12C3C4C1C5C2C3C45",
}


def embedded(smiles):
    mol = Chem.AddHs(Chem.MolFromSmiles(smiles))
    with rdBase.BlockLogs():
        assert rdDistGeom.EmbedMolecule(mol, randomSeed=7) == 0
    return mol


def stereo_of(mol, positions):
    """Isomeric SMILES by the coordinates alone, in angstrom."""
    copy = Chem.Mol(mol)
    copy.GetConformer().SetPositions(np.ascontiguousarray(positions, dtype=np.float64))
    with rdBase.BlockLogs():
        rdmolops.AssignStereochemistryFrom3D(copy, replaceExistingTags=True)
    return Chem.MolToSmiles(Chem.RemoveHs(copy))


@pytest.mark.parametrize("name", SMILES)
def test_steps_and_conformers_keep_the_configuration(name):
    mol = embedded(SMILES[name])
    molecule = ragdoll.Molecule.from_rdkit(mol)
    framework = ragdoll.build_framework(molecule)
    expected = stereo_of(mol, mol.GetConformer().GetPositions())
    assert name == "cubane" or any(mark in expected for mark in "/\\@")
    assert _core.inverted_centres(framework, molecule.positions) == 0
    moved = [
        _core.perturb(molecule.positions, size=size, seed=5, step=step)
        for size in (0.02, 0.08)
        for step in range(8)
    ]
    resolved, reports = ragdoll.EnsembleResolver(
        framework, solver="auto", max_iterations=2000, tolerance=0.01
    ).resolve_all(np.array(moved))
    kept = [
        x
        for x, report in zip(resolved, reports, strict=True)
        if report["converged"] and _core.inverted_centres(framework, x) == 0
    ]
    assert len(kept) >= 4
    assert {stereo_of(mol, 10 * x) for x in kept} == {expected}
    with warnings.catch_warnings(action="ignore"):  # rigid ones have fewer
        made = ragdoll.conformers(mol, 8, seed=1)
    assert made.GetNumConformers() >= 1
    assert {stereo_of(mol, c.GetPositions()) for c in made.GetConformers()} == {expected}


def test_a_hindered_biaryl_keeps_its_hand_and_biphenyl_does_not():
    for smiles, centres in (("Oc1ccc2ccccc2c1-c1c(O)ccc2ccccc12", 1), ("c1ccccc1-c1ccccc1", 0)):
        molecule = ragdoll.Molecule.from_rdkit(embedded(smiles))
        framework = ragdoll.build_framework(molecule)
        mirrored = molecule.positions * [1, 1, -1]
        assert _core.inverted_centres(framework, mirrored) == centres


def test_conformers_of_a_hindered_biaryl_have_its_hand():
    mol = embedded("Oc1ccc2ccccc2c1-c1c(O)ccc2ccccc12")
    framework = ragdoll.build_framework(ragdoll.Molecule.from_rdkit(mol))
    made = ragdoll.conformers(mol, 20, seed=1)
    places = [conformer.GetPositions() / 10 for conformer in made.GetConformers()]
    assert len(places) == 20
    assert [_core.inverted_centres(framework, x) for x in places] == [0] * 20


def test_isotopes_have_their_mass():
    molecule = ragdoll.Molecule.from_rdkit(embedded("[2H]C([2H])([2H])[13CH2]O"))
    assert molecule.masses[:2] == pytest.approx([2.0141, 12.011], abs=1e-3)
    assert molecule.masses[4] == pytest.approx(13.0034, abs=1e-3)
    assert molecule.elements[0] == 1


@pytest.mark.parametrize(
    "smiles",
    [
        "C[N+](C)(C)CCO.[Cl-]", "CN=[N+]=[N-]", "CN=C=O", "CC#CC#CC", "CC(C)=C=C=CC", "C[CH2]",
        "C[C+](C)C", "[CH3-]", "C[Hg]C", "CC[NH2]->[Zn](<-[NH2]C)(Cl)Cl", "F[P](F)(F)(F)F",
        "OB(O)c1ccccc1", "C1CC2CCC1CC2", "C1CC12CC2", "C[Si](C)(C)C#C", "O=[N+]([O-])c1ccccc1",
        "CS(=O)(=O)Nc1ccccn1", "C1=CC=CC=CC=C1", "C[As](C)C", "OI(=O)=O",
    ],
)  # fmt: skip
def test_unusual_molecules_resolve_within_the_tolerance(smiles):
    mol = embedded(smiles)
    molecule = ragdoll.Molecule.from_rdkit(mol)
    framework = ragdoll.build_framework(molecule)
    assert _core.inverted_centres(framework, molecule.positions) == 0
    moved = np.array(
        [_core.perturb(molecule.positions, size=0.01, seed=3, step=k) for k in range(8)]
    )
    _, reports = ragdoll.EnsembleResolver(framework, tolerance=0.01).resolve_all(moved)
    assert sum(report["converged"] for report in reports) >= 6


def test_hydrogen_bonds_hold_nothing_and_zero_order_bonds_are_dative():
    mol = embedded("O.O")
    mol.GetConformer().SetPositions(
        mol.GetConformer().GetPositions() + np.array([[0, 0, 0], [4.0, 0, 0]])[[0, 1, 0, 0, 1, 1]]
    )
    plain = ragdoll.Molecule.from_rdkit(mol)
    for kind, added in ((Chem.BondType.HYDROGEN, []), (Chem.BondType.ZERO, [5])):
        bonded = Chem.RWMol(mol)
        bonded.AddBond(0, 1, kind)
        bonded.UpdatePropertyCache(False)
        molecule = ragdoll.Molecule.from_rdkit(bonded)
        assert sorted(molecule.bond_orders) == sorted([*plain.bond_orders, *added])
