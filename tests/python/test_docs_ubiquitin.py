"""The page on ubiquitin: its commands and scripts run, and leave what the page says."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

PAGE = Path(__file__).resolve().parents[2] / "docs" / "ubiquitin.md"
_MAIN = "from ragdoll.cli import main; main()"


def _blocks():
    """Code of the page in its order: (language, text)."""
    return re.findall(r"```(sh|python)\n(.*?)```", PAGE.read_text(), flags=re.DOTALL)


@pytest.fixture(scope="module")
def said(proteins, tmp_path_factory):
    """What each block prints, run one after the other in one folder; few frames are enough."""
    folder = tmp_path_factory.mktemp("ubiquitin")
    shutil.copy(proteins / "1ubq.pdb", folder)
    outputs = []
    for language, text in _blocks():
        if language == "python":
            commands = [[sys.executable, "-c", text]]
        else:
            words = [line.split() for line in text.splitlines()]
            assert all(word[0] == "ragdoll" for word in words)
            commands = [[sys.executable, "-c", _MAIN, *word[1:]] for word in words]
        for command in commands:
            command = ["3" if part == "30" else part for part in command]  # frames
            ended = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300)
            assert ended.returncode == 0, (text, ended.stderr)
            outputs.append(ended.stdout)
    return folder, "\n".join(outputs)


def test_all_code_of_the_page_runs_and_leaves_its_files(said):
    folder, _ = said
    left = {path.name for path in folder.iterdir()}
    assert {"ubiquitin.pdb", "clusters.png", "clusters.pml", "dilution.png"} <= left
    assert {"ubiquitin.h5", "ubiquitin.png", "short.h5"} <= left


def test_what_the_page_shows_of_prepare_is_what_it_prints(said):
    shown = re.search(r"```\n(Found:.*?)```", PAGE.read_text(), flags=re.DOTALL)[1]
    for line in shown.splitlines():
        assert line in said[1]


def test_the_scripts_print_what_they_promise(said):
    assert "RMSF of residues 1-70" in said[1]
    assert "floppy modes" in said[1]
    assert "4 frames" in said[1]


def test_every_picture_of_the_page_exists():
    for path in re.findall(r"!\[[^]]*\]\(([^)]+)\)", PAGE.read_text()):
        assert (PAGE.parent / path).is_file(), path
