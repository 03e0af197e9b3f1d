"""CPU time of a step of ``ragdoll sample`` against size, from 20 to 8,000 residues.

    .venv/bin/python benchmarks/step_cost.py [--perturbation gaussian]

Structures are those of the folder that RAGDOLL_DATA names (default ../shared/data), GroEL-GroES by
more and more of its chains. A step is what a longer run takes more than a shorter one, so that
reading, modes and plans do not count; measuring what was written does. The last line is the cost
per atom, of that of the geometric mean: linear within 1.5 is from 0.67 to 1.5.
"""

import argparse
import os
import tempfile
import time
from pathlib import Path

import numpy as np

import ragdoll

_DATA = Path(os.environ.get("RAGDOLL_DATA", "../shared/data")) / "proteins"
_CASES = [
    ("1l2y.pdb", None),
    ("1ubq.pdb", None),
    ("1aki.pdb", None),
    ("4ake.pdb", None),
    ("1ewk.pdb.gz", None),
    ("1gru.pdb.gz", "ABC"),
    ("1gru.pdb.gz", "ABCDEFG"),
    ("1gru.pdb.gz", None),
]


def seconds_for(molecule, frames, perturbation, folder):
    """CPU seconds of a walk, and its steps."""
    options = ragdoll.SampleOptions(
        frames=frames, stride=1, perturbation=perturbation, seed=1, allow_low_quality=True
    )
    start = time.process_time()
    report = ragdoll.sample(molecule, Path(folder) / "a.h5", options, force=True)
    return time.process_time() - start, report.steps


def main():
    """Print one line for each size."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--perturbation", default="thermal")
    parser.add_argument("--seconds", type=float, default=10.0, help="Of each size, about.")
    parser.add_argument("--most", type=int, default=10**9, help="Atoms; larger ones are left out.")
    given = parser.parse_args()
    rows = []
    print(f"{'structure':24s} residues   atoms  steps   ms/step  us/atom")
    for name, chains in _CASES:
        molecule = ragdoll.Molecule.from_file(_DATA / name, chains=list(chains) if chains else None)
        if len(molecule) > given.most:
            continue
        with tempfile.TemporaryDirectory() as folder:
            few, one = seconds_for(molecule, 2, given.perturbation, folder)
            frames = int(np.clip(given.seconds / (30e-6 * len(molecule)), 8, 400))
            many, other = seconds_for(molecule, 2 + frames, given.perturbation, folder)
        cost = (many - few) / (other - one)
        rows.append((name, chains, molecule, other - one, cost))
        residues = molecule.topology.getNumResidues()
        what = name.split(".")[0] + (f" {chains}" if chains else "")
        print(
            f"{what:24s} {residues:8d} {len(molecule):7d} {other - one:6d} {1e3 * cost:9.2f} "
            f"{1e6 * cost / len(molecule):8.2f}",
            flush=True,
        )
    each = np.array([cost / len(molecule) for _, _, molecule, _, cost in rows])
    spread = each / np.exp(np.log(each).mean())
    print("cost per atom, of the mean:", " ".join(f"{x:.2f}" for x in spread))


if __name__ == "__main__":
    main()
