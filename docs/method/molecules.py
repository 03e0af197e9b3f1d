"""Where real molecules stand among the thesis' classes, and which technique wins on them.

.venv/bin/python docs/method/molecules.py [--quick] [--json] [--publish]

Reads proteins/ and ligands/ of RAGDOLL_DATA, by default shared/data beside the repository.
"""

import gzip
import os
from collections.abc import Iterator
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from common import (
    COLOURS,
    HERE,
    WEIGHTINGS,
    bootstrap,
    command_line,
    forces,
    percent,
    resolve,
    structures,
    table,
)
from rdkit import Chem, RDLogger

import ragdoll
from ragdoll import _core
from ragdoll.errors import InputError
from ragdoll.method.sources import structure_of

DATA = Path(os.environ.get("RAGDOLL_DATA", HERE.parents[2] / "shared" / "data"))
WITHOUT_BONDS = ("2k39_ca.pdb", "hivp_ca.pdb")  # CA atoms alone
LIGANDS = {
    "drugs": "minidrugbank.sdf.gz",
    "ligands": "platinum_subset_public.sdf",
    "crystals": "cod_crystals_public.sdf",
    "medium rings": "medium_rings_public.sdf",
    "macrocycles": "macrocycles_public.sdf",
}
RESOLVED = ("1l2y.pdb", "1crn.pdb", "1enh.pdb", "1vii.pdb", "1ubq.pdb", "bpti_openmm.pdb")
ORDERS = ("random", "bfs_cycle", "dfs_cycle", "bfs_reverse", "bfs_active", "bfs_worst")
BONDS, FRAMEWORK = "bond graph", "framework"
TOLERANCE = {BONDS: 1e-3, FRAMEWORK: 1e-2}
MOST = {BONDS: 10_000, FRAMEWORK: 1_000}
SEED = 500_000


def proteins(names=None) -> Iterator[tuple[str, ragdoll.Molecule]]:
    for path in sorted((DATA / "proteins").iterdir()):
        wanted = path.name in names if names else path.name not in WITHOUT_BONDS
        if wanted and ".pdb" in path.name or wanted and ".cif" in path.name:
            yield path.name, ragdoll.Molecule.from_file(path)


def ligands(file: str, most: int | None = None) -> Iterator[ragdoll.Molecule]:
    """Molecules of an SDF file; those that cannot be read are left out."""
    RDLogger.DisableLog("rdApp.*")
    path = DATA / "ligands" / file
    with (gzip.open if path.suffix == ".gz" else open)(path, "rb") as stream:
        count = 0
        for mol in Chem.ForwardSDMolSupplier(stream, removeHs=False):
            if mol is None or most is not None and count >= most:
                continue
            try:
                yield ragdoll.Molecule.from_rdkit(mol)
                count += 1
            except InputError:
                continue


# === Classes


def graph_of(source) -> dict:
    """Numbers of the largest component."""
    found = ragdoll.classify(source)
    largest = max(range(len(found.components)), key=lambda k: found.components[k]["joints"])
    component = found.components[largest]
    blocks = [b for b in found.blocks if b["component"] == largest]
    return {
        "class": component["class"],
        "joints": component["joints"],
        "rank": component["cycle_rank"],
        "diameter": component["diameter"],
        "block": max((len(b["joints"]) for b in blocks), default=0),
        "block_rank": max((b["cycle_rank"] for b in blocks), default=0),
        "on_cycles": sum(len(b["joints"]) for b in blocks) / component["joints"],
    }


def graphs(quick: bool) -> dict[str, list[dict]]:
    found = {}
    for name in ("tree", "1-cycle", "2-cycle", "n-cycle"):
        drawn = structures(name, 20 if quick else 200, SEED)
        found[name] = [graph_of(structure) for _, structure in drawn]
    for name, file in LIGANDS.items():
        found[name] = [graph_of(m) for m in ligands(file, 10 if quick else None)]
    found["proteins"] = [graph_of(m) for _, m in proteins(RESOLVED[:3] if quick else None)]
    return found


# === Techniques


def framework_structure(molecule: ragdoll.Molecule):
    """The bars of a molecule's framework: bonds, angles and planar units."""
    framework = ragdoll.build_framework(molecule, contacts=False)
    ids = [f"j{k}" for k in range(len(molecule.positions))]
    return _core.Structure(
        ids,
        np.asarray(molecule.positions),
        np.asarray(framework.bars),
        np.asarray(framework.bar_lengths),
        np.asarray(framework.masses),
    )


def race(kind: str, molecules: list[ragdoll.Molecule], per_structure: int) -> list[dict]:
    of = structure_of if kind == BONDS else framework_structure
    drawn = []
    for k, molecule in enumerate(molecules):
        structure = of(molecule)
        drawn.append((structure, forces(structure, per_structure, 0.1, 2.0, SEED + k)))
    return [_cell(kind, drawn, order, weighting) for order in ORDERS for weighting in WEIGHTINGS]


def _cell(kind: str, drawn, order: str, weighting: str) -> dict:
    most, iterations, visits, failed = MOST[kind], [], [], 0
    for structure, pushes in drawn:
        of_structure = []
        for k, (joint, vector, _) in enumerate(pushes):
            done = resolve(
                structure,
                joint,
                vector,
                order,
                weighting,
                seed=k,
                most=most,
                tolerance=TOLERANCE[kind],
            )
            of_structure.append(done["iterations"] if done["converged"] else most)
            visits.append(done["bar_visits"] / structure.bar_count)
            failed += not done["converged"]
        iterations.append(np.array(of_structure))
    every = np.concatenate(iterations)
    return {
        "order": order,
        "weighting": weighting,
        "mean": float(every.mean()),
        "interval": bootstrap(iterations, np.mean),
        "p99": int(np.percentile(every, 99, method="inverted_cdf")),
        "visits": float(np.mean(visits)),
        "failed": int(failed),
        "forces": len(every),
    }


def measure(quick: bool) -> dict:
    if not (DATA / "proteins").is_dir() or not (DATA / "ligands").is_dir():
        return {"skipped": "No molecules: set RAGDOLL_DATA to a folder with proteins and ligands."}
    found: dict = {"graphs": graphs(quick), "races": {}}
    small = [
        m
        for file in ("minidrugbank.sdf.gz", "macrocycles_public.sdf")
        for m in ligands(file, 4 if quick else 40)
    ]
    large = [m for _, m in proteins(RESOLVED[:1] if quick else RESOLVED)]
    for kind in (BONDS, FRAMEWORK):
        found["races"][f"ligands, {kind}"] = race(kind, small, 3 if quick else 10)
        found["races"][f"proteins, {kind}"] = race(kind, large, 3 if quick else 10)
    return found


def tables(found: dict) -> dict[str, str]:
    rows = []
    for name, graphs_found in found["graphs"].items():
        column = {k: np.array([g[k] for g in graphs_found]) for k in graphs_found[0]}
        shares = [
            percent(int((column["class"] == c).sum()), len(graphs_found))
            for c in ("tree", "1-cycle", "2-cycle", "n-cycle")
        ]
        rows.append(
            [
                name,
                len(graphs_found),
                " / ".join(share.removesuffix(" %") for share in shares),
                _span(column["joints"]),
                _span(column["rank"]),
                f"{100 * (column['rank'] / column['joints']).mean():.2g}",
                _span(column["block"]),
                f"{int(column['block_rank'].max())}",
                f"{100 * column['on_cycles'].mean():.0f} %",
                _span(column["diameter"]),
            ]
        )
    head = ["", "how many", "tree / 1 / 2 / n, %", "joints", "cycle rank", "rank per 100 joints"]
    head += ["largest block", "its highest rank", "on cycles", "diameter"]
    out = {"molecules": table(head, rows)}
    for name, cells in found["races"].items():
        by = {(c["order"], c["weighting"]): c for c in cells}
        rows = []
        for order in ORDERS:
            row = [order]
            for weighting in WEIGHTINGS:
                c = by[order, weighting]
                low, high = c["interval"]
                fails = f", {percent(c['failed'], c['forces'])} fail" if c["failed"] else ""
                row.append(
                    f"{c['mean']:.3g} ({low:.3g}–{high:.3g}), {c['p99']}; {c['visits']:.3g}{fails}"
                )
            rows.append(row)
        out[name] = table(["order", *WEIGHTINGS], rows)
    return out


def _span(values: np.ndarray) -> str:
    return f"{np.median(values):.0f} ({values.min()}–{values.max()})"


def draw(found: dict, path: Path) -> None:
    figure, axes = plt.subplots(1, 3, figsize=(13, 4.2), constrained_layout=True)
    for k, (name, graphs_found) in enumerate(found["graphs"].items()):
        real = k >= 4
        for axis, value in zip(axes, ("rank", "block", "diameter"), strict=True):
            axis.plot(
                [g["joints"] for g in graphs_found],
                [g[value] for g in graphs_found],
                "o" if real else "x",
                color=COLOURS[(k - 4) % len(COLOURS)] if real else "#bbbbbb",
                markersize=4,
                alpha=0.7,
                label=name if real else "thesis' classes" if k == 0 else None,
            )
    for axis, label in zip(
        axes, ("cycle rank", "joints of the largest block", "diameter, bars"), strict=True
    ):
        axis.set_xscale("log")
        axis.set_yscale("symlog", linthresh=1)  # trees have rank 0
        axis.set_ylim(-0.2, 2 * axis.dataLim.ymax)
        axis.set_xlabel("joints")
        axis.set_ylabel(label)
        axis.spines[["top", "right"]].set_visible(False)
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(
        handles, labels, frameon=False, fontsize=9, loc="outside lower center", ncols=len(labels)
    )
    figure.savefig(path, dpi=110)


if __name__ == "__main__":
    command_line(measure, tables, draw, "molecules.png")
