"""The state of walkers in a file, from which a later run goes on."""

import json
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from .errors import InputError
from .version import __version__
from .whole_file import whole_file

# what has to be as it was for the steps to be those of one run
_SAME = ("input_hash", "seed", "replicas", "perturbation", "step_angstrom", "stride", "motion")


def write_states(path: Path, states: list[dict[str, Any]], parameters: dict[str, Any]) -> None:
    """Write the states of all walkers; the file appears when it is complete."""
    arrays: dict[str, Any] = {
        "version": __version__,
        "parameters": json.dumps({name: parameters[name] for name in _SAME}),
        "steps": np.array([state["steps"] for state in states]),
        "accepted": np.array([state["accepted"] for state in states]),
        "positions": np.array([state["positions"] for state in states]),
    }
    for k, state in enumerate(states):
        arrays[f"motion_{k}"] = state["motion"]
    with whole_file(path) as part, open(part, "wb") as file:
        np.savez(file, **arrays)


def read_states(path: Path, parameters: dict[str, Any], atoms: int) -> list[dict[str, Any]]:
    """Read what write_states wrote.

    Raises:
        InputError: the file cannot be read, or it belongs to another run.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            known = json.loads(str(file["parameters"]))
            states = [
                {
                    "positions": np.ascontiguousarray(positions),
                    "steps": int(steps),
                    "accepted": int(accepted),
                    "motion": file[f"motion_{k}"],
                }
                for k, (positions, steps, accepted) in enumerate(
                    zip(file["positions"], file["steps"], file["accepted"], strict=True)
                )
            ]
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror or error}.") from None
    except (ValueError, KeyError, zipfile.BadZipFile):
        raise InputError(f"{path} is no state of a run; give what --state wrote.") from None
    wanted = json.loads(json.dumps({name: parameters[name] for name in _SAME}))
    for name in _SAME:
        if known.get(name) != wanted[name]:
            raise InputError(
                f"{path} belongs to another run: its {name.replace('_', ' ')} is "
                f"{known.get(name)}, not {wanted[name]}."
            )
    if any(state["positions"].shape != (atoms, 3) for state in states):
        raise InputError(f"{path} belongs to another molecule.")
    return states
