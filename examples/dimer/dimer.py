"""A symmetric dimer: both copies move alike.

    dimer.py FILE [--chains A,B]

Without a file: HIV-1 protease, without its ligand, from MDAnalysisTests.
"""

import argparse
from pathlib import Path

import matplotlib
import numpy as np

import ragdoll

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("file", nargs="?", help="PDB or mmCIF file")
parser.add_argument("--chains", default="A,B")
parser.add_argument("--frames", type=int, default=20)
parser.add_argument("-o", "--output", default=Path(__file__).with_name("dimer.png"), type=Path)
given = parser.parse_args()
if given.file is None:
    from importlib.resources import files

    given.file = str(files("MDAnalysisTests") / "data" / "1hvr.pdb")
chains = tuple(given.chains.split(","))
options = ragdoll.PrepareOptions(chains=chains, heterogens="drop")
molecule = ragdoll.prepare(given.file, options=options).molecule


def superposed(a, b):
    """The points a laid over b."""
    u, _, vt = np.linalg.svd((a - a.mean(axis=0)).T @ (b - b.mean(axis=0)))
    u[:, 2] *= np.sign(np.linalg.det(u @ vt))
    return (a - a.mean(axis=0)) @ u @ vt + b.mean(axis=0)


def sampled(symmetric, name):
    """CA atoms of both chains in all frames, (2, frames, n, 3) angstrom."""
    path = given.output.with_name(f"{name}.h5")
    report = ragdoll.sample(
        molecule,
        path,
        ragdoll.SampleOptions(
            frames=given.frames,
            perturbation="momentum",
            seed=1,
            motion=ragdoll.MotionOptions(symmetric=symmetric),
        ),
        force=True,
    )
    with ragdoll.open_trajectory(path) as trajectory:
        frames = 10 * trajectory.positions.astype(float)
    print(
        f"{name}: {report.frames} frames, RMSD from the input up to "
        f"{report.geometry['rmsd_max_angstrom']:.2f} angstrom"
    )
    copies = [
        [a.index for a in molecule.topology.atoms() if a.name == "CA" and a.residue.chain.id == c]
        for c in chains
    ]
    return np.array([frames[:, copy] for copy in copies])


def apart(copies):
    """RMSD of the copies from each other in each frame."""
    return np.array(
        [
            np.sqrt(((superposed(one, other) - other) ** 2).sum(axis=1).mean())
            for one, other in zip(copies[0], copies[1], strict=True)
        ]
    )


def fluctuations(copy):
    """RMSF of one copy, angstrom."""
    mean = copy[0]
    for _ in range(5):
        laid = np.array([superposed(frame, mean) for frame in copy])
        mean = laid.mean(axis=0)
    return np.sqrt(((laid - mean) ** 2).sum(axis=2).mean(axis=0))


alike, alone = sampled(chains, "symmetric"), sampled((), "free")
figure, axes = plt.subplots(1, 3, figsize=(11, 3.4), dpi=120, layout="constrained")
axes[0].plot(apart(alone), label="each on its own")
axes[0].plot(apart(alike), label="alike")
axes[0].set_xlabel("frame")
axes[0].set_ylabel(f"RMSD of {chains[0]} from {chains[1]} / Å")
axes[0].legend()
for axis, copies, title in ((axes[1], alone, "each on its own"), (axes[2], alike, "alike")):
    for copy, name in zip(copies, chains, strict=True):
        axis.plot(fluctuations(copy), label=name, linestyle="-" if name == chains[0] else "--")
    axis.set_title(title, fontsize=10)
    axis.set_xlabel("residue of the chain")
    axis.set_ylabel("RMSF / Å")
    axis.legend()
axes[1].sharey(axes[2])
figure.savefig(given.output)
