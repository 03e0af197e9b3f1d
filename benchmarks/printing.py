"""The tables that are printed."""

from rich.console import Console
from rich.table import Table

from limits import limits_of
from programs import Records
from rows import R_DRAWN_ONCE, R, ms_each, rows_of, select


def digits(value: float | None, form: str = ".3g") -> str:
    return "-" if value is None else f"{value:{form}}"


def judged(records: Records) -> Table:
    """The rows of the JSON file beside their physical limits."""
    limits = limits_of(records)
    table = Table("row", "ours", "baseline", "unit", "ratio", "goal", "met", "limit", "x limit")
    table.add_column("ratio, R's order drawn once")
    for row, once in zip(rows_of(records), rows_of(records, R_DRAWN_ONCE), strict=True):
        limit = limits.get(row["name"])
        off = row["ours"] / limit if limit and row["ours"] is not None else None
        table.add_row(
            row["name"],
            digits(row["ours"]),
            digits(row["baseline"]),
            row["unit"],
            digits(row["ratio"]),
            f"{row['sense']} {digits(row['goal'], 'g')}",
            {True: "yes", False: "no", None: "-"}[row["met"]],
            digits(limit),
            digits(off),
            "" if once["ratio"] == row["ratio"] else digits(once["ratio"]),
        )
    return table


def networks(records: Records) -> Table:
    """All joints displaced by 0.1 A for each coordinate."""
    table = Table(
        "network", "joints", "tolerance", "contender", "ms", "iterations", "most", "resolved"
    )
    table.add_column("x R")
    table.add_column("x lean R")
    table.add_column("x R, order drawn once")
    cases = select(records, "network")
    group = None
    for case in cases:
        key = [case.get("molecule", "peptide"), case["network"], case["joints"], case["tolerance"]]
        if group is not None and key != group:
            table.add_section()
        group = key

        def speed(rival: str, case: dict = case, key: list = key) -> float | None:
            for other in cases:
                same = [other.get("molecule", "peptide"), other["network"]]
                same += [other["joints"], other["tolerance"]]
                if same == key and other["contender"] == rival and ms_each(case):
                    return other["ms"] / ms_each(case)
            return None

        unit = " A" if case["tolerance_kind"] == "angstrom" else ""
        resolved = f"{case['converged']}/{case['breaks']}"
        if case["wrong"]:
            resolved += f", {case['wrong']} wrong"
        if case["inverted"]:
            resolved += f", {case['inverted']} inverted"
        table.add_row(
            f"{key[0]}, {key[1]}",
            str(case["joints"]),
            f"{case['tolerance']:g}{unit}",
            case["contender"],
            digits(case["ms"]),
            digits(case["iterations"]),
            digits(case["most_iterations"], "d"),
            resolved,
            digits(speed(R)),
            digits(speed("plain lean")),
            digits(speed(R_DRAWN_ONCE)),
        )
    return table


def openmm(records: Records) -> Table:
    """applyConstraints: where it converges and where it does not."""
    table = Table(
        "OpenMM's CCMA on", "angle forces", "tolerance", "displaced by, A", "ms", "worst |d - L|/L"
    )

    def beside(case: dict) -> str:
        for ours in select(
            records,
            "fails",
            molecule=case["molecule"],
            network=case["network"],
            contender="newton",
        ):
            if abs(ours["sigma_angstrom"] - case["sigma_angstrom"]) < 1e-9:
                return f"{ours['converged']}/{ours['breaks']}, {ours['ms']:.3g} ms"
        return ""

    for case in select(records, "openmm"):
        worst = case["worst_relative"]
        if worst is None or worst > 1e3:
            told = "NaN or infinite" if worst is None else f"{worst:.1e}"
        else:
            told = f"{worst:.1e}" + ("" if case["converged"] else ", not converged")
        table.add_row(
            f"{case['molecule']}, {case['network']}, {case['bars']} constraints",
            "yes" if case["angle_forces"] else "no",
            f"{case['tolerance']:g}",
            f"{case['sigma_angstrom']:g}",
            digits(case["ms"]),
            told,
            beside(case),
        )
    return table


def conformers(records: Records) -> Table:
    table = Table("conformers of", "contacts", "solver", "precision", "lanes", "accepted")
    table.add_column("ms each")
    table.add_column("contacts add, ms a step")
    for case in select(records, "conformers"):
        contacts = case["network"] == "contacts"
        without = select(
            records,
            "conformers",
            network="molecule",
            solver=case["solver"],
            precision=case["precision"],
            molecule=case["molecule"],
        )
        added = case["ms_per_step"] - without[0]["ms_per_step"] if contacts and without else None
        works = "" if case["works"] == case["solver"] else f" ({case['works']})"
        accepted = f"{case['accepted']}/{case['steps']}"
        if case["wrong"] or case["inverted"]:
            accepted += f", {case['wrong']} wrong, {case['inverted']} inverted"
        table.add_row(
            case["molecule"],
            "yes" if contacts else "no",
            case["solver"] + works,
            case["precision"],
            f"{case['lanes']} {case['instructions']}",
            accepted,
            digits(case["ms_per_accepted"]),
            digits(added),
        )
    return table


def forced(records: Records) -> Table:
    table = Table("one forced joint, bonds", "contender", "visits", "us", "failed", "wrong")
    for case in select(records, "forced"):
        table.add_row(
            f"{case['joints']} joints",
            case["contender"],
            digits(case["visits"]),
            digits(case["us"]),
            digits(case.get("failed"), "d"),
            digits(case.get("wrong"), "d"),
        )
    return table


def cycles(records: Records) -> Table:
    table = Table("block", "tolerance", "forces", "most iterations", "failed", "wrong")
    table.add_column("visits for each bar")
    for case in select(records, "block_iterations"):
        table.add_row(
            case["class"],
            f"{case['tolerance']:g}",
            str(case["forces"]),
            str(case["most_iterations"]),
            str(case["failed"]),
            str(case["wrong"]),
            digits(case["visits_per_bar"]),
        )
    table.add_section()
    for case in select(records, "small_cycles"):
        table.add_row(
            f"{case['class']}, {case['contender']}",
            "1e-06",
            "1000",
            "",
            "",
            "",
            f"p50 {case['p50_us']:.3g} us, p99 {case['p99_us']:.3g} us",
        )
    return table


def visits(records: Records) -> Table:
    table = Table("2000 joints", "loop", "ns a bar visit", "ms")
    for case in select(records, "visits"):
        table.add_row(
            case["network"],
            case["contender"],
            digits(case["ns_per_visit"]),
            digits(case["ms"]),
        )
    return table


def setup(records: Records) -> Table:
    table = Table("set-up of a peptide", "part", "joints", "ms", "us a joint")
    for case in select(records, "setup"):
        table.add_row(
            case["network"],
            case["part"],
            str(case["joints"]),
            digits(case["ms"]),
            digits(1e3 * case["ms"] / case["joints"]),
        )
    return table


def numbering(records: Records) -> Table:
    table = Table("ordered, a peptide's bonds", "joints numbered", "order", "precision", "ms")
    table.add_column("ns a bar visit")
    for case in select(records, "numbering"):
        table.add_row(
            f"{case['joints']} joints",
            case["numbering"],
            case["order"],
            case["precision"],
            digits(case["ms"]),
            digits(1e6 * case["ms"] / case["visits"]),
        )
    return table


def steps(records: Records) -> Table:
    table = Table("accepted step of", "by", "ms")
    for case in select(records, "step"):
        table.add_row(case["molecule"], case["contender"], digits(case["ms"]))
    return table


def print_all(records: Records) -> None:
    console = Console(highlight=False)
    if not console.is_terminal:
        console.width = 130  # a file or a pipe has no width of its own
    ours = (visits, numbering, cycles, forced, networks, openmm, conformers, setup, steps)
    for make in (*ours, judged):
        table = make(records)
        if table.row_count:
            console.print(table)
