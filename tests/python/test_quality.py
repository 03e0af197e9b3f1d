"""Quality of frames: against measures of our own by numpy, and against published values."""

import json

import numpy as np
import pytest
from openmm import unit

import ragdoll
from ragdoll import InputError, Molecule
from ragdoll.quality_report import molecule_terms


@pytest.fixture(scope="module")
def ubiquitin(proteins):
    return Molecule.from_file(proteins / "1d3z.pdb")


@pytest.fixture(scope="module")
def measured(sampled_villin):
    return ragdoll.quality(sampled_villin.path)


def _lengths(x, pairs):
    return np.linalg.norm(x[..., pairs[:, 1], :] - x[..., pairs[:, 0], :], axis=-1)


def _angles(x, triples):
    u, v = (x[..., triples[:, k], :] - x[..., triples[:, 1], :] for k in (0, 2))
    cosines = (u * v).sum(-1) / np.linalg.norm(u, axis=-1) / np.linalg.norm(v, axis=-1)
    return np.degrees(np.arccos(np.clip(cosines, -1, 1)))


def test_bonds_and_angles_of_a_file_are_what_numpy_finds_in_it(recompute, sampled_villin, measured):
    sampled = recompute.read(sampled_villin.path)
    off = 10 * (_lengths(sampled.frames, sampled.bonds) - _lengths(sampled.start, sampled.bonds))
    np.testing.assert_allclose(
        measured.frames["bond_rms_angstrom"], np.sqrt((off**2).mean(axis=1)), atol=1e-9
    )
    assert measured.worst["bond_max_angstrom"] == pytest.approx(np.abs(off).max())
    assert measured.worst_frame["bond_max_angstrom"] == np.abs(off).max(axis=1).argmax()
    around = {}
    for a, b in sampled.bonds.tolist():
        around.setdefault(a, []).append(b)
        around.setdefault(b, []).append(a)
    triples = np.array(
        [
            (ends[i], centre, ends[j])
            for centre, ends in around.items()
            for i in range(len(ends))
            for j in range(i)
        ]
    )
    off = _angles(sampled.frames, triples) - _angles(sampled.start, triples)
    np.testing.assert_allclose(
        measured.frames["angle_rms_degree"], np.sqrt((off**2).mean(axis=1)), rtol=1e-6
    )
    assert measured.mean["angle_rms_degree"] == pytest.approx(np.sqrt((off**2).mean()))
    assert len(measured) == len(sampled.frames) == 20


def test_peptide_bonds_and_the_hands_of_centres_are_what_numpy_finds(
    recompute, sampled_villin, measured
):
    sampled = recompute.read(sampled_villin.path)
    omegas = recompute.torsions(sampled.frames, recompute.omega_atoms(sampled, proline=True))
    off = 180 - np.abs(omegas)  # all are trans
    np.testing.assert_allclose(
        measured.frames["omega_rms_degree"], np.sqrt((off**2).mean(axis=1)), rtol=1e-6
    )
    assert measured.worst["omega_max_degree"] == pytest.approx(off.max())
    assert measured.worst["inverted_alphas"] == recompute.inverted(sampled) == 0
    assert measured.worst["inverted_centres"] == 0


def test_the_ramachandran_plot_is_that_of_mdanalysis(dry_villin):
    mda = pytest.importorskip("MDAnalysis")
    from MDAnalysis.analysis.data.filenames import Rama_ref
    from MDAnalysis.analysis.dihedrals import Ramachandran

    residues = mda.Universe(str(dry_villin)).select_atoms("protein and not resname GLY PRO")
    angles = Ramachandran(residues, check_protein=False).run().results.angles[0]
    column, row = (np.rint((angles + 180) / 4).astype(int) % 90).T
    density = np.load(Rama_ref)[row, column]
    found = ragdoll.quality(Molecule.from_file(dry_villin))
    assert found.counts["ramachandran_residues"] == len(angles) > 25
    assert found.input["ramachandran_core_percent"] == pytest.approx(100 * (density >= 17).mean())
    assert found.input["ramachandran_outlier_percent"] == pytest.approx(100 * (density < 1).mean())
    assert 0 < found.input["ramachandran_core_percent"] <= 100


def test_clashes_are_what_a_search_of_all_pairs_finds(ubiquitin):
    radii = {6: 1.70, 7: 1.55, 8: 1.52, 16: 1.80}
    heavy = np.flatnonzero(ubiquitin.elements > 1)
    own = ubiquitin.elements[heavy]
    near = np.eye(len(ubiquitin), dtype=bool)
    bonded = np.zeros_like(near)
    bonded[ubiquitin.bonds[:, 0], ubiquitin.bonds[:, 1]] = True
    bonded |= bonded.T
    for _ in range(4):
        near |= near @ bonded
    x = 10 * ubiquitin.positions[heavy]
    distances = np.linalg.norm(x[:, None] - x[None], axis=-1)
    radius = np.array([radii[e] for e in own])
    overlap = radius[:, None] + radius[None] - distances
    polar = np.isin(own, (7, 8))
    clash = overlap >= np.where(polar[:, None] & polar[None], 0.8, 0.4)
    clash &= ~near[np.ix_(heavy, heavy)] & ~((own == 16)[:, None] & (own == 16)[None])
    found = ragdoll.quality(ubiquitin)
    count = clash.sum() / 2
    assert count > 0
    assert found.input["clashes_per_1000"] == pytest.approx(1000 * count / len(heavy))


def test_frames_of_molecular_dynamics_have_the_published_quality(proteins):
    # bond and angle RMSZ 1.37 and 1.62, omega 8.9 degrees and 0.2 %, clashes 0.1, map 90.5 and 1.5
    mda = pytest.importorskip("MDAnalysis")
    universe = mda.Universe(str(proteins / "p38.pdb"), str(proteins / "p38_md_100frames.dcd"))
    frames = np.array([step.positions.copy() for step in universe.trajectory]) / 10
    found = ragdoll.quality(Molecule.from_file(proteins / "p38.pdb"), frames)
    assert len(found) == 100
    mean = found.mean
    assert mean["bond_rmsz"] == pytest.approx(1.37, abs=0.01)
    assert mean["angle_rmsz"] == pytest.approx(1.62, abs=0.01)
    assert mean["omega_rms_degree"] == pytest.approx(8.9, abs=0.05)
    assert mean["omega_over_30_percent"] == pytest.approx(0.2, abs=0.05)
    assert mean["clashes_per_1000"] == pytest.approx(0.1, abs=0.05)
    assert mean["ramachandran_core_percent"] == pytest.approx(90.5, abs=0.1)
    assert mean["ramachandran_outlier_percent"] == pytest.approx(1.5, abs=0.1)


@pytest.mark.parametrize(
    ("name", "bonds", "angles"), [("1ubq", 1.01, 1.23), ("1crn", 1.01, 1.07), ("4ake", 0.44, 0.76)]
)
def test_crystals_are_near_ideal_values(name, bonds, angles, proteins):
    found = ragdoll.quality(Molecule.from_file(proteins / f"{name}.pdb"))
    assert found.input["bond_rmsz"] == pytest.approx(bonds, abs=0.01)
    assert found.input["angle_rmsz"] == pytest.approx(angles, abs=0.01)
    assert found.input["all_atom_clashscore"] is None  # it has no hydrogens
    assert found.mean["bond_rms_angstrom"] == 0


def test_a_mirror_image_has_every_centre_inverted(ubiquitin):
    found = ragdoll.quality(ubiquitin, ubiquitin.positions * [1, 1, -1])
    assert found.worst["inverted_alphas"] > 60
    assert found.worst["inverted_centres"] == found.counts["centres"]
    assert found.mean["bond_rms_angstrom"] == pytest.approx(0, abs=1e-9)


def test_a_molecule_is_measured_in_any_unit_and_one_frame_or_many(ubiquitin):
    one = ragdoll.quality(ubiquitin, ubiquitin.positions)
    other = ragdoll.quality(ubiquitin, np.stack([10 * ubiquitin.positions] * 2) * unit.angstrom)
    assert (len(one), len(other)) == (1, 2)
    assert other.worst["bond_max_angstrom"] == pytest.approx(0, abs=1e-9)
    assert one.input == other.input


def test_a_nucleic_acid_has_what_applies_and_none_for_the_rest(proteins):
    found = ragdoll.quality(Molecule.from_file(proteins / "1bna.pdb"))
    assert found.input["ramachandran_core_percent"] is None
    assert found.input["omega_rms_degree"] is None
    assert found.input["bond_rmsz"] is None
    assert found.input["inverted_centres"] == 0
    assert found.counts["centres"] > 60
    assert found.worst_frame["omega_rms_degree"] is None
    json.dumps(found.as_dict(), allow_nan=False)


def test_upper_bounds_are_told_by_kind(ubiquitin):
    framework = {
        "tethers": np.array([[0, 5], [0, 9], [3, 20]]),
        "tether_lengths": np.array([0.05, 5.0, 0.1]),
        "tether_kinds": np.array([1, 3, 1]),
    }
    found = ragdoll.quality(ubiquitin, framework=framework)
    assert found.counts["bounds"] == {"hydrogen_bond": 2, "hydrophobic": 1}
    lengths = _lengths(ubiquitin.positions, framework["tethers"]) - framework["tether_lengths"]
    assert found.input["excess_hydrogen_bond_angstrom"] == pytest.approx(10 * lengths[[0, 2]].max())
    assert found.input["excess_hydrophobic_angstrom"] == 0
    assert found.input["excess_angstrom"] == found.input["excess_hydrogen_bond_angstrom"]


def test_what_cannot_be_measured_is_said(ubiquitin, tmp_path):
    with pytest.raises(InputError, match="atoms but the positions have the shape"):
        ragdoll.quality(ubiquitin, ubiquitin.positions[:-1])
    broken = ubiquitin.positions.copy()
    broken[3] = np.nan
    with pytest.raises(InputError, match="not finite"):
        ragdoll.quality(ubiquitin, broken)


def test_a_file_of_mdtraj_is_measured_against_its_first_frame(sampled_villin, measured, tmp_path):
    mdtraj = pytest.importorskip("mdtraj")
    mdtraj.load(str(sampled_villin.path)).save(str(tmp_path / "other.h5"))
    found = ragdoll.quality(tmp_path / "other.h5")
    assert len(found) == 20
    assert found.frames["bond_rms_angstrom"][0] == 0
    np.testing.assert_allclose(
        found.frames["omega_rms_degree"], measured.frames["omega_rms_degree"], rtol=1e-5
    )


# -------------------------------------------------------------------------------- the command line


def test_the_command_tells_what_the_function_finds(run_many, sampled_villin, measured, dry_villin):
    told, table, alone, missing = run_many(
        [
            ["quality", sampled_villin.path, "--json"],
            ["quality", sampled_villin.path],
            ["quality", dry_villin, "--json"],
            ["quality", "there_is_none.h5"],
        ]
    )
    assert (told.code, told.stderr) == (0, "")
    assert told.json == measured.as_dict()
    assert told.json["frames"] == 20
    assert "Ramachandran outliers" in table.stdout
    assert alone.json["frames"] == 1
    assert missing.code == 2
    assert "there_is_none.h5" in missing.sentence


# ------------------------------------------------------------------------------ limits of sampling

_CLASHES = {"max_clash_growth": 5.0}


def _sampled(dry_villin, path, **values):
    limits = ragdoll.QualityLimits(
        **{name.removeprefix("max_"): value for name, value in _CLASHES.items()}
    )
    # without contacts frames have clashes, some more and some less
    options = ragdoll.SampleOptions(
        frames=12,
        seed=3,
        stride=5,
        perturbation="gaussian",
        limits=limits,
        contacts=False,
        constraints=None,
        **values,
    )
    return ragdoll.sample(Molecule.from_file(dry_villin), path, options)


def test_frames_below_a_limit_are_counted_and_not_written(dry_villin, tmp_path):
    allowed = _sampled(dry_villin, tmp_path / "all.h5", allow_low_quality=True)
    kept = _sampled(dry_villin, tmp_path / "kept.h5")
    own = allowed.quality["input"]["clashes_per_1000"]
    low = ragdoll.quality(tmp_path / "all.h5").frames["clashes_per_1000"] > own + 5 + 1e-9
    assert low.any()
    assert not allowed.low_frames
    assert kept.low_frames["clashes"] >= low.sum()
    assert kept.frames == 12
    assert kept.quality["worst"]["clashes_per_1000"] <= own + 5 + 1e-9
    # the walk is the same, so that the frames that both have are
    with (
        ragdoll.open_trajectory(tmp_path / "all.h5") as one,
        ragdoll.open_trajectory(tmp_path / "kept.h5") as other,
    ):
        for step, frame in zip(one.step[~low], one.positions[~low], strict=True):
            place = np.flatnonzero(other.step == step)
            np.testing.assert_array_equal(other.positions[place[0]], frame)
    assert "clashes" in kept.last_fault


def test_replicas_leave_out_the_frames_that_single_runs_do(dry_villin, tmp_path):
    single = _sampled(dry_villin, tmp_path / "single.h5")
    replicas = _sampled(dry_villin, tmp_path / "replicas.h5", replicas=2)
    assert replicas.replicas[0].low_frames == sum(single.low_frames.values()) > 0
    with (
        ragdoll.open_trajectory(tmp_path / "single.h5") as one,
        ragdoll.open_trajectory(tmp_path / "replicas.h5") as both,
    ):
        first = both.observables["replica"] == 0
        np.testing.assert_array_equal(both.positions[first], one.positions)


def test_a_run_that_cannot_keep_its_quality_says_so(run_many, dry_villin, tmp_path):
    flags = ["sample", dry_villin, "--frames", 2, "--stride", 1, "--perturbation", "gaussian"]
    flags += ["--solver", "ordered", "--json"]
    low, table, allowed, refused = run_many(
        [
            [*flags, "-o", tmp_path / "low.h5", "--max-angle-rms-degree", "0.01"],
            [*flags[:-1], "-o", tmp_path / "t.h5", "--max-bond-rms-angstrom", "0.0001"],
            [
                *flags,
                "-o",
                tmp_path / "allowed.h5",
                "--max-angle-rms-degree",
                "0.01",
                "--allow-low-quality",
            ],
            [*flags, "-o", tmp_path / "none.h5", "--max-clash-growth", "-1"],
        ]
    )
    assert low.code == 3
    assert "0 of 2 frames were written: others had low quality (20 by angle rms" in low.sentence
    assert "--allow-low-quality" in low.sentence
    assert low.json["low_frames"] == {"angle_rms": 20}
    assert low.json["quality"] == {}
    assert table.code == 3
    assert "frames of low quality" in table.stdout
    assert (allowed.code, allowed.json["frames"]) == (0, 2)
    assert allowed.json["quality"]["frames"] == 2
    assert refused.code == 2
    assert "--max-clash-growth" in refused.sentence


def test_every_limit_is_judged(dry_villin, tmp_path):
    molecule = Molecule.from_file(dry_villin)
    _sampled(dry_villin, tmp_path / "all.h5", allow_low_quality=True)
    with ragdoll.open_trajectory(tmp_path / "all.h5") as trajectory:
        frame = trajectory.positions[-1].astype(float)
    tethers = {"tethers": np.array([[0, 9]]), "tether_lengths": np.array([0.1])}
    terms = molecule_terms(molecule, tethers)
    none = dict.fromkeys(vars(ragdoll.QualityLimits()))
    assert ragdoll.QualityLimits(**none).judge(terms).fault(frame) == ("", "")
    mirrored = frame * [-1, 1, 1]
    noisy = frame + np.random.default_rng(1).normal(0, 0.1, frame.shape)
    for limit, measure, x in (
        ("bond_rms_angstrom", "bond_rms", frame),
        ("angle_rms_degree", "angle_rms", frame),
        ("clash_growth", "clashes", noisy),
        ("inverted_centres", "inverted_centres", mirrored),
        ("outlier_growth_percent", "ramachandran_outliers", mirrored),
        ("core_loss_percent", "ramachandran_core", mirrored),
        ("omega_growth_percent", "omega", noisy),
        ("excess_angstrom", "bounds", frame),
    ):
        found, words = ragdoll.QualityLimits(**{**none, limit: 0}).judge(terms).fault(x)
        assert found == measure
        assert words.endswith("at most 0")
