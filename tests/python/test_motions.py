"""Perturbations of ``ragdoll sample``: seeds, replicas, restarts, constraints, symmetry."""

import os
from pathlib import Path

import numpy as np
import pytest

import ragdoll
from ragdoll.motion_options import MotionOptions, mode_numbers, symmetric_copies

ROOT = Path(__file__).resolve().parents[2]
DATA = Path(os.environ.get("RAGDOLL_DATA", ROOT.parent / "shared" / "data"))
TRP_CAGE = DATA / "proteins" / "1l2y.pdb"
DNA = DATA / "proteins" / "1bna.pdb"
KINDS = {
    "thermal": {},
    "ball": {},
    "momentum": {},
    "hinge": {},
    "modes": {"modes": "1-3", "mode_amplitude_angstrom": 0.5},
    "steer": {"steer": ("resid 20 and name CA; 0.1 0 0", "resid 1; to 10 0 0")},
    "away": {"away_from": "density"},
}


@pytest.fixture(scope="module")
def molecule():
    if not TRP_CAGE.exists():
        pytest.skip(f"{TRP_CAGE} is not there; set RAGDOLL_DATA")
    return ragdoll.Molecule.from_file(TRP_CAGE)


def _options(kind, **more):
    values = {
        "perturbation": kind,
        "motion": MotionOptions(**KINDS[kind]),
        "frames": 3,
        "stride": 2,
        "step_angstrom": 0.03,
        "seed": 5,
        "replicas": 2,
        "threads": 1,
        "tolerance_angstrom": 0.01,
        "allow_low_quality": True,
    }
    return ragdoll.SampleOptions(**{**values, **more})


def _frames(path):
    with ragdoll.open_trajectory(path) as trajectory:
        return [(frame.positions.astype(float), frame.step) for frame in trajectory]


@pytest.mark.parametrize("kind", KINDS)
def test_runs_are_repeated_replicated_and_gone_on_with(molecule, tmp_path, kind):
    report = ragdoll.sample(molecule, tmp_path / "a.h5", _options(kind))
    assert report.frames == 6
    assert report.geometry["tolerance_violations"] == 0
    assert report.geometry["contact_violations"] == 0
    assert report.geometry["chirality_inverted"] == 0
    assert all(value == 0 for value in report.geometry["tether_excess_angstrom"].values())
    assert report.geometry["rmsd_max_angstrom"] > 0.005
    first = _frames(tmp_path / "a.h5")
    # replica 1 is the run with the next seed
    ragdoll.sample(molecule, tmp_path / "b.h5", _options(kind, seed=6, replicas=1))
    alone = _frames(tmp_path / "b.h5")
    assert all(np.array_equal(a[0], b[0]) for a, b in zip(first[1::2], alone, strict=True))
    # in two runs
    state = tmp_path / "state.npz"
    ragdoll.sample(molecule, tmp_path / "c.h5", _options(kind, frames=1), state=state)
    ragdoll.sample(molecule, tmp_path / "d.h5", _options(kind, frames=2), restart=state)
    both = _frames(tmp_path / "c.h5") + _frames(tmp_path / "d.h5")
    assert all(
        np.array_equal(a[0], b[0]) and a[1] == b[1] for a, b in zip(first, both, strict=True)
    )


def test_a_state_of_another_run_is_refused(molecule, tmp_path):
    state = tmp_path / "state.npz"
    ragdoll.sample(molecule, tmp_path / "a.h5", _options("momentum", frames=1), state=state)
    with pytest.raises(ragdoll.InputError, match="its seed is 5, not 6"):
        ragdoll.sample(molecule, tmp_path / "b.h5", _options("momentum", seed=6), restart=state)
    with pytest.raises(ragdoll.InputError, match="its perturbation is momentum, not hinge"):
        ragdoll.sample(molecule, tmp_path / "b.h5", _options("hinge"), restart=state)
    text = tmp_path / "text.npz"
    text.write_text("no state")
    with pytest.raises(ragdoll.InputError, match="is no state of a run"):
        ragdoll.sample(molecule, tmp_path / "b.h5", _options("momentum"), restart=text)


def test_steering_moves_what_is_pulled(molecule, tmp_path):
    motion = MotionOptions(steer=("resid 20 and name CA; 0.2 0 0",))
    options = _options("steer", motion=motion, frames=4, stride=5, replicas=None, constraints=None)
    options = ragdoll.SampleOptions(**{**vars(options), "threads": None})
    ragdoll.sample(molecule, tmp_path / "a.h5", options)
    atom = next(
        a.index for a in molecule.topology.atoms() if a.name == "CA" and a.residue.index == 19
    )
    way = [frame[atom][0] - molecule.positions[atom][0] for frame, _ in _frames(tmp_path / "a.h5")]
    assert way[-1] > 0.02


def test_chains_that_are_symmetric_move_alike(tmp_path):
    if not DNA.exists():
        pytest.skip(f"{DNA} is not there; set RAGDOLL_DATA")
    molecule = ragdoll.Molecule.from_file(DNA)
    motion = MotionOptions(symmetric=("A", "B"))
    options = _options("momentum", motion=motion, replicas=1, frames=2, stride=1)
    report = ragdoll.sample(molecule, tmp_path / "a.h5", options)
    assert report.frames == 2
    assert any("Copies were made alike" in note for note in report.notes)
    assert report.geometry["tolerance_violations"] == 0
    first, second = (np.array(copy) for copy in symmetric_copies(molecule, ("A", "B")))
    for frame, _ in _frames(tmp_path / "a.h5"):
        one, other = frame[first], frame[second]
        assert ragdoll._core.superposed_rmsd(one, other) < 1e-4


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--perturbation", "jump"], "perturbation 'jump' is not known"),
        (["--perturbation", "steer"], "needs a --steer"),
        (["--steer", "all; 0 0 1"], "--steer is for --perturbation steer"),
        (["--perturbation", "steer", "--steer", "all; 1 2"], "three numbers of angstrom"),
        (["--perturbation", "steer", "--steer", "resid 999; 0 0 1"], "matches no atom"),
        (["--perturbation", "modes", "--modes", "0-3"], "--modes must be numbers from 1"),
        (["--perturbation", "momentum", "--persistence", "2"], "--persistence must be from 0 to 1"),
        (["--perturbation", "away", "--away-from", "home"], "way of keeping away 'home'"),
        (["--temperature-kelvin", "0"], "--temperature-kelvin must be above 0"),
        (["--thermal-modes", "0"], "--thermal-modes must be from 1 to 1000, not 0"),
        (["--thermal-step-angstrom", "nan"], "--thermal-step-angstrom must be above 0"),
        (["--symmetric", "A"], "--symmetric needs two chains"),
        (["--symmetric", "A,Q"], "--symmetric names chain 'Q'"),
        (["--perturbation", "hinge", "--platform", "CPU"], "leave out --platform"),
    ],
)
def test_what_makes_no_sense_is_refused_in_one_sentence(run_ragdoll, tmp_path, arguments, words):
    if not TRP_CAGE.exists():
        pytest.skip(f"{TRP_CAGE} is not there; set RAGDOLL_DATA")
    ended = run_ragdoll("sample", TRP_CAGE, "-o", tmp_path / "a.h5", *arguments)
    assert ended.code == 2
    assert words in ended.sentence
    assert not (tmp_path / "a.h5").exists()


def test_the_command_samples_by_modes(run_ragdoll, tmp_path):
    if not TRP_CAGE.exists():
        pytest.skip(f"{TRP_CAGE} is not there; set RAGDOLL_DATA")
    out = tmp_path / "a.h5"
    flags = ["--perturbation", "modes", "--modes", "1", "--mode-amplitude-angstrom", "1"]
    ended = run_ragdoll(
        "sample", TRP_CAGE, "-o", out, *flags, "--frames", "2", "--stride", "2", "--json"
    )
    assert ended.code == 0, ended.stderr
    assert ended.json["parameters"]["motion"]["mode_amplitude_angstrom"] == 1


def test_numbers_of_modes():
    assert mode_numbers("1-3,7, 9 - 10,2") == [1, 2, 3, 7, 9, 10]
    for text in ("", "a", "3-1", "0", "1,,2"):
        with pytest.raises(ragdoll.InputError, match="--modes must be"):
            mode_numbers(text)
