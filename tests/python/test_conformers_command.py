"""``ragdoll conformers``: many molecules in one call, whatever is among them."""

import csv
import gzip
import json
import os
import signal
import time

import h5py
import mdtraj
import numpy as np
import pytest
from rdkit import Chem
from rdkit.Chem import rdDistGeom

import ragdoll
from ragdoll.batch.conforming import record_seed

SMILES = ["CCCCO alcohol", "CC(C)CC(=O)NC amide", "c1ccccc1CCN amine", "CCOCC ether"]

# stands in for core where a test wants time to pass
SLOW = """
import time
from ragdoll.batch import conforming
sample = conforming.sample
def slowly(mol, **options):
    time.sleep(0.15)
    return sample(mol, **options)
conforming.sample = slowly
"""
HANGS = """
import os, signal, time
from ragdoll.batch import conforming
sample = conforming.sample
def hangs(mol, **options):
    symbols = {atom.GetSymbol() for atom in mol.GetAtoms()}
    if "Br" in symbols:
        signal.signal(signal.SIGALRM, signal.SIG_IGN)
        time.sleep(1000)
    if "I" in symbols:
        os.kill(os.getpid(), signal.SIGSEGV)
    while "Cl" in symbols:
        time.sleep(0.01)
    return sample(mol, **options)
conforming.sample = hangs
"""
FULL_DISK = """
import resource
resource.setrlimit(resource.RLIMIT_FSIZE, ({size}, {size}))
"""


@pytest.fixture
def smiles(tmp_path):
    """A file with these lines."""

    def write(lines, name="in.smi"):
        path = tmp_path / name
        path.write_text("".join(f"{line}\n" for line in lines))
        return path

    return write


def molecules(path):
    with Chem.SDMolSupplier(str(path), removeHs=False) as supplier:
        found = list(supplier)
    assert None not in found
    return found


def titles(path):
    return [mol.GetProp("_Name") for mol in molecules(path)]


def places(mol):
    return mol.GetConformer().GetPositions()


def left_over(folder):
    return sorted(name for name in os.listdir(folder) if ".partial" in name)


def test_each_molecule_has_its_conformers_together_in_the_order_of_the_input(
    run_ragdoll, smiles, tmp_path
):
    path = smiles(SMILES)
    run = run_ragdoll("conformers", path, "-o", tmp_path / "out.sdf", "-n", 3, "--json")
    assert run.code == 0, run.stderr
    found = molecules(tmp_path / "out.sdf")
    assert titles(tmp_path / "out.sdf") == [
        name for line in SMILES for name in 3 * [line.split()[1]]
    ]
    assert [mol.GetIntProp("ragdoll_conformer") for mol in found] == [1, 2, 3] * 4
    assert all(mol.GetConformer().Is3D() for mol in found)
    assert {mol.GetProp("ragdoll_version") for mol in found} == {ragdoll.__version__}
    seeds = [int(mol.GetProp("ragdoll_seed")) for mol in found[::3]]
    assert seeds == [record_seed(0, k) for k in range(4)]
    for k, line in enumerate(SMILES):
        assert Chem.MolToSmiles(Chem.RemoveHs(found[3 * k])) == Chem.CanonSmiles(line.split()[0])
    report = run.json
    assert (report["molecules"], report["complete"], report["conformers"]) == (4, 4, 12)
    assert report["failed"] == report["short"] == []
    assert report["parameters"]["input_hash"] == found[0].GetProp("ragdoll_input_hash")
    assert json.loads(found[0].GetProp("ragdoll_options"))["count"] == 3
    assert left_over(tmp_path) == []


def test_the_function_gives_what_the_command_writes(run_ragdoll, smiles, tmp_path):
    path = smiles(SMILES)
    run_ragdoll("conformers", path, "-o", tmp_path / "out.sdf", "-n", 3, "--seed", 5, "--quiet")
    mol = Chem.MolFromSmiles("CC(C)CC(=O)NC")
    made = ragdoll.conformers(mol, 3, seed=record_seed(5, 1))
    for conformer, written in zip(
        made.GetConformers(), molecules(tmp_path / "out.sdf")[3:6], strict=True
    ):
        assert np.allclose(conformer.GetPositions(), places(written), atol=6e-5)


@pytest.mark.parametrize("kind", ["sdf", "sdf.gz"])
def test_workers_do_not_change_the_output(run_ragdoll, smiles, tmp_path, kind):
    path = smiles(SMILES * 3)
    outputs = []
    for workers in (1, 3):
        output = tmp_path / f"{workers}.{kind}"
        run = run_ragdoll("conformers", path, "-o", output, "-n", 2, "--workers", workers)
        assert run.code == 0, run.stderr
        outputs.append(output.read_bytes())
    assert outputs[0] == outputs[1]
    text = outputs[0] if kind == "sdf" else gzip.decompress(outputs[0])
    assert text.count(b"$$$$") == 24


HOSTILE = [
    "CCO first",
    "",
    "*CC* polymer",
    "[*:1]C dummy",
    "C(C)(C)(C)(C)C five",
    "c1cccc1 kekule",
    "nonsense!",
    "CC(=O)[O-].[Na+].[Cl-].[K+] salts",
    "[Fe] iron",
    "[Fe+2].c1cc[cH-]c1.c1cc[cH-]c1 ferrocene",
    "N[Pt](N)(Cl)Cl cisplatin",
    "C[CH2] radical",
    "[2H]C([2H])([2H])O isotopes",
    "[NH3+]CC(=O)[O-] zwitterion",
    "[H]C([H])O partial",
    "[H][H] h2",
    "[He]",
    "CCO same",
    "CCN same",
    'CC odd\x01name\x0bwith\u2028breaks, "quotes" & <tags> Ünï',
    "CC $$$$",
    "CC > <name>",
    "C" * 300_000 + " huge",
    "C(" * 20_000 + "C" + ")" * 20_000 + " deep",
    "C%(100000)CC%(100000) ring",
    "CCC last",
]
FAILING = {
    "polymer": "no element",
    "dummy": "no element",
    "five": "valence",
    "kekule": "kekulize",
    "line 7": "syntax error",
    "huge": "more than 5000",
}


def test_bad_molecules_cost_a_line_each_and_never_the_run(run_ragdoll, smiles, tmp_path):
    path = smiles(HOSTILE)
    output, table = tmp_path / "out.sdf", tmp_path / "table.csv"
    run = run_ragdoll(
        *("conformers", path, "-o", output, "-n", 2, "--json", "--report", table),
        *("--seconds-per-molecule", 20),
    )
    assert run.code == 3, run.stderr
    assert "have no conformers" in run.sentence
    report = run.json
    failed = {fault["title"]: fault["reason"] for fault in report["failed"]}
    for title, words in FAILING.items():
        assert words in failed[title]
    assert set(failed) - set(FAILING) <= {"deep", "ring"}
    log = run.stderr.splitlines()
    assert len(log) == len(failed) + len(report["short"]) + 1
    for fault in report["failed"]:
        assert any(line.startswith(f"line {fault['line']}") for line in log)
    names = titles(output)
    assert names[:2] == ["first", "first"] and names[-2:] == ["last", "last"]
    assert names.count("same") == 4
    assert 'odd name with breaks, "quotes" & <tags> Ünï' in names
    assert "'$$$$'" in names and "> <name>" in names
    assert report["molecules"] == len(HOSTILE) - 1
    assert report["conformers"] == len(names)
    rows = list(csv.DictReader(table.open(encoding="utf-8")))
    assert len(rows) == report["molecules"]
    assert [row["title"] for row in rows if row["status"] == "failed"] == list(failed)
    assert all(row["reason"] for row in rows if row["status"] != "complete")


def test_what_takes_too_long_or_crashes_is_given_up(run_ragdoll, smiles, tmp_path):
    path = smiles(["CCO a", "CCBr hangs", "CCI crashes", "CCCl slow", "CCN b"])
    run = run_ragdoll(
        *("conformers", path, "-o", tmp_path / "out.sdf", "-n", 2, "--json"),
        *("--seconds-per-molecule", 2, "--workers", 2),
        before=HANGS,
    )
    assert run.code == 3
    assert [fault["reason"] for fault in run.json["failed"]] == [
        "it took longer than 2 s",
        "the process that worked on it died of SIGSEGV",
    ]
    (short,) = run.json["short"]
    assert short["reason"] == "the start alone: sampling took too long"
    assert titles(tmp_path / "out.sdf") == ["a", "a", "slow", "b", "b"]


def test_fewer_conformers_than_asked_come_with_the_reason(run_ragdoll, smiles, tmp_path):
    path = smiles(["c1ccccc1 ring", "CCCCO chain"])
    run = run_ragdoll(
        *("conformers", path, "-o", tmp_path / "out.sdf", "-n", 3, "--json"),
        *("--rmsd-prune-angstrom", 0.3),
    )
    assert run.code == 3
    (fault,) = run.json["short"]
    assert (fault["title"], fault["conformers"]) == ("ring", 1)
    assert fault["reason"]
    assert "line 1 (ring): 1 conformers" in run.stderr
    assert titles(tmp_path / "out.sdf") == ["ring", "chain", "chain", "chain"]


def test_where_no_molecule_can_be_done_nothing_is_written(run_ragdoll, smiles, tmp_path):
    run = run_ragdoll("conformers", smiles(["x", "y"]), "-o", tmp_path / "out.sdf")
    assert run.code == 3
    assert "No molecule gave conformers" in run.sentence
    assert os.listdir(tmp_path) == ["in.smi"]


# ----------------------------------------------------------------------------------- interruption


def wait_for_entries(path, count, process):
    journal = path.with_name(f"{path.name}.partial.jsonl")
    end = time.monotonic() + 120
    while not journal.exists() or journal.read_bytes().count(b"\n") < count + 1:
        assert process.poll() is None
        assert time.monotonic() < end
        time.sleep(0.01)


@pytest.mark.parametrize("kind", ["sdf", "h5"])
def test_a_killed_run_goes_on_and_nothing_is_lost_or_there_twice(
    run_ragdoll, start_ragdoll, smiles, tmp_path, kind
):
    path = smiles([*SMILES, "bad bad"] * 4)
    whole, output = tmp_path / f"whole.{kind}", tmp_path / f"out.{kind}"
    options = ["-n", 2, "--workers", 2, "--seed", 3, "--quiet"]
    run_ragdoll("conformers", path, "-o", whole, *options)
    command = ["conformers", path, "-o", output, *options]
    for entries in (3, 9):
        process = start_ragdoll(*command, before=SLOW)
        wait_for_entries(output, entries, process)
        process.send_signal(signal.SIGKILL)
        process.communicate()
        assert not output.exists()
    run = run_ragdoll(*command, "--json")
    assert run.code == 3, run.stderr
    assert run.json["taken_up"] >= 9
    assert (run.json["molecules"], run.json["failed_count"]) == (20, 4)
    if kind == "sdf":
        assert output.read_bytes() == whole.read_bytes()
    else:
        with h5py.File(output) as one, h5py.File(whole) as other:
            assert list(one["molecules"]) == list(other["molecules"])
            for name in one["molecules"]:
                pair = [file[f"molecules/{name}/coordinates"][:] for file in (one, other)]
                assert np.array_equal(*pair)
    assert left_over(tmp_path) == []


DIES_AT_THE_END = """
import os, signal
from ragdoll.trajectory import CollectionWriter
add = CollectionWriter.add
def dies(writer, name, *arguments, **options):
    if name == "0000003":
        os.kill(os.getpid(), signal.SIGKILL)
    add(writer, name, *arguments, **options)
CollectionWriter.add = dies
"""


def test_a_run_that_is_killed_while_it_finishes_goes_on(run_ragdoll, smiles, tmp_path):
    command = ["conformers", smiles(SMILES), "-o", tmp_path / "out.h5", "-n", 2, "--quiet"]
    killed = run_ragdoll(*command, before=DIES_AT_THE_END)
    assert killed.code == -signal.SIGKILL
    assert not (tmp_path / "out.h5").exists()
    run = run_ragdoll(*command, "--json")
    assert run.code == 0, run.stderr
    assert run.json["taken_up"] == 4
    assert len(ragdoll.molecule_names(tmp_path / "out.h5")) == 4
    assert sorted(os.listdir(tmp_path)) == ["in.smi", "out.h5"]


def test_an_interrupted_run_says_so_and_goes_on(run_ragdoll, start_ragdoll, smiles, tmp_path):
    path, output = smiles(SMILES * 5), tmp_path / "out.sdf"
    command = ["conformers", path, "-o", output, "-n", 2]
    process = start_ragdoll(*command, before=SLOW)
    wait_for_entries(output, 3, process)
    process.send_signal(signal.SIGINT)
    stderr = process.communicate()[1]
    assert process.returncode == 130
    assert "Interrupted" in stderr and "goes on" in stderr and "Traceback" not in stderr
    assert not output.exists()
    run = run_ragdoll(*command, "--json")
    assert run.code == 0
    assert run.json["taken_up"] >= 3
    assert titles(output) == [line.split()[1] for line in SMILES * 5 for _ in range(2)]


def test_what_another_run_left_is_not_gone_on_with(run_ragdoll, start_ragdoll, smiles, tmp_path):
    path, output = smiles(SMILES * 5), tmp_path / "out.sdf"
    process = start_ragdoll("conformers", path, "-o", output, "-n", 2, before=SLOW)
    wait_for_entries(output, 2, process)
    process.kill()
    process.communicate()
    other = run_ragdoll("conformers", path, "-o", output, "-n", 3)
    assert other.code == 2
    assert "count 2" in other.sentence and "--force" in other.sentence
    path.write_text("CCCCCC new\n")
    other = run_ragdoll("conformers", path, "-o", output, "-n", 2)
    assert other.code == 2
    assert "input_hash" in other.sentence
    forced = run_ragdoll("conformers", path, "-o", output, "-n", 2, "--force")
    assert forced.code == 0, forced.stderr
    assert titles(output) == ["new", "new"]


def test_a_full_disk_ends_the_run_in_a_sentence_and_what_is_done_is_kept(
    run_ragdoll, smiles, tmp_path
):
    path, output = smiles(SMILES * 5), tmp_path / "out.sdf"
    command = ["conformers", path, "-o", output, "-n", 2, "--quiet"]
    run = run_ragdoll(*command, before=FULL_DISK.format(size=20_000))
    assert run.code == 1
    assert "cannot be written" in run.sentence and "goes on" in run.sentence
    assert not output.exists()
    again = run_ragdoll(*command, "--json")
    assert again.code == 0, again.stderr
    assert again.json["taken_up"] > 0
    assert titles(output) == [line.split()[1] for line in SMILES * 5 for _ in range(2)]


def test_a_disk_too_full_for_the_collection_keeps_what_is_done(run_ragdoll, smiles, tmp_path):
    path, output = smiles(SMILES * 2), tmp_path / "out.h5"
    command = ["conformers", path, "-o", output, "-n", 2, "--quiet"]
    run = run_ragdoll(*command, before=FULL_DISK.format(size=60_000))
    assert run.code == 1
    assert "cannot be written" in run.sentence
    assert not output.exists()
    again = run_ragdoll(*command, "--json")
    assert again.code == 0, again.stderr
    assert again.json["taken_up"] == 8
    assert len(ragdoll.molecule_names(output)) == 8


# ----------------------------------------------------------------------------------------- outputs


def test_many_molecules_in_hdf5_are_groups_laid_out_as_trajectories(run_ragdoll, smiles, tmp_path):
    path, output = smiles([*SMILES, "bad bad"]), tmp_path / "out.h5"
    run = run_ragdoll("conformers", path, "-o", output, "-n", 3, "--seed", 4)
    assert run.code == 3
    names = ragdoll.molecule_names(output)
    assert names == ["0000001", "0000002", "0000003", "0000004"]
    with ragdoll.open_trajectory(output, names[1]) as trajectory:
        assert trajectory.positions.shape == (3, 21, 3)
        assert trajectory.attributes["title"] == "amide"
        assert trajectory.attributes["seed"] == record_seed(4, 1)
        assert trajectory.attributes["version"] == ragdoll.__version__
        assert trajectory.observables["energy"].shape == (3,)
        assert trajectory.topology.getNumBonds() == 20
        mol = Chem.MolFromMolBlock(trajectory.texts["mol_block"], removeHs=False)
        lengths = np.linalg.norm(
            trajectory.positions[:, trajectory.bonds[:, 0]]
            - trajectory.positions[:, trajectory.bonds[:, 1]],
            axis=-1,
        )
        start = places(mol) / 10
        expected = np.linalg.norm(
            start[trajectory.bonds[:, 0]] - start[trajectory.bonds[:, 1]], axis=-1
        )
        assert np.abs(lengths - expected).max() < 2e-3
    with h5py.File(output) as file:
        about = file["ragdoll"]
        assert about.attrs["seed"] == 4
        parameters = json.loads(about["parameters"][()])
        assert parameters["count"] == 3
        assert len(about.attrs["input_hash"]) == 64
        group = file["molecules/0000001"]
        assert group["particles/trajectory/position/value"] == group["coordinates"]
    with pytest.raises(ragdoll.TrajectoryError, match="holds many molecules"):
        ragdoll.open_trajectory(output)
    with pytest.raises(ragdoll.TrajectoryError, match="no molecule 9"):
        ragdoll.open_trajectory(output, "9")


def test_one_molecule_in_hdf5_is_a_trajectory(run_ragdoll, smiles, tmp_path):
    path, output = smiles(SMILES[1:2]), tmp_path / "out.h5"
    run = run_ragdoll("conformers", path, "-o", output, "-n", 3)
    assert run.code == 0, run.stderr
    assert ragdoll.molecule_names(output) == []
    loaded = mdtraj.load(output)
    assert (loaded.n_frames, loaded.n_atoms) == (3, 21)
    report = ragdoll.quality(output).as_dict()
    assert report["frames"] == 3
    with ragdoll.open_trajectory(output) as trajectory:
        assert trajectory.parameters["count"] == 3
        assert len(trajectory.framework["bars"]) > 20


def test_large_molecules_are_written_as_v3000(tmp_path):
    from ragdoll.batch.conforming import MadeConformers
    from ragdoll.batch.records import Record
    from ragdoll.batch.sd_output import sd_records

    mol = Chem.MolFromSmiles("C" * 1001)
    conformer = Chem.Conformer(1001)
    conformer.Set3D(True)
    conformer.SetPositions(np.arange(3003.0).reshape(1001, 3))
    mol.AddConformer(conformer)
    data = sd_records(Record(0, 1, "smiles", "long", ""), MadeConformers(mol, np.zeros(1), "x"), {})
    assert b"V3000" in data
    (tmp_path / "out.sdf").write_bytes(data)
    (read,) = molecules(tmp_path / "out.sdf")
    assert read.GetNumAtoms() == 1001
    assert read.GetProp("_Name") == "long"


def test_minimised_conformers_carry_their_energies(run_ragdoll, smiles, tmp_path):
    path, output = smiles(["CCCCO a"]), tmp_path / "out.sdf"
    run = run_ragdoll(
        *("conformers", path, "-o", output, "-n", 20, "--minimize", "mmff94s", "--json"),
        *("--energy-window-kcal", 3, "--rmsd-prune-angstrom", 0.2),
    )
    assert run.code == 3
    found = molecules(output)
    relative = [float(mol.GetProp("ragdoll_relative_energy_kcal_mol")) for mol in found]
    assert relative == sorted(relative)
    assert relative[0] == 0 and relative[-1] <= 3
    assert {mol.GetProp("ragdoll_energy_by") for mol in found} == {"MMFF94s"}
    assert len(found) == run.json["conformers"] < 20


@pytest.mark.parametrize("kind", ["sdf", "h5"])
def test_configurations_that_are_left_open_can_all_be_made(run_ragdoll, smiles, tmp_path, kind):
    path, output = smiles(["CC(O)C(F)Cl open", "C[C@H](O)F given"]), tmp_path / f"out.{kind}"
    run = run_ragdoll(*("conformers", path, "-o", output, "-n", 2, "--stereo-isomers", 8, "--json"))
    assert run.code == 0, run.stderr
    assert (run.json["molecules"], run.json["conformers"]) == (2, 10)
    if kind == "h5":
        found = []
        for name in ragdoll.molecule_names(output):
            with ragdoll.open_trajectory(output, name) as trajectory:
                found += 2 * [(trajectory.attributes["title"], trajectory.attributes["smiles"])]
    else:
        found = [
            (mol.GetProp("_Name"), Chem.MolToSmiles(Chem.RemoveHs(mol)))
            for mol in molecules(output)
        ]
    assert [title for title, _ in found] == 8 * ["open"] + 2 * ["given"]
    assert found[0::2] == found[1::2]
    assert len({smiles_ for title, smiles_ in found if title == "open"}) == 4


def test_conformers_start_from_the_input_where_it_has_them(run_ragdoll, tmp_path):
    records = []
    for smiles_, title in (("CCCCO", "one"), ("CC(C)CC(=O)NC", "two")):
        mol = Chem.AddHs(Chem.MolFromSmiles(smiles_))
        rdDistGeom.EmbedMolecule(mol, randomSeed=9)
        mol = Chem.RemoveHs(mol) if title == "two" else mol  # as crystal structures are
        mol.SetProp("_Name", title)
        records.append(Chem.MolToMolBlock(mol) + f"> <tag>\n{title} tag\n\n$$$$\n")
    (tmp_path / "in.sdf").write_text("".join(records))
    for start in ("input", "embed"):
        run = run_ragdoll(
            *("conformers", tmp_path / "in.sdf", "-o", tmp_path / f"{start}.sdf"),
            *("-n", 2, "--start", start),
        )
        assert run.code == 0, run.stderr
    given = molecules(tmp_path / "in.sdf")
    found = {start: molecules(tmp_path / f"{start}.sdf") for start in ("input", "embed")}
    assert [mol.GetProp("tag") for mol in found["input"]] == 2 * ["one tag"] + 2 * ["two tag"]
    assert found["input"][2].GetNumAtoms() == 21
    for k, mol in enumerate(given):
        for start, same in (("input", True), ("embed", False)):
            pairs = [(b.GetBeginAtomIdx(), b.GetEndAtomIdx()) for b in mol.GetBonds()]
            first, second = np.array(pairs).T
            old, new = places(mol), places(found[start][2 * k])
            off = np.linalg.norm(old[first] - old[second], axis=1) - np.linalg.norm(
                new[first] - new[second], axis=1
            )
            assert (np.abs(off).max() < 2e-3) == same


# ---------------------------------------------------------------------------------------- refusals


def test_what_cannot_be_used_is_refused_in_a_sentence(run_many, smiles, tmp_path):
    path = smiles(SMILES)
    (tmp_path / "empty.smi").write_text("")
    (tmp_path / "blank.smi").write_text("\n\n# nothing\n")
    (tmp_path / "folder.sdf").mkdir()
    (tmp_path / "paper.sdf").write_bytes(b"%PDF-1.7\n1 0 obj\n<< >>\n" * 50)
    (tmp_path / "there.sdf").write_text("mine")
    out = tmp_path / "out.sdf"
    cases = [
        ([path, "-o", out, "-n", 0], "--count"),
        ([path, "-o", out, "-n", -5], "--count"),
        ([path, "-o", out, "--rmsd-prune-angstrom", "nan"], "--rmsd-prune-angstrom"),
        ([path, "-o", out, "--rmsd-prune-angstrom", -1], "--rmsd-prune-angstrom"),
        ([path, "-o", out, "--energy-window-kcal", "nan"], "--energy-window-kcal"),
        ([path, "-o", out, "--minimize", "amber"], "--minimize"),
        ([path, "-o", out, "--start", "crystal"], "--start"),
        ([path, "-o", out, "--workers", 0], "--workers"),
        ([path, "-o", out, "--stereo-isomers", -1], "--stereo-isomers"),
        ([path, "-o", out, "--seconds-per-molecule", 0], "--seconds-per-molecule"),
        ([path, "-o", out, "--seed", -1], "--seed"),
        ([path, "-o", tmp_path / "out.xyz"], "tells no format"),
        ([path, "-o", tmp_path / "there.sdf"], "exists already"),
        ([path, "-o", tmp_path / "folder.sdf"], "is a folder"),
        ([path, "-o", tmp_path / "none" / "out.sdf"], "no folder"),
        ([path, "-o", "/proc/out.sdf"], "cannot be written"),
        ([path, "-o", out, "--report", path], "is the input"),
        ([tmp_path / "none.smi", "-o", out], "There is no file"),
        ([tmp_path / "folder.sdf", "-o", out], "is a folder"),
        ([tmp_path / "empty.smi", "-o", out], "is empty"),
        ([tmp_path / "blank.smi", "-o", out], "holds no molecules"),
        ([tmp_path / "paper.sdf", "-o", out], "is no text"),
        ([tmp_path / "there.sdf", "-o", out], "is no SD file"),
    ]
    before = sorted(os.listdir(tmp_path))
    for (_, words), run in zip(
        cases, run_many([["conformers", *case] for case, _ in cases]), strict=True
    ):
        assert run.code in (1, 2), (words, run)
        assert words in run.sentence
    assert (tmp_path / "there.sdf").read_text() == "mine"
    assert sorted(os.listdir(tmp_path)) == before


def test_force_replaces_an_output(run_ragdoll, smiles, tmp_path):
    (tmp_path / "out.sdf").write_text("old")
    run = run_ragdoll("conformers", smiles(SMILES), "-o", tmp_path / "out.sdf", "-n", 1, "--force")
    assert run.code == 0, run.stderr
    assert len(molecules(tmp_path / "out.sdf")) == 4
