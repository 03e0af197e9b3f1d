"""Samples every protein of the data folder and measures the frames anew: a slow validation.

    python tests/validation/run_proteins.py [--frames 200] [--seed 7] [FILES]

The measurement (recompute.py) uses nothing of ragdoll. The data folder is what RAGDOLL_DATA names,
else ../shared/data beside the repository. Exit code 1 if a protein fails.
"""

import argparse
import gzip
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import gemmi
import mdtraj
import numpy as np
import recompute
from scipy.spatial import cKDTree

_HERE = Path(__file__).resolve()
_DATA = Path(os.environ.get("RAGDOLL_DATA", _HERE.parents[3] / "shared" / "data"))
_TRACES = {"2k39_ca.pdb", "hivp_ca.pdb"}  # CA only: refused
_BIG = {"1gr5.pdb.gz", "1gru.pdb.gz"}  # for size and speed, not for geometry
_COMMAND = "import sys; from ragdoll.cli import main; sys.exit(main())"
_HEADER = (
    f"{'file':20s} {'atoms':>6s} {'rejected':>11s} {'share':>6s} {'bond':>7s} {'omega':>6s} "
    f"{'centres':>7s} {'inv':>3s} {'viol':>4s} {'worst':>6s} {'RMSD 1st':>8s} {'last':>6s} "
    f"{'fr/s':>7s} {'wall s':>6s}  verdict"
)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=200)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("files", nargs="*", type=Path, help="default: all of the data folder")
    arguments = parser.parse_args()
    files = arguments.files or sorted(
        path
        for path in (_DATA / "proteins").glob("*")
        if path.name.removesuffix(".gz").endswith((".pdb", ".cif"))
    )
    if not files:
        print(f"There are no proteins in {_DATA}; set RAGDOLL_DATA to the data folder.")
        return 1
    print(_HEADER, flush=True)
    failed = []
    for path in files:
        with tempfile.TemporaryDirectory() as folder:
            faults, row = check(path, Path(folder) / "out.h5", arguments.frames, arguments.seed)
        print(f"{path.name:20s} {row}  {'; '.join(faults) or 'good'}", flush=True)
        if faults:
            failed.append(path.name)
    words = f"FAILED: {', '.join(failed)}" if failed else "all good"
    print(f"{len(files)} files, {arguments.frames} frames each, seed {arguments.seed}: {words}")
    return 1 if failed else 0


def check(path: Path, output: Path, frames: int, seed: int) -> tuple[list[str], str]:
    """What is wrong with one protein, and its row of the table."""
    start = time.perf_counter()
    run = subprocess.run(
        [sys.executable, "-c", _COMMAND, "sample", str(path), "-o", str(output), "--json"]
        + ["--frames", str(frames), "--seed", str(seed)],
        capture_output=True,
        text=True,
    )
    wall = time.perf_counter() - start
    if path.name in _TRACES:
        good = run.returncode == 2 and "CA" in run.stderr and not output.exists()
        return [] if good else [f"exit {run.returncode}, not refused"], "refused"
    last = (run.stderr.strip().splitlines() or ["no message"])[-1]
    if not output.exists():
        return [f"exit {run.returncode}: {last}"], "no output"
    said = json.loads(run.stdout)
    sampled = recompute.read(output)
    measured = recompute.measure(sampled)
    faults = _faults(measured, said, frames, geometry_counts=path.name not in _BIG)
    if run.returncode != 0:
        faults.append(f"exit {run.returncode}: {last}")
    if "Traceback" in run.stderr:
        faults.append("traceback")
    if not _same_input(path, sampled):
        faults.append("input positions are not the file's")
    loaded = mdtraj.load_frame(str(output), len(sampled.frames) - 1)
    if np.abs(loaded.xyz[0] - sampled.frames[-1]).max() > 1e-6:
        faults.append("mdtraj reads other positions")
    share = said["rejected_steps"] / said["steps"]
    rejected = f"{said['rejected_steps']}/{said['steps']}"
    row = (
        f"{said['atoms']:6d} {rejected:>11s} {100 * share:5.2f}% "
        f"{measured.bond_max_relative:7.5f} {measured.omega_max:6.2f} {measured.centres:7d} "
        f"{measured.inverted:3d} {measured.contact_violations:4d} {measured.contact_worst:6.4f} "
        f"{measured.rmsd[0]:8.3f} {measured.rmsd[-1]:6.3f} {said['frames_per_second']:7.2f} "
        f"{wall:6.1f}"
    )
    return faults, row


def _faults(measured, said: dict, frames: int, geometry_counts: bool) -> list[str]:
    geometry = said["geometry"]
    tenth = max(1, len(measured.rmsd) // 10)
    growth = measured.rmsd[-tenth:].mean() - measured.rmsd[:tenth].mean()
    judged = {
        "rejected above 1 %": said["rejected_steps"] > 0.01 * said["steps"],
        "bond": measured.bond_max_relative > 0.01,
        "omega": measured.omega_max > 15,
        "chirality": measured.inverted > 0 or geometry["chirality_inverted"] > 0,
        "contacts": measured.contact_violations > 0,
        "RMSD does not grow": frames > 1 and growth <= 0,
    }
    agreed = {
        "frames": measured.frames == said["frames"] == frames,
        "bond_max_relative": _near(geometry["bond_max_relative"], measured.bond_max_relative, 1e-7),
        "omega": _near(geometry["omega_max_deviation_degree"], measured.omega_max_all, 1e-3),
        "contact_violations": geometry["contact_violations"] == measured.contact_violations,
        "contact_worst": _near(geometry["contact_worst_angstrom"], measured.contact_worst, 1e-5),
        "rmsd_last": _near(geometry["rmsd_last_angstrom"], measured.rmsd[-1], 1e-4),
        "rmsd_max": _near(geometry["rmsd_max_angstrom"], measured.rmsd.max(), 1e-4),
    }
    faults = [name for name, bad in judged.items() if bad] if geometry_counts else []
    return faults + [f"JSON says another {name}" for name, same in agreed.items() if not same]


def _near(said: float, measured: float, allowed: float) -> bool:
    return abs(said - measured) <= allowed


def _same_input(path: Path, sampled: recompute.Sampled) -> bool:
    """Whether every atom began where the structure file has one."""
    if path.name.removesuffix(".gz").endswith(".cif"):
        model = gemmi.read_structure(str(path))[0]
        places = [cra.atom.pos.tolist() for cra in model.all()]
    else:
        with (gzip.open if path.suffix == ".gz" else open)(path, "rt", encoding="latin-1") as file:
            places = [
                [float(line[column : column + 8]) for column in (30, 38, 46)]
                for line in file
                if line.startswith(("ATOM", "HETATM"))
            ]
    return bool(cKDTree(np.array(places) / 10).query(sampled.start)[0].max() < 1e-5)


if __name__ == "__main__":
    sys.exit(main())
