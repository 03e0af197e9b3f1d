"""Ligands: RDKit's molecules, and the same molecules stripped of their bonds."""

import numpy as np
import openmm.app as app
import pytest
from rdkit import Chem
from rdkit.Chem import AllChem

from ragdoll.errors import InputError
from ragdoll.molecule import Molecule

SINGLE, DOUBLE = 1, 2


def embedded(smiles, hydrogens=True):
    mol = Chem.AddHs(Chem.MolFromSmiles(smiles))
    assert AllChem.EmbedMolecule(mol, randomSeed=7) == 0
    AllChem.MMFFOptimizeMolecule(mol)
    return mol if hydrogens else Chem.RemoveHs(mol)


def as_unknown_residue(mol):
    """Topology and positions of an RDKit molecule, stripped of all that is known of its bonds."""
    topology = app.Topology()
    residue = topology.addResidue("XXX", topology.addChain("A"))
    for atom in mol.GetAtoms():
        element = app.Element.getByAtomicNumber(atom.GetAtomicNum())
        topology.addAtom(f"{atom.GetSymbol()}{atom.GetIdx()}", element, residue)
    return topology, mol.GetConformer().GetPositions() * 0.1


def bond_table(molecule):
    return {
        tuple(pair): int(order)
        for pair, order in zip(molecule.bonds.tolist(), molecule.bond_orders, strict=True)
    }


def test_rdkit_molecule():
    mol = embedded("CC(=O)Oc1ccccc1C(=O)[O-]")
    mol.SetProp("_Name", "aspirin")
    molecule = Molecule.from_rdkit(mol)
    assert len(molecule) == mol.GetNumAtoms()
    assert molecule.charges.sum() == -1
    assert np.bincount(molecule.bond_orders).tolist() == [0, 12, 2, 0, 6]
    assert molecule.source == "aspirin"
    np.testing.assert_allclose(
        molecule.positions, mol.GetConformer().GetPositions() / 10, atol=1e-9
    )
    assert molecule.topology.getNumBonds() == mol.GetNumBonds()


def test_rdkit_molecule_is_refused_without_a_conformer():
    flat = Chem.MolFromSmiles("CCO")
    with pytest.raises(InputError, match="no conformer"):
        Molecule.from_rdkit(flat)
    AllChem.Compute2DCoords(flat)
    with pytest.raises(InputError, match="flat"):
        Molecule.from_rdkit(flat)
    with pytest.raises(InputError, match="conformer 3"):
        Molecule.from_rdkit(embedded("CCO"), conformer=3)


@pytest.mark.parametrize("hydrogens", [True, False])
@pytest.mark.parametrize(
    "smiles",
    [
        "CC(=O)Nc1ccc(O)cc1", "N#Cc1ccncc1", "OC(=O)CCC(N)=O", "C1CCCCC1", "CC=CC=O",
        "CS(=O)(=O)c1ccsc1", "Cc1nc2ccccc2[nH]1", "C#CCO", "C1CC1CN",
    ],
)  # fmt: skip
def test_bond_orders_of_unknown_residues(smiles, hydrogens):
    mol = embedded(smiles, hydrogens)
    truth = Molecule.from_rdkit(mol)
    found = Molecule.from_topology(*as_unknown_residue(mol))
    np.testing.assert_array_equal(found.bonds, truth.bonds)
    assert bond_table(found) == bond_table(truth)


def test_groups_with_equivalent_bonds_are_recognized():
    nitro = Molecule.from_topology(*as_unknown_residue(embedded("O=[N+]([O-])c1ccccc1", False)))
    assert np.bincount(nitro.bond_orders).tolist() == [0, 2, 1, 0, 6]
    assert sorted(nitro.charges.tolist())[::8] == [-1, 1]
    guanidine = Molecule.from_topology(*as_unknown_residue(embedded("CNC(N)=[NH2+]", False)))
    assert sorted(guanidine.bond_orders.tolist()) == [SINGLE, SINGLE, SINGLE, DOUBLE]
    phosphate = Molecule.from_topology(*as_unknown_residue(embedded("COP(=O)([O-])[O-]", False)))
    assert sorted(phosphate.bond_orders.tolist()) == [SINGLE] * 4 + [DOUBLE]
    assert phosphate.charges.sum() == -2


def test_glycan_is_linked_to_its_asparagine(tmp_path):
    """By distance, by the file's record, and not at all where the record is absurd."""
    mol = embedded("NC(=O)CNC1CCCCO1", False)
    amide, sugar = list(range(5)), list(range(5, mol.GetNumAtoms()))
    points = mol.GetConformer().GetPositions()
    lines = []
    for serial, index in enumerate(amide + sugar, 1):
        atom = mol.GetAtomWithIdx(index)
        name, number = ("ASX", 1) if index in amide else ("GLX", 2)
        x, y, z = points[index]
        symbol = atom.GetSymbol()
        lines.append(
            f"HETATM{serial:5d}  {symbol}{index:<2d} {name} A{number:4d}    "
            f"{x:8.3f}{y:8.3f}{z:8.3f}  1.00  0.00          {symbol:>2s}"
        )
    path = tmp_path / "link.pdb"
    path.write_text("\n".join(lines) + "\n")
    near = Molecule.from_file(path)
    assert len(near.bonds) == mol.GetNumBonds()
    path.write_text("\n".join([*lines, "CONECT    1    9"]) + "\n")
    wrong = Molecule.from_file(path)
    assert len(wrong.bonds) == mol.GetNumBonds()
    assert any("was left out" in note for note in wrong.notes)
