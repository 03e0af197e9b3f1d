"""Why bfs_cycle with 1/0 fails at times: a rule, how often it is right, and what it looks at.

.venv/bin/python docs/method/inconsistency.py [--quick] [--json] [--publish]
"""

from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from common import CLASSES, COLOURS, command_line, forces, percent, resolve, structures, table

from ragdoll import _core

TECHNIQUE = ("bfs_cycle", "1/0")
RANGES = ((0.1, 2.0), (2.0, 20.0))  # mean bar lengths
SPREAD = ((0.1, 0.5), (0.5, 2.0), (2.0, 5.0), (5.0, 20.0))
LENGTHS = ((3, 4), (5, 8), (9, 16), (17, 99))
DISTANCES = ((0, 0), (1, 1), (2, 3), (4, 99))
SLACKS = (0.0, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3, 9.0)
LEARN, TEST = 0, 100_000  # first seeds: the rules were found on the one, and are tried on the other


@dataclass
class Problems:
    """The problem constraints of one traversal, B of them.

    Attributes:
        anchors: parents of both ends. (B, 2)
        final: whether both stay where the first pass leaves them. (B,)
        lengths: of the bar to the one parent, the problem constraint, the bar to the other. (B, 3)
        cycle: joints of the cycle that each closes with the tree. (B,)
        distance: bars from the root to that cycle. (B,)
    """

    anchors: np.ndarray
    final: np.ndarray
    lengths: np.ndarray
    cycle: np.ndarray
    distance: np.ndarray


class Traversals:
    """The problem constraints of a structure, by root."""

    def __init__(self, structure):
        self.framework = structure.framework()
        self.length = {
            (min(p, q), max(p, q)): length
            for (p, q), length in zip(
                structure.bars.tolist(), structure.bar_lengths.tolist(), strict=True
            )
        }
        self.known: dict[int, Problems] = {}

    def at(self, root: int) -> Problems:
        if root not in self.known:
            self.known[root] = self._find(root)
        return self.known[root]

    def _find(self, root: int) -> Problems:
        bars, problem = _core.order(self.framework, "bfs_cycle", [root], 0)
        parent = {root: root}
        depth = {root: 0}
        ends = []
        for (p, q), closes in zip(bars.tolist(), problem, strict=True):
            if closes:
                ends.append((p, q))
            else:
                parent[q], depth[q] = p, depth[p] + 1
        moved = {joint for pair in ends for joint in pair}
        for (_, q), closes in zip(bars.tolist(), problem, strict=True):
            if not closes and parent[q] in moved:
                moved.add(q)  # parents come before their children
        rows = []
        for p, q in ends:
            a, b = parent[p], parent[q]
            x, y = p, q
            while x != y:
                x, y = (parent[x], y) if depth[x] >= depth[y] else (x, parent[y])
            rows.append(
                (
                    (a, b),
                    a not in moved and b not in moved,
                    [self.length[min(u, v), max(u, v)] for u, v in ((a, p), (p, q), (b, q))],
                    depth[p] + depth[q] - 2 * depth[x] + 1,
                    depth[x],
                )
            )
        return Problems(*(np.array(column) for column in zip(*rows, strict=True)))


def slack(problems: Problems, positions, tolerance: float) -> np.ndarray:
    """How far each distance of anchors is inside what the three bars allow, in their sum. (B,)

    Negative: no place of the two ends satisfies all three.
    """
    a, b = problems.anchors.T
    apart = np.linalg.norm(positions[a] - positions[b], axis=1)
    total, longest = problems.lengths.sum(1), problems.lengths.max(1)
    most = total * (1 + tolerance)
    least = longest * (1 - tolerance) - (total - longest) * (1 + tolerance)
    return np.minimum(most - apart, apart - least) / total


# === The rule after one pass


def try_rule(class_name: str, reach, count: int, per_structure: int, tolerance=1e-3) -> dict:
    """Confusion of the rule, and what the failures look like at the end."""
    hit = {"kept": 0, "false_alarms": 0, "missed": 0, "caught": 0}
    final = {"final_alarms": 0, "false_final_alarms": 0}
    still_bad = slow = 0
    for seed, structure in structures(class_name, count, TEST):
        traversals = Traversals(structure)
        for joint, vector, _ in forces(structure, per_structure, *reach, seed):
            problems = traversals.at(joint)
            first = resolve(structure, joint, vector, *TECHNIQUE, most=1, tolerance=tolerance)
            negative = slack(problems, first["positions"], tolerance) < 0
            alarm = bool(negative.any())
            done = resolve(structure, joint, vector, *TECHNIQUE, tolerance=tolerance)
            if (negative & problems.final).any():
                final["final_alarms"] += 1
                final["false_final_alarms"] += done["converged"]
            if done["converged"]:
                hit["false_alarms" if alarm else "kept"] += 1
                continue
            hit["caught" if alarm else "missed"] += 1
            later = resolve(structure, joint, vector, *TECHNIQUE, most=10_001, tolerance=tolerance)
            rest = np.linalg.norm(later["positions"] - done["positions"], axis=1) < 1e-6
            bad = slack(problems, done["positions"], tolerance) < 0
            still_bad += bool((bad & rest[problems.anchors].all(1)).any())
            if not alarm:
                later = resolve(
                    structure, joint, vector, *TECHNIQUE, most=100_000, tolerance=tolerance
                )
                slow += later["converged"]
    return hit | final | {"failures_with_anchors_at_rest": still_bad, "missed_but_slow": slow}


# === What can be said before anything moves


@dataclass
class Sample:
    """Forces with what was known of them beforehand, and whether they failed."""

    features: list[np.ndarray]  # (B, 3) each: ln size, cycle, distance of each problem constraint
    failed: np.ndarray


def sample(class_name: str, first_seed: int, count: int, per_range: int) -> Sample:
    features, failed = [], []
    for seed, structure in structures(class_name, count, first_seed):
        traversals = Traversals(structure)
        for k, reach in enumerate(SPREAD):
            for joint, vector, size in forces(structure, per_range, *reach, 10 * seed + k):
                problems = traversals.at(joint)
                columns = (np.full(len(problems.cycle), np.log(size)),)
                features.append(np.stack([*columns, problems.cycle, problems.distance], 1))
                # what has not resolved after 2000 iterations is looked at more closely elsewhere
                done = resolve(structure, joint, vector, *TECHNIQUE, most=2000)
                failed.append(not done["converged"])
    return Sample(features, np.array(failed))


def columns_of(features: np.ndarray) -> np.ndarray:
    """What the logistic rule sees of problem constraints. (B, 5)"""
    size, cycle, distance = features.T
    length = np.log(cycle)
    return np.stack([np.ones_like(size), size, length, np.minimum(distance, 4), size * length], 1)


def learn(found: Sample, ridge: float = 1e-3) -> np.ndarray:
    """Logistic regression on 1-cycles of 5 joints and more, by Newton's method."""
    x = np.concatenate([columns_of(f) for f in found.features])
    cycle = np.concatenate([f[:, 1] for f in found.features])
    x, y = x[cycle >= 5], found.failed[cycle >= 5].astype(float)
    weights = np.zeros(x.shape[1])
    for _ in range(50):
        p = 1 / (1 + np.exp(-x @ weights))
        hessian = (x * (p * (1 - p))[:, None]).T @ x + ridge * np.eye(len(weights))
        weights += np.linalg.solve(hessian, x.T @ (y - p) - ridge * weights)
    return weights


def risk(weights: np.ndarray, found: Sample) -> np.ndarray:
    """Probability of failure: that not every problem constraint holds. (F,)"""
    risks = []
    for features in found.features:
        p = 1 / (1 + np.exp(-columns_of(features) @ weights))
        p[features[:, 1] < 5] = 0  # cycles of 3 and 4 joints cannot fail
        risks.append(1 - np.prod(1 - p))
    return np.array(risks)


def ranks_auc(risks: np.ndarray, failed: np.ndarray) -> float:
    """How often a failure is thought riskier than a success."""
    good, bad = np.sort(risks[~failed]), risks[failed]
    below, upto = np.searchsorted(good, bad), np.searchsorted(good, bad, "right")
    return float((below + upto).sum() / (2 * len(good) * max(len(bad), 1)))


def rates(found: Sample) -> dict[str, list]:
    """Failures and forces of 1-cycles by size, cycle and distance."""
    features = np.concatenate(found.features)
    size, cycle, distance = np.exp(features[:, 0]), features[:, 1], features[:, 2]
    out = {"by_cycle": [], "by_distance": []}
    for name, values, bins in (
        ("by_cycle", cycle, LENGTHS),
        ("by_distance", distance, DISTANCES),
    ):
        for low, high in bins:
            row = []
            for least, most in SPREAD:
                chosen = (values >= low) & (values <= high) & (size >= least) & (size < most)
                row.append([int(found.failed[chosen].sum()), int(chosen.sum())])
            out[name].append(row)
    return out


# === Failure or slowness


def near_the_boundary(count: int, per_structure: int, tolerance: float = 1e-6) -> list[dict]:
    """Iterations of 1-cycles by their slack after one pass."""
    slacks, iterations, converged, longer = [], [], [], []
    for seed, structure in structures("1-cycle", count, TEST + 50_000):
        traversals = Traversals(structure)
        for joint, vector, _ in forces(structure, per_structure, 0.1, 20.0, seed):
            first = resolve(structure, joint, vector, *TECHNIQUE, most=1, tolerance=tolerance)
            slacks.append(slack(traversals.at(joint), first["positions"], tolerance).min())
            done = resolve(structure, joint, vector, *TECHNIQUE, tolerance=tolerance)
            iterations.append(done["iterations"])
            converged.append(done["converged"])
            if not done["converged"]:
                done = resolve(
                    structure, joint, vector, *TECHNIQUE, most=100_000, tolerance=tolerance
                )
            longer.append(done["converged"])
    slacks, iterations = np.array(slacks), np.array(iterations)
    converged, longer = np.array(converged), np.array(longer)
    rows = []
    for low, high in zip((-np.inf, *SLACKS[:-1]), SLACKS, strict=True):
        chosen = (slacks >= low) & (slacks < high)
        done = iterations[chosen & converged]
        rows.append(
            {
                "from": None if low == -np.inf else low,
                "to": high,
                "forces": int(chosen.sum()),
                "unresolved": int((chosen & ~converged).sum()),
                "unresolved_after_100000": int((chosen & ~longer).sum()),
                "p50": float(np.median(done)) if len(done) else None,
                "most": int(done.max()) if len(done) else None,
            }
        )
    return rows


def measure(quick: bool) -> dict:
    count, per_structure = (60, 10) if quick else (1000, 20)
    found: dict = {
        "rule": [
            {"class": name, "reach": list(reach)} | try_rule(name, reach, count, per_structure)
            for reach in RANGES
            for name in CLASSES
        ]
    }
    learnt = sample("1-cycle", LEARN, 150 if quick else 2000, 5)
    weights = learn(learnt)
    risks = risk(weights, learnt)
    # the threshold that tells failures and successes apart best where the rule was learnt
    candidates = np.quantile(risks, np.linspace(0.5, 0.999, 200))
    failed = learnt.failed
    balanced = [(risks[failed] >= t).mean() + (risks[~failed] < t).mean() for t in candidates]
    threshold = float(candidates[int(np.argmax(balanced))])
    found["beforehand"] = {"weights": weights.tolist(), "threshold": threshold, "classes": []}
    for name in CLASSES:
        new = sample(name, TEST + 200_000, 60 if quick else 1000, 5)
        if name == "1-cycle":
            found["rates"] = rates(new)
        alarm = (r := risk(weights, new)) >= threshold
        short = np.array([bool((f[:, 1] < 5).all()) for f in new.features])
        found["beforehand"]["classes"].append(
            {
                "class": name,
                "forces": len(new.failed),
                "failed": int(new.failed.sum()),
                "auc": ranks_auc(r, new.failed),
                "caught": int((alarm & new.failed).sum()),
                "false_alarms": int((alarm & ~new.failed).sum()),
                "even_hits": int(((r >= 0.5) == new.failed).sum()),
                "short": int(short.sum()),
                "short_failed": int((short & new.failed).sum()),
            }
        )
    found["boundary"] = near_the_boundary(60 if quick else 1500, 10)
    return found


def tables(found: dict) -> dict[str, str]:
    rows = []
    for r in found["rule"]:
        total = r["kept"] + r["caught"] + r["missed"] + r["false_alarms"]
        failures = r["caught"] + r["missed"]
        rows.append(
            [
                r["class"],
                "{:g}:{:g}".format(*r["reach"]),
                total,
                failures,
                r["caught"],
                f"{r['missed']}, {r['missed_but_slow']} slow",
                r["false_alarms"],
                f"{r['false_final_alarms']} of {r['final_alarms']}",
                percent(r["kept"] + r["caught"], total),
                r["failures_with_anchors_at_rest"],
            ]
        )
    head = ["class", "force", "forces", "failed", "caught", "missed", "false alarms"]
    head += ["false where anchors are final", "hit rate"]
    out = {"rule": table([*head, "explained at the end"], rows)}

    rows = []
    for r in found["beforehand"]["classes"]:
        rows.append(
            [
                r["class"],
                r["forces"],
                r["failed"],
                f"{r['auc']:.3f}",
                percent(r["caught"], r["failed"]),
                percent(r["false_alarms"], r["forces"] - r["failed"]),
                percent(r["even_hits"], r["forces"]),
                percent(r["forces"] - r["failed"], r["forces"]),
                f"{r['short_failed']} of {r['short']}",
            ]
        )
    head = ["class", "forces", "failed", "AUC", "failures caught", "false alarms"]
    head += ["hit rate at risk 1/2", "of 'never fails'", "failed on cycles of 3 and 4"]
    out["beforehand"] = table(head, rows)

    head = ["", *(f"{low:g} to {high:g}" for low, high in SPREAD)]
    for name, bins, word in (
        ("by_cycle", LENGTHS, "cycle of {} joints"),
        ("by_distance", DISTANCES, "{} bars from the cycle"),
    ):
        rows = []
        for (low, high), row in zip(bins, found["rates"][name], strict=True):
            span = str(low) if low == high else f"{low} or more" if high == 99 else f"{low}–{high}"
            cells = [f"{percent(failed, total)} of {total}" for failed, total in row]
            rows.append([word.format(span), *cells])
        out[name] = table(head, rows)

    rows = [
        [
            "below 0" if r["from"] is None else f"{r['from']:g} to {r['to']:g}",
            r["forces"],
            r["unresolved"],
            r["unresolved_after_100000"],
            "–" if r["p50"] is None else f"{r['p50']:.0f}",
            r["most"] or "–",
        ]
        for r in found["boundary"]
    ]
    rows[-1][0] = f"above {SLACKS[-2]:g}"
    head = ["slack", "forces", "unresolved at 10,000", "at 100,000", "median iterations", "most"]
    out["boundary"] = table(head, rows)
    return out


def draw(found: dict, path: Path) -> None:
    figure, axes = plt.subplots(1, 3, figsize=(12, 3.8), constrained_layout=True)
    labels = [f"{low:g}–{high:g}" for low, high in SPREAD]
    for axis, name, bins, title in (
        (axes[0], "by_cycle", LENGTHS, "joints of the cycle"),
        (axes[1], "by_distance", DISTANCES, "bars from the forced joint to the cycle"),
    ):
        for k, ((low, high), row) in enumerate(zip(bins, found["rates"][name], strict=True)):
            failed, total = np.array(row, dtype=float).T
            rate = failed / np.maximum(total, 1)
            error = 1.96 * np.sqrt(rate * (1 - rate) / np.maximum(total, 1))
            span = str(low) if low == high else f"{low}+" if high == 99 else f"{low}–{high}"
            axis.errorbar(
                np.arange(len(SPREAD)) + 0.05 * (k - 1.5),
                100 * rate,
                100 * error,
                marker="o",
                capsize=2,
                color=COLOURS[k],
                label=span,
            )
        axis.set_xticks(range(len(SPREAD)), labels)
        axis.set_xlabel("force, mean bar lengths")
        axis.set_ylabel("1-cycles that fail, %")
        axis.legend(title=title, frameon=False, fontsize=9, title_fontsize=9)
    rows = [r for r in found["boundary"] if r["p50"]]
    axes[2].plot(range(len(rows)), [r["p50"] for r in rows], "o-", color=COLOURS[0])
    axes[2].set_yscale("log")
    names = [f"{r['from']:g}" for r in rows]
    axes[2].set_xticks(range(len(rows)), names)
    axes[2].set_xlabel("slack of the anchors after one pass, at least")
    axes[2].set_ylabel("median of iterations to 1e-6")
    for axis in axes:
        axis.spines[["top", "right"]].set_visible(False)
    figure.savefig(path, dpi=110)


if __name__ == "__main__":
    command_line(measure, tables, draw, "inconsistency.png")
