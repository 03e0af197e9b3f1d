"""From records to the rows that are judged: ours, the baseline, their ratio, the goal."""

from collections.abc import Iterable

from programs import Records

KEYS = ("name", "ours", "baseline", "unit", "ratio", "goal", "sense", "met")
NEVER = 10_000  # iterations, where some force was not resolved: what the solver stops at
R = "plain"  # bars shuffled anew for each iteration, as the method has it
R_DRAWN_ONCE = "plain once"
SINGLE = ("auto", "newton", "ordered")  # solvers that get one break after the other


def ratio_row(
    name: str, unit: str, goal: float, ours: float | None, baseline: float | None
) -> dict:
    """Judged by baseline / ours, which is to be at least the goal."""
    ratio = baseline / ours if ours and baseline else None
    met = None if ratio is None else ratio >= goal
    return dict(zip(KEYS, (name, ours, baseline, unit, ratio, goal, ">=", met), strict=True))


def most_row(
    name: str, unit: str, goal: float | None, ours: float | None, baseline: float | None = None
) -> dict:
    """Judged by ours, which is to be at most the goal."""
    met = None if ours is None or goal is None else ours <= goal
    return dict(zip(KEYS, (name, ours, baseline, unit, None, goal, "<=", met), strict=True))


def select(records: Records, what: str, **wanted: object) -> Records:
    return [
        record
        for record in records
        if record["what"] == what and all(record.get(k) == v for k, v in wanted.items())
    ]


def largest(values: Iterable[float | None]) -> float | None:
    numbers = [value for value in values if value is not None]
    return max(numbers, default=None)


def smallest(values: Iterable[float | None]) -> float | None:
    numbers = [value for value in values if value is not None]
    return min(numbers, default=None)


def ms_each(record: dict) -> float | None:
    """ms for each break that was resolved and is right: the others' time is in it."""
    right = record["converged"] - record["wrong"]
    return record["ms"] * record["breaks"] / right if right > 0 else None


def fastest(records: Records) -> dict | None:
    """Of those that resolved most breaks."""
    right = [record for record in records if ms_each(record)]
    if not right:
        return None
    most = max(record["converged"] / record["breaks"] for record in right)
    return min(
        (record for record in right if record["converged"] / record["breaks"] == most), key=ms_each
    )


def first_molecule(records: Records, what: str) -> str | None:
    return next((r["molecule"] for r in records if r["what"] == what and "molecule" in r), None)


def ours_among(records: Records, *, ensemble: bool) -> dict | None:
    return fastest(
        [
            record
            for record in records
            if (" ensemble" in record["contender"] if ensemble else record["contender"] in SINGLE)
        ]
    )


# ---- one function for each group of rows


def block_iterations(records: Records) -> dict:
    cases = select(records, "block_iterations")
    clean = all(case["failed"] == 0 and case["wrong"] == 0 for case in cases)
    most = largest(case["most_iterations"] for case in cases)
    return most_row("block_iterations", "iterations", 1, most if clean else NEVER)


def small_cycles(records: Records, rival: str) -> list[dict]:
    """The worse of the two classes."""
    rows = []
    for name in ("p50", "p99"):
        pairs = []
        for class_name in ("1-cycle", "2-cycle"):
            found = {
                case["contender"]: case[f"{name}_us"]
                for case in select(records, "small_cycles", **{"class": class_name})
            }
            if rival in found:
                pairs.append((found["block"], found[rival]))
        ours, plain = min(pairs, key=lambda pair: pair[1] / pair[0], default=(None, None))
        rows.append(ratio_row(f"small_cycles_{name}", "us", 10, ours, plain))
    return rows


def forced_joint(records: Records, rival: str) -> list[dict]:
    """The worst size, from 1000 joints on."""
    large = [case for case in records if case.get("joints", 0) >= 1000]
    ours = select(large, "forced", contender="block")
    plain = select(large, "forced", contender=rival)
    failed = any(case["failed"] or case["wrong"] for case in ours)

    def worst(key: str) -> float | None:
        return None if failed else largest(case[key] for case in ours)

    return [
        most_row(f"forced_joint_{name}", key, goal, worst(key), largest(c[key] for c in plain))
        for name, key, goal in (("visits", "visits", 40), ("time", "us", 5))
    ]


def protein(records: Records, rival: str) -> list[dict]:
    rows = []
    found = select(
        records, "network", network="molecule", molecule=first_molecule(records, "network")
    )
    for tolerance, goals in ((1e-3, (300, 1000)), (1e-2, (10, 50))):
        cases = select(found, "network", tolerance=tolerance, tolerance_kind="angstrom")
        # R's breaks that were not resolved count with the time after which it gave up
        plain = next((case["ms"] for case in cases if case["contender"] == rival), None)
        for kind, goal in zip(("scalar", "ensemble"), goals, strict=True):
            best = ours_among(cases, ensemble=kind == "ensemble")
            name = f"protein_{'1e-3' if tolerance == 1e-3 else '1e-2'}_{kind}"
            rows.append(ratio_row(name, "ms", goal, ms_each(best) if best else None, plain))
    return rows


def dhfr_conformer(records: Records) -> dict:
    """Of DHFR; where its file is missing, of another molecule, as if it had DHFR's 1268 atoms."""
    best = smallest(
        case["ms_per_accepted"] * (1 if case["molecule"] == "DHFR" else 1268 / case["joints"])
        for case in select(records, "conformers", network="contacts", wrong=0, inverted=0)
    )
    return most_row("dhfr_conformer", "ms", 0.15, best)


def ccma(records: Records) -> list[dict]:
    """Where OpenMM converges."""
    molecule = first_molecule(records, "network")
    cases = select(records, "network", network="bonds", molecule=molecule, tolerance=6e-4)
    rivals = select(
        records, "openmm", network="bonds", molecule=molecule, tolerance=6e-4, converged=True
    )
    openmm = smallest(r["ms"] for r in rivals if abs(r["sigma_angstrom"] - 0.1) < 1e-9)
    rows = []
    for kind, goal in (("single", 5), ("ensemble", 20)):
        best = ours_among(cases, ensemble=kind == "ensemble")
        rows.append(ratio_row(f"ccma_{kind}", "ms", goal, ms_each(best) if best else None, openmm))
    return rows


def newton_sizes(records: Records) -> list[dict]:
    """From 1000 joints on, to 1e-3 A."""
    cases = [
        case
        for case in select(records, "network", contender="newton", tolerance=1e-3)
        if "molecule" not in case and case["joints"] >= 1000
    ]
    first = min(cases, key=lambda case: case["joints"], default=None)
    if first is None:
        return [
            most_row("newton_iterations", "iterations", None, None),
            most_row("newton_linear", "times", 1.5, None),
        ]
    right = all(case["converged"] == case["breaks"] and not case["wrong"] for case in cases)
    most = max(case["most_iterations"] for case in cases) if right else NEVER
    at_first = first["most_iterations"]
    linear = max(case["ms"] / case["joints"] for case in cases) / (first["ms"] / first["joints"])
    return [
        most_row("newton_iterations", "iterations", at_first + 1, most, at_first),
        most_row("newton_linear", "times", 1.5, linear, 1.0),
    ]


def setup(records: Records) -> dict:
    """Framework and `newton` of a peptide's bonds, at the largest size that OpenMM was given."""
    rivals = select(records, "setup", part="openmm")
    rival = max(rivals, key=lambda record: record["joints"], default=None)
    ours = None
    if rival is not None:
        parts = [
            select(records, "setup", network="bonds", part=part, joints=rival["joints"])
            for part in ("framework", "newton")
        ]
        if all(parts):
            ours = sum(part[0]["ms"] for part in parts)
    return ratio_row("setup", "ms", 1000, ours, rival["ms"] if rival else None)


def inverted(records: Records) -> dict:
    """Over all accepted frames of every run."""
    counts = [record["inverted"] for record in records if "inverted" in record]
    return most_row("inverted", "centres", 0, sum(counts) if counts else None)


def rows_of(records: Records, rival: str = R) -> list[dict]:
    """The list of the JSON file. `rival` is the contender that R stands for."""
    return [
        block_iterations(records),
        *small_cycles(records, rival),
        *forced_joint(records, rival),
        *protein(records, rival),
        dhfr_conformer(records),
        *ccma(records),
        *newton_sizes(records),
        setup(records),
        inverted(records),
    ]
