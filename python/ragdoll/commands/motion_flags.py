"""The flags of MotionOptions, for the command that samples."""

import functools
import inspect
from typing import Annotated, Any

import typer

from ..motion_options import MotionOptions
from .method_options import names_of

_DEFAULT = MotionOptions()


def _flags(
    temperature_kelvin: Annotated[
        float, typer.Option(help="thermal: what takes modes from the start, by its square root.")
    ] = _DEFAULT.temperature_kelvin,
    thermal_step_angstrom: Annotated[
        float, typer.Option(help="thermal: RMSD of a step, of CA and P.")
    ] = _DEFAULT.thermal_step_angstrom,
    thermal_modes: Annotated[
        int, typer.Option(help="thermal: how many modes swing, softest first.")
    ] = _DEFAULT.thermal_modes,
    persistence: Annotated[
        float, typer.Option(help="momentum: share of the last step that is made again, 0 to 1.")
    ] = _DEFAULT.persistence,
    hinge_degree: Annotated[
        float, typer.Option(help="hinge: deviation of the turns.")
    ] = _DEFAULT.hinge_degree,
    hinge_share: Annotated[
        float, typer.Option(help="hinge: share of the rotatable bonds that turn in a step.")
    ] = _DEFAULT.hinge_share,
    modes: Annotated[
        str, typer.Option(help="modes: which, softest first, such as 1-10 or 1,3.")
    ] = _DEFAULT.modes,
    mode_amplitude_angstrom: Annotated[
        float, typer.Option(help="modes: CA RMSD from the start at which a mode turns back.")
    ] = _DEFAULT.mode_amplitude_angstrom,
    mode_step_angstrom: Annotated[
        float, typer.Option(help="modes: CA RMSD of one step along the mode.")
    ] = _DEFAULT.mode_step_angstrom,
    mode_cutoff_angstrom: Annotated[
        float, typer.Option(help="modes: sites of the elastic network up to so far are joined.")
    ] = _DEFAULT.mode_cutoff_angstrom,
    steer: Annotated[
        list[str] | None,
        typer.Option(
            help="steer: 'SELECTION; X Y Z' pulls atoms by a vector in each step, angstrom; "
            "'SELECTION; to X Y Z' draws their centroid to a point. May be repeated."
        ),
    ] = None,
    steer_angstrom: Annotated[
        float, typer.Option(help="steer: how far a step draws atoms to a point.")
    ] = _DEFAULT.steer_angstrom,
    away_from: Annotated[
        str, typer.Option(help="away: nearest, centroid or density of the conformers visited.")
    ] = _DEFAULT.away_from,
    away_angstrom: Annotated[
        float, typer.Option(help="away: CA RMSD of one step away.")
    ] = _DEFAULT.away_angstrom,
    away_spacing_angstrom: Annotated[
        float, typer.Option(help="away: CA RMSD between conformers that are remembered.")
    ] = _DEFAULT.away_spacing_angstrom,
    symmetric: Annotated[
        str | None,
        typer.Option(help="Chains of one sequence that move alike, such as A,B.", metavar="CHAINS"),
    ] = None,
) -> MotionOptions:
    return MotionOptions(
        temperature_kelvin=temperature_kelvin,
        thermal_step_angstrom=thermal_step_angstrom,
        thermal_modes=thermal_modes,
        persistence=persistence,
        hinge_degree=hinge_degree,
        hinge_share=hinge_share,
        modes=modes,
        mode_amplitude_angstrom=mode_amplitude_angstrom,
        mode_step_angstrom=mode_step_angstrom,
        mode_cutoff_angstrom=mode_cutoff_angstrom,
        steer=tuple(steer or ()),
        steer_angstrom=steer_angstrom,
        away_from=away_from,
        away_angstrom=away_angstrom,
        away_spacing_angstrom=away_spacing_angstrom,
        symmetric=tuple(names_of(symmetric) or ()),
    )


def takes_motion(command: Any) -> Any:
    """Give a command the flags, in the place of its parameter ``motion``."""
    own = inspect.signature(command)
    flags = inspect.signature(_flags).parameters
    parameters = []
    for name, parameter in own.parameters.items():
        parameters.extend(flags.values() if name == "motion" else [parameter])

    @functools.wraps(command)
    def run(**values: Any) -> Any:
        motion = _flags(**{name: values.pop(name) for name in flags})
        return command(**values, motion=motion)

    run.__signature__ = inspect.Signature(
        [p.replace(kind=inspect.Parameter.KEYWORD_ONLY) for p in parameters]
    )
    run.__annotations__ = {p.name: p.annotation for p in parameters}
    return run
