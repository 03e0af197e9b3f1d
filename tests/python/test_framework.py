"""Frameworks as Python sees them."""

import numpy as np
import pytest
from ragdoll._core import GeometryCheck, Resolver, inverted_centres, order, worst_violation
from rdkit import Chem
from rdkit.Chem import AllChem

from ragdoll import Framework, InputError, Molecule, build_framework


def molecule_of(smiles, seed=7):
    mol = Chem.AddHs(Chem.MolFromSmiles(smiles))
    AllChem.EmbedMolecule(mol, randomSeed=seed)
    return Molecule.from_rdkit(mol)


def kinds(framework):
    return np.bincount(framework.bar_kinds, minlength=3).tolist()


def test_ethane_has_bars_from_bonds_and_angles_and_two_centres():
    framework = build_framework(molecule_of("CC"))
    assert kinds(framework) == [7, 12, 0]
    assert framework.chirality_count == 2
    assert (framework.class_name, framework.cycle_rank, framework.component_count) == ("tree", 0, 1)


def test_benzene_is_a_one_cycle_whose_every_pair_in_the_ring_has_a_bar():
    framework = build_framework(molecule_of("c1ccccc1"))
    assert framework.class_name == "1-cycle"
    ring = {tuple(sorted(pair)) for pair in framework.bars.tolist() if max(pair) < 6}
    assert len(ring) == 15


def test_an_amide_does_not_turn_and_an_amine_does():
    amide = build_framework(molecule_of("CC(=O)NC"))
    amine = build_framework(molecule_of("CCNC"))
    assert kinds(amide)[2] == 4  # CA and O against CA and H
    assert kinds(amine)[2] == 0


def test_every_constraint_holds_at_the_input():
    molecule = molecule_of("CC1CCN(C(=O)c2ccccc2)C1")
    framework = build_framework(molecule)
    relative, _ = worst_violation(framework, molecule.positions)
    assert relative == 0


def test_a_mirror_image_has_every_centre_inverted():
    molecule = molecule_of("C[C@H](N)C(=O)O")
    framework = build_framework(molecule)
    mirrored = molecule.positions * [1, 1, -1]
    assert inverted_centres(framework, molecule.positions) == 0
    assert inverted_centres(framework, mirrored) == framework.chirality_count > 0


def test_resolving_a_perturbed_molecule_leaves_the_input_array_alone():
    molecule = molecule_of("CCCCO")
    framework = build_framework(molecule)
    moved = molecule.positions + np.random.default_rng(1).normal(0, 0.01, molecule.positions.shape)
    before = moved.copy()
    resolved, report = Resolver(framework, tolerance=0.001).resolve(moved)
    assert report["converged"] and report["iterations"] > 0
    assert np.array_equal(moved, before)
    assert worst_violation(framework, resolved)[0] <= 0.001


def test_two_atoms_at_one_place_are_refused_by_name():
    molecule = molecule_of("CC")
    positions = molecule.positions.copy()
    positions[1] = positions[0]
    with pytest.raises(InputError, match="one place"):
        build_framework(Molecule.from_topology(molecule.topology, positions))


def test_a_framework_from_arrays_names_what_is_wrong():
    masses = np.ones(3)
    with pytest.raises(ValueError, match="to itself"):
        Framework(masses=masses, bars=np.array([[1, 1]], np.int32), bar_lengths=np.ones(1))
    with pytest.raises(ValueError, match="two bars join"):
        Framework(masses=masses, bars=np.array([[0, 1], [1, 0]], np.int32), bar_lengths=np.ones(2))
    with pytest.raises(ValueError, match="not a positive number"):
        Framework(masses=masses, bars=np.array([[0, 1]], np.int32), bar_lengths=np.zeros(1))


def test_an_order_names_the_nearer_end_first_and_the_bars_that_close_cycles():
    bars = np.array([[0, 1], [0, 2], [1, 3], [2, 1]], np.int32)  # figure 5.5 of the thesis
    framework = Framework(masses=np.ones(4), bars=bars, bar_lengths=np.ones(4))
    joints, problem = order(framework, "bfs_cycle", [0])
    assert joints.tolist() == bars.tolist()
    assert problem.tolist() == [0, 0, 0, 1]


def test_geometry_of_the_input_shows_no_deviation():
    molecule = molecule_of("CC(=O)NC")
    framework = build_framework(molecule)
    check = GeometryCheck(framework, molecule.positions, np.zeros((0, 4), np.int32), 0.01)
    check.add(molecule.positions)
    report = check.report()
    assert report["bond_max"] == 0 and report["rmsd_last"] < 1e-9
    assert report["contact_violations"] == report["chirality_inverted"] == 0
