"""Preparing structures: what is found, what is mended, and that what is there stays in place."""

import json

import gemmi
import numpy as np
import pytest

import ragdoll
from ragdoll import InputError, Molecule, PrepareOptions


@pytest.fixture(scope="module")
def lines(dry_villin):
    return dry_villin.read_text().splitlines()


def _heavy(lines):
    return [line for line in lines if line[76:78].strip() != "H" and _element(line) != "H"]


def _element(line):
    return line[12:16].strip().lstrip("0123456789")[:1]


def _number(line):
    return int(line[22:26])


def _sequence(lines, chain="A"):
    """SEQRES records of the atoms' residues."""
    names = {}
    for line in lines:
        names.setdefault(_number(line), line[17:20])
    names = [name.replace("HIE", "HIS") for name in names.values()]
    rows = [names[k : k + 13] for k in range(0, len(names), 13)]
    return [
        f"SEQRES {number:>3} {chain}{len(names):>5}  {' '.join(row)}"
        for number, row in enumerate(rows, start=1)
    ]


def _in_chain(lines, chain="A"):
    return [line[:21] + chain + line[22:] for line in lines]


def _prepared(tmp_path, text, **values):
    path = tmp_path / "given.pdb"
    path.write_text("\n".join(text) + "\n")
    return ragdoll.prepare(path, tmp_path / "prepared.pdb", PrepareOptions(**values), force=True)


def _kept_in_place(lines, molecule):
    """Whether every heavy atom of the lines is in the molecule, where it was."""
    places = {tuple(np.round(10 * place, 3)) for place in molecule.positions}
    wanted = {tuple(float(line[k : k + 8]) for k in (30, 38, 46)) for line in _heavy(lines)}
    return wanted <= places


def test_a_complete_structure_is_left_as_it_is(dry_villin, tmp_path):
    report = ragdoll.prepare(dry_villin, tmp_path / "same.pdb")
    before = Molecule.from_file(dry_villin)
    np.testing.assert_array_equal(report.molecule.elements, before.elements)
    np.testing.assert_allclose(report.molecule.positions, before.positions)
    assert report.found() == ["Nothing stands in the way."]
    assert report.left == []
    assert report.quality["clashes_per_1000"] >= 0


def test_hydrogens_are_placed(lines, tmp_path):
    bare = _heavy(lines)
    report = _prepared(tmp_path, bare)
    assert len(report.molecule) == len(lines)
    assert "There are no hydrogens." in report.found()
    assert _kept_in_place(lines, report.molecule)
    without = _prepared(tmp_path, bare, add_hydrogens=False)
    assert len(without.molecule) == len(bare)
    assert ragdoll.quality(report.molecule).input["all_atom_clashscore"] < 40


def test_missing_side_chains_are_completed(lines, tmp_path):
    cut = [line for line in lines if not (_number(line) == 10 and line[12:16].strip()[:2] != "CB")]
    cut += [line for line in lines if _number(line) == 10 and line[12:16].strip() in "N CA C O"]
    cut.sort(key=_number)
    report = _prepared(tmp_path, cut)
    assert list(report.missing_atoms) == ["PHE10"] or len(report.missing_atoms) == 1
    assert report.molecule.missing_atoms == []
    assert any("Completed" in sentence for sentence in report.done)
    assert len(report.molecule) == len(lines)
    assert _kept_in_place(cut, report.molecule)


def test_a_missing_loop_is_built_from_the_sequence(lines, tmp_path):
    chained = _in_chain(lines)
    cut = [line for line in chained if _number(line) not in (14, 15)]
    report = _prepared(tmp_path, _sequence(chained) + _heavy(cut))
    (gap,) = report.missing_residues
    assert (gap.before[1], gap.after[1], len(gap.names)) == (13, 16, 2)
    assert len(report.added) == 2
    assert report.left == []
    assert len(report.molecule) == len(lines)
    assert _kept_in_place(cut, report.molecule)
    numbers = [int(residue.id) for residue in report.molecule.topology.residues()]
    assert numbers == sorted(set(numbers))
    # one chain, as before
    whole = Molecule.from_file(tmp_path / "prepared.pdb")
    assert ragdoll.build_framework(whole).component_count == 1


def test_a_loop_that_is_too_long_stays_away_and_is_told(lines, tmp_path):
    chained = _in_chain(lines)
    cut = [line for line in chained if _number(line) not in (14, 15)]
    report = _prepared(
        tmp_path, _sequence(chained) + _heavy(cut), longest_loop=1, add_hydrogens=False
    )
    assert report.added == []
    assert any("between 13 and 16" in sentence for sentence in report.left)


def test_ends_are_built_only_if_asked(lines, tmp_path):
    chained = _in_chain(lines)
    first = _number(chained[0])
    cut = [line for line in chained if _number(line) != first]
    text = _sequence(chained) + _heavy(cut)
    plain = _prepared(tmp_path, text, add_hydrogens=False)
    built = _prepared(tmp_path, text, add_hydrogens=False, build_ends=True)
    assert plain.added == []
    assert any("--build-ends" in note for note in plain.notes)
    assert len(built.added) == 1


def test_selenomethionine_becomes_methionine_with_its_torsions(lines, tmp_path):
    number = next(_number(line) for line in lines if line[17:20] == "MET")
    text = []
    for line in _heavy(lines):
        if _number(line) == number:
            line = "HETATM" + line[6:17] + "MSE" + line[20:]
            if line[12:16].strip() == "SD":
                line = line[:12] + "SE  " + line[16:76].ljust(60) + "SE"
        text.append(line)
    report = _prepared(tmp_path, text)
    assert list(report.nonstandard.values()) == ["MET"]
    molecule = report.molecule
    atoms = {
        atom.name: atom.index
        for atom in molecule.topology.atoms()
        if int(atom.residue.id) == number
    }
    assert molecule.elements[atoms["SD"]] == 16
    x = 10 * molecule.positions
    assert np.linalg.norm(x[atoms["SD"]] - x[atoms["CG"]]) == pytest.approx(1.803, abs=1e-3)
    assert np.linalg.norm(x[atoms["CE"]] - x[atoms["SD"]]) == pytest.approx(1.791, abs=1e-3)
    kept = _prepared(tmp_path, text, replace_nonstandard=False)
    assert (kept.molecule.elements == 34).sum() == 1


def test_waters_and_ions_stay_or_go_by_flag(villin, tmp_path):
    text = [line for line in villin.read_text().splitlines() if line.startswith("ATOM")]
    waters = [line for line in text[582:] if line[17:20] in ("HOH", "SOL", "WAT")][:30]
    text = (
        text[:582]
        + waters
        + ["HETATM 9999 MG    MG B   1      10.000  10.000 100.000  1.00  0.00          MG"]
    )
    dry = _prepared(tmp_path, text)
    assert (dry.waters, dry.heterogens) == (10, {"MG": 1})
    assert len(dry.molecule) == 583
    assert len(_prepared(tmp_path, text, heterogens="drop").molecule) == 582
    assert len(_prepared(tmp_path, text, heterogens="ligands").molecule) == 582
    assert len(_prepared(tmp_path, text, keep_water=True).molecule) == 582 + 30 + 1
    only = waters
    with pytest.raises(InputError, match="nothing but what is dropped"):
        _prepared(tmp_path, only)


def test_alternate_locations_are_told_and_one_is_taken(lines, tmp_path):
    text = []
    for line in _heavy(lines):
        if _number(line) == 12 and line[12:16].strip() == "CB":
            text.append(line[:16] + "A" + line[17:])
            moved = f"{float(line[30:38]) + 0.3:8.3f}"
            text.append(line[:16] + "B" + line[17:30] + moved + line[38:])
        else:
            text.append(line)
    first = _prepared(tmp_path, text, add_hydrogens=False)
    second = _prepared(tmp_path, text, add_hydrogens=False, altloc="B")
    assert len(first.alternates) == 1
    shift = np.abs(first.molecule.positions - second.molecule.positions).max()
    assert shift == pytest.approx(0.03, abs=1e-6)


@pytest.mark.parametrize("suffix", ["pdb", "cif"])
def test_what_is_written_is_read_as_it_was(lines, suffix, tmp_path):
    (tmp_path / "in.pdb").write_text("\n".join(_heavy(lines)) + "\n")
    path = tmp_path / f"out.{suffix}"
    report = ragdoll.prepare(tmp_path / "in.pdb", path)
    again = Molecule.from_file(path)
    np.testing.assert_array_equal(again.elements, report.molecule.elements)
    np.testing.assert_allclose(again.positions, report.molecule.positions, atol=6e-5)
    np.testing.assert_array_equal(again.bonds, report.molecule.bonds)
    names = [atom.name for atom in again.topology.atoms()]
    assert names == [atom.name for atom in report.molecule.topology.atoms()]
    assert gemmi.read_structure(str(path))[0].count_atom_sites() == len(again)


def test_the_same_file_gives_the_same_atoms(lines, tmp_path):
    chained = _in_chain(lines)
    cut = [line for line in chained if _number(line) not in (14, 15)]
    text = _sequence(chained) + _heavy(cut)
    one = _prepared(tmp_path, text).molecule.positions
    np.testing.assert_array_equal(one, _prepared(tmp_path, text).molecule.positions)


# ------------------------------------------------------------------------------- files of the world


def test_deuterium_and_unknown_atoms_do_not_stand_in_the_way(proteins, tmp_path):
    report = ragdoll.prepare(proteins / "5pti.cif.gz", tmp_path / "5pti.pdb")
    assert (report.waters, report.unknown_atoms, report.heterogens) == (63, 1, {"PO4": 1})
    assert not any(atom.name[0] == "D" for atom in report.molecule.topology.atoms())
    disulfides = [
        pair
        for pair in report.molecule.bonds.tolist()
        if set(report.molecule.elements[pair]) == {16}
    ]
    assert len(disulfides) == 3


def test_oxidised_cysteine_is_replaced_and_the_ligand_kept(proteins, tmp_path):
    report = ragdoll.prepare(proteins / "1hvr.pdb", tmp_path / "1hvr.pdb")
    assert list(report.nonstandard.values()) == ["CYS", "CYS"]
    assert report.heterogens == {"XK2": 1}
    names = {residue.name for residue in report.molecule.topology.residues()}
    assert "XK2" in names
    assert "CSO" not in names
    assert report.left == []


def test_free_glutamate_stays_a_ligand(proteins, tmp_path):
    options = PrepareOptions(chains=("A",), add_hydrogens=False)
    report = ragdoll.prepare(proteins / "1ewk.pdb.gz", tmp_path / "1ewk.cif", options)
    assert report.heterogens["GLU"] == 1
    assert any("29 residues between 124 and 154" in sentence for sentence in report.left)
    assert sum(r.name == "GLU" and r.id == "901" for r in report.molecule.topology.residues()) <= 1


def test_small_ligands_get_their_hydrogens(proteins, tmp_path):
    options = PrepareOptions(ph=7)
    report = ragdoll.prepare(proteins / "181l.pdb", tmp_path / "181l.pdb", options)
    found = {}
    for residue in report.molecule.topology.residues():
        if residue.name in ("BNZ", "HED"):
            symbols = sorted(atom.element.symbol for atom in residue.atoms())
            found[residue.name] = symbols.count("H")
    assert found == {"BNZ": 6, "HED": 10}


def test_structures_of_alpha_carbons_are_refused_in_a_sentence(proteins, tmp_path):
    with pytest.raises(InputError, match="only the CA atom"):
        ragdoll.prepare(proteins / "hivp_ca.pdb", tmp_path / "none.pdb")
    assert not (tmp_path / "none.pdb").exists()


# -------------------------------------------------------------------------------- the command line


def test_the_command_reports_and_writes(run_many, lines, tmp_path):
    source, output = tmp_path / "bare.pdb", tmp_path / "out.pdb"
    source.write_text("\n".join(_heavy(lines)) + "\n")
    dry, done, again, none, bad, sampled = run_many(
        [
            ["prepare", source, "--dry-run"],
            ["prepare", source, "-o", output, "--json"],
            ["prepare", source, "-o", source, "--force"],
            ["prepare", source],
            ["prepare", source, "-o", tmp_path / "out.xyz"],
            ["sample", output, "-o", tmp_path / "out.h5", "--frames", "2", "--quiet"],
        ]
    )
    assert dry.code == 0
    assert "There are no hydrogens." in dry.stdout
    assert done.code == 0
    told = done.json
    assert (told["atoms"], told["found"]["hydrogens"]) == (582, 0)
    assert told["dry_run"] is False
    assert told["parameters"]["ph"] == 7
    assert json.dumps(told)
    assert "is the input" in again.sentence
    assert "--dry-run" in none.sentence
    assert ".pdb or .cif" in bad.sentence
    assert [run.code for run in (again, none, bad)] == [2, 2, 2]
    assert sampled.code == 0, sampled.stderr
