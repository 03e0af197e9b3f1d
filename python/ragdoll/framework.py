"""From a molecule to its framework; the decisions are core's."""

from collections.abc import Sequence

import numpy as np
from openmm import unit

from . import _core
from .constraint_options import ConstraintOptions
from .errors import InputError
from .molecule import Molecule

# what a trajectory file keeps of a framework
_ARRAYS = (
    "masses",
    "fixed",
    "bars",
    "bar_lengths",
    "bar_kinds",
    "tethers",
    "tether_lengths",
    "tether_kinds",
    "contacts",
    "contact_lengths",
    "contact_kinds",
    "hydrogen_bonds",
    "hydrogen_bond_energies",
    "salt_bridges",
    "volumes",
    "volume_lower",
    "volume_upper",
    "volume_scale",
    "volume_kinds",
    "contact_radii",
    "contact_polarity",
    "contact_exclusions",
    "close_pairs",
    "close_pair_lengths",
)


def core_molecule(molecule: Molecule) -> _core.Molecule:
    """The molecule as core sees it.

    Raises:
        InputError: a bond or a coordinate makes no sense.
    """
    try:
        return _core.Molecule(
            molecule.elements,
            molecule.charges,
            molecule.masses,
            molecule.positions,
            molecule.bonds,
            molecule.bond_orders,
            molecule.labels,
        )
    except ValueError as error:
        raise InputError(f"{molecule.source or 'The molecule'}: {error}.") from None


def _nanometers(length: float | unit.Quantity) -> float:
    return float(length.value_in_unit(unit.nanometer) if unit.is_quantity(length) else length)


def build_framework(
    molecule: Molecule,
    *,
    contacts: bool = True,
    contact_scale: float = 0.85,
    planarity_degree: float = 10.0,
    heavy_allowance: float | unit.Quantity = 0.01,
    hydrogen_allowance: float | unit.Quantity = 0.05,
    constraints: ConstraintOptions | None = None,
    conformations: Sequence[np.ndarray] = (),
) -> _core.Framework:
    """Bars from bonds (1-2), angles (1-3) and planar units (1-4), at their lengths in the input;
    volumes that keep tetrahedral centres and planar units; contacts from van der Waals radii; with
    ``constraints`` also hydrogen bonds, tethers, torsions and the user's own.

    Args:
        molecule: atoms, bonds and positions; with box vectors, contacts are by minimum image.
        contacts: whether atoms keep apart.
        contact_scale: contacts are at least this share of the sum of the radii (Bondi 1964; H by
            Rowland and Taylor 1996), unless they start closer.
        planarity_degree: how far planar units may turn or bend from the input.
        heavy_allowance: how much closer pairs of N, O, F and S may come, nm.
        hydrogen_allowance: how much closer a polar hydrogen may come to N, O, F and S, nm.
        constraints: what holds beside covalent bonds; None: nothing.
        conformations: further positions (N, 3) in nm, such as the end of a path, that
            ``constraints`` have to allow: bounds are wide enough for them, and hydrogen bonds and
            tethers that one of them does not have are not held.

    Raises:
        InputError: two atoms are at one place, an option is out of range, or a selection is wrong.
    """
    asked = None if constraints is None else constraints.for_core(molecule, conformations)
    try:
        return _core.build_framework(
            core_molecule(molecule),
            contacts=contacts,
            contact_scale=contact_scale,
            planarity_degree=planarity_degree,
            heavy_allowance=_nanometers(heavy_allowance),
            hydrogen_allowance=_nanometers(hydrogen_allowance),
            constraints=asked,
            box_vectors=molecule.box_vectors,
        )
    except InputError:
        raise
    except ValueError as error:
        raise InputError(f"{molecule.source or 'The molecule'}: {error}.") from None


def framework_arrays(framework: _core.Framework) -> dict[str, np.ndarray]:
    """The framework as named arrays, for a trajectory file: enough to measure it again."""
    arrays = {name: getattr(framework, name) for name in _ARRAYS}
    arrays["contact_rule"] = np.array(
        [
            framework.contact_scale,
            framework.contact_heavy_allowance,
            framework.contact_hydrogen_allowance,
        ]
    )
    return arrays


def peptide_torsions(molecule: Molecule) -> np.ndarray:
    """Omega torsions CA-C-N-CA of all peptide bonds between residues. (n, 4) int32."""
    atoms = list(molecule.topology.atoms())
    alpha = {atom.residue.index: atom.index for atom in atoms if atom.name == "CA"}
    torsions = []
    for i, j in molecule.bonds:
        first, second = atoms[i], atoms[j]
        if (first.name, second.name) == ("N", "C"):
            first, second = second, first
        if (first.name, second.name) != ("C", "N") or first.residue is second.residue:
            continue
        ends = alpha.get(first.residue.index), alpha.get(second.residue.index)
        if None not in ends:
            torsions.append((ends[0], first.index, second.index, ends[1]))
    return np.array(torsions, dtype=np.int32).reshape(-1, 4)
