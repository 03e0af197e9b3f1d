"""The flags of ConstraintOptions, for every command that samples."""

import functools
import inspect
from pathlib import Path
from typing import Annotated, Any

import typer

from ..constraint_options import ConstraintOptions
from ..user_constraints import UserConstraint, read_constraints

_DEFAULT = ConstraintOptions()


def _flags(
    hbonds: Annotated[
        bool, typer.Option("--hbonds/--no-hbonds", help="Hold hydrogen bonds and salt bridges.")
    ] = _DEFAULT.hbonds,
    hbond_cutoff_kcal: Annotated[
        float, typer.Option(help="Hydrogen bonds at least this strong are held, kcal/mol.")
    ] = _DEFAULT.hbond_cutoff_kcal,
    hbond_angstrom: Annotated[
        float, typer.Option(help="The most between hydrogen and acceptor.")
    ] = _DEFAULT.hbond_angstrom,
    hbond_angle_degree: Annotated[
        float, typer.Option(help="The least angle of donor, hydrogen and acceptor.")
    ] = _DEFAULT.hbond_angle_degree,
    hbond_room: Annotated[
        float, typer.Option(help="Share of the room that criteria leave to the length, 0 to 1.")
    ] = _DEFAULT.hbond_room,
    place_hydrogens: Annotated[
        bool,
        typer.Option(
            "--place-hydrogens/--no-place-hydrogens",
            help="Find hydrogen bonds of molecules without hydrogens by placing them.",
        ),
    ] = _DEFAULT.place_hydrogens,
    solvent_hbonds: Annotated[
        bool, typer.Option("--solvent-hbonds", help="Hold hydrogen bonds of kept waters.")
    ] = _DEFAULT.solvent_hbonds,
    hydrophobic: Annotated[
        bool, typer.Option("--hydrophobic/--no-hydrophobic", help="Hold non-polar contacts.")
    ] = _DEFAULT.hydrophobic,
    tether_margin_angstrom: Annotated[
        float, typer.Option(help="The most between surfaces of non-polar atoms and rings.")
    ] = _DEFAULT.tether_margin_angstrom,
    stacking: Annotated[
        bool, typer.Option("--stacking/--no-stacking", help="Hold stacked aromatic rings.")
    ] = _DEFAULT.stacking,
    stacking_angstrom: Annotated[
        float, typer.Option(help="The most between centres of stacked rings.")
    ] = _DEFAULT.stacking_angstrom,
    stacking_angle_degree: Annotated[
        float, typer.Option(help="The most between planes of stacked rings.")
    ] = _DEFAULT.stacking_angle_degree,
    metals: Annotated[
        bool, typer.Option("--metals/--no-metals", help="Bars from metals to what binds them.")
    ] = _DEFAULT.metals,
    torsion_basins: Annotated[
        bool,
        typer.Option("--torsion-basins/--no-torsion-basins", help="Keep phi and psi plausible."),
    ] = _DEFAULT.torsion_basins,
    torsion_region: Annotated[
        str, typer.Option(help="basin: each residue's own; joined: helix and strand are joined.")
    ] = _DEFAULT.torsion_region,
    staggered: Annotated[
        bool, typer.Option("--staggered/--no-staggered", help="Side chains are not eclipsed.")
    ] = _DEFAULT.staggered,
    eclipsed_degree: Annotated[
        float, typer.Option(help="How near side chains come to the eclipsed positions.")
    ] = _DEFAULT.eclipsed_degree,
    bar: Annotated[
        list[str] | None,
        typer.Option(
            help="'SEL1; SEL2; ANGSTROM' or 'SEL1; SEL2': keep this or the present distance "
            "between the atoms of two selections (MDAnalysis' language). May be repeated."
        ),
    ] = None,
    tether: Annotated[
        list[str] | None,
        typer.Option(help="'SEL1; SEL2; ANGSTROM': keep them at most so far apart."),
    ] = None,
    contact: Annotated[
        list[str] | None,
        typer.Option(help="'SEL1; SEL2; ANGSTROM': keep them at least so far apart."),
    ] = None,
    fix: Annotated[list[str] | None, typer.Option(help="'SEL': these atoms do not move.")] = None,
    move: Annotated[
        list[str] | None,
        typer.Option(
            help="'SEL': these atoms move and all others are fixed, such as 'resname LIG or byres "
            "around 8 resname LIG'."
        ),
    ] = None,
    constraints_file: Annotated[
        Path | None,
        typer.Option("--constraints", help="JSON list of bars, tethers, contacts, fixed atoms."),
    ] = None,
) -> ConstraintOptions:
    values = dict(locals())
    user: list[UserConstraint] = []
    for kind in ("bar", "tether", "contact", "fix", "move"):
        user += [UserConstraint.parse(kind, text) for text in values.pop(kind) or ()]
    file = values.pop("constraints_file")
    if file is not None:
        user += read_constraints(file)
    options = ConstraintOptions(**values, user=tuple(user))
    options.check()
    return options


def takes_constraints(command):
    """Give a command that has a parameter ``constraints`` the flags that make it.

    The flags come in the place of the parameter, which gets a ConstraintOptions.
    """
    own = inspect.signature(command).parameters
    flags = inspect.signature(_flags).parameters

    @functools.wraps(command)
    def run(**values: Any):
        constraints = _flags(**{name: values.pop(name) for name in flags})
        return command(**values, constraints=constraints)

    parameters = []
    for name, parameter in own.items():
        parameters += flags.values() if name == "constraints" else [parameter]
    # typer asks for keywords alone, in this sequence
    run.__signature__ = inspect.Signature(
        [p.replace(kind=inspect.Parameter.KEYWORD_ONLY) for p in parameters]
    )
    run.__annotations__ = {p.name: p.annotation for p in parameters}
    return run
