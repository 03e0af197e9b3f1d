"""Files of small molecules are cut into records, whatever they look like."""

import gzip
import tracemalloc

import pytest
from rdkit import Chem
from rdkit.Chem import rdDistGeom

from ragdoll import InputError
from ragdoll.batch.parsing import parse
from ragdoll.batch.records import MoleculeFile
from ragdoll.batch.text_lines import LONGEST_LINE


@pytest.fixture
def read(tmp_path):
    """Records of a file with this name and these bytes."""

    def read(name, data):
        path = tmp_path / name
        path.write_bytes(data if isinstance(data, bytes) else data.encode())
        with MoleculeFile(path) as file:
            return list(file)

    return read


def sd_record(smiles, title):
    mol = Chem.AddHs(Chem.MolFromSmiles(smiles))
    rdDistGeom.EmbedMolecule(mol, randomSeed=1)
    mol.SetProp("_Name", title)
    return Chem.MolToMolBlock(mol) + "> <pic50>\n7.5\n\n$$$$\n"


def mol2_record(title):
    atoms = "1 C1 0 0 0 C.3 1 LIG 0\n2 O1 1.4 0 0 O.3 1 LIG 0\n"
    return f"@<TRIPOS>MOLECULE\n{title}\n2 1\nSMALL\nNO_CHARGES\n@<TRIPOS>ATOM\n{atoms}" + (
        "@<TRIPOS>BOND\n1 1 2 1\n"
    )


def test_a_line_is_a_molecule_with_the_rest_of_the_line_as_its_title(read):
    records = read("a.smi", "CCO ethanol\nCC\tgas two\r\nC\n")
    assert [(r.text, r.title, r.line, r.number) for r in records] == [
        ("CCO", "ethanol", 1, 0),
        ("CC", "gas two", 2, 1),
        ("C", "line 3", 3, 2),
    ]


def test_headers_comments_and_blank_lines_are_no_molecules(read):
    records = read("a.smi", "\n# by hand\nSMILES name\n\n  \nCCO smiles\n# end\n\nCC b")
    assert [(r.text, r.title, r.line, r.number) for r in records] == [
        ("CCO", "smiles", 6, 0),
        ("CC", "b", 9, 1),
    ]


def test_an_extension_in_bars_belongs_to_the_molecule_and_not_to_the_title(read):
    (record,) = read("a.smi", "C[C@H](O)F |o1:1| name\n")
    assert (record.text, record.title) == ("C[C@H](O)F |o1:1|", "name")
    assert parse(record).GetNumAtoms() == 4


@pytest.mark.parametrize(
    "encoding", ["utf-8", "utf-8-sig", "latin-1", "utf-16", "utf-16-le", "utf-16-be"]
)
def test_an_encoding_does_not_change_what_is_read(read, encoding):
    records = read("a.smi", "CCO Äthanol\nCC Äthan\n".encode(encoding))
    assert [(r.text, r.title) for r in records] == [("CCO", "Äthanol"), ("CC", "Äthan")]


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_lines_end_as_any_system_ends_them(read, end):
    assert [r.title for r in read("a.smi", f"CCO a{end}{end}CC b{end}")] == ["a", "b"]


def test_a_packed_file_is_unpacked_whatever_it_is_called(read):
    data = gzip.compress(b"CCO a\nCC b\n")
    assert [r.title for r in read("a.smi.gz", data)] == ["a", "b"]
    assert [r.title for r in read("a.smi", data)] == ["a", "b"]


def test_a_packed_file_that_breaks_off_gives_what_it_has_and_says_so(read):
    import random

    letters = random.Random(1)
    lines = "".join(f"CCO {letters.random()}\n" for _ in range(20000))
    data = gzip.compress(lines.encode())
    records = read("a.smi.gz", data[: len(data) // 2])
    assert len(records) > 1000
    assert not any(record.error for record in records[:-1])
    assert "cannot be read on" in records[-1].error


def test_a_line_without_end_costs_its_record_and_little_memory(tmp_path):
    path = tmp_path / "a.smi"
    path.write_bytes(b"CC a\n" + b"C" * 40_000_000 + b" long\nCCC b\n")
    tracemalloc.start()
    with MoleculeFile(path) as file:
        records = list(file)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert [(r.title, r.line) for r in records] == [("a", 1), ("line 2", 2), ("b", 3)]
    assert str(LONGEST_LINE) in records[1].error
    assert peak < 20_000_000


def test_a_large_file_is_read_in_the_memory_of_a_small_one(tmp_path):
    path = tmp_path / "a.smi.gz"
    with gzip.open(path, "wb", compresslevel=1) as file:
        for _ in range(40):
            file.write(b"CC(C)Cc1ccc(cc1)C(C)C(=O)O ibuprofen\n" * 10_000)
    count = 0
    tracemalloc.start()
    with MoleculeFile(path) as molecules:
        for record in molecules:
            count += record.title == "ibuprofen"
            if count == 50_000:
                break
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert count == 50_000
    assert peak < 3_000_000


def test_titles_with_control_characters_stay_in_one_line(read):
    titles = [r.title for r in read("a.smi", "CC a\x00b\x0bc\u2028d\nCC $$$$\n")]
    assert titles == ["a b c d", "'$$$$'"]
    assert all(len(title.splitlines()) == 1 for title in titles)


def test_a_table_is_read_by_the_names_of_its_columns(read):
    records = read("a.csv", 'id,price,SMILES\n"a, b",3,CCO\nc,4,"CC"\nd,5\n')
    assert [(r.text, r.title, r.error) for r in records] == [
        ("CCO", "a, b", ""),
        ("CC", "c", ""),
        ("", "line 4", "the row has no SMILES"),
    ]
    assert [r.title for r in read("a.tsv", "CCO\ta\nCC\tb\n")] == ["a", "b"]


def test_records_of_an_sd_file_keep_title_and_data(read):
    records = read("a.sdf", sd_record("CCO", "one") + sd_record("CC", ""))
    assert [r.title for r in records] == ["one", "molecule 2"]
    mol = parse(records[0])
    assert mol.GetNumAtoms() == 9
    assert mol.GetProp("pic50") == "7.5"
    assert mol.GetConformer().Is3D()


def test_after_a_broken_record_an_sd_file_goes_on(read):
    broken = "broken\n\n\n 99 99  0  0  0  0  0  0  0  0999 V2000\nnonsense\n$$$$\n"
    text = sd_record("CCO", "one") + broken + "$$$$\n" + sd_record("CC", "two")
    records = read("a.sdf", text)
    assert [r.title for r in records] == ["one", "broken", "molecule 3", "two"]
    assert parse(records[3]).GetNumAtoms() == 8
    for record in records[1:3]:
        with pytest.raises(InputError):
            parse(record)


def test_the_last_record_needs_no_end(read):
    text = sd_record("CCO", "one").removesuffix("$$$$\n")
    assert [r.title for r in read("a.sdf", text)] == ["one"]
    assert [r.title for r in read("a.mol", text.split("> <")[0])] == ["one"]


def test_an_sd_file_in_latin_1_is_read(read):
    text = sd_record("CCO", "Äthanol").encode("latin-1")
    (record,) = read("a.sdf", text)
    assert record.title == "Äthanol"
    assert parse(record).GetNumAtoms() == 9


def test_molecules_of_a_mol2_file_are_read_one_by_one(read):
    records = read("a.mol2", "# by hand\n" + mol2_record("one") + "\n" + mol2_record("two"))
    assert [r.title for r in records] == ["one", "two"]
    assert parse(records[1]).GetNumAtoms() >= 2


@pytest.mark.parametrize(
    "text, words",
    [
        ("C(C)(C)(C)(C)C", "valence"),
        ("c1cccc1", "kekulize"),
        ("C1CC", "unclosed ring"),
        ("xyz", "syntax error"),
        ("[Xx]", "syntax error"),
        ("CC(C", "parentheses"),
    ],
)
def test_what_rdkit_cannot_read_is_told_in_its_words(read, text, words):
    (record,) = read("a.smi", text + "\n")
    with pytest.raises(InputError, match=words) as caught:
        parse(record)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "name, data, words",
    [
        ("a.smi", b"", "is empty"),
        ("a.sdf", b"%PDF-1.4\n%\xe2\xe3\xcf\xd3\n1 0 obj\n", "is no text"),
        ("a.sdf", b"hello\nworld\n", "is no SD file"),
        ("a.sdf", bytes(range(256)) * 20, "is no text"),
        ("a.mol2", b"hello\n", "is no MOL2 file"),
        ("a.smi.gz", b"\x1f\x8bnonsense", "no whole gzip file"),
        ("a.xyz", b"3\n\n", "no name that tells its format"),
    ],
)
def test_a_file_that_is_something_else_is_refused_in_one_sentence(read, name, data, words):
    with pytest.raises(InputError, match=words) as caught:
        read(name, data)
    assert str(caught.value).endswith(".")


def test_a_missing_file_and_a_folder_are_refused(tmp_path):
    with pytest.raises(InputError, match="There is no file"):
        MoleculeFile(tmp_path / "none.smi")
    (tmp_path / "folder.smi").mkdir()
    with pytest.raises(InputError, match="is a folder"):
        MoleculeFile(tmp_path / "folder.smi")
