"""``ragdoll rigidity``: rigid clusters, hinges and floppy modes of a molecule."""

import os
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table
from rich.text import Text

from ..bond_lists import RigidityOptions
from ..errors import InputError
from ..exits import DONE
from ..molecule import Molecule
from ..rigidity_analysis import DilutionResult, RigidityResult, dilution, rigidity
from ..user_constraints import UserConstraint
from ..whole_file import part_of, whole_file
from .ligand_flags import NO_LIGANDS, LigandFlags, takes_ligands
from .method_options import AsJson, Quiet, check_file, names_of, show, tell

_DEFAULT = RigidityOptions()
_WEAKEST_OF_A_DILUTION = -0.1


@takes_ligands
def run(
    input: Annotated[Path, typer.Argument(help="PDB or mmCIF file, also .gz.")],
    output: Annotated[
        list[Path] | None,
        typer.Option(
            "--output",
            "-o",
            help="Clusters as .pml for PyMOL, .cif or .png; may be repeated.",
        ),
    ] = None,
    hbond_cutoff_kcal: Annotated[
        float | None,
        typer.Option(
            help="Hydrogen bonds at least this strong count, kcal/mol. "
            f"Default: {_DEFAULT.hbond_cutoff_kcal:g}, or {_WEAKEST_OF_A_DILUTION:g} of a dilution."
        ),
    ] = None,
    as_dilution: Annotated[
        bool,
        typer.Option("--dilution", help="All cutoffs: take hydrogen bonds away, weakest first."),
    ] = False,
    hbond_angstrom: Annotated[
        float, typer.Option(help="The most between hydrogen and acceptor.")
    ] = _DEFAULT.hbond_angstrom,
    hbond_angle_degree: Annotated[
        float, typer.Option(help="The least angle of donor, hydrogen and acceptor.")
    ] = _DEFAULT.hbond_angle_degree,
    tether_angstrom: Annotated[
        float,
        typer.Option(help="The most between surfaces of non-polar atoms; negative: no tethers."),
    ] = _DEFAULT.tether_angstrom,
    hbond_bars: Annotated[int, typer.Option(help="Bars of a hydrogen bond.")] = _DEFAULT.hbond_bars,
    tether_bars: Annotated[int, typer.Option(help="Bars of a tether.")] = _DEFAULT.tether_bars,
    lock: Annotated[
        str,
        typer.Option(
            help="Covalent bonds that do not turn: peptide, guanidinium, multiple, aromatic, "
            "primary_amide."
        ),
    ] = ",".join(_DEFAULT.locks),
    fix: Annotated[
        list[str] | None,
        typer.Option(help="'SEL': these atoms are one rigid body. May be repeated."),
    ] = None,
    move: Annotated[
        list[str] | None,
        typer.Option(help="'SEL': all atoms but these are one rigid body. May be repeated."),
    ] = None,
    ligands: LigandFlags = NO_LIGANDS,
    model: Annotated[int, typer.Option(help="Model of the file, from 1.")] = 1,
    altloc: Annotated[
        str | None, typer.Option(help="Alternate location; by default each residue's first.")
    ] = None,
    chain: Annotated[
        list[str] | None, typer.Option(help="Chain to keep; may be repeated. Default: all.")
    ] = None,
    keep_solvent: Annotated[
        bool, typer.Option("--keep-solvent", help="Keep waters and ions as bodies of their own.")
    ] = False,
    solvent_hbonds: Annotated[
        bool, typer.Option("--solvent-hbonds", help="Count hydrogen bonds of kept waters.")
    ] = False,
    add_hydrogens: Annotated[
        bool, typer.Option("--add-hydrogens", help="Add missing hydrogens by PDBFixer.")
    ] = False,
    ph: Annotated[float, typer.Option("--ph", help="For --add-hydrogens.")] = 7.0,
    as_json: AsJson = False,
    force: Annotated[bool, typer.Option("--force", help="Replace existing outputs.")] = False,
    quiet: Quiet = False,
) -> int:
    """Tell what in a molecule is rigid and what can move, by the pebble game over its bonds."""
    if hbond_cutoff_kcal is None:
        hbond_cutoff_kcal = _WEAKEST_OF_A_DILUTION if as_dilution else _DEFAULT.hbond_cutoff_kcal
    options = RigidityOptions(
        hbond_cutoff_kcal=hbond_cutoff_kcal,
        hbond_angstrom=hbond_angstrom,
        hbond_angle_degree=hbond_angle_degree,
        tether_angstrom=tether_angstrom,
        hbond_bars=hbond_bars,
        tether_bars=tether_bars,
        locks=tuple(names_of(lock) or ()),
        solvent_hbonds=solvent_hbonds,
        fixed=tuple(
            UserConstraint.parse(kind, text)
            for kind, texts in (("fix", fix), ("move", move))
            for text in texts or ()
        ),
    )
    # refuse before a large file is read
    options.check()
    outputs = output or []
    for path in outputs:
        _check_output(path, as_dilution, force, input)
    if not 0 <= ph <= 14:
        raise InputError(f"--ph must be from 0 to 14, not {ph}.")
    ligands.check()
    molecule = Molecule.from_file(
        input,
        model=model,
        altloc=altloc,
        chains=chain,
        keep_solvent=keep_solvent,
        add_hydrogens=add_hydrogens,
        ph=ph,
        **ligands.arguments(),
    )
    tell(molecule.notes, quiet)
    result = (dilution if as_dilution else rigidity)(molecule, options)
    tell(result.notes, quiet)
    for path in outputs:
        _write(path, result, input)
    table = _dilution_table if as_dilution else _table
    show(result.as_dict() if as_json else {}, as_json, quiet, lambda: table(result))
    return DONE


def _check_output(path: Path, as_dilution: bool, force: bool, source: Path) -> None:
    kinds = (".png",) if as_dilution else (".pml", ".cif", ".png")
    if path.suffix.lower() not in kinds:
        what = "A dilution" if as_dilution else "Rigid clusters"
        names = kinds[0] if as_dilution else ".pml, .cif or .png"
        raise InputError(f"{what} cannot be written to {path}; give a name that ends in {names}.")
    check_file(path, force, [source])
    part = part_of(path)
    try:
        part.touch()
        part.unlink()
    except OSError as error:
        raise InputError(f"{path} cannot be written: {error.strerror}.") from None


def _write(path: Path, result: RigidityResult | DilutionResult, source: Path) -> None:
    """Write one output, which appears when it is complete."""
    with whole_file(path) as part:
        if path.suffix.lower() == ".png":
            from .. import rigidity_picture

            rigidity_picture.draw(result, part)
        else:
            from .. import rigidity_files

            if path.suffix.lower() == ".pml":
                text = rigidity_files.pymol_script(result, os.path.abspath(source))
            else:
                text = rigidity_files.mmcif(result)
            part.write_text(text, encoding="utf-8")


def _table(result: RigidityResult) -> Table:
    bonds = result.bonds
    table = Table(title=Text(result.molecule.source), show_header=False, title_justify="left")
    table.add_row("atoms", f"{len(result.molecule)}")
    table.add_row("covalent bonds, locked", f"{len(bonds.covalent)}, {int(bonds.locked.sum())}")
    table.add_row(
        "hydrogen bonds, of these salt bridges",
        f"{len(bonds.hbonds)}, {int(bonds.salt_bridge.sum())}, "
        f"cutoff {result.options.hbond_cutoff_kcal:g} kcal/mol",
    )
    table.add_row("hydrophobic tethers", f"{len(bonds.tethers)}")
    table.add_row("degrees of freedom", f"{result.degrees_of_freedom}")
    table.add_row("floppy modes", f"{result.floppy_modes}")
    table.add_row(
        "rigid clusters",
        f"{len(result.cluster_sizes)}, the largest of "
        f"{', '.join(str(size) for size in result.cluster_sizes[:4])} atoms",
    )
    table.add_row("hinges", f"{len(result.hinges)}")
    groups = [(freedoms, len(hinges)) for freedoms, hinges in result.hinge_groups if freedoms]
    coupled = [f"{hinges} with {freedoms}" for freedoms, hinges in groups if hinges > 1][:3]
    if coupled:
        table.add_row("hinges that turn together, with freedoms", ", ".join(coupled))
    table.add_row(
        "over-constrained",
        f"{int((result.region_of_body >= 0).sum())} atoms, {result.redundant_bars} redundant bars",
    )
    return table


def _dilution_table(result: DilutionResult, most: int = 24) -> Table:
    table = Table(title=Text(result.molecule.source), title_justify="left")
    for name in ("cutoff, kcal/mol", "hydrogen bonds", "floppy modes", "clusters", "largest"):
        table.add_column(name, justify="right")
    step = max(1, -(-len(result) // most))
    chosen = [k for k in range(len(result)) if k % step == 0 or k == len(result) - 1]
    for index in chosen:
        level = result.at(index)
        cutoff = result.cutoffs_kcal[index]
        table.add_row(
            "none" if cutoff != cutoff else f"{cutoff:.2f}",
            f"{result.levels[index]}",
            f"{level.floppy_modes}",
            f"{len(level.cluster_sizes)}",
            f"{level.largest_cluster}",
        )
    return table
