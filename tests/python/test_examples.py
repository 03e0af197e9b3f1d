"""The examples run on files that a user gives, and draw their pictures."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
# a C++ example prints; test_cpp_conformers.py builds and runs it
FOLDERS = sorted(
    path.name
    for path in EXAMPLES.iterdir()
    if path.is_dir() and not (path / "CMakeLists.txt").is_file()
)

# script, files, further arguments, and what it prints
RUNS = {
    "hinge": (
        ["1hhp.pdb", "1hvr.pdb"],
        ["--target-chain", "A"],
        r"the RMSD from the end went from 1\.\d+ to 0\.[0-3]",
    ),
    "loop": (["1hhp.pdb"], ["43", "58", "--frames", "2"], r"the rest by 0\.00\d"),
    "complex": (["1hvr.pdb"], ["XK2", "--frames", "2"], r"residues at the ligand"),
    "conformers": ([], ["CC(C)Cc1ccc(cc1)C(C)C(=O)O", "-n", "4"], r"\d conformers; minimised, \d"),
    "ligand_pocket": (
        ["1hvr.pdb"],
        ["--frames", "3"],
        r"fixed ones moved by 0 angstrom(.|\n)*N ILE50 A - O1 XK2263 A: [12]\.\d\d to",
    ),
    "dimer": (["1hvr.pdb"], ["--frames", "2"], r"symmetric: 2 frames"),
}


@pytest.mark.parametrize("name", RUNS)
def test_an_example_runs_on_files_that_are_given(name, proteins, tmp_path):
    files, further, words = RUNS[name]
    picture = tmp_path / "picture.png"
    ended = subprocess.run(
        [
            sys.executable,
            EXAMPLES / name / f"{name}.py",
            *[str(proteins / file) for file in files],
            *further,
            "-o",
            picture,
        ],
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert ended.returncode == 0, ended.stderr
    assert re.search(words, ended.stdout), ended.stdout
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("name", FOLDERS)
def test_every_example_has_a_script_a_page_and_its_picture(name):
    folder = EXAMPLES / name
    page = (folder / "README.md").read_text()
    assert list(folder.glob("*.py"))
    pictures = re.findall(r"!\[[^]]*\]\(([^)]+)\)", page)
    assert pictures
    assert all((folder / path).is_file() for path in pictures)
