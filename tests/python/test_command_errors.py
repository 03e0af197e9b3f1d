"""The command line in bad weather: always one sentence, the right exit code, and no stray file."""

import gzip
import os
import pty
import resource
import shutil
import signal
import time
from dataclasses import dataclass
from pathlib import Path

import pytest

mdtraj = pytest.importorskip("mdtraj")

# segments many times a second, as long runs have them
SHORT_SEGMENTS = """
from ragdoll.trajectory import TrajectoryWriter
def shortened(self, *arguments, made=TrajectoryWriter.__init__, **options):
    made(self, *arguments, **options, segment_seconds=0.02)
TrajectoryWriter.__init__ = shortened
"""


@pytest.fixture
def folder(tmp_path):
    """An empty folder for outputs."""
    made = tmp_path / "outputs"
    made.mkdir()
    return made


@pytest.fixture(scope="module")
def protein_lines(villin):
    lines = villin.read_text().splitlines()
    return [line for line in lines if line.startswith("ATOM")][:582]


@dataclass
class Refusal:
    """A command line that must end with exit code 2 and these words, and write nothing."""

    arguments: list
    words: str


def with_x(line, text):
    return line[:30] + text.rjust(8) + line[38:]


def files_of(folder):
    return sorted(path.name for path in folder.iterdir())


# ------------------------------------------------------------------------------------------ input


BAD_FILES = {
    "empty": (b"", "is empty"),
    "blank": (b"\n \n", "is empty"),
    "zeros": (bytes(1000), "binary"),
    "noise": (bytes((i * i * 31 + i) % 255 + 1 for i in range(5000)), "contains no atoms"),
    "prose": (b"hello\n", "contains no atoms"),
    "without atoms": (b"REMARK   1 NOTHING\nEND\n", "contains no atoms"),
    "other encoding": ("ATOM".encode("utf-16") * 99, "binary"),
    "broken cif": (b"data_x\nloop_\n_atom_site.id\n_atom_site.Cartn_x\n1 2 3\n", "valid mmCIF"),
    "empty cif": (b"data_x\n", "no atom coordinates"),
}
BAD_COORDINATES = ["nan", "inf", "-inf", "1e308", "abc", ""]


def bad_files(folder, villin, protein_lines):
    """Files that are no molecule, with words of the refusal, by name."""
    found = {name: (content, words, "bad.pdb") for name, (content, words) in BAD_FILES.items()}
    for text in BAD_COORDINATES:
        lines = [*protein_lines[:4], with_x(protein_lines[4], text), *protein_lines[5:]]
        found[f"coordinate {text}"] = (lines, "line 5", "bad.pdb")
    lines = protein_lines.copy()
    lines[5] = lines[5][:30] + lines[4][30:54] + lines[5][54:]
    found["two atoms at one place"] = (lines, "at one place", "bad.pdb")
    trace = [line for line in protein_lines if line[12:16] == " CA "]
    found["only alpha carbons"] = (trace, "only the CA atom", "bad.pdb")
    water = [line for line in villin.read_text().splitlines() if "HOH" in line][:30]
    found["only water"] = (water, "only water", "bad.pdb")
    cut = [*protein_lines[:4], protein_lines[4][:40], *protein_lines[5:]]
    found["cut atom line"] = (cut, "line 5", "bad.pdb")
    found["gz that is none"] = (protein_lines, "not gzipped", "bad.pdb.gz")
    damaged = gzip.compress(villin.read_bytes())[:5000]
    found["gz that is cut"] = (damaged, "damaged gzip", "bad.pdb.gz")
    refusals = {}
    for number, (name, (content, words, file)) in enumerate(found.items()):
        (folder / str(number)).mkdir()
        path = folder / str(number) / file
        path.write_bytes(content if isinstance(content, bytes) else "\n".join(content).encode())
        refusals[name] = Refusal([path], words)
    refusals["missing"] = Refusal([folder / "none.pdb"], "does not exist")
    refusals["directory"] = Refusal([folder], "is a directory")
    return refusals


FILE_NAMES = [
    *BAD_FILES,
    *(f"coordinate {text}" for text in BAD_COORDINATES),
    *["two atoms at one place", "only alpha carbons", "only water", "cut atom line"],
    *["gz that is none", "gz that is cut", "missing", "directory"],
]


@pytest.fixture(scope="module")
def refusals(run_many, villin, dry_villin, protein_lines, tmp_path_factory):
    """All command lines that must be refused, run; (Run, Refusal, folder of the output) by name."""
    files = bad_files(tmp_path_factory.mktemp("bad"), villin, protein_lines)
    options = {text: Refusal([dry_villin, *text.split()], words) for text, words in BAD_OPTIONS}
    asked = files | options
    folders = [tmp_path_factory.mktemp("refused") for _ in asked]
    runs = run_many(
        ["sample", "-o", folder / "a.h5", "--json", *refusal.arguments]
        for folder, refusal in zip(folders, asked.values(), strict=True)
    )
    return dict(zip(asked, zip(runs, asked.values(), folders, strict=True), strict=True))


def check_refused(run, refusal, folder):
    assert run.code == 2
    assert refusal.words in run.sentence
    assert run.stdout == ""
    assert list(folder.iterdir()) == []


@pytest.mark.parametrize("name", FILE_NAMES)
def test_a_file_that_is_no_molecule_is_refused(refusals, name):
    check_refused(*refusals[name])


def test_a_file_cut_within_its_last_line_is_sampled_without_that_atom(
    run_ragdoll, folder, tmp_path, protein_lines
):
    path = tmp_path / "cut.pdb"
    path.write_text("\n".join([*protein_lines[:300], protein_lines[300][:40]]))
    run = run_ragdoll(
        *["sample", path, "-o", folder / "a.h5", "--frames", 1, "--stride", 1, "--json"]
    )
    assert run.code == 0
    assert run.json["atoms"] == 300
    assert "line 301" in run.stderr


# ---------------------------------------------------------------------------------------- options

BAD_OPTIONS = [
    ("--order foo", "order 'foo' is not known"),
    ("--order bfs_tree", "choose bfs_cycle"),
    ("--weighting .5/.6", "add to 1"),
    ("--weighting nan/nan", "add to 1"),
    ("--solver foo", "solver 'foo' is not known"),
    ("--perturbation foo", "perturbation 'foo' is not known"),
    ("--perturbation none", "gaussian or ball"),
    ("--platform foo", "Reference or CPU"),
    ("--tolerance 0", "--tolerance"),
    ("--tolerance -1", "--tolerance"),
    ("--tolerance nan", "--tolerance"),
    ("--tolerance inf", "--tolerance"),
    ("--tolerance abc", "--tolerance"),
    ("--frames 0", "--frames"),
    ("--frames -3", "--frames"),
    ("--frames 99999999999999", "--frames"),
    ("--stride 0", "--stride"),
    ("--step-angstrom nan", "--step-angstrom"),
    ("--step-angstrom 1e300", "--step-angstrom"),
    ("--max-iterations 0", "--max-iterations"),
    ("--seed -1", "--seed"),
    ("--seed 99999999999", "--seed"),
    ("--contact-scale nan", "contact scale"),
    ("--planarity-degree 0", "planarity"),
    ("--ph nan", "--ph"),
    ("--model 2", "no model 2"),
    ("--chain Z", "no chain"),
    ("--nonsense", "No such option"),
]


@pytest.mark.parametrize("options", [text for text, _ in BAD_OPTIONS])
def test_an_option_that_makes_no_sense_is_refused(refusals, options):
    check_refused(*refusals[options])


def test_a_command_that_lacks_something_is_refused(run_many):
    lacking = {
        "Give a command": [],
        "No such command 'foo'": ["foo"],
        "Missing argument": ["sample"],
        "Missing option '--output'": ["sample", "a.pdb"],
        "unexpected extra argument": ["sample", "a.pdb", "b.pdb", "-o", "c.h5"],
    }
    for words, run in zip(lacking, run_many(lacking.values()), strict=True):
        assert run.code == 2
        assert words in run.sentence


# ----------------------------------------------------------------------------------------- output


def test_an_existing_output_is_kept_unless_forced(run_ragdoll, dry_villin, folder):
    output = folder / "a.h5"
    output.write_text("precious")
    arguments = ["sample", dry_villin, "-o", output, "--frames", 1, "--stride", 1, "--json"]
    run = run_ragdoll(*arguments)
    assert run.code == 2
    assert "--force" in run.sentence
    assert output.read_text() == "precious"
    assert run_ragdoll(*arguments, "--force").code == 0
    assert files_of(folder) == ["a.h5"]
    assert mdtraj.load(str(output)).n_frames == 1


@pytest.mark.parametrize("link", [None, os.symlink, os.link])
def test_the_input_is_never_replaced(run_ragdoll, folder, protein_lines, link):
    source = folder / "in.pdb"
    source.write_text("\n".join(protein_lines))
    output = source
    if link is not None:
        output = folder / "out.h5"
        link(source, output)
    run = run_ragdoll("sample", source, "-o", output, "--force")
    assert run.code == 2
    assert "is the input" in run.sentence
    assert source.read_text() == "\n".join(protein_lines)


def test_a_missing_folder_a_folder_and_a_device_are_refused(run_many, dry_villin, folder):
    places = {
        "there is no folder": folder / "none" / "a.h5",
        "is a folder": folder,
        "not a regular file": "/dev/null",
        "is not a folder": dry_villin / "a.h5",
    }
    runs = run_many(["sample", dry_villin, "-o", place] for place in places.values())
    for words, run in zip(places, runs, strict=True):
        assert run.code == 2
        assert words in run.sentence
    assert files_of(folder) == []


def test_a_folder_that_cannot_be_written_is_refused(run_ragdoll, dry_villin, tmp_path):
    locked = tmp_path / "locked"
    locked.mkdir(mode=0o555)
    if os.geteuid() == 0 and shutil.which("setpriv") is None:
        pytest.skip("root may write everywhere, and setpriv, which takes that away, is missing")
    # root without its capabilities is a normal user
    script = tmp_path / "unprivileged"
    words = "setpriv --bounding-set=-all --inh-caps=-all"
    script.write_text(f'#!/bin/sh\nexec {words} "$@"\n')
    script.chmod(0o755)
    before = f"""
import os, sys
if os.geteuid() == 0 and os.environ.get("UNPRIVILEGED") is None:
    os.environ["UNPRIVILEGED"] = "1"
    os.execv({str(script)!r}, [{str(script)!r}, *sys.orig_argv])
"""
    run = run_ragdoll("sample", dry_villin, "-o", locked / "a.h5", before=before)
    assert run.code == 2
    assert "Permission denied" in run.sentence
    assert list(locked.iterdir()) == []


# -------------------------------------------------------------------------------------- full disk


def limit_files(kilobytes):
    """What ``ulimit -f`` does."""
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (1024 * kilobytes, 1024 * kilobytes))


def test_a_disk_without_room_ends_in_1_and_leaves_nothing(run_ragdoll, dry_villin, folder):
    arguments = [
        "sample",
        dry_villin,
        "-o",
        folder / "a.h5",
        "--frames",
        20,
        "--stride",
        1,
        "--json",
    ]
    run = run_ragdoll(*arguments, preexec_fn=limit_files(20))
    assert run.code == 1
    assert "cannot be written: File too large" in run.sentence
    assert run.stdout == ""
    assert files_of(folder) == []


def test_a_disk_that_fills_up_keeps_finished_segments_and_names_them(
    run_ragdoll, dry_villin, folder
):
    run = run_ragdoll(
        *["sample", dry_villin, "-o", folder / "a.h5", "--frames", 300, "--stride", 2],
        before=SHORT_SEGMENTS,
        preexec_fn=limit_files(1200),
    )
    assert run.code == 1
    segments = files_of(folder)
    assert segments
    assert f"kept in {folder / segments[0]}" in run.sentence
    assert all(name.startswith("a.0") and name.endswith(".h5") for name in segments)
    frames = sum(mdtraj.load(str(folder / name)).n_frames for name in segments)
    assert f"{frames} of its" in run.sentence


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no /dev/full")
def test_a_full_standard_output_ends_in_1(run_ragdoll, dry_villin, folder):
    with open("/dev/full", "w") as full:
        run = run_ragdoll(
            *["sample", dry_villin, "-o", folder / "a.h5", "--frames", 1, "--stride", 1, "--json"],
            stdout=full,
        )
    assert run.code == 1
    assert "No space left" in run.sentence
    assert files_of(folder) == ["a.h5"]


# ---------------------------------------------------------------------------------- interruptions


def wait_for(condition, seconds=60):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_an_interrupted_run_keeps_its_frames_in_one_file(
    start_ragdoll, villin, folder, number, run_ragdoll
):
    process = start_ragdoll(
        "sample",
        villin,
        "-o",
        folder / "a.h5",
        "--frames",
        100_000,
        "--json",
        before=SHORT_SEGMENTS,
    )
    wait_for(lambda: len(files_of(folder)) >= 2)
    process.send_signal(number)
    stdout, stderr = process.communicate(timeout=60)
    run = type(run_ragdoll("--version"))(process.returncode, stdout, stderr)
    assert run.code == 130
    assert files_of(folder) == ["a.h5"]
    loaded = mdtraj.load(str(folder / "a.h5"))
    assert run.json["frames"] == loaded.n_frames > 0
    assert run.json["interrupted"]
    assert f"{loaded.n_frames} of 100000 frames were written" in run.sentence


def test_an_interruption_while_the_molecule_is_read_leaves_nothing(run_ragdoll, dry_villin, folder):
    before = """
import os, signal
from ragdoll.molecule import Molecule
Molecule.from_file = lambda *a, **k: os.kill(os.getpid(), signal.SIGINT)
"""
    run = run_ragdoll("sample", dry_villin, "-o", folder / "a.h5", "--json", before=before)
    assert run.code == 130
    assert run.sentence == "Interrupted."
    assert run.stdout == ""
    assert files_of(folder) == []


@pytest.mark.parametrize("moment", ["before", "after"])
def test_an_interruption_while_segments_are_merged_completes_the_file(
    run_ragdoll, dry_villin, folder, moment
):
    before = f"""
import os, signal
from ragdoll.trajectory import TrajectoryWriter
def close(self, closed=TrajectoryWriter.close, sent=[]):
    if {moment == "after"}:
        closed(self)
    if not sent:
        sent.append(1)
        os.kill(os.getpid(), signal.SIGTERM)
    closed(self)
TrajectoryWriter.close = close
"""
    run = run_ragdoll(
        *["sample", dry_villin, "-o", folder / "a.h5", "--frames", 200, "--stride", 1, "--json"],
        before=SHORT_SEGMENTS + before,
    )
    assert run.code == 130
    assert "200 of 200 frames" in run.sentence
    assert run.json["frames"] == 200
    assert files_of(folder) == ["a.h5"]
    assert mdtraj.load(str(folder / "a.h5")).n_frames == 200


def test_a_killed_run_leaves_segments_that_open_and_that_force_removes(
    start_ragdoll, run_ragdoll, dry_villin, folder
):
    process = start_ragdoll(
        "sample", dry_villin, "-o", folder / "a.h5", "--frames", 100_000, before=SHORT_SEGMENTS
    )
    wait_for(lambda: len(files_of(folder)) >= 3)
    process.kill()
    process.communicate()
    segments = [name for name in files_of(folder) if not name.endswith(".part")]
    assert all(mdtraj.load(str(folder / name)).n_frames > 0 for name in segments)
    arguments = ["sample", dry_villin, "-o", folder / "a.h5", "--frames", 1, "--stride", 1]
    run = run_ragdoll(*arguments)
    assert run.code == 2
    assert "a.000.h5 is left from an interrupted run" in run.sentence
    assert run_ragdoll(*arguments, "--force").code == 0
    assert files_of(folder) == ["a.h5"]


# ---------------------------------------------------------------------------------------- streams


@pytest.mark.parametrize("arguments", [["info"], ["info", "--json"], ["--help"]])
def test_a_reader_that_goes_away_ends_nothing(start_ragdoll, arguments):
    process = start_ragdoll(*arguments)
    process.stdout.close()
    stderr = process.stderr.read()
    assert process.wait(timeout=60) == 0
    assert stderr == ""


@pytest.mark.parametrize("closed", [1, 2])
def test_a_closed_stream_ends_nothing(run_ragdoll, dry_villin, folder, closed):
    run = run_ragdoll(
        *["sample", dry_villin, "-o", folder / "a.h5", "--frames", 1, "--stride", 1],
        preexec_fn=lambda: os.close(closed),
    )
    assert run.code == 0
    assert files_of(folder) == ["a.h5"]
    assert mdtraj.load(str(folder / "a.h5")).n_frames == 1


def test_an_encoding_without_angstrom_ends_nothing(run_ragdoll, dry_villin, folder):
    run = run_ragdoll(
        *["sample", dry_villin, "-o", folder / "a.h5", "--frames", 1, "--stride", 1],
        env={**os.environ, "PYTHONIOENCODING": "ascii"},
    )
    assert run.code == 0
    assert "RMSD from the input" in run.stdout


def test_a_terminal_sees_progress_and_a_file_does_not(
    start_ragdoll, run_ragdoll, dry_villin, folder
):
    arguments = ["sample", dry_villin, "--frames", 60, "--stride", 5]
    ours, theirs = pty.openpty()
    process = start_ragdoll(*arguments, "-o", folder / "a.h5", stderr=theirs)
    os.close(theirs)
    seen = b""
    while True:
        try:
            read = os.read(ours, 65536)
        except OSError:  # the other end is closed
            break
        if not read:
            break
        seen += read
    os.close(ours)
    stdout, _ = process.communicate(timeout=60)
    assert b"sampling" in seen
    assert b"60" in seen
    assert "frames" in stdout
    run = run_ragdoll(*arguments, "-o", folder / "b.h5")
    assert "sampling" not in run.stderr
    assert "\x1b" not in run.stderr + run.stdout
