"""What holds a framework beside covalent bonds: found, kept, told and refused."""

import dataclasses
import json

import numpy as np
import pytest
from openmm import app, unit
from ragdoll._core import worst_violation
from rdkit import Chem
from rdkit.Chem import AllChem

import ragdoll
from ragdoll import (
    ConstraintOptions,
    InputError,
    Molecule,
    SampleOptions,
    UserConstraint,
    build_framework,
)

h5py = pytest.importorskip("h5py")


def molecule_of(smiles, seed=7):
    mol = Chem.AddHs(Chem.MolFromSmiles(smiles))
    AllChem.EmbedMolecule(mol, randomSeed=seed)
    return Molecule.from_rdkit(mol)


def held(molecule, **options):
    return build_framework(molecule, constraints=ConstraintOptions(**options))


@pytest.fixture(scope="module")
def adenylate_kinase(proteins):
    return Molecule.from_file(proteins / "4ake_a_withH.pdb")


@pytest.fixture(scope="module")
def ubiquitin(proteins):
    return Molecule.from_file(proteins / "1ubq.pdb")


def test_a_protein_has_the_hydrogen_bonds_and_tethers_that_rigidity_finds(adenylate_kinase):
    framework = held(adenylate_kinase)
    found = ragdoll.rigidity(adenylate_kinase)
    assert framework.hydrogen_bonds.tolist() == found.bonds.hbonds.tolist()
    assert np.allclose(framework.hydrogen_bond_energies / 4.184, found.bonds.hbond_kcal)
    counts = framework.constraint_counts()
    assert counts["tethers"]["hydrophobic"] == len(found.bonds.tethers)
    assert counts["hydrogen_bonds"] == len(found.bonds.hbonds) > 150
    assert counts["tethers"]["backbone"] + counts["contacts"]["backbone"] > 800
    assert counts["contacts"]["side chain"] > 300


@pytest.mark.parametrize(
    "name", ["4ake_a_withH.pdb", "1ubq.pdb", "1crn.pdb", "1bna.pdb", "1hvr.pdb", "5pti.cif.gz"]
)
def test_no_bound_is_tighter_than_the_input(name, proteins):
    molecule = Molecule.from_file(proteins / name)
    relative, worst = worst_violation(held(molecule), molecule.positions)
    assert relative == 0, worst


@pytest.mark.parametrize("name", ["1d3z.pdb", "4ake_a_withH.pdb", "1vii.pdb", "1bck_withH.pdb"])
def test_without_its_hydrogens_a_molecule_has_the_same_hydrogen_bonds(name, proteins):
    whole = Molecule.from_file(proteins / name)
    modeller = app.Modeller(whole.topology, whole.positions * unit.nanometer)
    modeller.delete([a for a in whole.topology.atoms() if a.element.symbol == "H"])
    bare = Molecule.from_topology(modeller.topology, modeller.positions)

    def pairs(molecule):
        atoms = held(molecule).hydrogen_bonds[:, [0, 2]]
        return {tuple(molecule.labels[i] for i in pair) for pair in atoms.tolist()}

    without, with_hydrogens = pairs(bare), pairs(whole)
    assert len(without & with_hydrogens) >= 0.95 * len(with_hydrogens)
    assert len(without) <= 1.1 * len(with_hydrogens)
    assert (held(bare).hydrogen_bonds[:, 1] == -1).all()


def test_hydrogens_that_are_added_lie_where_their_bonds_are_flat(ubiquitin, proteins):
    pytest.importorskip("pdbfixer")
    whole = Molecule.from_file(proteins / "1ubq.pdb", add_hydrogens=True)
    assert len(held(whole).hydrogen_bonds) >= 0.95 * len(held(ubiquitin).hydrogen_bonds)
    atoms = {(a.residue.index, a.name): a.index for a in whole.topology.atoms()}
    for residue in range(1, 18):
        x = whole.positions[[atoms[residue, name] for name in ("N", "CA", "H")]]
        before = whole.positions[atoms[residue - 1, "C"]]
        around = np.array([before, x[1], x[2]]) - x[0]
        unit_vectors = around / np.linalg.norm(around, axis=1, keepdims=True)
        angles = [unit_vectors[i] @ unit_vectors[j] for i, j in ((0, 1), (0, 2), (1, 2))]
        assert np.degrees(np.arccos(angles)).sum() == pytest.approx(360, abs=2)


def test_disulfides_are_bars(proteins):
    molecule = Molecule.from_file(proteins / "1crn.pdb")
    framework = held(molecule)
    sulfur = molecule.elements == 16
    bonds = framework.bars[framework.bar_kinds == 0]
    assert sulfur[bonds].all(axis=1).sum() == 3


def test_calcium_is_held_by_what_coordinates_it(proteins):
    molecule = Molecule.from_file(proteins / "1cll.pdb", keep_solvent=True)
    framework = held(molecule)
    metal = framework.bars[framework.bar_kinds == 3]
    calcium = [i for i in range(len(molecule)) if molecule.elements[i] == 20]
    assert len(calcium) == 4
    for ion in calcium:
        donors = metal[(metal == ion).any(axis=1)]
        assert 5 <= len(donors) <= 7
        others = donors[donors != ion]
        assert set(molecule.elements[others]) == {8}
        assert all("HOH" not in molecule.labels[i] for i in others)
    # no bar joins two donors, unless their own molecule does
    assert not (framework.bar_kinds[(framework.bars == calcium[0]).any(axis=1)] == 1).any()


def test_stacked_bases_are_held(proteins):
    counts = held(Molecule.from_file(proteins / "1bna.pdb")).constraint_counts()
    assert counts["tethers"]["stacking"] >= 3 * 20
    assert counts["hydrogen_bonds"] >= 25  # 12 base pairs of two or three
    none = held(Molecule.from_file(proteins / "1bna.pdb"), stacking=False)
    assert none.constraint_counts()["tethers"]["stacking"] == 0


def test_a_chain_of_unknown_residues_has_backbone_bonds(proteins, tmp_path):
    lines = [
        line[:17] + "UNK" + line[20:]
        for line in (proteins / "1ubq.pdb").read_text().splitlines()
        if line.startswith("ATOM") and line[12:16].strip() in ("N", "CA", "C", "O", "CB")
    ]
    path = tmp_path / "unk.pdb"
    path.write_text("\n".join(lines) + "\nEND\n")
    counts = held(Molecule.from_file(path)).constraint_counts()
    assert counts["hydrogen_bonds"] > 30
    assert counts["contacts"]["backbone"] > 200


def test_ten_thousand_waters_are_held_by_nothing(tmp_path):
    grid = np.stack(np.meshgrid(*[np.arange(22) * 3.1] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    shape = np.array([[0, 0, 0], [0.96, 0, 0], [-0.24, 0.93, 0]])
    lines = []
    for k, place in enumerate(grid[:10_000]):
        for name, (x, y, z) in zip(("O", "H1", "H2"), place + shape, strict=True):
            lines.append(
                f"HETATM{len(lines) % 100000:5d}  {name:<3} HOH A{k % 10000:4d}    "
                f"{x:8.3f}{y:8.3f}{z:8.3f}  1.00  0.00           {name[0]}"
            )
    path = tmp_path / "waters.pdb"
    path.write_text("\n".join(lines) + "\nEND\n")
    molecule = Molecule.from_file(path, keep_solvent=True)
    counts = held(molecule).constraint_counts()
    assert len(molecule) == 30_000
    assert sum(counts["tethers"].values()) == counts["hydrogen_bonds"] == 0


def test_alpha_carbons_alone_are_refused_in_one_sentence(run_ragdoll, proteins, tmp_path):
    run = run_ragdoll("sample", proteins / "hivp_ca.pdb", "-o", tmp_path / "x.h5")
    assert run.code == 2
    assert "only the CA atom" in run.sentence


def test_a_plain_framework_has_no_tethers(ubiquitin):
    counts = build_framework(ubiquitin).constraint_counts()
    assert not any(counts["tethers"].values()) and not any(counts["contacts"].values())


def test_none_leaves_what_the_user_sets(ubiquitin):
    user = (UserConstraint("tether", "resid 1 and name CA", "resid 70 and name CA", 50.0),)
    framework = build_framework(ubiquitin, constraints=ConstraintOptions.none(user))
    counts = framework.constraint_counts()
    assert counts["tethers"] == {**dict.fromkeys(counts["tethers"], 0), "user": 1}
    assert framework.tether_lengths.tolist() == [5.0]
    assert framework.hydrogen_bonds.shape == (0, 3)


# === Sampling keeps them


@pytest.fixture(scope="module")
def sampled(run_ragdoll, proteins, tmp_path_factory):
    """20 frames of ubiquitin with hydrogens."""
    path = tmp_path_factory.mktemp("held") / "ubiquitin.h5"
    arguments = ["--frames", 20, "--stride", 5, "--replicas", 2, "--seed", 4, "--json"]
    run = run_ragdoll("sample", proteins / "1d3z.pdb", "-o", path, *arguments)
    assert run.code == 0, run.stderr
    return path, run.json


def test_sampled_frames_never_exceed_a_bound(sampled):
    path, report = sampled
    excess = report["geometry"]["tether_excess_angstrom"]
    assert excess["hydrogen bond"] <= 0 and excess["hydrophobic"] <= 0
    assert max(report["geometry"]["contact_excess_angstrom"].values()) <= 0
    assert report["geometry"]["tolerance_violations"] == 0
    with h5py.File(path) as file:
        frames = file["coordinates"][:].astype(float)
        framework = file["ragdoll/framework"]
        for name, side in (("tethers", 1), ("contacts", -1)):
            pairs = framework[name][:]
            lengths = framework[name[:-1] + "_lengths"][:]
            d = np.linalg.norm(frames[:, pairs[:, 0]] - frames[:, pairs[:, 1]], axis=2)
            assert (side * (d - lengths)).max() <= 0, name
    assert report["frames"] == 40


def test_held_hydrogen_bonds_are_found_again_in_every_frame(sampled, proteins):
    path, _ = sampled
    molecule = Molecule.from_file(proteins / "1d3z.pdb")
    with ragdoll.open_trajectory(path) as trajectory:
        bonds = {tuple(atoms) for atoms in trajectory.framework["hydrogen_bonds"].tolist()}
        for frame in list(trajectory)[::4]:
            moved = dataclasses.replace(molecule, positions=frame.positions.astype(float))
            # by the same distances and angles; energies rise and fall
            found = ragdoll.rigidity(moved, hbond_cutoff_kcal=0.0).bonds.hbonds
            assert bonds <= {tuple(atoms) for atoms in found.tolist()}


def test_the_file_tells_what_was_held(sampled):
    path, report = sampled
    with h5py.File(path) as file:
        framework = file["ragdoll/framework"]
        kinds = np.bincount(framework["tether_kinds"][:], minlength=6)
        assert len(framework["contact_kinds"]) == len(framework["contacts"])
        bonds = framework["hydrogen_bonds"][:]
        assert bonds.shape == (report["constraints"]["hydrogen_bonds"], 3)
        assert (np.diff(framework["hydrogen_bond_energies"][:]) >= 0).all()
        assert len(framework["salt_bridges"]) == len(bonds)
        parameters = json.loads(file["ragdoll/parameters"][()])
    names = ["user", "hydrogen bond", "salt bridge", "hydrophobic", "stacking", "backbone"]
    assert report["constraints"]["tethers"] == dict(zip(names, kinds.tolist(), strict=True))
    assert parameters["constraints"]["hbond_cutoff_kcal"] == -1.0
    assert parameters["constraints"]["torsion_basins"] is True


def test_sampled_residues_stay_on_the_map_of_phi_and_psi(sampled, proteins):
    dihedrals = pytest.importorskip("MDAnalysis.analysis.data.filenames")
    counts = np.load(dihedrals.Rama_ref)  # [psi, phi] from -180 by 4 degrees
    path, _ = sampled
    with ragdoll.open_trajectory(path) as trajectory:
        residues = list(trajectory.topology.residues())
        frames = np.array([frame.positions for frame in trajectory])
    where = {(a.residue.index, a.name): a.index for r in residues for a in r.atoms()}
    rows = [
        [where[k, "C"], where[k + 1, "N"], where[k + 1, "CA"], where[k + 1, "C"], where[k + 2, "N"]]
        for k in range(len(residues) - 2)
        if residues[k + 1].name not in ("GLY", "PRO")
    ]
    x = frames[:, np.array(rows)]

    def torsion(first):
        b = np.diff(x[:, :, first : first + 4], axis=2)
        n = np.cross(b[:, :, 1], b[:, :, 2])
        along = np.linalg.norm(b[:, :, 1], axis=2) * (b[:, :, 0] * n).sum(axis=2)
        return np.degrees(np.arctan2(along, (np.cross(b[:, :, 0], b[:, :, 1]) * n).sum(axis=2)))

    cell = [np.rint((angle + 180) / 4).astype(int) % 90 for angle in (torsion(1), torsion(0))]
    found = counts[cell[0], cell[1]]
    assert (found >= 17).mean() >= 0.85
    assert (found < 1).mean() <= 0.02


def test_atoms_that_are_fixed_do_not_move(proteins, tmp_path):
    molecule = Molecule.from_file(proteins / "1l2y.pdb")
    fixed = (UserConstraint("fix", "resid 1:5"),)
    options = SampleOptions(
        frames=2, stride=2, replicas=1, constraints=ConstraintOptions(user=fixed)
    )
    ragdoll.sample(molecule, tmp_path / "fixed.h5", options)
    still = [a.index for a in molecule.topology.atoms() if a.residue.index < 5]
    with ragdoll.open_trajectory(tmp_path / "fixed.h5") as trajectory:
        for frame in trajectory:
            moved = np.linalg.norm(frame.positions - molecule.positions, axis=1)
            assert moved[still].max() < 1e-6 and moved.max() > 0.01


def test_the_users_tether_contact_and_bar_hold(proteins, tmp_path):
    molecule = Molecule.from_file(proteins / "1l2y.pdb")
    user = (
        UserConstraint("tether", "resid 1 and name CA", "resid 20 and name CA", 14.0),
        UserConstraint("contact", "resid 1 and name CA", "resid 20 and name CA", 6.0),
        UserConstraint("bar", "resid 2 and name CA", "resid 12 and name CA"),
    )
    options = SampleOptions(
        frames=3, stride=5, replicas=1, tolerance=0.001, constraints=ConstraintOptions(user=user)
    )
    report = ragdoll.sample(molecule, tmp_path / "user.h5", options)
    assert report.constraints["bars"]["user"] == 1
    alpha = {a.residue.id: a.index for a in molecule.topology.atoms() if a.name == "CA"}

    def distance(x, one, other):
        return float(np.linalg.norm(x[alpha[one]] - x[alpha[other]]))

    with ragdoll.open_trajectory(tmp_path / "user.h5") as trajectory:
        for frame in trajectory:
            assert 0.6 <= distance(frame.positions, "1", "20") <= 1.4
            start = distance(molecule.positions, "2", "12")
            assert distance(frame.positions, "2", "12") == pytest.approx(start, rel=1.1e-3)


def test_both_ends_of_a_path_are_within_all_bounds(proteins):
    start = Molecule.from_file(proteins / "1d3z.pdb", model=1)
    end = Molecule.from_file(proteins / "1d3z.pdb", model=7)
    constraints = ConstraintOptions()
    alone = build_framework(start, constraints=constraints)
    both = build_framework(start, constraints=constraints, conformations=[end.positions])
    for framework, most in ((both, 1e-6), (alone, np.inf)):
        pairs = framework.tethers
        d = np.linalg.norm(end.positions[pairs[:, 0]] - end.positions[pairs[:, 1]], axis=1)
        assert (d - framework.tether_lengths).max() <= most
        pairs = framework.contacts
        d = np.linalg.norm(end.positions[pairs[:, 0]] - end.positions[pairs[:, 1]], axis=1)
        assert (framework.contact_lengths - d).max() <= most
    assert 0 < len(both.hydrogen_bonds) < len(alone.hydrogen_bonds)


# === What cannot be


REFUSED = [
    (["--hbond-cutoff-kcal", "nan"], "--hbond-cutoff-kcal must be a number"),
    (["--hbond-cutoff-kcal", "strong"], "valid number"),
    (["--hbond-cutoff-kcal", "2"], "from -100 to 0, not 2"),
    (["--tether-margin-angstrom", "-1"], "--tether-margin-angstrom must be"),
    (["--eclipsed-degree", "90"], "--eclipsed-degree must be"),
    (["--torsion-region", "sea"], "not 'sea'"),
    (["--tether", "name CA; name CB"], "lacks a length"),
    (["--tether", "name CA"], "two selections and a length"),
    (["--tether", "name CA; name CB; far"], "has the length 'far'"),
    (["--tether", "name CA; name CB; -3"], "give a positive number"),
    (["--tether", "resname XYZ; name CB; 3"], "'resname XYZ' matches no atom"),
    (["--contact", "nme CA; name CB; 3"], "'nme CA' is no selection"),
    (["--bar", "index 0; index 0"], "joins an atom with itself"),
    (["--fix", ""], "lacks a selection"),
    (["--fix", "resname XYZ"], "matches no atom"),
    (["--constraints", "missing.json"], "missing.json cannot be read"),
]


def test_flags_that_make_no_sense_are_refused_in_one_sentence(run_many, dry_villin, tmp_path):
    commands = [["sample", dry_villin, "-o", tmp_path / "x.h5", *flags] for flags, _ in REFUSED]
    for run, (flags, words) in zip(run_many(commands), REFUSED, strict=True):
        assert run.code == 2, flags
        assert words in run.sentence, flags
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{", "is no JSON file"),
        ("{}", "must be a JSON list"),
        ("[3]", "entry 1, is no object"),
        ('[{"kind": "rope", "first": "all", "second": "all"}]', "entry 1, has the kind 'rope'"),
        (
            '[{"kind": "fix", "atoms": "index 1"}, {"kind": "tether", "first": "index 1"}]',
            "entry 2",
        ),
        ('[{"kind": "bar", "first": "index 1", "second": "index 2", "nm": 3}]', "has 'nm'"),
        (
            '[{"kind": "bar", "first": "index 1", "second": "index 2", "angstrom": "x"}]',
            "has the length 'x'",
        ),
        ('[{"kind": "fix", "atoms": 7}]', "needs texts"),
    ],
)
def test_entries_of_a_file_that_make_no_sense_are_named(text, words, tmp_path):
    path = tmp_path / "constraints.json"
    path.write_text(text)
    with pytest.raises(InputError, match=words) as refused:
        ragdoll.user_constraints.read_constraints(path)
    assert str(path) in str(refused.value)


def test_a_file_holds_what_flags_say(tmp_path):
    path = tmp_path / "constraints.json"
    path.write_text(
        json.dumps(
            [
                {"kind": "tether", "first": "index 1", "second": "index 8", "angstrom": 9},
                {"kind": "bar", "first": "index 1", "second": "index 9"},
                {"kind": "fix", "atoms": "index 3"},
            ]
        )
    )
    entries = ragdoll.user_constraints.read_constraints(path)
    texts = [("tether", "index 1; index 8; 9"), ("bar", "index 1; index 9"), ("fix", "index 3")]
    flags = [UserConstraint.parse(kind, text) for kind, text in texts]
    for entry, flag in zip(entries, flags, strict=True):
        assert vars(entry) | {"origin": ""} == vars(flag) | {"origin": ""}


def test_a_bond_cannot_be_given_another_length():
    user = (UserConstraint("bar", "index 0", "index 1", 3.0),)
    with pytest.raises(InputError, match="has the length that it has"):
        held(molecule_of("CCO"), user=user)


def test_the_core_says_nothing_of_its_own_in_the_reports_of_plain_molecules():
    molecule = molecule_of("CC(=O)NC")
    counts = held(molecule).constraint_counts()
    assert counts["hydrogen_bonds"] == 0
    assert counts["bars"]["user"] == counts["bars"]["metal"] == 0
