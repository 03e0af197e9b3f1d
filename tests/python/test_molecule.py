"""Molecules from files and topologies: bonds, charges, hydrogens."""

import io
from pathlib import Path

import numpy as np
import openmm.app as app
import pytest
from openmm import unit
from rdkit import Chem

from ragdoll.errors import InputError
from ragdoll.molecule import Molecule
from ragdoll.neighbors import close_pairs

VILLIN = Path(app.__file__).parent / "data" / "test.pdb"
SINGLE = 1


@pytest.fixture(scope="module")
def villin():
    return Molecule.from_file(VILLIN)


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
    assert villin.masses[:2].tolist() == [14.00672, 1.007947]
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
    rdkit = {tuple(sorted((b.GetBeginAtomIdx(), b.GetEndAtomIdx()))) for b in mol.GetBonds()}
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
    molecule = Molecule.from_file(path)
    residues = [label.split()[1] for label in molecule.labels if label.startswith("CA ")]
    joined = [
        order_by_label(molecule, f"C {one}", f"N {other}") == SINGLE
        for one, other in zip(residues, residues[1:], strict=False)
    ]
    assert joined.count(False) == 1
    assert residues[joined.index(False)].endswith("9")


def test_missing_heavy_atoms_are_named(villin, tmp_path):
    lines = VILLIN.read_text().splitlines()
    cut = [
        line for line in lines if not (line[12:16].strip() in ("CE", "NZ") and "LYS    30" in line)
    ]
    assert len(cut) == len(lines) - 2
    path = tmp_path / "cut.pdb"
    path.write_text("\n".join(cut))
    molecule = Molecule.from_file(path)
    (missing,) = molecule.missing_atoms
    assert missing.residue.startswith("LYS30")
    assert missing.names == ("CE", "NZ")


def test_topology_with_and_without_bonds(villin):
    pdb = app.PDBFile(str(VILLIN))
    for positions in (
        pdb.positions,
        pdb.getPositions(asNumpy=True),
        pdb.getPositions(asNumpy=True)._value,
    ):
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


def test_hydrogens_of_rigid_water_are_not_bonded_to_each_other():
    topology = app.Topology()
    water = topology.addResidue("HOH", topology.addChain("W"))
    symbols = {"H1": "H", "O": "O", "H2": "H"}
    h1, o, h2 = (topology.addAtom(n, app.Element.getBySymbol(s), water) for n, s in symbols.items())
    for pair in ((h1, h2), (h1, o), (o, h2)):
        topology.addBond(*pair)
    places = [[0.0757, 0.0587, 0], [0, 0, 0], [-0.0757, 0.0587, 0]]
    molecule = Molecule.from_topology(topology, places, keep_solvent=True)
    assert molecule.bonds.tolist() == [[0, 1], [1, 2]]


def test_topology_refuses_what_does_not_fit(villin):
    with pytest.raises(InputError, match="582 atoms"):
        Molecule.from_topology(villin.topology, villin.positions[:5])
    broken = np.array(villin.positions)
    broken[3, 1] = np.nan
    with pytest.raises(InputError, match="no usable place"):
        Molecule.from_topology(villin.topology, broken)


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


def test_lone_hydrogens_get_a_note():
    topology = app.Topology()
    residue = topology.addResidue("XXX", topology.addChain("A"))
    topology.addAtom("H1", app.Element.getBySymbol("H"), residue)
    molecule = Molecule.from_topology(topology, [[0.0, 0.0, 0.0]])
    assert molecule.bonds.shape == (0, 2)
    assert any("near enough" in note for note in molecule.notes)


def test_close_pairs_are_all_pairs_within_the_cutoff():
    points = np.random.default_rng(5).uniform(-3, 3, (300, 3))
    distance = np.linalg.norm(points[:, None] - points[None], axis=2)
    i, j = np.nonzero(np.triu(distance < 0.7, 1))
    np.testing.assert_array_equal(close_pairs(points, 0.7), np.column_stack((i, j)))
    assert close_pairs(points[:1], 1.0).shape == (0, 2)
