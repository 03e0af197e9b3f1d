"""Every protein file of the shared data against the bonds that OpenMM and RDKit find."""

import gzip
import io
import os
import warnings
from pathlib import Path

import numpy as np
import openmm.app as app
import pytest
from rdkit import Chem, RDLogger

from ragdoll.errors import InputError
from ragdoll.molecule import Molecule
from ragdoll.neighbors import close_pairs

DATA = Path(os.environ.get("RAGDOLL_DATA", Path(__file__).parents[3] / "shared" / "data"))
PROTEINS = DATA / "proteins"
FILES = sorted(p.name for p in PROTEINS.glob("*") if p.name.endswith((".pdb", ".gz")))
TRACES = {"2k39_ca.pdb", "hivp_ca.pdb"}
# Atoms, bonds, double bonds, aromatic bonds.
COUNTS = {
    "1crn.pdb": (327, 337, 53, 18),
    "1bna.pdb": (486, 544, 46, 192),
    "1hvr.pdb": (1890, 1922, 241, 120),
    "5pti.cif.gz": (897, 910, 73, 48),
    "1ewk.pdb.gz": (7250, 7420, 1148, 712),
    "tyk2_protein.pdb": (4652, 4714, 359, 273),
}


def content(name):
    raw = (PROTEINS / name).read_bytes()
    return (gzip.decompress(raw) if name.endswith(".gz") else raw).decode("latin-1")


def heavy_bonds(molecule, pairs, points):
    """Pairs of `points` (angstrom) as pairs of the molecule's heavy atoms that lie there."""
    mine = molecule.positions * 10
    near = close_pairs(np.concatenate((mine, points)), 0.003)
    near = near[(near[:, 0] < len(mine)) & (near[:, 1] >= len(mine))]
    index = dict(zip((near[:, 1] - len(mine)).tolist(), near[:, 0].tolist(), strict=True))
    found = set()
    for pair in pairs:
        i, j = (index.get(atom) for atom in pair)
        if i is not None and j is not None and min(molecule.elements[[i, j]]) > 1:
            found.add((min(i, j), max(i, j)))
    return found


def length(molecule, pair):
    return 10 * np.linalg.norm(molecule.positions[pair[0]] - molecule.positions[pair[1]])


if not FILES:
    pytest.skip(
        "no protein files; set RAGDOLL_DATA to the folder that holds proteins/",
        allow_module_level=True,
    )


@pytest.mark.parametrize("name", [name for name in FILES if name not in TRACES])
def test_heavy_atom_bonds_are_those_of_openmm(name):
    molecule = Molecule.from_file(PROTEINS / name)
    reader = app.PDBxFile if ".cif" in name else app.PDBFile
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # it warns of repeated hydrogen names
        pdb = reader(io.StringIO(content(name)))
    points = pdb.getPositions(asNumpy=True)._value * 10
    theirs = heavy_bonds(molecule, [(a.index, b.index) for a, b in pdb.topology.bonds()], points)
    mine = heavy_bonds(molecule, molecule.bonds.tolist(), molecule.positions * 10)
    # OpenMM bonds what follows in the list, across gaps in the chain; and a terminal oxygen of
    # 1bck, which stands apart in the file, is a residue of its own to it.
    assert all(length(molecule, pair) > 2.0 for pair in theirs - mine)
    assert len(mine - theirs) == (1 if name == "1bck_withH.pdb" else 0)
    degree = np.bincount(molecule.bonds.ravel(), minlength=len(molecule))
    alone = (degree == 0) & (molecule.elements == 1)
    assert alone.sum() == (1 if name == "1cll.pdb" else 0)  # an oxygen that the file calls H21
    assert degree[molecule.elements == 1].max(initial=0) <= 1


@pytest.mark.parametrize(
    "name", [n for n in FILES if n not in TRACES and ".cif" not in n and "1gr" not in n]
)
def test_heavy_atom_bonds_are_those_of_rdkit(name):
    molecule = Molecule.from_file(PROTEINS / name)
    RDLogger.DisableLog("rdApp.*")
    try:
        mol = Chem.MolFromPDBBlock(content(name), sanitize=False, removeHs=False)
    finally:
        RDLogger.EnableLog("rdApp.*")
    points = mol.GetConformer(0).GetPositions()
    pairs = [(bond.GetBeginAtomIdx(), bond.GetEndAtomIdx()) for bond in mol.GetBonds()]
    theirs = heavy_bonds(molecule, pairs, points)
    mine = heavy_bonds(molecule, molecule.bonds.tolist(), molecule.positions * 10)
    assert mine == theirs


@pytest.mark.parametrize("name", sorted(COUNTS))
def test_counts(name):
    molecule = Molecule.from_file(PROTEINS / name)
    orders = np.bincount(molecule.bond_orders, minlength=5)
    assert (len(molecule), len(molecule.bonds), orders[2], orders[4]) == COUNTS[name]


@pytest.mark.parametrize("name", sorted(TRACES))
def test_traces_are_refused(name):
    with pytest.raises(InputError, match="needs all heavy atoms"):
        Molecule.from_file(PROTEINS / name)


def test_ligands_of_181l_and_1hvr():
    lysozyme = Molecule.from_file(PROTEINS / "181l.pdb")
    labels = lysozyme.labels
    benzene = [
        order
        for (i, j), order in zip(lysozyme.bonds.tolist(), lysozyme.bond_orders, strict=True)
        if "BNZ" in labels[i] and "BNZ" in labels[j]
    ]
    assert benzene == [4] * 6
    protease = Molecule.from_file(PROTEINS / "1hvr.pdb")
    assert [sum(f"CSO67 {c}" in label for label in protease.labels) for c in "AB"] == [9, 9]
    of_inhibitor = [
        order
        for (i, j), order in zip(protease.bonds.tolist(), protease.bond_orders, strict=True)
        if "XK2" in protease.labels[i] and "XK2" in protease.labels[j]
    ]
    assert (of_inhibitor.count(2), of_inhibitor.count(4)) == (1, 34)


def test_missing_side_chains_of_barnase():
    molecule = Molecule.from_file(PROTEINS / "1bni.pdb")
    assert len(molecule.missing_atoms) == 12
    assert sum(len(missing.names) for missing in molecule.missing_atoms) == 42


def test_groel_loads():
    molecule = Molecule.from_file(PROTEINS / "1gru.pdb.gz")
    assert len(molecule) == 58688
