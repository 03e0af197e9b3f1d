"""Rigid clusters and dilution: against ProFlex, and what the functions promise."""

import gzip
import json
import math

import gemmi
import numpy as np
import pytest

import ragdoll
from ragdoll import InputError, Molecule, RigidityOptions

# hydrogen bonds, tethers, degrees of freedom and floppy modes of ProFlex 5.2 at each cutoff; 1BCK
# with its twelve waters, which it leaves without hydrogen bonds
PROFLEX = {
    "1dif_withH": {
        -0.1: (167, 131, 254, 248),
        -1.0: (155, 131, 261, 255),
        -2.0: (135, 131, 284, 278),
        -3.0: (113, 131, 346, 340),
    },
    "1bck_withH": {
        -0.1: (157, 121, 191, 113),
        -1.0: (141, 121, 212, 134),
        -2.0: (109, 121, 270, 192),
        -3.0: (88, 121, 313, 235),
    },
    "4ake_a_withH": {
        -1.0: (163, 132, 320, 314),
        -2.0: (130, 132, 381, 375),
        -3.0: (103, 132, 445, 439),
    },
}
# atoms of the largest cluster that have more than one bond
LARGEST = {
    ("1dif_withH", -1.0): 978,
    ("1bck_withH", -2.0): 501,
    ("4ake_a_withH", -1.0): 553,
    ("4ake_a_withH", -2.0): 133,
}


@pytest.fixture(scope="module")
def molecules(proteins):
    return {
        name: Molecule.from_file(proteins / f"{name}.pdb", keep_solvent=name == "1bck_withH")
        for name in PROFLEX
    }


@pytest.mark.parametrize("name", ["1dif_minus1", "4ake_a_minus2", "4ake_a_minus3"])
def test_proflex_own_bonds_give_its_degrees_of_freedom(name, proteins):
    path = proteins.parent / "rigidity" / f"{name}.json"
    if not path.is_file():
        pytest.skip("no bond lists; set RAGDOLL_DATA to the folder that holds rigidity/")
    given = json.loads(path.read_text())
    locked = {tuple(sorted(pair)) for pair in given["locked"]}
    bonds = given["covalent"] + given["tethers"] + given["hbonds"]
    bars = [6 if tuple(sorted(pair)) in locked else 5 for pair in given["covalent"]]
    bars += [2] * len(given["tethers"]) + [5] * len(given["hbonds"])
    found = ragdoll.network_rigidity(len(given["atoms"]), np.array(bonds) - 1, bars)
    assert found.degrees_of_freedom == given["dof"]
    assert found.floppy_modes == given["floppy"]
    largest = {"1dif_minus1": 978, "4ake_a_minus2": 133}
    if name in largest:
        assert found.largest_cluster_inner == largest[name]


@pytest.mark.parametrize("name", PROFLEX)
def test_our_own_bonds_are_within_three_percent_of_proflex(name, molecules):
    cutoffs = sorted(PROFLEX[name], reverse=True)
    levels = ragdoll.dilution(molecules[name], cutoffs_kcal=cutoffs)
    assert len(levels.bonds.tethers) == PROFLEX[name][cutoffs[0]][1]
    for index, cutoff in enumerate(cutoffs):
        hbonds, _, freedom, floppy = PROFLEX[name][cutoff]
        level = levels.at(index)
        assert levels.levels[index] == pytest.approx(hbonds, rel=0.03)
        assert level.degrees_of_freedom == pytest.approx(freedom, rel=0.03)
        assert level.floppy_modes == pytest.approx(floppy, rel=0.03)
        if (name, cutoff) in LARGEST:
            assert level.largest_cluster_inner == pytest.approx(LARGEST[name, cutoff], rel=0.03)


def test_locked_bonds_are_peptides_and_arginines_and_what_other_rings_hold_anyway(molecules):
    molecule = molecules["4ake_a_withH"]
    proflex = ragdoll.rigidity(molecule, locks=("peptide", "guanidinium"))
    assert int(proflex.bonds.locked.sum()) == 252
    more = ragdoll.rigidity(molecule)
    assert int(more.bonds.locked.sum()) > 252
    assert more.degrees_of_freedom == proflex.degrees_of_freedom
    assert np.array_equal(more.cluster_of_body, proflex.cluster_of_body)
    assert ragdoll.rigidity(molecule, locks=()).floppy_modes > more.floppy_modes


def test_a_dilution_holds_what_each_cutoff_alone_gives(molecules):
    molecule = molecules["1bck_withH"]
    levels = ragdoll.dilution(molecule)
    assert len(levels) == len(levels.bonds.hbonds) + 1
    assert np.array_equal(levels.levels, np.arange(len(levels))[::-1])
    for index in (0, 1, 20, 60, len(levels) - 2):
        alone = ragdoll.rigidity(molecule, hbond_cutoff_kcal=levels.cutoffs_kcal[index])
        level = levels.at(index)
        assert len(alone.bonds.hbonds) == levels.levels[index]
        assert level.counts() == alone.counts()
        assert np.array_equal(level.cluster_of_body, alone.cluster_of_body)
        assert np.array_equal(level.region_of_body, alone.region_of_body)
        assert np.array_equal(level.hinges, alone.hinges)
    assert math.isnan(levels.cutoffs_kcal[-1])
    clusters = [len(levels.at(k).cluster_sizes) for k in range(len(levels))]
    assert clusters[0] < clusters[-1]


def test_waters_are_bodies_without_hydrogen_bonds_unless_these_are_asked_for(molecules):
    molecule = molecules["1bck_withH"]
    alone = ragdoll.rigidity(molecule)
    assert alone.separate_bodies == 13
    assert alone.degrees_of_freedom == alone.floppy_modes + 78
    assert "Hydrogen bonds of waters were left out" in alone.notes[0]
    bound = ragdoll.rigidity(molecule, solvent_hbonds=True)
    assert bound.separate_bodies < 13
    assert len(bound.bonds.hbonds) > len(alone.bonds.hbonds)


def test_bars_and_reach_are_options(dry_villin):
    molecule = Molecule.from_file(dry_villin)
    usual = ragdoll.rigidity(molecule)
    assert ragdoll.rigidity(molecule, tether_angstrom=-1).bonds.tethers.shape == (0, 2)
    assert len(ragdoll.rigidity(molecule, tether_angstrom=1).bonds.tethers) > len(
        usual.bonds.tethers
    )
    assert len(ragdoll.rigidity(molecule, hbond_angstrom=2.0).bonds.hbonds) < len(
        usual.bonds.hbonds
    )
    straight = ragdoll.rigidity(molecule, hbond_angle_degree=160).bonds
    assert (straight.hbond_angle_degree >= 160).all()
    assert 0 < len(straight.hbonds) < len(usual.bonds.hbonds)
    looser = ragdoll.rigidity(molecule, hbond_bars=1, tether_bars=1)
    assert looser.floppy_modes > usual.floppy_modes


def test_energies_are_sorted_and_geometry_is_that_of_the_positions(dry_villin):
    molecule = Molecule.from_file(dry_villin)
    bonds = ragdoll.rigidity(molecule, hbond_cutoff_kcal=-0.5).bonds
    assert (np.diff(bonds.hbond_kcal) >= 0).all()
    assert bonds.hbond_kcal.max() <= -0.5
    x = 10 * molecule.positions
    donor, hydrogen, acceptor = bonds.hbonds.T
    assert np.linalg.norm(x[hydrogen] - x[acceptor], axis=1) == pytest.approx(bonds.hbond_angstrom)
    u, v = x[donor] - x[hydrogen], x[acceptor] - x[hydrogen]
    cosine = (u * v).sum(axis=1) / np.linalg.norm(u, axis=1) / np.linalg.norm(v, axis=1)
    assert np.degrees(np.arccos(cosine)) == pytest.approx(bonds.hbond_angle_degree, abs=1e-6)
    assert (molecule.elements[hydrogen] == 1).all()
    a, b = bonds.tethers.T
    assert np.linalg.norm(x[a] - x[b], axis=1) == pytest.approx(bonds.tether_angstrom)


def test_hinge_groups_cover_all_hinges_once(dry_villin):
    found = ragdoll.rigidity(Molecule.from_file(dry_villin), tether_angstrom=-1)
    hinges = np.concatenate([group for _, group in found.hinge_groups])
    assert sorted(hinges) == found.hinges.tolist()
    assert sum(freedoms for freedoms, _ in found.hinge_groups) == found.floppy_modes


def test_networks_that_make_no_sense_are_refused():
    with pytest.raises(InputError, match="^Bond 1 of the network names a body that there is not"):
        ragdoll.network_rigidity(2, [[0, 1], [1, 2]], [5, 5])
    with pytest.raises(InputError, match="7 bars"):
        ragdoll.network_rigidity(2, [[0, 1]], [7])


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("hbond_cutoff_kcal", math.nan),
        ("hbond_cutoff_kcal", 0.5),
        ("hbond_angstrom", -1.0),
        ("hbond_angle_degree", 200.0),
        ("tether_angstrom", math.inf),
        ("hbond_bars", 0),
        ("tether_bars", 7),
        ("locks", ("everything",)),
    ],
)
def test_options_out_of_range_are_refused_by_name(name, value):
    with pytest.raises(InputError, match=name.removesuffix("s")):
        RigidityOptions(**{name: value}).check()


def test_cutoffs_of_a_dilution_must_be_numbers(dry_villin):
    molecule = Molecule.from_file(dry_villin)
    with pytest.raises(InputError, match="numbers"):
        ragdoll.dilution(molecule, RigidityOptions(), cutoffs_kcal=[-0.5])
    with pytest.raises(InputError, match="number"):
        ragdoll.dilution(molecule, cutoffs_kcal=[math.nan])


def _without_hydrogens(source, target):
    lines = source.read_text().splitlines()
    lines = [line for line in lines if not line[12:16].strip().lstrip("0123456789").startswith("H")]
    target.write_text("\n".join(lines) + "\n")


# -------------------------------------------------------------------------------- the command line


def test_the_command_tells_what_the_function_finds(run_ragdoll, dry_villin):
    run = run_ragdoll("rigidity", dry_villin, "--json")
    assert (run.code, run.stderr) == (0, "")
    found = ragdoll.rigidity(Molecule.from_file(dry_villin))
    assert run.json == json.loads(json.dumps(found.as_dict()))
    told = run.json
    assert told["atoms"] == 582
    assert told["hydrogen_bonds"] == len(told["hydrogen_bond_list"]) > 10
    assert told["tethers"] == len(told["tether_list"]) > 5
    assert told["hinges"] == len(told["hinge_list"])
    assert sum(told["rigid_clusters"]) == 582
    assert told["largest_cluster"] == told["rigid_clusters"][0]
    assert max(told["cluster_of_atom"]) == len(told["rigid_clusters"]) - 1
    assert told["parameters"]["hbond_cutoff_kcal"] == -1
    assert (
        told["hydrogen_bond_list"][0]["energy_kcal"] < told["hydrogen_bond_list"][-1]["energy_kcal"]
    )


def test_the_command_prints_a_table(run_many, dry_villin):
    plain, diluted, quiet = run_many(
        [
            ["rigidity", dry_villin],
            ["rigidity", dry_villin, "--dilution"],
            ["rigidity", dry_villin, "--quiet"],
        ]
    )
    assert "floppy modes" in plain.stdout
    assert "none" in diluted.stdout
    assert (quiet.stdout, quiet.stderr) == ("", "")


def test_a_dilution_has_an_entry_for_each_cutoff(run_ragdoll, dry_villin, tmp_path):
    picture = tmp_path / "dilution.png"
    run = run_ragdoll("rigidity", dry_villin, "--dilution", "--json", "-o", picture)
    assert run.code == 0
    entries = run.json["dilution"]
    assert len(entries) == run.json["hydrogen_bonds"] + 1
    assert entries[0]["hydrogen_bonds"] == run.json["hydrogen_bonds"]
    assert entries[-1]["hbond_cutoff_kcal"] is None
    cutoffs = [entry["hbond_cutoff_kcal"] for entry in entries[:-1]]
    assert cutoffs == sorted(cutoffs, reverse=True)
    modes = [entry["floppy_modes"] for entry in entries]
    assert modes == sorted(modes)
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_clusters_become_files_for_viewers(run_ragdoll, dry_villin, tmp_path):
    outputs = [tmp_path / f"clusters.{kind}" for kind in ("pml", "cif", "png")]
    flags = [word for path in outputs for word in ("-o", path)]
    run = run_ragdoll("rigidity", dry_villin, "--json", *flags)
    assert run.code == 0, run.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(p.name for p in outputs)
    clusters = run.json["cluster_of_atom"]

    script = outputs[0].read_text()
    assert f"load {dry_villin.resolve()}, ragdoll" in script
    assert "color cluster_1_colour, cluster_1" in script
    assert script.count("distance hydrogen_bonds") == run.json["hydrogen_bonds"]

    document = gemmi.cif.read(str(outputs[1]))
    column = document[0].find_values("_atom_site.ragdoll_cluster")
    assert [int(value) - 1 for value in column] == clusters
    structure = gemmi.make_structure_from_block(document[0])
    factors = [atom.b_iso - 1 for chain in structure[0] for res in chain for atom in res]
    assert factors == clusters
    assert Molecule.from_file(outputs[1]).elements.tolist() == (
        Molecule.from_file(dry_villin).elements.tolist()
    )

    from matplotlib import image

    pixels = image.imread(outputs[2])
    assert len(np.unique(pixels.reshape(-1, pixels.shape[2]), axis=0)) > 20


def test_the_script_of_pymol_selects_every_atom_of_a_cluster_once(dry_villin):
    from ragdoll.rigidity_files import _selections

    found = ragdoll.rigidity(Molecule.from_file(dry_villin))
    atoms = list(found.molecule.topology.atoms())
    selected = []
    for words in _selections(found, np.flatnonzero(found.cluster_of_body == 0)):
        chain, name, residues = words.split(" and ")
        for residue in residues.removeprefix("resi ").split("+"):
            selected += [
                atom.index
                for atom in atoms
                if f'chain "{atom.residue.chain.id}"' == chain
                and f'name "{atom.name}"' == name
                and atom.residue.id == residue
            ]
    assert sorted(selected) == np.flatnonzero(found.cluster_of_body == 0).tolist()


def test_hydrogens_are_needed_and_can_be_added(run_many, dry_villin, tmp_path):
    bare = tmp_path / "bare.pdb"
    _without_hydrogens(dry_villin, bare)
    refused, done = run_many(
        [["rigidity", bare, "--json"], ["rigidity", bare, "--json", "--add-hydrogens"]]
    )
    assert refused.code == 2
    assert "has no hydrogens" in refused.sentence
    assert "--add-hydrogens" in refused.sentence
    assert done.code == 0
    assert done.json["hydrogen_bonds"] > 10


def test_chains_can_be_chosen_and_files_gzipped(run_ragdoll, proteins, tmp_path):
    zipped = tmp_path / "1dif.pdb.gz"
    zipped.write_bytes(gzip.compress((proteins / "1dif_withH.pdb").read_bytes()))
    run = run_ragdoll("rigidity", zipped, "--chain", "A", "--json", "-o", tmp_path / "a.png")
    assert run.code == 0, run.stderr
    assert run.json["atoms"] < 3126
    assert all(
        name.endswith(" A") for bond in run.json["hydrogen_bond_list"] for name in bond["names"]
    )


def test_what_cannot_be_done_is_refused_in_a_sentence(run_many, dry_villin, tmp_path):
    (tmp_path / "there.png").write_text("precious")
    cases = {
        "valid number": ["--hbond-cutoff-kcal", "abc"],
        "not nan": ["--hbond-cutoff-kcal", "nan"],
        "not inf": ["--hbond-cutoff-kcal", "inf"],
        "from -100 to 0": ["--hbond-cutoff-kcal", "2"],
        "no lock 'x'": ["--lock", "x"],
        "--ph": ["--ph", "20"],
        ".pml, .cif or .png": ["-o", tmp_path / "a.jpg"],
        "A dilution cannot be written": ["--dilution", "-o", tmp_path / "a.pml"],
        "--force": ["-o", tmp_path / "there.png"],
        "does not exist": ["-o", tmp_path / "none" / "a.png"],
    }
    runs = run_many(["rigidity", dry_villin, *flags] for flags in cases.values())
    for words, run in zip(cases, runs, strict=True):
        assert run.code == 2, words
        assert words in run.sentence, run.sentence
        assert run.stdout == ""
    assert (tmp_path / "there.png").read_text() == "precious"
    assert [path.name for path in tmp_path.iterdir()] == ["there.png"]


def test_input_that_has_nothing_to_tell_ends_in_a_sentence_or_a_result(
    run_many, dry_villin, villin, tmp_path
):
    lines = dry_villin.read_text().splitlines()
    water = [line for line in villin.read_text().splitlines() if line[17:20] == "HOH"]
    unknown = [
        line[:17] + "UNK" + line[20:]
        for line in lines
        if line[12:16].strip() in ("N", "CA", "C", "O", "CB", "H", "HA")
    ]
    twice = [*lines, lines[4][:12] + " C9 " + lines[4][16:]]
    for name, text in (("water", water), ("unk", unknown), ("twice", twice)):
        (tmp_path / f"{name}.pdb").write_text("\n".join(text) + "\n")
    dry, wet, unk, on_top = run_many(
        [
            ["rigidity", tmp_path / "water.pdb"],
            ["rigidity", tmp_path / "water.pdb", "--keep-solvent", "--json"],
            ["rigidity", tmp_path / "unk.pdb", "--json"],
            ["rigidity", tmp_path / "twice.pdb"],
        ]
    )
    assert dry.code == 2
    assert "only water" in dry.sentence
    assert (wet.code, wet.json["floppy_modes"]) == (0, 0)
    assert wet.json["largest_cluster"] == 3
    assert unk.code == 0
    assert unk.json["hydrogen_bonds"] > 0
    assert on_top.code == 2
    assert "lie at one place" in on_top.sentence
