"""How much a file's single precision may add to the violations of constraints."""

import math
from dataclasses import dataclass

import numpy as np

from ._core import Framework

_SHORTEST_CONTACT = 0.1  # nm; bounds of contacts are hardly ever shorter


@dataclass(frozen=True)
class Rounding:
    """The most that rounding adds to any constraint's violation."""

    relative: float  #: to the constraint's length or scale
    nanometers: float  #: as a length; of a volume: over scale^(2/3)


def rounding_of(framework: Framework, positions: np.ndarray) -> Rounding:
    """What rounding positions like these (nm) to single precision may do.

    Each coordinate moves by half a unit in the last place at most, each joint by sqrt(3) times
    that, a distance by both its ends, and a volume by its gradients.
    """
    moved = math.sqrt(3) * np.abs(positions).max(initial=1.0) * 2.0**-24
    lengths = np.concatenate(
        [framework.bar_lengths, framework.close_pair_lengths, [_SHORTEST_CONTACT]]
    )
    relative, nanometers = 2 * moved / lengths.min(), 2 * moved
    if len(framework.volumes):
        scale = framework.volume_scale
        change = moved * _gradients(positions[framework.volumes]).sum(axis=1)
        relative = max(relative, (change / scale).max())
        nanometers = max(nanometers, (change / scale ** (2 / 3)).max())
    return Rounding(float(relative), float(nanometers))


def _gradients(corners: np.ndarray) -> np.ndarray:
    """Lengths of a signed volume's gradients at its four joints; corners (n, 4, 3) -> (n, 4)."""
    ab, ac, ad = (corners[:, k] - corners[:, 0] for k in (1, 2, 3))
    b, c, d = np.cross(ac, ad), np.cross(ad, ab), np.cross(ab, ac)
    return np.linalg.norm(np.stack([b + c + d, b, c, d], axis=1), axis=2)
