"""The C++ program `benchmark`: built once, run with a command, its records read."""

import json
import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BUILD = ROOT / "build" / "benchmarks"

Records = list[dict]


@cache
def program() -> Path:
    """Build `benchmark`, Release and core only; CMake knows whether there is anything to do."""
    options = dict.fromkeys(("TESTS", "OPENMM", "TRAJECTORY", "METHOD_FILES", "PYTHON"), "OFF")
    configure = ["cmake", "-S", str(ROOT), "-B", str(BUILD), "-DCMAKE_BUILD_TYPE=Release"]
    configure += [f"-DRAGDOLL_BUILD_{name}={value}" for name, value in options.items()]
    configure += ["-DRAGDOLL_BUILD_BENCHMARKS=ON"]
    build = ["cmake", "--build", str(BUILD), "--parallel", "2", "--target", "benchmark"]
    for command in (configure, build):
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            sys.exit(f"benchmarks/run: `benchmark` could not be built.\n{done.stdout}{done.stderr}")
    return BUILD / "benchmarks" / "benchmark"


def run(*words: object) -> Records:
    """Records that a command prints."""
    command = [str(program()), *map(str, words)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"benchmarks/run: {' '.join(command)}: {done.stderr.strip() or done.returncode}")
    return [json.loads(line) for line in done.stdout.splitlines()]


def instructions(*words: object) -> tuple[int, Records]:
    """Instructions that callgrind counts while a command runs, and the command's records."""
    valgrind = shutil.which("valgrind")
    assert valgrind is not None, "the caller looks for valgrind"
    command = [valgrind, "--tool=callgrind", "--callgrind-out-file=/dev/null"]
    command += [str(program()), *map(str, words)]
    done = subprocess.run(command, capture_output=True, text=True)
    counts = [line for line in done.stderr.splitlines() if "Collected :" in line]
    if done.returncode or not counts:
        sys.exit(f"benchmarks/run: {' '.join(command)}: {done.stderr.strip()}")
    records = [json.loads(line) for line in done.stdout.splitlines()]
    return int(counts[0].split(":")[1]), records
