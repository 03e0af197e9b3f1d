"""Reading PDB and mmCIF files: what is kept, what is refused, and with which words."""

import gzip
import os

import numpy as np
import pytest

from ragdoll.errors import InputError
from ragdoll.molecule import Molecule
from ragdoll.structure_file import read_structure_file

GLYCINE = """\
ATOM      1  N   GLY A   1       1.104   6.134  -6.504  1.00 11.00           N
ATOM      2  CA  GLY A   1       2.104   7.134  -6.504  1.00 12.00           C
ATOM      3  C   GLY A   1       3.404   6.434  -6.204  1.00 13.00           C
ATOM      4  O   GLY A   1       3.504   5.234  -6.304  1.00 14.00           O
"""
WATER = "HETATM    9  O   HOH A   2       9.504   5.234  -6.304  1.00  0.00           O\n"
ZINC = "HETATM    9 ZN    ZN A   2       9.504   5.234  -6.304  1.00  0.00          ZN\n"
CIF_HEAD = """\
data_x
loop_
_atom_site.group_PDB
_atom_site.id
_atom_site.type_symbol
_atom_site.label_atom_id
_atom_site.label_alt_id
_atom_site.label_comp_id
_atom_site.label_asym_id
_atom_site.label_seq_id
_atom_site.Cartn_x
_atom_site.Cartn_y
_atom_site.Cartn_z
_atom_site.occupancy
_atom_site.B_iso_or_equiv
_atom_site.auth_seq_id
_atom_site.auth_asym_id
_atom_site.pdbx_PDB_model_num
"""


@pytest.fixture
def write(tmp_path):
    def write_file(content, name="a.pdb"):
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return write_file


def with_altlocs(text, shifts):
    """Repeat each atom of `text` for each letter of `shifts`, moved by so many angstrom along x."""
    lines = []
    for line in text.splitlines():
        for letter, shift in shifts.items():
            x = float(line[30:38]) + shift
            lines.append(f"{line[:16]}{letter}{line[17:30]}{x:8.3f}{line[38:]}")
    return "\n".join(lines) + "\n"


def test_atoms_of_a_pdb_file(write):
    file = read_structure_file(write(GLYCINE))
    assert [atom.name for atom in file.topology.atoms()] == ["N", "CA", "C", "O"]
    np.testing.assert_allclose(file.positions[1], [0.2104, 0.7134, -0.6504])
    np.testing.assert_allclose(file.b_factors, [11, 12, 13, 14])
    assert len(file.source_hash) == 64


def test_gzip_crlf_and_short_lines_change_nothing(write):
    plain = Molecule.from_file(write(GLYCINE))
    short = "".join(line[:54] + "\n" for line in GLYCINE.splitlines())
    for content, name in (
        (gzip.compress(GLYCINE.encode()), "b.pdb.gz"),
        (GLYCINE.replace("\n", "\r\n"), "c.pdb"),
        (short, "d.pdb"),
    ):
        other = Molecule.from_file(write(content, name))
        np.testing.assert_array_equal(other.positions, plain.positions)
        np.testing.assert_array_equal(other.elements, [7, 6, 6, 8])


def test_line_numbers_of_old_files_are_no_charges(write):
    old = "".join(f"{line[:72]}1DIF{n:4d}\n" for n, line in enumerate(GLYCINE.splitlines(), 99))
    molecule = Molecule.from_file(write(old))
    assert molecule.elements.tolist() == [7, 6, 6, 8]
    assert molecule.charges.sum() == 1  # the terminal nitrogen


def test_ca_of_an_amino_acid_is_carbon_wherever_its_name_stands(write):
    text = "".join(line[:66] + "\n" for line in GLYCINE.splitlines()).replace(
        " CA  GLY", "CA   GLY"
    )
    assert Molecule.from_file(write(text)).elements.tolist() == [7, 6, 6, 8]


def test_deuterium_is_hydrogen(write):
    line = "ATOM      5  D   GLY A   1       0.504   6.134  -7.304  1.00  0.00           D\n"
    molecule = Molecule.from_file(write(GLYCINE + line))
    assert molecule.elements[4] == 1
    assert [0, 4] in molecule.bonds.tolist()


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (GLYCINE.replace("2.104", "  NaN"), "line 2: the x coordinate"),
        (GLYCINE.replace("   2.104", "********"), "line 2: the x coordinate"),
        (GLYCINE.replace("   7.134", "  12.xxx"), "line 2: the y coordinate"),
        (GLYCINE.replace("   2.104", "9999.999"), "without a place"),
        (GLYCINE.replace("7.134  -6.504  1.00 12.00           C", "7.1"), "line 2: the atom rec"),
        (GLYCINE.replace("3.404   6.434  -6.204", "1.104   6.134  -6.504"), "N of GLY1 A and C of"),
        (GLYCINE + GLYCINE.replace("  1.104", "  0.504").replace("2.104", "2.504")
         .replace("3.404", "3.804").replace("3.504", "3.904"), "occurs twice in GLY1 A"),
        ("", "is empty"),
        (" \n\n", "is empty"),
        (b"\x00\x01\x02\xff" * 100, "binary"),
        ("hello\nworld\n", "contains no atoms"),
        (WATER, "only water"),
        (WATER + ZINC, "only water and single ions"),
        ("data_x\n_cell.length_a 1\n", "no atom coordinates"),
        ("data_x\nloop_\n_a.b\n_a.c\n1 2 3\n", "no valid mmCIF file"),
        (CIF_HEAD + "ATOM 7 C CA . GLY A 1 1.0 abc 3.0 1 1 1 A 1\n", "atom 7 of _atom_site: the y"),
        (CIF_HEAD + "ATOM 7 C CA . GLY A 1 1.0 ? 3.0 1 1 1 A 1\n", "atom 7 of _atom_site: the y"),
    ],
)  # fmt: skip
def test_refused_content(write, content, words):
    path = write(content)
    with pytest.raises(InputError, match=words) as caught:
        Molecule.from_file(path)
    message = str(caught.value)
    assert "\n" not in message
    assert path.name in message or "occurs twice" in words


def test_refused_files(write, tmp_path):
    with pytest.raises(InputError, match="does not exist"):
        Molecule.from_file(tmp_path / "none.pdb")
    with pytest.raises(InputError, match="is a directory"):
        Molecule.from_file(tmp_path)
    with pytest.raises(InputError, match="not gzipped"):
        Molecule.from_file(write(GLYCINE, "a.pdb.gz"))
    with pytest.raises(InputError, match="damaged gzip"):
        Molecule.from_file(write(gzip.compress(GLYCINE.encode())[:60], "b.pdb.gz"))


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read every file")
def test_unreadable_file(write):
    path = write(GLYCINE)
    path.chmod(0)
    with pytest.raises(InputError, match="permissions"):
        Molecule.from_file(path)


def test_refused_options(write):
    path = write(GLYCINE)
    with pytest.raises(InputError, match="no model 2"):
        Molecule.from_file(path, model=2)
    with pytest.raises(InputError, match='no chain "B"; its chains are "A"'):
        Molecule.from_file(path, chains=["B"])
    with pytest.raises(InputError, match="no alternate location B"):
        Molecule.from_file(path, altloc="B")


def test_ca_only_files_are_refused(write):
    trace = "".join(
        f"ATOM  {n:5d}  CA  ALA A{n:4d}    {3.8 * n:8.3f}   0.000   0.000  1.00  0.00\n"
        for n in range(1, 6)
    )
    with pytest.raises(InputError, match="needs all heavy atoms"):
        Molecule.from_file(write(trace))


def test_a_cut_last_line_is_left_out_with_a_note(write):
    molecule = Molecule.from_file(write(GLYCINE[:-45]))
    assert len(molecule) == 3
    assert any("line 4" in note for note in molecule.notes)
    assert molecule.missing_atoms[0].names == ("O",)


def test_solvent_goes_unless_kept(write):
    cell = "CRYST1   20.000   30.000   40.000  90.00  90.00  90.00 P 1           1\n"
    path = write(cell + GLYCINE + WATER + ZINC.replace("9.504", "8.504"))
    molecule = Molecule.from_file(path)
    assert len(molecule) == 4
    assert molecule.box_vectors is None
    assert any("1 water, 1 ZN" in note for note in molecule.notes)
    wet = Molecule.from_file(path, keep_solvent=True)
    assert wet.elements.tolist() == [7, 6, 6, 8, 8, 30]
    np.testing.assert_allclose(wet.box_vectors, np.diag([2.0, 3.0, 4.0]))


def test_a_single_atom_is_a_molecule(write):
    assert len(Molecule.from_file(write(ZINC.replace("ZN", "AR")))) == 1


def test_unknown_elements_are_left_out_with_a_note(write):
    line = "HETATM    9 UNK  UNX A   2       9.504   5.234  -6.304  1.00  0.00           X\n"
    molecule = Molecule.from_file(write(GLYCINE + line))
    assert len(molecule) == 4
    assert any("unknown element" in note for note in molecule.notes)


def test_the_first_alternate_location_or_the_asked_one(write):
    path = write(with_altlocs(GLYCINE, {"B": 0.3, "A": 0.0}))
    first = Molecule.from_file(path)
    asked = Molecule.from_file(path, altloc="A")
    np.testing.assert_allclose(first.positions[:, 0] - asked.positions[:, 0], 0.03)
    assert any("4 atoms of other alternate locations" in note for note in first.notes)


def test_one_of_two_residues_at_one_place(write):
    alanine = with_altlocs(GLYCINE, {"B": 0.3}).replace("GLY", "ALA")
    path = write(with_altlocs(GLYCINE, {"A": 0.0}) + alanine)
    assert [r.name for r in Molecule.from_file(path).topology.residues()] == ["GLY"]
    assert [r.name for r in Molecule.from_file(path, altloc="B").topology.residues()] == ["ALA"]


def test_models_and_chains(write):
    other = GLYCINE.replace("GLY A", "GLY B").replace("-6.", "-2.")
    path = write(
        f"MODEL        1\n{GLYCINE}TER\n{other}ENDMDL\nMODEL        2\n{other}ENDMDL\nEND\n"
    )
    assert len(Molecule.from_file(path)) == 8
    assert Molecule.from_file(path, chains=["B"]).labels[0] == "N GLY1 B"
    assert len(Molecule.from_file(path, model=2)) == 4


def test_insertion_codes_keep_residues_apart(write):
    inserted = GLYCINE.replace("A   1 ", "A   1A").replace("-6.", "-2.")
    molecule = Molecule.from_file(write(GLYCINE + inserted))
    assert [(r.id, r.insertionCode) for r in molecule.topology.residues()] == [
        ("1", ""),
        ("1", "A"),
    ]
    assert molecule.labels[4] == "N GLY1A A"
