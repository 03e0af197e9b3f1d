"""Formal charges of standard residues."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from openmm.app import Residue

from .residue_match import TemplateMatch

# The atom that carries the charge, the charge, the atoms whose hydrogens decide, and how many
# hydrogens the charged form has.
_IONIZED = {
    "ASP": ("OD2", -1, ("OD1", "OD2"), 0),
    "GLU": ("OE2", -1, ("OE1", "OE2"), 0),
    "LYS": ("NZ", 1, ("NZ",), 3),
    "ORN": ("NE", 1, ("NE",), 3),
    "ARG": ("NH2", 1, ("NE", "NH1", "NH2"), 5),
}
_NEUTRAL_BY_NAME = {"ASH", "GLH", "LYN", "ARN"}


def standard_charges(
    residues: Sequence[Residue],
    matches: Sequence[TemplateMatch | None],
    elements: NDArray[np.int32],
    bonds: dict[tuple[int, int], int],
) -> dict[int, int]:
    """Return the formal charge of each charged atom of standard residues.

    Hydrogens decide where there are any on the group; else the form that is usual at pH 7 is taken.

    Args:
        residues: the structure's residues.
        matches: their templates, None for residues that are not standard.
        elements: (N,) atomic numbers.
        bonds: all bonds.
    """
    hydrogens = [0] * len(elements)
    heavy = [0] * len(elements)
    for pair in bonds:
        for atom, other in (pair, pair[::-1]):
            if elements[other] == 1:
                hydrogens[atom] += 1
            else:
                heavy[atom] += 1

    charges: dict[int, int] = {}
    chain = None
    for residue, match in zip(residues, matches, strict=True):
        begins_chain = residue.chain is not chain
        chain = residue.chain
        if match is None:
            continue
        at = match.indices
        name = match.template.name
        if name in _IONIZED and residue.name not in _NEUTRAL_BY_NAME:
            carrier, charge, deciding, needed = _IONIZED[name]
            count = sum(hydrogens[at[atom]] for atom in deciding if atom in at)
            if carrier in at and count in (0, needed):
                charges[at[carrier]] = charge
        elif name == "HIS" and "ND1" in at and "NE2" in at:
            both = hydrogens[at["ND1"]] and hydrogens[at["NE2"]]
            if both or residue.name in ("HIP", "HSP"):
                charges[at["ND1"]] = 1
        elif residue.name == "CYM" and "SG" in at:
            charges[at["SG"]] = -1
        if match.template.is_amino_acid:
            _charge_ends(match, begins_chain, hydrogens, heavy, charges)
        elif match.template.is_nucleotide:
            for atom in ("OP2", "OP3"):
                if atom in at and heavy[at[atom]] == 1 and hydrogens[at[atom]] == 0:
                    charges[at[atom]] = -1
    return charges


def _charge_ends(
    match: TemplateMatch,
    begins_chain: bool,
    hydrogens: list[int],
    heavy: list[int],
    charges: dict[int, int],
) -> None:
    at = match.indices
    oxygens = [at[atom] for atom in ("OXT", "O") if atom in at]
    if "OXT" in at and heavy[at["OXT"]] == 1 and not any(hydrogens[i] for i in oxygens):
        charges[at["OXT"]] = -1
    if begins_chain and "N" in at and match.template.name != "PCA":
        own = 2 if match.template.name == "PRO" else 1
        # A nitrogen bonded to the residue before, or to a cap, is no end.
        if heavy[at["N"]] == own and hydrogens[at["N"]] in (0, 4 - own):
            charges[at["N"]] = 1
