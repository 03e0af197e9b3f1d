"""Thermal modes, which ``ragdoll sample`` moves proteins by when nothing else is asked for."""

import numpy as np
import pytest

import ragdoll
from ragdoll import thermal_network

h5py = pytest.importorskip("h5py")


@pytest.fixture(scope="module")
def molecule(villin):
    return ragdoll.Molecule.from_file(villin)


@pytest.fixture(scope="module")
def framework(molecule):
    return ragdoll.build_framework(molecule)


@pytest.fixture(scope="module")
def moves(molecule, framework):
    return thermal_network.fluctuations(molecule, framework, count=40)


@pytest.fixture(scope="module")
def sampled(run_ragdoll, villin, tmp_path_factory):
    """Villin with nothing but a seed: the file and the report."""
    path = tmp_path_factory.mktemp("thermal") / "villin.h5"
    run = run_ragdoll("sample", villin, "-o", path, "--seed", 2, "--json")
    assert run.code == 0, run.stderr
    return path, run.json


def _strain(pairs, moves, positions):
    """How pairs' distances deviate, to first order, nm."""
    lines = positions[pairs[:, 1]] - positions[pairs[:, 0]]
    lines /= np.linalg.norm(lines, axis=1)[:, None]
    changes = ((moves[:, pairs[:, 1]] - moves[:, pairs[:, 0]]) * lines).sum(axis=2)
    return np.sqrt((changes**2).sum(axis=0))


def test_modes_are_softest_first_and_deform_bars_much_less_than_they_move_atoms(
    molecule, framework, moves
):
    assert moves.shape == (40, len(molecule), 3)
    heavy = np.asarray(molecule.elements) > 1
    sizes = np.sqrt((moves[:, heavy] ** 2).sum(axis=(1, 2)))
    assert (np.diff(sizes) <= 1e-9).all()
    assert sizes[0] > 1.5 * sizes[-1]
    deviations = np.sqrt((moves**2).sum(axis=(0, 2)))
    bars = np.asarray(framework.bars)
    strain = _strain(bars, moves, molecule.positions)
    assert np.sqrt((strain[heavy[bars].all(axis=1)] ** 2).mean()) < 0.05 * deviations[heavy].mean()
    # hydrogens go along
    assert np.sqrt((strain**2).mean()) < 0.1 * deviations.mean()


def test_deviations_grow_with_the_square_root_of_the_temperature(molecule, framework, moves):
    cold = thermal_network.fluctuations(molecule, framework, count=40, temperature_kelvin=3.0)
    # widest modes are held at high temperature
    ratio = np.linalg.norm(moves[-1]) / np.linalg.norm(cold[-1])
    assert ratio == pytest.approx(10, rel=0.05)


def test_torsions_change_as_differences_say():
    random = np.random.default_rng(3)
    places = random.normal(size=(4, 3))
    bonds = np.array([(0, 1), (1, 2), (2, 3)])
    row = thermal_network._turns(places, np.arange(4), bonds, np.ones(4, bool)).toarray()[0]

    def torsion(flat):
        a, b, c = np.diff(flat.reshape(4, 3), axis=0)
        one, other = np.cross(a, b), np.cross(b, c)
        return np.arctan2(np.cross(one, other) @ b / np.linalg.norm(b), one @ other)

    steps = 1e-6 * np.eye(12)
    flat = places.ravel()
    numbers = [(torsion(flat + step) - torsion(flat - step)) / 2e-6 for step in steps]
    np.testing.assert_allclose(row, numbers, atol=1e-6)


def test_fixed_atoms_are_in_no_mode(molecule):
    user = (ragdoll.UserConstraint("fix", "resid 5"),)
    held = ragdoll.build_framework(molecule, constraints=ragdoll.ConstraintOptions(user=user))
    fixed = np.asarray(held.fixed) != 0
    assert fixed.any()
    moves = thermal_network.fluctuations(molecule, held, count=20)
    deviations = np.sqrt((moves**2).sum(axis=(0, 2)))
    heavy = np.asarray(molecule.elements) > 1
    assert deviations[fixed & heavy].max() < 0.05 * deviations[~fixed].mean()


def test_residues_of_large_structures_are_rigid(molecule, framework, monkeypatch):
    monkeypatch.setattr(thermal_network, "_MOST_ATOMS", 100)
    moves = thermal_network.fluctuations(molecule, framework, count=20)
    heavy = [
        [atom.index for atom in residue.atoms() if atom.element.atomic_number > 1]
        for residue in molecule.topology.residues()
    ]
    pairs = np.array([(a, b) for atoms in heavy for a in atoms for b in atoms if a < b])
    strain = _strain(pairs, moves, molecule.positions)
    assert strain.max() < 0.05 * np.sqrt((moves**2).sum(axis=(0, 2))).mean()


def test_nothing_but_a_seed_gives_thermal_motion_of_good_geometry(sampled):
    path, report = sampled
    parameters = report["parameters"]
    assert parameters["perturbation"] == "thermal"
    assert parameters["stride"] == 1
    assert report["solver"] == "newton"
    assert report["frames"] == 20
    geometry = report["geometry"]
    assert geometry["bond_rms_angstrom"] <= 0.004
    assert geometry["angle_rms_degree"] <= 0.6
    assert geometry["tolerance_violations"] == geometry["contact_violations"] == 0
    assert all(excess == 0 for excess in geometry["tether_excess_angstrom"].values())
    assert 0.3 < geometry["rmsd_max_angstrom"] < 3


def test_each_frame_is_another_conformer(sampled, molecule):
    path, _ = sampled
    alphas = [atom.index for atom in molecule.topology.atoms() if atom.name == "CA"]
    with h5py.File(path) as file:
        frames = file["coordinates"][:].astype(float)[:, alphas]
    frames = [molecule.positions[alphas], *frames]
    for one, other in zip(frames, frames[1:], strict=False):
        assert ragdoll._core.superposed_rmsd(np.ascontiguousarray(one), other) > 0.01


def test_a_hotter_ensemble_is_wider(molecule, tmp_path):
    spread = []
    for kelvin in (30.0, 600.0):
        motion = ragdoll.MotionOptions(temperature_kelvin=kelvin)
        options = ragdoll.SampleOptions(frames=6, seed=1, motion=motion)
        report = ragdoll.sample(molecule, tmp_path / f"{kelvin}.h5", options)
        spread.append(report.geometry["rmsd_max_angstrom"])
    assert spread[1] > 2 * spread[0]


def test_small_molecules_move_at_random_and_the_report_says_so(tmp_path):
    from rdkit import Chem
    from rdkit.Chem import AllChem

    heptanol = Chem.AddHs(Chem.MolFromSmiles("CCCCCCCO"))
    AllChem.EmbedMolecule(heptanol, randomSeed=1)
    molecule = ragdoll.Molecule.from_rdkit(heptanol)
    report = ragdoll.sample(molecule, tmp_path / "a.h5", ragdoll.SampleOptions(frames=2))
    assert report.parameters["perturbation"] == "gaussian"
    assert report.parameters["stride"] == 10
    assert any("Fewer than 10 residues" in note for note in report.notes)
    asked = ragdoll.SampleOptions(frames=1, perturbation="thermal")
    assert ragdoll.sample(molecule, tmp_path / "b.h5", asked).frames == 1


def test_a_platform_asks_for_random_moves(molecule):
    options, notes = ragdoll.SampleOptions(platform="CPU").settled(molecule)
    assert (options.perturbation, options.stride, notes) == ("gaussian", 10, [])
    assert not options.by_walkers
