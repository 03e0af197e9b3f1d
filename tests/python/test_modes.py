"""Normal modes of the elastic network, against dense linear algebra and plain formulas."""

import os
from pathlib import Path

import numpy as np
import pytest

import ragdoll

ROOT = Path(__file__).resolve().parents[2]
DATA = Path(os.environ.get("RAGDOLL_DATA", ROOT.parent / "shared" / "data"))
UBIQUITIN = DATA / "proteins" / "1ubq.pdb"


@pytest.fixture(scope="module")
def ubiquitin():
    if not UBIQUITIN.exists():
        pytest.skip(f"{UBIQUITIN} is not there; set RAGDOLL_DATA")
    return ragdoll.Molecule.from_file(UBIQUITIN)


def _dense(places, cutoff):
    """The network's matrix as its definition has it."""
    count = len(places)
    hessian = np.zeros((3 * count, 3 * count))
    for i in range(count):
        for j in range(i):
            line = places[i] - places[j]
            square = line @ line
            if square < cutoff**2:
                block = np.outer(line, line) / square
                a, b = slice(3 * i, 3 * i + 3), slice(3 * j, 3 * j + 3)
                hessian[a, a] += block
                hessian[b, b] += block
                hessian[a, b] -= block
                hessian[b, a] -= block
    return hessian


def test_modes_are_those_of_the_network(ubiquitin):
    found = ragdoll.modes(ubiquitin, count=12)
    hessian = _dense(10 * ubiquitin.positions[found.sites], 15.0)
    values = np.linalg.eigvalsh(hessian)
    assert found.zero_modes == 6
    assert found.eigenvalues == pytest.approx(values[6:18], rel=1e-8)
    for value, vector in zip(found.eigenvalues, found.vectors, strict=True):
        flat = vector.ravel()
        assert flat @ flat == pytest.approx(1)
        assert np.allclose(hessian @ flat, value * flat, atol=1e-7)


def test_large_structures_have_the_modes_of_dense_algebra():
    path = DATA / "proteins" / "4ake.pdb"
    if not path.exists():
        pytest.skip(f"{path} is not there; set RAGDOLL_DATA")
    molecule = ragdoll.Molecule.from_file(path)  # 428 sites: sparse
    found = ragdoll.modes(molecule, count=6)
    again = ragdoll.modes(molecule, count=6)
    hessian = _dense(10 * molecule.positions[found.sites], 15.0)
    assert found.eigenvalues == pytest.approx(np.linalg.eigvalsh(hessian)[6:12], rel=1e-6)
    assert np.array_equal(found.vectors, again.vectors)


def test_collectivity_is_that_of_its_formula(ubiquitin):
    found = ragdoll.modes(ubiquitin, count=5)
    for vector, told in zip(found.vectors, found.collectivity, strict=True):
        shares = (vector**2).sum(axis=1)
        entropy = -sum(share * np.log(share) for share in shares if share > 0)
        assert told == pytest.approx(np.exp(entropy) / len(shares))
        assert 1 / len(shares) <= told <= 1


def test_modes_of_atoms_move_sites_as_they_are_and_residues_as_bodies(ubiquitin):
    found = ragdoll.modes(ubiquitin, count=3)
    moves = found.of_atoms()
    assert moves.shape == (3, len(ubiquitin), 3)
    sites = np.sqrt(len(found.sites)) * found.vectors
    assert np.allclose(moves[:, found.sites], sites)
    assert np.sqrt((moves[:, found.sites] ** 2).sum(axis=2).mean(axis=1)) == pytest.approx(1)
    # bonds within a residue keep their lengths to first order
    bonds = [(i, j) for i, j in ubiquitin.bonds if found.site_of_atom[i] == found.site_of_atom[j]]
    for i, j in bonds:
        line = ubiquitin.positions[i] - ubiquitin.positions[j]
        assert np.allclose((moves[:, i] - moves[:, j]) @ line, 0, atol=1e-9)


def test_overlaps_are_cosines_with_the_way_to_the_other_structure(ubiquitin):
    found = ragdoll.modes(ubiquitin, count=4)
    moved = ubiquitin.positions + 0.1 * found.of_atoms()[1]
    other = ragdoll.Molecule.from_topology(ubiquitin.topology, moved)
    towards = ragdoll.modes(ubiquitin, count=4, towards=other)
    assert towards.overlaps[1] > 0.99
    assert max(towards.overlaps[[0, 2, 3]]) < 0.1
    assert towards.rmsd_angstrom == pytest.approx(1.0, abs=0.02)


def test_the_command_writes_every_format(run_ragdoll, tmp_path, ubiquitin):
    for suffix in ("npz", "nmd", "h5"):
        out = tmp_path / f"modes.{suffix}"
        ended = run_ragdoll("modes", UBIQUITIN, "--count", "3", "-o", out, "--json", "--quiet")
        assert ended.code == 0, ended.stderr
        assert [mode["mode"] for mode in ended.json["modes"]] == [1, 2, 3]
    found = ragdoll.modes(ubiquitin, count=3)
    with np.load(tmp_path / "modes.npz") as file:
        assert np.allclose(file["vectors"], found.vectors)
        assert np.allclose(file["eigenvalues"], found.eigenvalues)
    text = (tmp_path / "modes.nmd").read_text().splitlines()
    lines = {line.split()[0]: line.split()[1:] for line in text}
    assert len(lines["coordinates"]) == 3 * 76 and len(lines["resids"]) == 76
    numbers = [float(word) for word in text[-1].split()[3:]]
    assert np.allclose(numbers, found.vectors[2].ravel(), atol=1e-5)
    with ragdoll.open_trajectory(tmp_path / "modes.h5") as trajectory:
        assert np.allclose(trajectory.arrays["mode_vectors"], found.vectors)
        assert np.allclose(trajectory.frame(0).positions, ubiquitin.positions, atol=1e-5)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--count", "0"], "--count must be from 1"),
        (["--cutoff-angstrom", "nan"], "The cutoff must be from 4"),
        (["-o", "modes.txt"], "give .npz, .nmd or .h5"),
        (["--target-chain", "A"], "--target-chain is for --towards"),
    ],
)
def test_what_makes_no_sense_is_refused_in_one_sentence(run_ragdoll, arguments, words):
    if not UBIQUITIN.exists():
        pytest.skip(f"{UBIQUITIN} is not there; set RAGDOLL_DATA")
    ended = run_ragdoll("modes", UBIQUITIN, *arguments)
    assert ended.code == 2
    assert words in ended.sentence
