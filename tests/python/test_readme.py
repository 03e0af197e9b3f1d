"""The code in the README does what it says."""

import re
import subprocess
import sys
from pathlib import Path

import mdtraj
import pytest

README = Path(__file__).resolve().parents[2] / "README.md"


def _blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", README.read_text(), flags=re.DOTALL)


@pytest.mark.parametrize("code", _blocks("python"))
def test_python_code_runs_and_leaves_its_trajectory(code, tmp_path):
    run = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    assert "iterations" in run.stdout
    trajectory = mdtraj.load(tmp_path / "villin.h5")
    assert trajectory.n_frames == 20
    assert trajectory.n_atoms == 582


def test_there_is_python_code_of_about_ten_lines():
    (code,) = _blocks("python")
    assert len([line for line in code.splitlines() if line.strip()]) < 20


def test_every_folder_of_the_map_exists():
    for folder in re.findall(r"^\| `([a-z/_]+)` \|", README.read_text(), flags=re.MULTILINE):
        assert (README.parent / folder).is_dir(), folder


def test_every_picture_exists():
    for path in re.findall(r"!\[[^]]*\]\(([^)]+)\)", README.read_text()):
        assert (README.parent / path).is_file(), path
