"""Paths from one structure to another, at the command line and in Python."""

import os
from pathlib import Path

import numpy as np
import pytest
from openmm import unit
from openmm.app import PDBFile

import ragdoll
from ragdoll import _core
from ragdoll.constraint_options import ConstraintOptions
from ragdoll.matching import match, placed
from ragdoll.targeting import TargetOptions

ROOT = Path(__file__).resolve().parents[2]
DATA = Path(os.environ.get("RAGDOLL_DATA", ROOT.parent / "shared" / "data"))
TRP_CAGE = DATA / "proteins" / "1l2y.pdb"
UBIQUITIN = DATA / "proteins" / "1ubq.pdb"


@pytest.fixture(scope="module")
def ends():
    """Two models of the Trp-cage, all hydrogens."""
    if not TRP_CAGE.exists():
        pytest.skip(f"{TRP_CAGE} is not there; set RAGDOLL_DATA")
    return (
        ragdoll.Molecule.from_file(TRP_CAGE, model=1),
        ragdoll.Molecule.from_file(TRP_CAGE, model=7),
    )


def _superposed(moved, fixed):
    one, other = moved.mean(axis=0), fixed.mean(axis=0)
    u, _, vt = np.linalg.svd((moved - one).T @ (fixed - other))
    u[:, -1] *= np.sign(np.linalg.det(u @ vt))
    return (moved - one) @ (u @ vt) + other


def _rmsd(a, b):
    return float(np.sqrt(((_superposed(a, b) - b) ** 2).sum(axis=1).mean()))


def _alphas(molecule):
    return [atom.index for atom in molecule.topology.atoms() if atom.name == "CA"]


@pytest.fixture(scope="module")
def path(ends, tmp_path_factory):
    output = tmp_path_factory.mktemp("target") / "path.h5"
    return output, ragdoll.target(*ends, output)


def test_a_path_reaches_its_target_in_small_steps_that_come_nearer(ends, path):
    output, report = path
    start, end = ends
    alphas = _alphas(start)
    goal = 10 * end.positions[_alphas(end)]
    with ragdoll.open_trajectory(output) as trajectory:
        frames = [10 * frame.positions.astype(float) for frame in trajectory]
        told = [frame.observables["rmsd"] for frame in trajectory]
    assert report.arrived and report.frames == len(frames)
    assert np.allclose(frames[0], 10 * start.positions, atol=1e-4)
    rmsds = [_rmsd(frame[alphas], goal) for frame in frames]
    assert np.allclose(rmsds, 10 * np.array(told), atol=1e-3)
    assert all(later < earlier for earlier, later in zip(rmsds, rmsds[1:], strict=False))
    assert rmsds[0] == pytest.approx(report.rmsd_start_angstrom, abs=1e-3)
    assert rmsds[-1] == pytest.approx(report.rmsd_end_angstrom, abs=1e-3)
    assert rmsds[-1] <= 0.2
    steps = [
        np.linalg.norm(later[alphas] - earlier[alphas], axis=1).max()
        for earlier, later in zip(frames, frames[1:], strict=False)
    ]
    assert max(steps) <= 0.5
    assert max(steps) == pytest.approx(report.widest_step_angstrom, abs=1e-3)


def test_every_frame_of_a_path_keeps_its_constraints(path):
    output, report = path
    tolerance = 1e-3  # nm
    with ragdoll.open_trajectory(output) as trajectory:
        held = trajectory.framework
        for frame in trajectory:
            x = frame.positions.astype(float)

            def distance(pairs, x=x):
                return np.linalg.norm(x[pairs[:, 0]] - x[pairs[:, 1]], axis=1)

            assert np.abs(distance(held["bars"]) - held["bar_lengths"]).max() <= tolerance
            assert (distance(held["tethers"]) - held["tether_lengths"]).max() <= tolerance
            assert (held["contact_lengths"] - distance(held["contacts"])).max() <= tolerance
            a, b, c, d = (x[held["volumes"][:, k]] for k in range(4))
            volume = ((b - a) * np.cross(c - a, d - a)).sum(axis=1)
            slack = tolerance * np.cbrt(held["volume_scale"]) ** 2
            assert (volume >= held["volume_lower"] - slack).all()
            assert (volume <= held["volume_upper"] + slack).all()
    quality = report.quality
    assert quality["worst"]["bond_rms_angstrom"] <= 0.004
    assert quality["worst"]["angle_rms_degree"] <= 0.6
    assert quality["worst"]["inverted_centres"] == 0
    assert report.geometry["tolerance_violations"] == 0


def test_the_same_seed_goes_the_same_way_and_another_seed_another(ends, tmp_path):
    options = {"variant": "random", "constraints": None, "retries": 1}
    frames = []
    for name, seed in (("one", 1), ("again", 1), ("other", 2)):
        ragdoll.target(*ends, tmp_path / f"{name}.h5", TargetOptions(seed=seed, **options))
        with ragdoll.open_trajectory(tmp_path / f"{name}.h5") as trajectory:
            frames.append([frame.positions for frame in trajectory])
    assert np.array_equal(frames[0], frames[1])
    assert not np.array_equal(frames[0][1], frames[2][1])


def test_the_command_tells_what_it_did_and_goes_back(ends, run_ragdoll, tmp_path):
    first, second = tmp_path / "first.pdb", tmp_path / "second.pdb"
    for molecule, name in zip(ends, (first, second), strict=True):
        with open(name, "w") as file:
            PDBFile.writeFile(molecule.topology, molecule.positions * unit.nanometer, file, True)
    out = tmp_path / "path.h5"
    there = run_ragdoll("target", first, second, "-o", out, "--json", "--quiet", "--no-hbonds")
    assert there.code == 0, there.stderr
    for name in ("frames", "rmsd_start_angstrom", "rmsd_end_angstrom", "cpu_seconds", "quality"):
        assert name in there.json
    back = run_ragdoll(
        "target", first, second, "-o", out, "--json", "--reverse", "--force", "--no-hbonds"
    )
    assert back.code == 0, back.stderr
    assert back.json["rmsd_start_angstrom"] == pytest.approx(there.json["rmsd_start_angstrom"])
    with ragdoll.open_trajectory(out) as trajectory:
        assert np.allclose(trajectory.frame(0).positions, ends[1].positions, atol=1e-4)


def test_a_path_that_does_not_arrive_is_written_and_said(ends, run_ragdoll, tmp_path):
    start, end = ends
    # the target is a structure blown up by a half
    blown = tmp_path / "blown.pdb"
    with open(blown, "w") as file:
        PDBFile.writeFile(end.topology, 1.02 * end.positions * unit.nanometer, file, True)
    out = tmp_path / "path.h5"
    ended = run_ragdoll(
        "target", TRP_CAGE, blown, "-o", out, "--arrive-angstrom", "0.01", "--retries", "0"
    )
    assert ended.code == 3
    assert "angstrom from the target" in ended.sentence
    with ragdoll.open_trajectory(out) as trajectory:
        assert len(trajectory) > 1


@pytest.mark.parametrize(
    ("start", "end", "words"),
    [
        (UBIQUITIN, UBIQUITIN, "are the same conformation"),
        (UBIQUITIN, TRP_CAGE, "have too little in common for a path"),
        (UBIQUITIN, DATA / "proteins" / "2k39_ca.pdb", "has only the CA atom"),
    ],
)
def test_pairs_without_a_path_are_refused_in_one_sentence(run_ragdoll, tmp_path, start, end, words):
    if not start.exists():
        pytest.skip(f"{start} is not there; set RAGDOLL_DATA")
    ended = run_ragdoll("target", start, end, "-o", tmp_path / "path.h5")
    assert ended.code == 2
    assert words in ended.sentence
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("flag", "value", "words"),
    [
        ("--variant", "quick", "variant 'quick' is not known"),
        ("--step-angstrom", "0", "--step-angstrom must be above 0"),
        ("--spacing-angstrom", "0.6", "--spacing-angstrom must be above 0 and at most 0.5"),
        ("--tolerance-angstrom", "nan", "--tolerance-angstrom must be above 0"),
    ],
)
def test_options_that_make_no_sense_are_refused(run_ragdoll, tmp_path, flag, value, words):
    ended = run_ragdoll("target", "a.pdb", "b.pdb", "-o", tmp_path / "path.h5", flag, value)
    assert ended.code == 2
    assert words in ended.sentence


def test_residues_are_matched_by_aligned_sequences(ends, tmp_path):
    start, end = ends
    # the other one lacks residues 1, 2 and 11, and residue 5 is another one
    gone = ("1", "2", "11")
    lines = []
    for line in TRP_CAGE.read_text().splitlines():
        if line.startswith("ENDMDL"):
            break
        if line.startswith("ATOM") and line[22:26].strip() not in gone:
            if line[22:26].strip() == "5":
                if line[12:16].strip() not in ("N", "CA", "C", "O", "CB"):
                    continue
                line = line[:17] + "ALA" + line[20:]
            lines.append(line)
    cut = tmp_path / "cut.pdb"
    cut.write_text("\n".join(lines) + "\nEND\n")
    other = ragdoll.Molecule.from_file(cut)
    pair = match(start, other)
    assert pair.residues == 17
    assert pair.identity == pytest.approx(16 / 17)
    for i, j in zip(pair.first, pair.second, strict=True):
        assert np.allclose(start.positions[i], other.positions[j], atol=1e-4)
    assert len(pair.sites) == 17
    # atoms without a partner are placed beside those that have one
    assert np.allclose(placed(start, other, pair), start.positions, atol=0.02)


def test_names_of_side_chains_that_are_alike_after_half_a_turn_are_taken_as_they_lie(ends):
    start, _ = ends
    names = [(atom.residue.index, atom.name) for atom in start.topology.atoms()]
    swapped = start.positions.copy()
    tyrosine = next(r.index for r in start.topology.residues() if r.name == "TYR")
    for a, b in (("CD1", "CD2"), ("CE1", "CE2")):
        i, j = names.index((tyrosine, a)), names.index((tyrosine, b))
        swapped[[i, j]] = swapped[[j, i]]
    other = ragdoll.Molecule.from_topology(start.topology, swapped)
    pair = match(start, other)
    assert np.allclose(start.positions[pair.first], other.positions[pair.second])


def test_constraints_of_a_path_are_those_that_both_ends_have(ends, path):
    _, report = path
    start, end = ends
    options = ConstraintOptions()
    alone = ragdoll.build_framework(start, constraints=options).constraint_counts()
    assert 0 < report.constraints["hydrogen_bonds"] <= alone["hydrogen_bonds"]
    pair = match(start, end)
    common = ragdoll.build_framework(
        start, constraints=options, conformations=[placed(start, end, pair)]
    )
    there = placed(start, end, pair)
    pairs, lengths = common.tethers, common.tether_lengths
    distances = np.linalg.norm(there[pairs[:, 0]] - there[pairs[:, 1]], axis=1)
    assert (distances <= lengths + 1e-9).all()
    assert _core.superposed_rmsd(there[pair.first], end.positions[pair.second]) < 1e-6
