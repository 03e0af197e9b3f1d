"""Sampling: random steps, each resolved; frames go to a trajectory."""

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from .errors import InputError
from .molecule import Molecule
from .sample_options import SampleOptions
from .sample_report import ReplicaReport, SampleReport
from .sample_run import IntegratorRun, ReplicaRun
from .trajectory import check_output

__all__ = ["ReplicaReport", "SampleOptions", "SampleReport", "check_paths", "sample"]


def check_paths(source: str | Path, output: str | Path, force: bool) -> None:
    """Raise InputError if the output cannot be written, or would replace what is read."""
    exist = os.path.exists(source) and os.path.exists(output)
    if exist and os.path.samefile(source, output):
        raise InputError(f"{output} is the input; give another name for the output.")
    check_output(output, force)


def sample(
    molecule: Molecule,
    output: str | Path,
    options: SampleOptions | None = None,
    *,
    force: bool = False,
    progress: Callable[[int, int], None] | None = None,
    parameters: Mapping[str, Any] | None = None,
    restart: str | Path | None = None,
    state: str | Path | None = None,
) -> SampleReport:
    """Sample conformations of a molecule into an HDF5 trajectory.

    Each step moves atoms, by thermal modes unless the options say otherwise, and resolves the
    framework; a step that does not converge or inverts a chirality centre is taken back and drawn anew from the last good frame. Every
    ``stride`` accepted steps make a frame; the input is not among them. At most 10 attempts are
    made for each accepted step that the frames need. KeyboardInterrupt ends the run early: what is
    done is kept, and the report says ``interrupted``.

    With ``options.replicas`` independent walkers start at the molecule, each with a seed of its
    own and each what a run with that seed would be. Their frames share the file: the first of
    each, then the second of each; the observables ``replica`` and ``seed`` tell whose a frame is.

    Perturbations other than "gaussian" and "ball", and symmetric copies, walk in core too, one
    walker without ``options.replicas``.

    Args:
        molecule: where to start.
        output: the trajectory, ``.h5``.
        options: how to sample.
        force: replace an existing output.
        progress: called with the frames done and the frames asked for.
        parameters: further ones to store, such as how the molecule was read.
        restart: a state that an earlier run with these options wrote: the walk goes on from there,
            as if it had not been interrupted.
        state: where to write the state that this walk ends in, ``.npz``.

    Returns:
        The report; ``frames`` is smaller than ``frames_asked`` where frames are missing.

    Raises:
        InputError: an option, the molecule or the output cannot be used.
        TrajectoryError: the disk takes no more.
    """
    options = options or SampleOptions()
    options.check()
    check_paths(molecule.source, output, force)
    options, notes = options.settled(molecule)
    by_walkers = options.by_walkers or restart is not None or state is not None
    kind = ReplicaRun if by_walkers else IntegratorRun
    run = kind(molecule, Path(output), options, force, parameters or {})
    run.report.notes.extend(notes)
    if isinstance(run, ReplicaRun) and restart is not None:
        run.go_on_from(Path(restart))
    try:
        run.sample(progress or (lambda done, asked: None))
    except KeyboardInterrupt:
        run.report.interrupted = True
    finally:
        run.close()
    if isinstance(run, ReplicaRun) and state is not None:
        run.keep_states(Path(state))
    run.measure()
    return run.report
