"""ConstraintOptions: what holds a framework beside its covalent bonds."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from . import _core
from .errors import InputError
from .molecule import Molecule
from .user_constraints import UserConstraint, bounds_of

_ANGSTROM = 10.0  # per nm
_REGIONS = ("basin", "joined")


@dataclass(frozen=True)
class ConstraintOptions:
    """Which constraints hold beside covalent ones; by default all. No bound is tighter than the
    input, but the user's own.

    Attributes:
        hbonds: hydrogen bonds and salt bridges.
        hbond_cutoff_kcal: those at least this strong, kcal/mol (Dahiyat, Gordon and Mayo 1997).
        hbond_angstrom: the most between hydrogen and acceptor; sulfur and salt bridges reach
            further by 0.5 and 1.0 angstrom.
        hbond_angle_degree: the least angle of donor, hydrogen and acceptor.
        hbond_room: how much of the room between its length and the most a hydrogen bond may use;
            the rest is for its angles. From 0 to 1.
        place_hydrogens: where a molecule has no hydrogens, place those of donors to find hydrogen
            bonds by; heavy atoms are held then.
        solvent_hbonds: those of waters that are kept, too.
        hydrophobic: tethers between non-polar C and S that touch.
        tether_margin_angstrom: how far their surfaces, and those of stacked rings, may be apart.
        stacking: tethers between aromatic rings that lie on each other.
        stacking_angstrom, stacking_angle_degree: the most between their centres and planes.
        metals: bars from metals to the N, O and S that coordinate them, and to what the file
            records as bonded to them.
        torsion_basins: phi and psi stay where residues of their kind are found.
        torsion_region: "basin", the part of the map that a residue starts in, or "joined", where
            helix and strand are joined by the bridge between them.
        staggered: bonds of side chains keep off the eclipsed positions,
        eclipsed_degree: by this much.
        user: the user's own constraints.
    """

    hbonds: bool = True
    hbond_cutoff_kcal: float = -1.0
    hbond_angstrom: float = 2.5
    hbond_angle_degree: float = 110.0
    hbond_room: float = 0.5
    place_hydrogens: bool = True
    solvent_hbonds: bool = False
    hydrophobic: bool = True
    tether_margin_angstrom: float = 0.5
    stacking: bool = True
    stacking_angstrom: float = 5.5
    stacking_angle_degree: float = 30.0
    metals: bool = True
    torsion_basins: bool = True
    torsion_region: str = "basin"
    staggered: bool = True
    eclipsed_degree: float = 20.0
    user: tuple[UserConstraint, ...] = ()

    @classmethod
    def none(cls, user: tuple[UserConstraint, ...] = ()) -> "ConstraintOptions":
        """Nothing but what the user sets."""
        return cls(
            hbonds=False,
            hydrophobic=False,
            stacking=False,
            metals=False,
            torsion_basins=False,
            staggered=False,
            user=user,
        )

    def check(self) -> None:
        """Refuse what makes no sense.

        Raises:
            InputError: a value is out of range; the message names it.
        """
        numbers = (
            ("hbond_cutoff_kcal", "kcal/mol", -100.0, 0.0),
            ("hbond_angstrom", "angstrom", 1.0, 5.0),
            ("hbond_angle_degree", "degrees", 90.0, 180.0),
            ("hbond_room", "", 0.0, 1.0),
            ("tether_margin_angstrom", "angstrom", 0.0, 5.0),
            ("stacking_angstrom", "angstrom", 0.0, 10.0),
            ("stacking_angle_degree", "degrees", 0.0, 90.0),
            ("eclipsed_degree", "degrees", 0.0, 55.0),
        )
        for name, unit, low, high in numbers:
            value = getattr(self, name)
            if not math.isfinite(value) or not low <= value <= high:
                words = f"{unit}, " if unit else ""
                raise InputError(
                    f"--{name.replace('_', '-')} must be a number of {words}from {low:g} to "
                    f"{high:g}, not {value}."
                )
        if self.torsion_region not in _REGIONS:
            raise InputError(
                f"--torsion-region must be one of {', '.join(_REGIONS)}, not "
                f"'{self.torsion_region}'."
            )

    def for_core(
        self, molecule: Molecule, conformations: Sequence[NDArray[np.float64]] = ()
    ) -> _core.ConstraintOptions:
        """The options as core takes them, with the user's selections made.

        Args:
            molecule: whose atoms are selected.
            conformations: further positions (N, 3) in nm that the constraints have to allow.

        Raises:
            InputError: a value or a selection makes no sense.
        """
        self.check()
        options = _core.ConstraintOptions()
        options.hydrogen_bonds = self.hbonds
        options.hydrogen_bond_weakest = self.hbond_cutoff_kcal * _core.KILOJOULE_PER_KILOCALORIE
        options.set_hydrogen_bond_reach(
            self.hbond_angstrom / _ANGSTROM, (self.hbond_angstrom + 1.0) / _ANGSTROM
        )
        options.hydrogen_bond_angle_degree = self.hbond_angle_degree
        options.hydrogen_bond_room = self.hbond_room
        options.place_hydrogens = self.place_hydrogens
        options.solvent_hydrogen_bonds = self.solvent_hbonds
        options.hydrophobic = self.hydrophobic
        options.hydrophobic_margin = self.tether_margin_angstrom / _ANGSTROM
        options.stacking = self.stacking
        options.stacking_distance = self.stacking_angstrom / _ANGSTROM
        options.stacking_angle_degree = self.stacking_angle_degree
        options.stacking_margin = self.tether_margin_angstrom / _ANGSTROM
        options.metals = self.metals
        options.torsion_basins = self.torsion_basins
        options.set_torsion_region(self.torsion_region)
        options.staggered = self.staggered
        options.eclipsed_degree = self.eclipsed_degree
        for positions in conformations:
            options.add_conformation(np.ascontiguousarray(positions, dtype=np.float64))
        if self.metals:
            options.set_coordination(molecule.coordination)
        bounds = bounds_of(molecule, self.user)
        options.set_bars(*bounds.pairs["bar"])
        options.set_tethers(*bounds.pairs["tether"])
        options.set_contacts(*bounds.pairs["contact"])
        options.fixed = bounds.fixed
        return options
