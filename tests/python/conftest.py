"""What the tests of the command line share."""

import importlib.util
import json
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest
from openmm import app

ROOT = Path(__file__).resolve().parents[2]
DATA = Path(os.environ.get("RAGDOLL_DATA", ROOT.parent / "shared" / "data"))
_MAIN = "from ragdoll.cli import main; main()"


@dataclass
class Run:
    """A command that has ended."""

    code: int
    stdout: str
    stderr: str

    @property
    def sentence(self) -> str:
        """The one line that says what went wrong; checks that there is one and no traceback."""
        assert "Traceback" not in self.stderr
        lines = [line for line in self.stderr.splitlines() if line.startswith("ragdoll: ")]
        assert len(lines) == 1, self.stderr
        assert self.stderr.splitlines()[-1] == lines[0]
        assert lines[0].endswith(".")
        return lines[0].removeprefix("ragdoll: ")

    @property
    def json(self) -> dict:
        """The one object on standard output; NaN and infinity are no JSON."""

        def refuse(text):
            raise ValueError(f"{text} is no JSON")

        return json.loads(self.stdout, parse_constant=refuse)


def ragdoll_command(*arguments, before: str = "") -> list[str]:
    """The command line of ``ragdoll``; ``before`` is Python code to run ahead of it."""
    return [sys.executable, "-c", f"{before}\n{_MAIN}", *map(str, arguments)]


@pytest.fixture(scope="session")
def run_ragdoll():
    """Run ``ragdoll`` with these arguments, to its end."""

    def run(*arguments, before: str = "", **options) -> Run:
        options = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **options}
        ended = subprocess.run(
            ragdoll_command(*arguments, before=before), text=True, timeout=300, **options
        )
        return Run(ended.returncode, ended.stdout or "", ended.stderr or "")

    return run


_MANY = """
import json, os, sys
import ragdoll._trajectory, ragdoll.cli, ragdoll.picture

try:
    from pydantic import TypeAdapter  # typer loads it late

    TypeAdapter(int)
except ImportError:
    pass

ragdoll.cli._make_app()  # loads the commands

for number, arguments in enumerate(json.load(open("commands.json"))):
    child = os.fork()
    if child == 0:
        for stream, name in ((1, "stdout"), (2, "stderr")):
            os.dup2(os.open(f"{number}.{name}", os.O_WRONLY | os.O_CREAT), stream)
        sys.argv = ["ragdoll", *arguments]
        try:
            ragdoll.cli.main()
        except SystemExit as end:
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(end.code)  # spares the child Python's own end
    print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
"""


@pytest.fixture(scope="session")
def run_many(tmp_path_factory):
    """Run ``ragdoll`` with each of these lists of arguments; Python's modules load only once."""

    def run(commands) -> list[Run]:
        folder = tmp_path_factory.mktemp("many")
        commands = [[str(argument) for argument in command] for command in commands]
        (folder / "commands.json").write_text(json.dumps(commands))
        codes = subprocess.run(
            [sys.executable, "-c", _MANY], cwd=folder, capture_output=True, text=True, check=True
        ).stdout.split()
        return [
            Run(
                int(code),
                (folder / f"{number}.stdout").read_text(),
                (folder / f"{number}.stderr").read_text(),
            )
            for number, code in enumerate(codes)
        ]

    return run


@pytest.fixture(scope="session")
def start_ragdoll():
    """Start ``ragdoll`` with these arguments; what still runs at the end is killed."""
    started = []

    def start(*arguments, before: str = "", **options) -> subprocess.Popen:
        options = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **options}
        started.append(
            subprocess.Popen(ragdoll_command(*arguments, before=before), text=True, **options)
        )
        return started[-1]

    yield start
    for process in started:
        if process.poll() is None:
            process.kill()
            process.communicate()


@pytest.fixture(scope="session")
def villin() -> Path:
    """The villin headpiece in water that the OpenMM wheel carries."""
    return Path(app.__file__).parent / "data" / "test.pdb"


@pytest.fixture(scope="session")
def dry_villin(villin, tmp_path_factory) -> Path:
    """The 582 atoms of villin alone, which are read faster."""
    path = tmp_path_factory.mktemp("dry") / "villin.pdb"
    lines = [line for line in villin.read_text().splitlines() if line.startswith("ATOM")]
    path.write_text("\n".join(lines[:582]) + "\n")
    return path


@pytest.fixture(scope="session")
def proteins() -> Path:
    """The folder of protein files."""
    if not (DATA / "proteins").is_dir():
        pytest.skip("no protein files; set RAGDOLL_DATA to the folder that holds proteins/")
    return DATA / "proteins"


@pytest.fixture(scope="session")
def recompute():
    """tests/validation/recompute.py, which measures a file without ragdoll's code."""
    path = ROOT / "tests" / "validation" / "recompute.py"
    spec = importlib.util.spec_from_file_location("recompute", path)
    module = importlib.util.module_from_spec(spec)
    sys.modules["recompute"] = module
    spec.loader.exec_module(module)
    return module


@dataclass
class SampledVillin:
    """Villin sampled by the command line: the file and what the command said."""

    path: Path
    report: dict


@pytest.fixture(scope="session")
def sampled_villin(run_ragdoll, villin, tmp_path_factory) -> SampledVillin:
    """20 frames of villin by random moves and seed 7, the rest as by default."""
    path = tmp_path_factory.mktemp("sampled") / "villin.h5"
    random = ("--perturbation", "gaussian")
    run = run_ragdoll("sample", villin, "-o", path, "--frames", 20, "--seed", 7, "--json", *random)
    assert run.code == 0, run.stderr
    return SampledVillin(path, run.json)
