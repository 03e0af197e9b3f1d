"""Shapes of rings: molecules from SMILES, with RDKit's torsion terms."""

import numpy as np
import pytest
from rdkit import Chem
from rdkit.Chem import rdDistGeom

import ragdoll
from ragdoll import _core
from ragdoll.framework import core_molecule


def embed(smiles):
    mol = Chem.AddHs(Chem.MolFromSmiles(smiles))
    parameters = rdDistGeom.ETKDGv3()
    parameters.randomSeed = 42
    assert rdDistGeom.EmbedMolecule(mol, parameters) == 0
    return mol


def pools_of(mol, **settings):
    parameters = rdDistGeom.ETKDGv3()
    parameters.useSmallRingTorsions = parameters.useMacrocycleTorsions = True
    terms = rdDistGeom.GetExperimentalTorsions(mol, parameters)
    return _core.ring_conformers(
        core_molecule(ragdoll.Molecule.from_rdkit(mol)),
        np.array([list(t["atomIndices"]) for t in terms], np.int32).reshape(-1, 4),
        np.array([list(t["V"]) for t in terms], float).reshape(-1, 6),
        np.array([list(t["signs"]) for t in terms], float).reshape(-1, 6),
        **settings,
    )


def configuration(mol, pool, shape):
    """Labels of the molecule with the pool's shape, atoms beside it left where they hang."""
    copy = Chem.Mol(mol)
    conformer = copy.GetConformer()
    for atom, place in zip(pool["atoms"], shape, strict=True):
        conformer.SetAtomPosition(int(atom), (place * 10).tolist())
    within = set(pool["atoms"].tolist())
    Chem.AssignStereochemistryFrom3D(copy)
    labels = {}
    for atom in copy.GetAtoms():
        around = {n.GetIdx() for n in atom.GetNeighbors()} | {atom.GetIdx()}
        if around <= within:
            labels[atom.GetIdx()] = atom.GetChiralTag()
    for bond in copy.GetBonds():
        ends = {bond.GetBeginAtomIdx(), bond.GetEndAtomIdx()}
        if bond.IsInRing() and ends <= within:
            labels["bond", bond.GetIdx()] = bond.GetStereo()
    return labels


STEREO = {
    "trans-decalin": "C1CCC[C@H]2CCCC[C@H]12",
    "cis-decalin": "C1CCC[C@@H]2CCCC[C@H]12",
    "glucose": "OC[C@H]1O[C@@H](O)[C@H](O)[C@@H](O)[C@@H]1O",
    "testosterone": "C[C@]12CC[C@H]3[C@H]([C@@H]1CC[C@@H]2O)CCC4=CC(=O)CC[C@]34C",
    "quinuclidine": "C1CN2CC[C@@H]1[C@H](O)C2",
    "E-lactone": "C[C@@H]1CCCCC/C=C/CCCC(=O)O1",
    "Z-lactone": "C[C@@H]1CCCCC/C=C\\CCCC(=O)O1",
    "cyclic tetrapeptide": "C[C@@H]1NC(=O)[C@H](C)NC(=O)[C@@H](C)NC(=O)[C@H](CC(C)C)NC1=O",
    "N-acylproline": "CC(=O)N1CCC[C@H]1C(=O)O",
}


@pytest.mark.parametrize("name", STEREO)
def test_stereocentres_and_double_bonds_of_rings_are_kept_in_every_shape(name):
    mol = embed(STEREO[name])
    for pool in pools_of(mol, count=25):
        start = mol.GetConformer().GetPositions()[pool["atoms"]] / 10
        expected = configuration(mol, pool, start)
        assert expected
        for shape in pool["conformations"]:
            assert configuration(mol, pool, shape) == expected


def amide_torsions(mol, pool, shape):
    place = dict(zip(pool["atoms"].tolist(), shape, strict=True))
    match = mol.GetSubstructMatches(Chem.MolFromSmarts("[#6;R]~[#6;R](=O)~[#7;R]~[#6;R]"))
    angles = []
    for a, b, _, c, d in match:
        if all(i in place for i in (a, b, c, d)) and mol.GetBondBetweenAtoms(b, c).IsInRing():
            p, q, r, s = (place[i] for i in (a, b, c, d))
            m, n = np.cross(q - p, r - q), np.cross(r - q, s - r)
            angles.append(m @ n / np.linalg.norm(m) / np.linalg.norm(n))
    return np.array(angles)


def test_amides_of_a_macrocycle_keep_their_side():
    mol = embed("O=C1CCCCCNC(=O)CCCCCN1")
    (pool,) = pools_of(mol, count=30)
    start = amide_torsions(mol, pool, mol.GetConformer().GetPositions()[pool["atoms"]] / 10)
    assert len(start) == 2
    for shape in pool["conformations"]:
        cosines = amide_torsions(mol, pool, shape)
        assert np.all(np.sign(cosines) == np.sign(start))
        assert np.all(np.abs(cosines) > 0.9)


@pytest.mark.parametrize(
    "smiles", ["c1ccccc1", "C1CC1", "C1CC2CCC1C2", "C1C2CC3CC1CC(C2)C3", "CCO"]
)
def test_rigid_rings_have_no_pool(smiles):
    assert pools_of(embed(smiles)) == []


@pytest.mark.parametrize(
    ("smiles", "least"),
    [
        ("C1CC=CCC1", 2),  # half chairs
        ("O=C(C)N1CCC[C@H]1C(=O)O", 2),  # up and down
        ("CC1CCCCC1", 2),  # axial and equatorial
        ("C1CCCCCC1", 2),
        ("O=C1CCCCCCCCCCCO1", 10),
    ],
)
def test_flexible_rings_have_more_than_one_shape(smiles, least):
    (pool,) = pools_of(embed(smiles))
    assert pool["minima"] >= least
    assert len(pool["energies"]) == len(pool["conformations"])


def test_equatorial_comes_before_axial():
    mol = embed("CC1CCCCC1")
    (pool,) = pools_of(mol)
    place = {int(atom): k for k, atom in enumerate(pool["atoms"])}
    methyl, root = 0, 1
    ring = [n.GetIdx() for n in mol.GetAtomWithIdx(root).GetNeighbors() if n.IsInRing()]

    def is_equatorial(shape):
        x = shape[[place[i] for i in pool["atoms"][:6]]]
        normal = np.linalg.svd(x - x.mean(0))[2][2]
        arm = shape[place[methyl]] - shape[place[root]]
        return abs(arm @ normal) < 0.6 * np.linalg.norm(arm)

    assert len(ring) == 2
    assert [is_equatorial(shape) for shape in pool["conformations"][:2]] == [True, False]


def chairs_of(name):
    """For each shape of a decalin, whether both rings are chairs; and the turn of its middle."""
    mol = embed(STEREO[name])
    (pool,) = pools_of(mol)
    systems = _core.ring_systems(core_molecule(ragdoll.Molecule.from_rdkit(mol)))
    assert [len(system["atoms"]) for system in systems] == [10]
    rings = [list(ring) for ring in mol.GetRingInfo().AtomRings()]
    place = {int(atom): k for k, atom in enumerate(pool["atoms"])}

    def torsion(p, q, r, s):
        m, n = np.cross(q - p, r - q), np.cross(r - q, s - r)
        return np.degrees(np.arctan2(np.linalg.norm(r - q) * ((q - p) @ n), m @ n))

    def is_chair(shape, ring):
        around = [shape[place[i]] for i in ring]
        angles = np.array([torsion(*(around[(k + j) % 6] for j in range(4))) for k in range(6)])
        return np.all(np.abs(np.abs(angles) - 55) < 15) and np.all(angles * np.roll(angles, 1) < 0)

    (middle,) = mol.GetSubstructMatches(Chem.MolFromSmarts("[H][C;R2][C;R2][H]"))
    turns = [torsion(*(shape[place[i]] for i in middle)) for shape in pool["conformations"]]
    return [all(is_chair(s, ring) for ring in rings) for s in pool["conformations"]], turns


def test_trans_decalin_is_two_chairs_in_one_way_and_stays_trans():
    chairs, turns = chairs_of("trans-decalin")
    assert chairs[0]
    assert sum(chairs) == 1
    assert np.all(np.abs(turns) > 140)


def test_cis_decalin_flips_between_two_pairs_of_chairs_and_stays_cis():
    chairs, turns = chairs_of("cis-decalin")
    assert chairs[:2] == [True, True]
    assert turns[0] * turns[1] < 0
    assert np.all(np.abs(turns) < 90)


def test_a_nitrogen_of_a_ring_turns_inside_out():
    mol = embed("CN1CCCCC1")
    (pool,) = pools_of(mol)
    place = {int(atom): k for k, atom in enumerate(pool["atoms"])}
    a, b = (n.GetIdx() for n in mol.GetAtomWithIdx(1).GetNeighbors() if n.IsInRing())

    def side(shape):
        n, methyl, p, q = (shape[place[i]] for i in (1, 0, a, b))
        return np.sign((methyl - n) @ np.cross(p - n, q - n))

    assert {side(shape) for shape in pool["conformations"]} == {1.0, -1.0}


def test_settings_that_make_no_sense_are_refused():
    with pytest.raises(ValueError, match="must be 1 or more"):
        pools_of(embed("C1CCCCC1"), count=0)
