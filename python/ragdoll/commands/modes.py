"""``ragdoll modes``: the softest normal modes of a structure's elastic network."""

from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table
from rich.text import Text

from ..elastic_network import Modes, modes, write_h5, write_nmd, write_npz
from ..errors import InputError
from ..exits import DONE
from ..molecule import Molecule
from ..whole_file import whole_file
from .ligand_flags import NO_LIGANDS, LigandFlags, takes_ligands
from .method_options import AsJson, Quiet, check_file, show, tell

_KINDS = (".npz", ".nmd", ".h5")


@takes_ligands
def run(
    input: Annotated[Path, typer.Argument(help="PDB or mmCIF file, also .gz.")],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="Modes as .npz, .nmd (NMWiz, ProDy) or .h5."),
    ] = None,
    count: Annotated[int, typer.Option(help="How many modes, the softest.")] = 10,
    cutoff_angstrom: Annotated[
        float, typer.Option(help="Sites up to so far apart are joined by springs.")
    ] = 15.0,
    towards: Annotated[
        Path | None, typer.Option(help="Another structure: overlaps with the way to it.")
    ] = None,
    target_chain: Annotated[
        list[str] | None, typer.Option(help="Chain of --towards; may be repeated.")
    ] = None,
    ligands: LigandFlags = NO_LIGANDS,
    model: Annotated[int, typer.Option(help="Model of the file, from 1.")] = 1,
    altloc: Annotated[
        str | None, typer.Option(help="Alternate location; by default each residue's first.")
    ] = None,
    chain: Annotated[
        list[str] | None, typer.Option(help="Chain to keep; may be repeated. Default: all.")
    ] = None,
    as_json: AsJson = False,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing output.")] = False,
    quiet: Quiet = False,
) -> int:
    """Normal modes of the elastic network of CA (or P) atoms: stiffness and collectivity."""
    if output is not None:
        if output.suffix.lower() not in _KINDS:
            raise InputError(f"Modes cannot be written to {output}; give .npz, .nmd or .h5.")
        check_file(output, force, [input])
    if target_chain and towards is None:
        raise InputError("--target-chain is for --towards; give that, or leave it out.")
    ligands.check()
    molecule = Molecule.from_file(
        input, model=model, altloc=altloc, chains=chain, **ligands.arguments()
    )
    other = None if towards is None else Molecule.from_file(towards, chains=target_chain)
    found = modes(molecule, count=count, cutoff_angstrom=cutoff_angstrom, towards=other)
    tell([*molecule.notes, *found.notes], quiet)
    if output is not None:
        _write(found, output, force)
    show(found.as_dict(), as_json, quiet, lambda: _table(found))
    return DONE


def _write(found: Modes, output: Path, force: bool) -> None:
    """Write one output, which appears when it is complete."""
    if output.suffix.lower() == ".h5":
        write_h5(found, output, force)
        return
    with whole_file(output) as part:
        (write_npz if output.suffix.lower() == ".npz" else write_nmd)(found, part)


def _table(found: Modes) -> Table:
    table = Table(title=Text(found.molecule.source), title_justify="left")
    for name in ("mode", "eigenvalue", "collectivity"):
        table.add_column(name, justify="right")
    if found.overlaps is not None:
        table.add_column("overlap", justify="right")
        table.add_column("cumulative", justify="right")
    for mode in found.as_dict()["modes"]:
        row = [f"{mode['mode']}", f"{mode['eigenvalue']:.4g}", f"{mode['collectivity']:.3f}"]
        if found.overlaps is not None:
            row += [f"{mode['overlap']:.3f}", f"{mode['cumulative_overlap']:.3f}"]
        table.add_row(*row)
    return table
