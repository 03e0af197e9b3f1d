"""``ragdoll sample --replicas``: each replica is the run of its seed."""

import json
import signal
import time

import numpy as np
import pytest

import ragdoll
from ragdoll import _core

h5py = pytest.importorskip("h5py")
mdtraj = pytest.importorskip("mdtraj")

COMMON = ["--frames", 3, "--stride", 2, "--seed", 11, "--json"]


def read(path):
    with h5py.File(path) as file:
        values = {name: group["value"][:] for name, group in file["observables"].items()}
        values["coordinates"] = file["coordinates"][:]
        values["step"] = file["particles/trajectory/position/step"][:]
        values["parameters"] = json.loads(file["ragdoll/parameters"].asstr()[()])
    return values


@pytest.fixture(scope="module")
def replicas(run_ragdoll, dry_villin, tmp_path_factory):
    """Three replicas of villin: the file's arrays and the report."""
    path = tmp_path_factory.mktemp("replicas") / "r.h5"
    run = run_ragdoll("sample", dry_villin, "-o", path, *COMMON, "--replicas", 3)
    assert run.code == 0, run.stderr
    return path, read(path), run.json


def test_frames_come_round_by_round_with_replica_and_seed(replicas):
    _, values, report = replicas
    assert values["replica"].tolist() == [0, 1, 2] * 3
    assert values["seed"].tolist() == [11, 12, 13] * 3
    assert values["coordinates"].shape == (9, 582, 3)
    assert report["frames"] == report["frames_asked"] == 9
    assert (values["converged"] == 1).all()


def test_the_report_tells_of_each_replica_and_of_all(replicas):
    _, values, report = replicas
    assert [r["replica"] for r in report["replicas"]] == [0, 1, 2]
    assert [r["seed"] for r in report["replicas"]] == [11, 12, 13]
    assert [r["frames"] for r in report["replicas"]] == [3, 3, 3]
    for key in ("steps", "rejected_steps"):
        assert report[key] == sum(r[key] for r in report["replicas"])
    assert report["rejected_share"] == report["rejected_steps"] / report["steps"]
    for r in report["replicas"]:
        assert r["steps"] == 6 + r["rejected_steps"]
        assert r["iterations_mean"] >= 1
        assert 0.05 < r["rmsd_last_angstrom"] < 2
    assert report["geometry"]["tolerance_violations"] == 0
    assert report["geometry"]["chirality_inverted"] == 0
    assert values["parameters"]["replicas"] == 3
    assert values["parameters"]["replica_seeds"] == [11, 12, 13]


@pytest.mark.parametrize("solver", ["auto", "ordered", "newton"])
def test_each_replica_is_bit_for_bit_the_run_of_its_seed(
    run_ragdoll, dry_villin, tmp_path, replicas, solver
):
    if solver == "auto":
        together = replicas[1]
    else:
        path = tmp_path / "r.h5"
        run = run_ragdoll(
            "sample", dry_villin, "-o", path, *COMMON, "--replicas", 2, "--solver", solver
        )
        assert run.code == 0, run.stderr
        together = read(path)
    for k in (0, 1):
        path = tmp_path / f"{k}.h5"
        single = ["sample", dry_villin, "-o", path, *COMMON, "--seed", 11 + k, "--solver", solver]
        run = run_ragdoll(*single)
        assert run.code == 0, run.stderr
        alone, mine = read(path), together["replica"] == k
        for name in ("coordinates", "step", "iterations", "bar_visits", "residual", "converged"):
            np.testing.assert_array_equal(together[name][mine], alone[name], err_msg=name)


def test_threads_change_nothing(run_ragdoll, dry_villin, tmp_path, replicas):
    path = tmp_path / "r.h5"
    arguments = ["sample", dry_villin, "-o", path, *COMMON, "--replicas", 3, "--threads", 1]
    assert run_ragdoll(*arguments).code == 0
    np.testing.assert_array_equal(read(path)["coordinates"], replicas[1]["coordinates"])


def test_one_replica_is_a_replica(run_ragdoll, dry_villin, tmp_path, replicas):
    path = tmp_path / "r.h5"
    run = run_ragdoll("sample", dry_villin, "-o", path, *COMMON, "--replicas", 1)
    assert run.code == 0, run.stderr
    assert len(run.json["replicas"]) == 1
    assert read(path)["replica"].tolist() == [0, 0, 0]


def test_other_programs_read_the_file(replicas):
    loaded = mdtraj.load(str(replicas[0]))
    assert (loaded.n_frames, loaded.n_atoms) == (9, 582)


REFUSED = {
    "--replicas 0": "--replicas must be from 1",
    "--replicas 2 --seed 2147483647": "The seed of the last replica would be 2147483648",
    "--replicas 2 --platform CPU": "leave out --platform",
    "--replicas 2 --threads 0": "--threads must be from 1",
    "--threads 2": "--threads is for --replicas",
    "--precision quadruple": "precision 'quadruple' is not known",
    "--tolerance 0.1 --tolerance-angstrom 0.1": "exclude each other",
    "--tolerance-angstrom 0": "--tolerance-angstrom must be a positive number",
    "--tolerance-angstrom nan": "--tolerance-angstrom must be a positive number",
}


def test_what_makes_no_sense_is_refused_in_a_sentence(run_many, dry_villin, tmp_path):
    runs = run_many(
        ["sample", dry_villin, "-o", tmp_path / "a.h5", *options.split()] for options in REFUSED
    )
    for run, (options, words) in zip(runs, REFUSED.items(), strict=True):
        assert run.code == 2, options
        assert words in run.sentence, options
    assert list(tmp_path.iterdir()) == []


def test_missing_frames_end_in_3_and_the_others_are_kept(run_ragdoll, dry_villin, tmp_path):
    run = run_ragdoll(
        *["sample", dry_villin, "-o", tmp_path / "a.h5", "--frames", 2, "--stride", 1],
        *["--max-iterations", 1, "--step-angstrom", 0.5, "--json", "--replicas", 2],
    )
    assert run.code == 3
    assert run.json["frames"] == 0
    assert [r["steps"] for r in run.json["replicas"]] == [20, 20]
    assert "0 of 4 frames were written: 40 of 40 steps were rejected in 2 of 2" in run.sentence
    assert list(tmp_path.iterdir()) == []


def test_ctrl_c_keeps_what_is_done(start_ragdoll, dry_villin, tmp_path):
    path = tmp_path / "a.h5"
    before = """
from ragdoll.trajectory import TrajectoryWriter
def told(self, *arguments, append=TrajectoryWriter.append, **options):
    append(self, *arguments, **options)
    print("frame", flush=True)
TrajectoryWriter.append = told
"""
    process = start_ragdoll(
        *["sample", dry_villin, "-o", path, "--frames", 100_000, "--stride", 1],
        *["--replicas", 4, "--quiet"],
        before=before,
    )
    for _ in range(10):
        assert process.stdout.readline() == "frame\n"
    process.send_signal(signal.SIGINT)
    start = time.monotonic()
    _, stderr = process.communicate(timeout=60)
    assert process.returncode == 130, stderr
    assert time.monotonic() - start < 30
    assert "Interrupted" in stderr
    assert mdtraj.load(str(path)).n_frames >= 10


def test_a_function_samples_replicas_too(dry_villin, tmp_path):
    molecule = ragdoll.Molecule.from_file(dry_villin)
    seen = []
    report = ragdoll.sample(
        molecule,
        tmp_path / "a.h5",
        ragdoll.SampleOptions(frames=2, stride=1, replicas=3, precision="single", seed=1),
        progress=lambda done, asked: seen.append((done, asked)),
    )
    assert seen == [(k, 6) for k in range(1, 7)]
    assert report.frames == 6
    assert report.precision == "single"
    assert report.geometry["tolerance_violations"] == 0


def test_an_ensemble_gives_what_a_resolver_gives(dry_villin):
    molecule = ragdoll.Molecule.from_file(dry_villin)
    framework = ragdoll.build_framework(molecule)
    settings = {"absolute_tolerance": 0.001, "max_iterations": 500}
    moved = np.array([_core.perturb(molecule.positions, size=0.01, step=k) for k in range(5)])
    given = moved.copy()
    for solver in ("ordered", "newton"):
        ensemble = ragdoll.EnsembleResolver(framework, solver=solver, **settings)
        resolved, reports = ensemble.resolve_all(moved)
        np.testing.assert_array_equal(moved, given)
        single = _core.Resolver(framework, solver=solver, **settings)
        for k in range(5):
            x, report = single.resolve(moved[k], step=k)
            np.testing.assert_array_equal(resolved[k], x)
            assert reports[k] == report
            assert report["converged"]
            assert report["residual_nm"] <= 0.001
    with pytest.raises(ValueError, match="the conformers have 3 positions each"):
        ensemble.resolve_all(np.zeros((2, 3, 3)))
