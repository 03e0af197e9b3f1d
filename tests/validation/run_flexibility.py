"""What ensembles of ``ragdoll sample`` are worth, against experiment, dynamics and elastic networks.

Runs the command line as a user would, without flags but --frames and --seed, and computes
everything anew from the files, by numpy, h5py and MDAnalysis, without any of ragdoll's code.

    .venv/bin/python tests/validation/run_flexibility.py [CASE ...] [--frames N] [--seed S]

Cases: ubiquitin, p38, hiv, adenylate, mglur, explore. Reads molecules from the folder that RAGDOLL_DATA names
(default ../shared/data). CPU seconds are those of the command, reading and writing included.
"""

import argparse
import gzip
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import warnings
from pathlib import Path

import h5py
import numpy as np

warnings.filterwarnings("ignore")
DATA = Path(os.environ.get("RAGDOLL_DATA", "../shared/data")) / "proteins"
RAGDOLL = Path(sys.executable).parent / "ragdoll"


def superposed(moved, fixed, chosen=slice(None)):
    """``moved`` on ``fixed`` by the chosen points (Kabsch)."""
    one, other = moved[chosen].mean(axis=0), fixed[chosen].mean(axis=0)
    u, _, vt = np.linalg.svd((moved[chosen] - one).T @ (fixed[chosen] - other))
    u[:, -1] *= np.sign(np.linalg.det(u @ vt))
    return (moved - one) @ (u @ vt) + other


def rmsd(a, b):
    """Of two conformers, superposed."""
    return float(np.sqrt(((superposed(a, b) - b) ** 2).sum(axis=1).mean()))


def about_mean(frames):
    """Frames superposed on their own mean, again and again."""
    frames = np.array(frames, dtype=float)
    mean = frames[0]
    for _ in range(10):
        frames = np.array([superposed(frame, mean) for frame in frames])
        mean = frames.mean(axis=0)
    return frames


def rmsf(frames):
    """Root mean square fluctuation of each point about the mean."""
    frames = about_mean(frames)
    return np.sqrt(((frames - frames.mean(axis=0)) ** 2).sum(axis=2).mean(axis=0))


def principal(frames, count=10):
    """The largest principal components, (count, 3n)."""
    frames = about_mean(frames)
    flat = (frames - frames.mean(axis=0)).reshape(len(frames), -1)
    return np.linalg.svd(flat, full_matrices=False)[2][:count]


def rmsip(one, other):
    """Root mean square inner product of two subspaces."""
    return float(np.sqrt(((one @ other.T) ** 2).sum() / len(one)))


def anm(places, cutoff=15.0):
    """Modes of the anisotropic network model, unweighted: values and vectors (n, 3N)."""
    lines = places[None] - places[:, None]
    squares = (lines**2).sum(axis=2)
    near = (squares < cutoff**2) & ~np.eye(len(places), dtype=bool)
    squares[~near] = 1
    blocks = -near[:, :, None, None].astype(float) * lines[..., :, None] * lines[..., None, :]
    blocks = blocks / squares[:, :, None, None]
    for k in range(len(places)):
        blocks[k, k] = -blocks[k].sum(axis=0)
    size = 3 * len(places)
    values, vectors = np.linalg.eigh(blocks.transpose(0, 2, 1, 3).reshape(size, size))
    return values[6:], vectors[:, 6:].T


def anm_rmsf(places):
    """RMSF of the network, but for a factor."""
    values, vectors = anm(places)
    return np.sqrt((vectors**2 / values[:, None]).sum(axis=0).reshape(-1, 3).sum(axis=1))


class Sampled:
    """One run of the command line and its file."""

    def __init__(self, source, folder, *flags):
        output = Path(folder) / "sampled.h5"
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        command = [str(RAGDOLL), "sample", str(source), "-o", str(output), "--force", "--quiet"]
        done = subprocess.run([*command, *map(str, flags)], check=False)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if done.returncode not in (0, 3):
            raise SystemExit(f"{source}: the command ended with {done.returncode}")
        self.seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        import json

        with h5py.File(output) as file:
            self.frames = np.array(file["coordinates"], dtype=float) * 10
            self.start = np.array(file["ragdoll/input_positions"], dtype=float) * 10
            self.bonds = np.array(file["connectivity/bonds"])
            topology = json.loads(file["topology"][0])
        self.sites = np.array(
            [
                atom["index"]
                for chain in topology["chains"]
                for residue in chain["residues"]
                for atom in residue["atoms"]
                if atom["name"] == "CA" and {"N", "C"} <= {a["name"] for a in residue["atoms"]}
            ]
        )

    def alphas(self):
        """CA of the frames."""
        return self.frames[:, self.sites]

    def bond_rms(self):
        """Of bonds against the input, angstrom."""
        lengths = [self._lengths(x) for x in (self.frames, self.start)]
        return float(np.sqrt(((lengths[0] - lengths[1]) ** 2).mean()))

    def _lengths(self, x):
        i, j = self.bonds.T
        return np.linalg.norm(x[..., i, :] - x[..., j, :], axis=-1)

    def angle_rms(self):
        """Of angles against the input, degrees."""
        beside = {}
        for i, j in self.bonds:
            beside.setdefault(i, []).append(j)
            beside.setdefault(j, []).append(i)
        triples = np.array(
            [
                (one, centre, other)
                for centre, ends in beside.items()
                for k, one in enumerate(ends)
                for other in ends[k + 1 :]
            ]
        )

        def angles(x):
            u = x[..., triples[:, 0], :] - x[..., triples[:, 1], :]
            v = x[..., triples[:, 2], :] - x[..., triples[:, 1], :]
            cosine = (u * v).sum(-1) / np.linalg.norm(u, axis=-1) / np.linalg.norm(v, axis=-1)
            return np.degrees(np.arccos(np.clip(cosine, -1, 1)))

        return float(np.sqrt(((angles(self.frames) - angles(self.start)) ** 2).mean()))

    def steps(self):
        """CA RMSD of each frame from the one before, the first from the input."""
        alphas = np.concatenate([self.start[None, self.sites], self.alphas()])
        return np.array([rmsd(b, a) for a, b in zip(alphas, alphas[1:], strict=False)])


def say(what, value, goal=""):
    """One line of the table."""
    print(f"  {what:58s} {value:>22s}   {goal}", flush=True)


def common(sampled):
    """What is asked of every ensemble."""
    say("bonds against the input, RMS angstrom", f"{sampled.bond_rms():.4f}", "<= 0.004")
    say("angles against the input, RMS degrees", f"{sampled.angle_rms():.2f}", "<= 0.6")
    say("mean RMSF of CA, angstrom", f"{rmsf(sampled.alphas()).mean():.2f}")


def trajectory(topology, frames):
    """CA of a trajectory of dynamics."""
    import MDAnalysis

    universe = MDAnalysis.Universe(str(DATA / topology), str(DATA / frames))
    atoms = universe.select_atoms("name CA")
    return np.array([atoms.positions.copy() for _ in universe.trajectory], dtype=float)


def ubiquitin(folder, given):
    """RMSF against the ensemble of residual dipolar couplings."""
    import MDAnalysis

    models = MDAnalysis.Universe(str(DATA / "2k39_ca.pdb"))
    models = np.array([models.atoms.positions.copy() for _ in models.trajectory], dtype=float)
    sampled = Sampled(DATA / "1ubq.pdb", folder, "--frames", given.frames, "--seed", given.seed)
    alphas, start = sampled.alphas(), sampled.start[sampled.sites]
    say("RMSF of 1-70 against 2K39, superposed on 1-70", correlation(alphas[:, :70], models[:, :70]), ">= 0.90")
    whole = np.corrcoef(rmsf(alphas)[:70], rmsf(models)[:70])[0, 1]
    say("the same, superposed on 1-76", f"{whole:.3f}", ">= 0.90")
    plain = np.corrcoef(anm_rmsf(start)[:70], rmsf(models[:, :70]))[0, 1]
    say("ANM of the same structure", f"{plain:.3f}")
    say("RMSIP10 with 2K39", f"{rmsip(principal(alphas[:, :70]), principal(models[:, :70])):.2f}")
    common(sampled)
    say("CPU ms for each frame", f"{1e3 * sampled.seconds / len(alphas):.1f}")


def correlation(frames, reference):
    """Pearson's, of RMSF."""
    return f"{np.corrcoef(rmsf(frames), rmsf(reference))[0, 1]:.3f}"


def against_dynamics(sampled, reference):
    """RMSIP and RMSF, beside those of the plain network on the same structure."""
    start, found = sampled.start[sampled.sites], principal(reference)
    say("RMSIP10 with MD", f"{rmsip(principal(sampled.alphas()), found):.3f}")
    say("RMSIP10 of ANM, from the structure sampled", f"{rmsip(anm(start)[1][:10], found):.3f}")
    say("RMSIP10 of ANM, from MD's first frame", f"{rmsip(anm(reference[0])[1][:10], found):.3f}")
    say("RMSF against MD", correlation(sampled.alphas(), reference))
    say("RMSF of ANM against MD", f"{np.corrcoef(anm_rmsf(start), rmsf(reference))[0, 1]:.3f}")
    common(sampled)


def p38(folder, given):
    """Against molecular dynamics of p38."""
    flags = ("--frames", given.frames, "--seed", given.seed)
    against_dynamics(
        Sampled(DATA / "p38.pdb", folder, *flags), trajectory("p38.pdb", "p38_md_100frames.dcd")
    )


def hiv(folder, given):
    """Against molecular dynamics of HIV protease."""
    flags = ("--frames", given.frames, "--seed", given.seed)
    against_dynamics(
        Sampled(DATA / "1hvr.pdb", folder, *flags), trajectory("hivp_ca.pdb", "hivp_ca_md.dcd")
    )


def adenylate(folder, given):
    """CPU time of a conformer of adenylate kinase, with hydrogens."""
    source = DATA / "4ake_a_withH.pdb"
    few = Sampled(source, folder, "--frames", 20, "--seed", given.seed)
    many = Sampled(source, folder, "--frames", 20 + given.frames, "--seed", given.seed)
    steps = many.steps()
    say("atoms", str(many.frames.shape[1]))
    cost = 1e3 * (many.seconds - few.seconds) / (len(many.frames) - len(few.frames))
    say("CPU ms for one more frame, written and measured", f"{cost:.1f}", "<= 5 (walk alone)")
    say("CPU s before the first frame", f"{few.seconds - 0.02 * cost:.1f}")
    say("CA RMSD from the frame before: least, mean", f"{steps.min():.2f}, {steps.mean():.2f}", ">= 0.1")
    common(many)


def mglur(folder, given):
    """From the open chain B of mGluR1 towards the closed chain A, untargeted."""
    import MDAnalysis

    path = Path(folder) / "1ewk.pdb"
    with gzip.open(DATA / "1ewk.pdb.gz") as packed, open(path, "wb") as file:
        shutil.copyfileobj(packed, file)
    closed = MDAnalysis.Universe(str(path)).select_atoms("name CA and chainID A and protein")
    opened = MDAnalysis.Universe(str(path)).select_atoms("name CA and chainID B and protein")
    both = sorted(set(closed.resids) & set(opened.resids))
    target = closed.positions[np.isin(closed.resids, both)].astype(float)
    sampled = Sampled(path, folder, "--chain", "B", "--seed", given.seed, *given.mglur.split())
    alphas = sampled.alphas()[:, : len(opened)][:, np.isin(opened.resids, both)]
    here = sampled.start[sampled.sites][: len(opened)][np.isin(opened.resids, both)]
    say("CA RMSD of the start from chain A, angstrom", f"{rmsd(here, target):.2f}")
    say("least of the frames", f"{min(rmsd(x, target) for x in alphas):.2f}", "<= 2")
    say("CPU seconds", f"{sampled.seconds:.0f}", "<= 600")
    common(sampled)


def explore(folder, given):
    """How far ubiquitin gets in a minute."""
    sampled = Sampled(DATA / "1ubq.pdb", folder, "--seed", given.seed, *given.explore.split())
    start = sampled.start[sampled.sites]
    say("largest CA RMSD from the start", f"{max(rmsd(x, start) for x in sampled.alphas()):.2f}", ">= 3")
    say("CPU seconds", f"{sampled.seconds:.0f}", "<= 60")
    common(sampled)


CASES = {
    case.__name__: case for case in (ubiquitin, p38, hiv, adenylate, mglur, explore)
}


def main():
    """Run the cases and print their tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="*", default=list(CASES))
    parser.add_argument("--frames", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--mglur", default="--perturbation modes --modes 1-5 --mode-amplitude-angstrom 4 --frames 200"
    )
    parser.add_argument(
        "--explore", default="--perturbation away --away-from density --frames 60"
    )
    given = parser.parse_args()
    for name in given.cases:
        print(f"{name}: {CASES[name].__doc__.splitlines()[0]}", flush=True)
        with tempfile.TemporaryDirectory() as folder:
            CASES[name](folder, given)


if __name__ == "__main__":
    main()
