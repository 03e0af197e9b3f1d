"""``ragdoll sample``: what it says, and whether the file holds it, by other programs."""

import hashlib
import importlib.metadata
import json
import shutil
import subprocess
import warnings

import numpy as np
import pytest

import ragdoll

h5py = pytest.importorskip("h5py")
mdtraj = pytest.importorskip("mdtraj")

KEYS = [
    "atoms",
    "joints",
    "bars",
    "contacts",
    "chirality_centres",
    "class",
    "cycle_rank",
    "components",
    "frames",
    "steps",
    "rejected_steps",
    "iterations_mean",
    "iterations_p99",
    "seconds",
    "frames_per_second",
    "geometry",
]
GEOMETRY_KEYS = [
    "bond_rms_angstrom",
    "bond_max_angstrom",
    "bond_max_relative",
    "angle_rms_degree",
    "omega_max_deviation_degree",
    "contact_violations",
    "contact_worst_angstrom",
    "chirality_inverted",
    "rmsd_last_angstrom",
    "rmsd_max_angstrom",
]


def coordinates(path):
    with h5py.File(path) as file:
        return file["coordinates"][:]


@pytest.fixture(scope="module")
def few(run_ragdoll, dry_villin, tmp_path_factory):
    """Sample 4 frames of villin, 2 steps apart; gives the coordinates."""
    folder = tmp_path_factory.mktemp("few")

    def sample(name, *options):
        path = folder / f"{name}.h5"
        arguments = ["sample", dry_villin, "-o", path, "--frames", 4, "--stride", 2, "--quiet"]
        if "--perturbation" not in options:
            options += ("--perturbation", "gaussian")
        run = run_ragdoll(*arguments, *options)
        assert run.code == 0, run.stderr
        return coordinates(path)

    return sample


@pytest.fixture(scope="module")
def seed_three(few):
    return few("three", "--seed", 3)


@pytest.fixture(scope="module")
def read_back(sampled_villin, recompute):
    return recompute.read(sampled_villin.path)


@pytest.fixture(scope="module")
def measured(read_back, recompute):
    return recompute.measure(read_back)


def test_the_report_has_all_keys(sampled_villin):
    report = sampled_villin.report
    assert not set(KEYS) - set(report)
    assert not set(GEOMETRY_KEYS) - set(report["geometry"])


def test_the_report_describes_villin(sampled_villin):
    report = sampled_villin.report
    assert report["atoms"] == report["joints"] == 582
    assert report["class"] == "n-cycle"
    assert report["cycle_rank"] == 589 - 582 + 1
    assert report["components"] == 1
    assert report["frames"] == 20
    assert report["steps"] == 200 + report["rejected_steps"]
    assert report["rejected_steps"] <= 2
    assert report["bars"] > 589
    assert report["contacts"] > 500
    assert report["chirality_centres"] >= 35
    assert 1 <= report["iterations_mean"] <= report["iterations_p99"]
    assert report["frames_per_second"] == pytest.approx(20 / report["seconds"])


def test_all_frames_are_written_and_the_input_is_not_among_them(sampled_villin, read_back):
    assert read_back.frames.shape == (20, 582, 3)
    assert np.abs(read_back.frames - read_back.start).max(axis=(1, 2)).min() > 0.001
    assert len(np.unique(read_back.frames[:, 0], axis=0)) == 20


def test_frames_lie_a_stride_of_accepted_steps_apart(sampled_villin):
    with h5py.File(sampled_villin.path) as file:
        steps = file["particles/trajectory/position/step"][:]
    assert steps[0] >= 10
    assert (np.diff(steps) >= 10).all()
    assert steps[-1] <= sampled_villin.report["steps"]


def test_the_stride_thins_the_same_walk(few, seed_three):
    every = few("every", "--seed", 3, "--frames", 8, "--stride", 1)
    np.testing.assert_array_equal(every[1::2], seed_three)


def test_the_same_seed_gives_identical_coordinates(few, seed_three):
    np.testing.assert_array_equal(few("again", "--seed", 3), seed_three)


def test_another_seed_gives_other_coordinates(few, seed_three):
    assert np.abs(few("four", "--seed", 4) - seed_three).max() > 0.01


def test_the_cpu_platform_gives_what_the_reference_platform_gives(few, seed_three):
    np.testing.assert_array_equal(few("cpu", "--seed", 3, "--platform", "CPU"), seed_three)


def test_the_ball_perturbation_moves_too(few, seed_three):
    ball = few("ball", "--seed", 3, "--perturbation", "ball")
    assert np.abs(ball - seed_three).max() > 0.001


@pytest.mark.parametrize(
    "technique", [("random", ".5/.5"), ("bfs_adapt", ".75/.25"), ("dfs_reverse", ".5/.5")]
)
def test_other_orders_and_weightings_sample_as_well(run_ragdoll, dry_villin, tmp_path, technique):
    order, weighting = technique
    run = run_ragdoll(
        *["sample", dry_villin, "-o", tmp_path / "a.h5", "--frames", 1, "--stride", 1, "--json"],
        *["--order", order, "--weighting", weighting, "--solver", "ordered"],
        *["--step-angstrom", 0.02],
    )
    assert run.code == 0, run.stderr
    assert run.json["geometry"]["bond_max_relative"] <= 0.01
    assert run.json["solver"] == "ordered"


def test_the_rmsd_grows(measured):
    assert measured.rmsd[0] < measured.rmsd[-1]
    assert measured.rmsd[:5].mean() < measured.rmsd[-5:].mean()
    assert measured.rmsd[-1] > 0.3


def test_bond_lengths_stay_within_the_tolerance_of_the_input(measured):
    assert 0 < measured.bond_max_relative <= 0.01


def test_the_hand_of_every_centre_stays(measured):
    assert measured.centres >= 33
    assert measured.inverted == 0


def test_peptide_torsions_stay_near_the_input(read_back, measured, recompute):
    assert len(recompute.omega_atoms(read_back, proline=True)) == 34
    assert 0 < measured.omega_max <= 15


def test_no_contact_is_violated_counted_over_all_pairs(read_back, recompute):
    pairs = np.stack(np.triu_indices(582, 1), axis=1)
    bounds = recompute.contact_bounds(read_back.framework, pairs)
    for frame in read_back.frames:
        distances = np.linalg.norm(frame[pairs[:, 1]] - frame[pairs[:, 0]], axis=1)
        assert (distances >= 0.99 * bounds).all()
    assert (bounds > 0).sum() > 100_000


def test_bonded_neighbours_and_only_they_are_exempt_from_contacts(read_back, recompute):
    near = [{atom} for atom in range(582)]
    for i, j in read_back.bonds:
        near[i].add(j)
        near[j].add(i)
    within_three = [
        {c for b in near[a] for c in near[b]}
        | {d for b in near[a] for c in near[b] for d in near[c]}
        for a in range(582)
    ]
    excluded = {tuple(sorted(pair)) for pair in read_back.framework["contact_exclusions"].tolist()}
    for i, j in excluded:
        assert j in within_three[i]
    assert excluded >= {tuple(sorted(pair)) for pair in read_back.bonds.tolist()}


def test_contact_radii_are_those_of_bondi_and_rowland_and_taylor(read_back):
    expected = {"H": 0.11, "C": 0.17, "N": 0.155, "O": 0.152, "S": 0.18}
    for element, radius in zip(
        read_back.elements, read_back.framework["contact_radii"], strict=True
    ):
        assert radius == pytest.approx(expected[element], abs=0.0101), element


def test_the_report_agrees_with_the_file(sampled_villin, measured):
    said = sampled_villin.report["geometry"]
    assert said["bond_max_relative"] == pytest.approx(measured.bond_max_relative, abs=1e-7)
    assert said["omega_max_deviation_degree"] == pytest.approx(measured.omega_max_all, abs=1e-3)
    assert said["contact_violations"] == measured.contact_violations == 0
    assert said["contact_worst_angstrom"] == pytest.approx(measured.contact_worst, abs=1e-5)
    assert said["chirality_inverted"] == measured.inverted == 0
    assert said["rmsd_last_angstrom"] == pytest.approx(measured.rmsd[-1], abs=1e-4)
    assert said["rmsd_max_angstrom"] == pytest.approx(measured.rmsd.max(), abs=1e-4)


def test_mdtraj_reads_the_topology_and_the_input_it_came_from(sampled_villin, read_back, villin):
    loaded = mdtraj.load(str(sampled_villin.path))
    original = mdtraj.load(str(villin))
    protein = original.atom_slice(original.topology.select("protein"))
    assert loaded.n_frames == 20
    lines = [line for line in villin.read_text().splitlines() if line.startswith("ATOM")][:582]
    assert [a.name for a in loaded.topology.atoms] == [line[12:16].strip() for line in lines]
    assert [a.element for a in loaded.topology.atoms] == [a.element for a in protein.topology.atoms]
    places = [(line[17:20].strip(), int(line[22:26])) for line in lines]
    assert [(a.residue.name, a.residue.resSeq) for a in loaded.topology.atoms] == places
    assert loaded.topology.n_bonds == protein.topology.n_bonds
    np.testing.assert_allclose(read_back.start, protein.xyz[0], atol=1e-5)
    np.testing.assert_array_equal(loaded.xyz, coordinates(sampled_villin.path))


def test_mdanalysis_reads_the_same_coordinates(sampled_villin, dry_villin):
    MDAnalysis = pytest.importorskip("MDAnalysis")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        universe = MDAnalysis.Universe(str(dry_villin), str(sampled_villin.path), format="H5MD")
        seen = np.array([frame.positions.copy() for frame in universe.trajectory])
    np.testing.assert_allclose(seen / 10, coordinates(sampled_villin.path), atol=1e-5)


@pytest.mark.skipif(shutil.which("h5dump") is None, reason="h5dump is not installed")
def test_h5dump_reads_the_file(sampled_villin):
    dump = subprocess.run(["h5dump", str(sampled_villin.path)], capture_output=True, text=True)
    assert dump.returncode == 0
    assert dump.stderr == ""
    assert 'DATASET "coordinates"' in dump.stdout


def test_the_file_holds_all_that_made_it(sampled_villin, villin):
    with h5py.File(sampled_villin.path) as file:
        attributes = dict(file["ragdoll"].attrs)
        parameters = json.loads(file["ragdoll/parameters"].asstr()[()])
        assert file.attrs["programVersion"] == ragdoll.__version__
        names = set(file["ragdoll/framework"])
    digest = hashlib.sha256(villin.read_bytes()).hexdigest()
    assert attributes["seed"] == parameters["seed"] == 7
    assert attributes["version"] == parameters["version"] == ragdoll.__version__
    assert attributes["input_hash"] == parameters["input_hash"] == digest
    assert parameters["input"] == str(villin)
    assert importlib.metadata.version("openmm").startswith(parameters["openmm_version"])
    options = (
        "frames stride step_angstrom perturbation order weighting solver tolerance max_iterations "
        "contacts contact_scale planarity_degree platform model altloc chains keep_solvent "
        "add_hydrogens ph"
    )
    assert not set(options.split()) - set(parameters)
    assert {"bars", "bar_lengths", "volumes", "contact_radii", "contact_rule"} <= names


def test_every_frame_carries_its_iterations_and_residual(sampled_villin):
    with h5py.File(sampled_villin.path) as file:
        values = {name: group["value"][:] for name, group in file["observables"].items()}
    assert set(values) == {"iterations", "bar_visits", "residual", "converged"}
    assert all(len(value) == 20 for value in values.values())
    assert (values["converged"] == 1).all()
    assert (values["iterations"] >= 1).all()
    assert ((values["residual"] > 0) & (values["residual"] <= 0.01)).all()


def test_without_contacts_atoms_may_overlap(run_ragdoll, dry_villin, tmp_path):
    run = run_ragdoll(
        *["sample", dry_villin, "-o", tmp_path / "a.h5", "--frames", 2, "--stride", 1],
        *["--no-contacts", "--json"],
    )
    assert run.code == 0, run.stderr
    assert run.json["contacts"] == 0
    with h5py.File(tmp_path / "a.h5") as file:
        assert file["ragdoll/framework/contact_radii"].size == 0


def test_rejected_steps_are_counted_and_missing_frames_end_in_3(run_ragdoll, dry_villin, tmp_path):
    run = run_ragdoll(
        *["sample", dry_villin, "-o", tmp_path / "a.h5", "--frames", 2, "--stride", 1],
        *["--max-iterations", 1, "--step-angstrom", 0.5, "--json"],
    )
    assert run.code == 3
    assert run.json["frames"] == 0
    assert run.json["steps"] == run.json["rejected_steps"] == 20
    assert "0 of 2 frames were written: 20 of 20 steps were rejected" in run.sentence
    assert list(tmp_path.iterdir()) == []


def test_quiet_says_nothing_but_why_frames_are_missing(run_ragdoll, dry_villin, tmp_path):
    arguments = [
        "sample",
        dry_villin,
        "-o",
        tmp_path / "a.h5",
        "--frames",
        1,
        "--stride",
        1,
        "--quiet",
    ]
    run = run_ragdoll(*arguments)
    assert (run.code, run.stdout, run.stderr) == (0, "", "")
    run = run_ragdoll(*arguments, "--max-iterations", 1, "--step-angstrom", 1, "--force")
    assert run.code == 3
    assert run.stdout == ""
    assert run.stderr == f"ragdoll: {run.sentence}\n"


def test_a_small_tolerance_is_said_to_be_beyond_single_precision(run_ragdoll, dry_villin, tmp_path):
    run = run_ragdoll(
        *["sample", dry_villin, "-o", tmp_path / "a.h5", "--frames", 1, "--stride", 1],
        *["--tolerance", 1e-7, "--max-iterations", 2],
    )
    assert run.code == 3
    assert "single precision" in run.stderr


def test_a_single_atom_is_sampled(run_ragdoll, villin, tmp_path):
    line = next(line for line in villin.read_text().splitlines() if line.startswith("ATOM"))
    (tmp_path / "one.pdb").write_text(line + "\n")
    run = run_ragdoll("sample", tmp_path / "one.pdb", "-o", tmp_path / "a.h5", "--json")
    assert run.code == 0, run.stderr
    assert run.json["atoms"] == 1
    assert mdtraj.load(str(tmp_path / "a.h5")).n_atoms == 1


def test_several_chains_with_gaps_and_ligands_are_sampled(
    run_ragdoll, proteins, tmp_path, recompute
):
    run = run_ragdoll(
        *["sample", proteins / "1hvr.pdb", "-o", tmp_path / "a.h5", "--frames", 20],
        *["--seed", 7, "--json"],
    )
    assert run.code == 0, run.stderr
    measured = recompute.measure(recompute.read(tmp_path / "a.h5"))
    assert run.json["rejected_steps"] <= 0.01 * run.json["steps"]
    assert measured.bond_max_relative <= 0.01
    assert measured.omega_max <= 15
    assert measured.inverted == measured.contact_violations == 0
    assert measured.rmsd[-1] > 0.3
    assert measured.rmsd[:5].mean() < measured.rmsd[-5:].mean()
