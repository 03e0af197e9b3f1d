"""Pictures of rigid clusters: along the chains, and of a dilution."""

from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402
from matplotlib.ticker import MaxNLocator  # noqa: E402

from .rigidity_analysis import DilutionResult, NetworkRigidity, RigidityResult  # noqa: E402
from .rigidity_files import PALETTE, rgb  # noqa: E402

_FLEXIBLE = (0.93, 0.93, 0.93)
_BACKBONE = ("CA", "P")
_MOST_ROWS = 400


class _Residues:
    """The residues of a molecule along its chains, each with the atom that stands for it."""

    def __init__(self, topology):
        self.atoms: list[int] = []
        self.names: list[str] = []
        self.breaks: list[int] = []  # where another chain begins
        self.chains: list[str] = []
        self.of_atom = np.full(topology.getNumAtoms(), -1)
        for chain in topology.chains():
            if self.atoms:
                self.breaks.append(len(self.atoms))
            self.chains.append(chain.id)
            for residue in chain.residues():
                for atom in residue.atoms():
                    self.of_atom[atom.index] = len(self.atoms)
                self.atoms.append(_stand_in(residue))
                self.names.append(str(residue.id))

    def __len__(self) -> int:
        """Return the number of residues."""
        return len(self.atoms)

    def clusters(self, rigidity: NetworkRigidity) -> np.ndarray:
        """The cluster of each residue, -1 for one that is rigid with no other."""
        clusters = rigidity.cluster_of_body[self.atoms]
        members = np.bincount(clusters, minlength=len(rigidity.cluster_sizes))
        return np.where(members[clusters] > 1, clusters, -1)

    def mark(self, axes) -> None:
        """Number the residues and part the chains."""
        axes.set_xlim(-0.5, len(self) - 0.5)
        for place in self.breaks:
            axes.axvline(place - 0.5, color="black", linewidth=0.8)
        ticks = [int(t) for t in MaxNLocator(12, integer=True).tick_values(0, len(self) - 1)]
        ticks = [t for t in ticks if 0 <= t < len(self)]
        axes.set_xticks(ticks, [self.names[t] for t in ticks])


def _stand_in(residue) -> int:
    atoms = list(residue.atoms())
    if len(atoms) > 1:
        for atom in atoms:
            if atom.name in _BACKBONE:
                return atom.index
    heavy = [atom for atom in atoms if atom.element.symbol != "H"]
    return (heavy or atoms)[0].index


def draw(result: RigidityResult | DilutionResult, path: str | Path) -> None:
    """Draw rigid clusters, or a dilution, into a PNG.

    Raises:
        OSError: the disk takes no more.
    """
    figure = plt.figure(figsize=(11, 6.5 if isinstance(result, DilutionResult) else 4.5), dpi=150,
                        layout="constrained")  # fmt: skip
    try:
        if isinstance(result, DilutionResult):
            _draw_dilution(figure, result)
        else:
            _draw_clusters(figure, result)
        figure.savefig(path, format="png")
    finally:
        plt.close(figure)


def _draw_clusters(figure, result: RigidityResult) -> None:
    """Clusters of the backbone as one bar; below, hinges and over-constrained atoms by residue."""
    residues = _Residues(result.molecule.topology)
    bar, curves = figure.subplots(2, 1, sharex=True, height_ratios=[1, 2.2])
    clusters = residues.clusters(result)
    order = list(dict.fromkeys(int(c) for c in np.sort(clusters) if c >= 0))
    colours = {cluster: rgb(PALETTE[k % len(PALETTE)]) for k, cluster in enumerate(order)}
    image = np.array([[colours.get(int(c), _FLEXIBLE) for c in clusters]])
    bar.imshow(image, aspect="auto", extent=(-0.5, len(residues) - 0.5, 0, 1))
    bar.set_yticks([])
    bar.set_ylabel("rigid\nclusters")
    residues.mark(bar)
    if residues.breaks:
        for start, name in zip([0, *residues.breaks], residues.chains, strict=True):
            bar.text(start, 1.03, f" chain {name}", fontsize=8, va="bottom")

    hinges = residues.of_atom[result.bonds.ends[result.hinges].ravel()]
    atoms = np.bincount(residues.of_atom, minlength=len(residues))
    stressed = residues.of_atom[result.region_of_body >= 0]
    share = np.bincount(stressed, minlength=len(residues)) / np.maximum(atoms, 1)
    along = np.arange(len(residues))
    # each hinge has two ends, which may lie in two residues
    curves.bar(along, np.bincount(hinges, minlength=len(residues)) / 2, width=1.0,
               color="#56b4e9", label="hinges")  # fmt: skip
    curves.set_ylabel("hinges")
    curves.set_xlabel("residue")
    curves.yaxis.set_major_locator(MaxNLocator(integer=True))
    residues.mark(curves)
    right = curves.twinx()
    right.step(along, 100 * share, where="mid", color="#d55e00", linewidth=1.0)
    right.set_ylim(0, 105)
    right.set_ylabel("over-constrained atoms / %", color="#d55e00")
    figure.suptitle(
        f"{Path(result.molecule.source).name} at {result.options.hbond_cutoff_kcal:g} kcal/mol: "
        f"{result.floppy_modes} floppy modes, {len(result.bonds.hbonds)} hydrogen bonds; "
        "grey: rigid with no other residue",
        fontsize=10,
    )


def _draw_dilution(figure, result: DilutionResult) -> None:
    """Rows of coloured bars from all hydrogen bonds to none; only rows that differ are drawn."""
    residues = _Residues(result.molecule.topology)
    rows, levels = [], []
    for index in range(len(result)):
        clusters = residues.clusters(result.at(index))
        if index in (0, len(result) - 1) or not _same_sets(clusters, rows[-1]):
            rows.append(clusters)
            levels.append(index)
    if len(rows) > _MOST_ROWS:
        chosen = np.unique(np.linspace(0, len(rows) - 1, _MOST_ROWS).astype(int))
        rows, levels = [rows[k] for k in chosen], [levels[k] for k in chosen]
    colours = _inherited_colours(rows)
    image = np.array([[_FLEXIBLE if c < 0 else rgb(PALETTE[c % len(PALETTE)]) for c in row]
                      for row in colours])  # fmt: skip
    axes, curve = figure.subplots(1, 2, sharey=True, width_ratios=[5, 1])
    axes.imshow(image, aspect="auto", interpolation="nearest",
                extent=(-0.5, len(residues) - 0.5, len(rows) - 0.5, -0.5))  # fmt: skip
    residues.mark(axes)
    axes.set_xlabel("residue" + (", chains " + ", ".join(residues.chains)
                                 if residues.breaks else ""))  # fmt: skip
    step = max(1, -(-len(rows) // 30))
    ticks = range(0, len(rows), step)
    labels = []
    for k in ticks:
        cutoff = result.cutoffs_kcal[levels[k]]
        count = result.levels[levels[k]]
        labels.append(f"{'none' if np.isnan(cutoff) else f'{cutoff:.2f}'}  {count:4d}")
    axes.set_yticks(list(ticks), labels, fontsize=7, family="monospace")
    axes.set_ylabel("weakest hydrogen bond / kcal/mol, and how many there are")
    modes = [result.at(index).floppy_modes for index in levels]
    curve.plot(modes, np.arange(len(rows)), color="black", linewidth=1.0)
    curve.set_xlabel("floppy modes")
    curve.set_xlim(left=0)
    figure.suptitle(
        f"{Path(result.molecule.source).name}: rigid clusters of the backbone as hydrogen bonds "
        "are taken away; grey: rigid with no other residue",
        fontsize=10,
    )


def _same_sets(one: np.ndarray, other: np.ndarray) -> bool:
    """Whether two rows part the residues alike, whatever the numbers of their clusters."""
    return np.array_equal(_first_members(one), _first_members(other))


def _first_members(row: np.ndarray) -> np.ndarray:
    """Each residue's first fellow in its cluster, -1 where it is alone."""
    first: dict[int, int] = {}
    return np.array([-1 if c < 0 else first.setdefault(int(c), k) for k, c in enumerate(row)])


def _inherited_colours(rows: list[np.ndarray]) -> list[np.ndarray]:
    """Numbers of colours: where a cluster breaks, its largest piece keeps the colour."""
    coloured: list[np.ndarray] = []
    used = 0
    for row in rows:
        result = np.full(len(row), -1)
        taken: set[int] = set()
        clusters, sizes = np.unique(row[row >= 0], return_counts=True)
        for cluster in clusters[np.argsort(-sizes, kind="stable")]:
            members = row == cluster
            before = coloured[-1][members] if coloured else np.empty(0, dtype=int)
            before = before[before >= 0]
            parent = int(np.bincount(before).argmax()) if len(before) else -1
            if parent < 0 or parent in taken:
                parent = used
                used += 1
            taken.add(parent)
            result[members] = parent
        coloured.append(result)
    return coloured
