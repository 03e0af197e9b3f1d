"""Atoms by a selection in MDAnalysis' language."""

import numpy as np
from numpy.typing import NDArray

from .molecule import Molecule


def select_atoms(molecule: Molecule, text: str, origin: str) -> NDArray[np.int64]:
    """The atoms that a selection matches.

    Args:
        molecule: whose atoms.
        text: the selection, such as "resid 1:20 and name CA".
        origin: what messages call it.

    Raises:
        InputError: the text is no selection, or it matches nothing.
    """
    from .user_constraints import UserConstraint, _Selector

    return _Selector(molecule)(text, UserConstraint("fix", text, origin=origin))
