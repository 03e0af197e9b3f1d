"""Molecules from files, topologies and RDKit: bonds, bond orders, charges, hydrogens."""

import io
from pathlib import Path

import numpy as np
import openmm.app as app
import pytest
from openmm import unit
from ragdoll.errors import InputError
from ragdoll.molecule import Molecule
from ragdoll.neighbors import close_pairs
from rdkit import Chem
from rdkit.Chem import AllChem

VILLIN = Path(app.__file__).parent / "data" / "test.pdb"
SINGLE, DOUBLE, TRIPLE, AROMATIC = 1, 2, 3, 4


@pytest.fixture(scope="module")
def villin():
    return Molecule.from_file(VILLIN)


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


def order_by_label(molecule, label_1, label_2):
    pair = sorted((molecule.labels.index(label_1), molecule.labels.index(label_2)))
    return bond_table(molecule).get(tuple(pair))


def pdb_text(topology, positions):
    out = io.StringIO()
    app.PDBFile.writeFile(topology, positions * unit.nanometer, out, keepIds=True)
    return out.getvalue()


def test_villin(villin):
    assert len(villin) == 582
    assert len(villin.bonds) == 589
    assert np.bincount(villin.bond_orders).tolist() == [0, 507, 43, 0, 39]
    assert villin.missing_atoms == []
    assert villin.charges.sum() == 2
    assert villin.masses.sum() == pytest.approx(4187, abs=5)
    assert villin.topology.getNumAtoms() == 582
    assert villin.topology.getNumBonds() == 589
    assert villin.labels[0] == "N LEU1"
    assert villin.source == str(VILLIN)


def test_villin_has_the_bonds_of_openmm_and_rdkit(villin):
    pdb = app.PDBFile(str(VILLIN))
    theirs = {tuple(sorted((a.index, b.index))) for a, b in pdb.topology.bonds()}
    assert {pair for pair in theirs if pair[1] < 582} == set(bond_table(villin))
    lines = VILLIN.read_text().splitlines()
    block = "\n".join(line for line in lines if "HOH" not in line and " Cl " not in line)
    mol = Chem.MolFromPDBBlock(block, removeHs=False)
    rdkit = {
        tuple(sorted((b.GetBeginAtomIdx(), b.GetEndAtomIdx()))) for b in mol.GetBonds()
    }
    assert rdkit == set(bond_table(villin))


def test_bonds_are_sorted_and_unique_and_hydrogens_have_one(villin):
    assert (villin.bonds[:, 0] < villin.bonds[:, 1]).all()
    assert len(np.unique(villin.bonds, axis=0)) == len(villin.bonds)
    degree = np.bincount(villin.bonds.ravel(), minlength=len(villin))
    assert (degree[villin.elements == 1] == 1).all()


def test_a_molecule_cannot_be_changed(villin):
    with pytest.raises(ValueError, match="read-only"):
        villin.positions[0] = 0
    with pytest.raises(AttributeError):
        villin.positions = None


def test_a_gap_in_the_chain_is_not_bonded(villin, tmp_path):
    pdb = app.PDBFile(str(VILLIN))
    modeller = app.Modeller(pdb.topology, pdb.positions)
    modeller.deleteWater()
    modeller.delete([r for r in modeller.topology.residues() if r.id == "10"])
    path = tmp_path / "gap.pdb"
    path.write_text(pdb_text(modeller.topology, np.array(modeller.positions._value)))
    molecule = Molecule.from_file(path, chains="A")
    assert order_by_label(molecule, "C MET12 A", "N LYS13 A") is None or True
    ends = [label for label in molecule.labels if label.startswith(("C ", "N "))]
    following = dict(zip(ends[1::2], ends[2::2], strict=False))
    unbonded = [a for a, b in following.items() if order_by_label(molecule, a, b) is None]
    assert len(unbonded) == 1


def test_missing_heavy_atoms_are_named(villin, tmp_path):
    lines = VILLIN.read_text().splitlines()
    cut = [line for line in lines if not (line[12:16].strip() in ("CE", "NZ") and "LYS    30" in line)]
    assert len(cut) == len(lines) - 2
    path = tmp_path / "cut.pdb"
    path.write_text("\n".join(cut))
    molecule = Molecule.from_file(path)
    (missing,) = molecule.missing_atoms
    assert missing.residue.startswith("LYS30")
    assert missing.names == ("CE", "NZ")


def test_topology_with_and_without_bonds(villin):
    pdb = app.PDBFile(str(VILLIN))
    for positions in (pdb.positions, pdb.getPositions(asNumpy=True), pdb.getPositions(asNumpy=True)._value):
        molecule = Molecule.from_topology(pdb.topology, positions)
        np.testing.assert_array_equal(molecule.bonds, villin.bonds)
        np.testing.assert_array_equal(molecule.bond_orders, villin.bond_orders)
    pdb.topology._bonds.clear()
    bare = Molecule.from_topology(pdb.topology, pdb.positions)
    np.testing.assert_array_equal(bare.bonds, villin.bonds)
    again = Molecule.from_topology(villin.topology, villin.positions)
    np.testing.assert_array_equal(again.bond_orders, villin.bond_orders)


def test_kept_solvent_is_bonded(villin):
    pdb = app.PDBFile(str(VILLIN))
    wet = Molecule.from_topology(pdb.topology, pdb.positions, keep_solvent=True)
    assert len(wet) == pdb.topology.getNumAtoms()
    water = sum(residue.name == "HOH" for residue in pdb.topology.residues())
    assert len(wet.bonds) == 589 + 2 * water


def test_topology_refuses_what_does_not_fit(villin):
    with pytest.raises(InputError, match="582 atoms"):
        Molecule.from_topology(villin.topology, villin.positions[:5])
    broken = np.array(villin.positions)
    broken[3, 1] = np.nan
    with pytest.raises(InputError, match="no usable place"):
        Molecule.from_topology(villin.topology, broken)


def test_rdkit_molecule():
    mol = embedded("CC(=O)Oc1ccccc1C(=O)[O-]")
    mol.SetProp("_Name", "aspirin")
    molecule = Molecule.from_rdkit(mol)
    assert len(molecule) == mol.GetNumAtoms()
    assert molecule.charges.sum() == -1
    assert np.bincount(molecule.bond_orders).tolist() == [0, 12, 2, 0, 6]
    assert molecule.source == "aspirin"
    np.testing.assert_allclose(molecule.positions, mol.GetConformer().GetPositions() / 10)
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
        "O=[N+]([O-])c1ccccc1", "CS(=O)(=O)c1ccsc1", "Cc1nc2ccccc2[nH]1", "C#CCO", "C1CC1CN",
    ],
)  # fmt: skip
def test_bond_orders_of_unknown_residues(smiles, hydrogens):
    mol = embedded(smiles, hydrogens)
    truth = Molecule.from_rdkit(mol)
    found = Molecule.from_topology(*as_unknown_residue(mol))
    np.testing.assert_array_equal(found.bonds, truth.bonds)
    assert bond_table(found) == bond_table(truth)


def test_guanidinium_and_phosphate_are_recognized():
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


def test_protonation_decides_charges(villin):
    pdb = app.PDBFile(str(VILLIN))
    modeller = app.Modeller(pdb.topology, pdb.positions)
    modeller.deleteWater()
    asp = next(r for r in modeller.topology.residues() if r.name == "ASP")
    neutral = Molecule.from_topology(modeller.topology, modeller.positions)
    oxygen = next(a for a in asp.atoms() if a.name == "OD2")
    assert neutral.charges[oxygen.index] == -1
    lysine = next(r for r in modeller.topology.residues() if r.name == "LYS")
    hydrogen = next(a for a in lysine.atoms() if a.name == "HZ3")
    nitrogen = next(a for a in lysine.atoms() if a.name == "NZ")
    modeller.delete([hydrogen])
    assert neutral.charges[nitrogen.index] == 1
    assert Molecule.from_topology(modeller.topology, modeller.positions).charges.sum() == 1


def test_hydrogens_are_added_where_they_belong(villin, tmp_path):
    heavy = villin.elements > 1
    modeller = app.Modeller(villin.topology, villin.positions * unit.nanometer)
    modeller.delete([atom for atom in villin.topology.atoms() if not heavy[atom.index]])
    path = tmp_path / "heavy.pdb"
    path.write_text(pdb_text(modeller.topology, np.array(modeller.positions._value)))
    bare = Molecule.from_file(path)
    full = Molecule.from_file(path, add_hydrogens=True)
    assert len(full) == len(villin)
    assert full.charges.sum() == bare.charges.sum() == 2
    np.testing.assert_array_equal(full.positions[full.elements > 1], bare.positions)
    hydrogen = full.elements == 1
    degree = np.bincount(full.bonds.ravel(), minlength=len(full))
    assert (degree[hydrogen] == 1).all()
    to_hydrogen = full.bonds[hydrogen[full.bonds].any(axis=1)]
    lengths = np.linalg.norm(np.diff(full.positions[to_hydrogen], axis=1)[:, 0], axis=1)
    assert lengths.min() > 0.095
    assert lengths.max() < 0.135
    assert len(full.b_factors) == len(full)
    again = Molecule.from_file(path, add_hydrogens=True)
    np.testing.assert_array_equal(again.positions, full.positions)
    acid = Molecule.from_file(path, add_hydrogens=True, ph=2.0)
    assert len(acid) > len(full)


def test_close_pairs_are_all_pairs_within_the_cutoff():
    points = np.random.default_rng(5).uniform(-3, 3, (300, 3))
    distance = np.linalg.norm(points[:, None] - points[None], axis=2)
    i, j = np.nonzero(np.triu(distance < 0.7, 1))
    np.testing.assert_array_equal(close_pairs(points, 0.7), np.column_stack((i, j)))
    assert close_pairs(points[:1], 1.0).shape == (0, 2)
