"""MotionOptions: what moves the atoms of a sample before constraints are resolved."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from openmm.app import Chain

from . import _core
from .elastic_network import modes
from .errors import InputError
from .molecule import Molecule
from .sites import site_of, sites_of
from .thermal_network import fluctuations

_ANGSTROM = 10.0  # per nm
_MOST_MODES = 1000
#: perturbations that RagdollIntegrator makes itself
PLAIN = ("gaussian", "ball")
_PULL = re.compile(r"^(?P<selection>.*?);(?P<to>\s*to\b)?(?P<numbers>[^;]*)$", re.DOTALL)


@dataclass(frozen=True)
class MotionOptions:
    """How perturbations move. Lengths in angstrom, each step's unless said otherwise.

    Attributes:
        temperature_kelvin: of "thermal": deviations from the start grow with its square root.
        thermal_step_angstrom: of "thermal": RMSD of a step, of CA and P.
        thermal_modes: of "thermal": how many modes swing.
        persistence: of "momentum": the share of the last step that is made again, 0 to 1.
        hinge_degree: of "hinge": deviation of the turns.
        hinge_share: of "hinge": share of the hinges that turn in a step.
        modes: of "modes": numbers of modes, such as "1-10" or "1,3".
        mode_amplitude_angstrom: of "modes": CA RMSD from the start at which a mode turns back.
        mode_step_angstrom: of "modes": CA RMSD of a step along the mode.
        mode_cutoff_angstrom: of "modes": up to which sites of the elastic network are joined.
        steer: of "steer": pulls, each "SELECTION; X Y Z", a vector in angstrom for each step, or
            "SELECTION; to X Y Z", a point that the centroid of the atoms is drawn to.
        steer_angstrom: of "steer": how far a step draws atoms to a point at most.
        away_from: of "away": "nearest", "centroid" or "density" of the conformers visited.
        away_angstrom: of "away": CA RMSD of a step.
        away_spacing_angstrom: of "away": CA RMSD between conformers that are remembered.
        symmetric: chains of one sequence that move alike; () for none.
    """

    temperature_kelvin: float = 300.0
    thermal_step_angstrom: float = 0.5
    thermal_modes: int = 100
    persistence: float = 0.95
    hinge_degree: float = 10.0
    hinge_share: float = 0.05
    modes: str = "1-10"
    mode_amplitude_angstrom: float = 2.0
    mode_step_angstrom: float = 0.1
    mode_cutoff_angstrom: float = 15.0
    steer: tuple[str, ...] = ()
    steer_angstrom: float = 0.1
    away_from: str = "nearest"
    away_angstrom: float = 0.1
    away_spacing_angstrom: float = 0.5
    symmetric: tuple[str, ...] = ()

    def check(self, perturbation: str) -> None:
        """Raise InputError at the first option that makes no sense."""
        if not 0 <= self.persistence <= 1:
            raise InputError(f"--persistence must be from 0 to 1, not {self.persistence}.")
        for name, most in (
            ("temperature_kelvin", 100_000.0),
            ("thermal_step_angstrom", 10.0),
            ("hinge_degree", 180.0),
            ("hinge_share", 1.0),
            ("mode_amplitude_angstrom", 1000.0),
            ("mode_step_angstrom", 10.0),
            ("steer_angstrom", 10.0),
            ("away_angstrom", 10.0),
            ("away_spacing_angstrom", 100.0),
        ):
            value = getattr(self, name)
            if not (math.isfinite(value) and 0 < value <= most):
                flag = "--" + name.replace("_", "-")
                raise InputError(f"{flag} must be above 0 and at most {most:g}, not {value}.")
        try:
            _core.check_away(self.away_from)
        except ValueError as error:
            raise InputError(f"{error}.") from None
        if not 1 <= self.thermal_modes <= _MOST_MODES:
            raise InputError(
                f"--thermal-modes must be from 1 to {_MOST_MODES}, not {self.thermal_modes}."
            )
        mode_numbers(self.modes)
        for pull in self.steer:
            _pull_of(pull)
        if perturbation == "steer" and not self.steer:
            raise InputError("--perturbation steer needs a --steer 'SELECTION; X Y Z'.")
        if perturbation != "steer" and self.steer:
            raise InputError("--steer is for --perturbation steer; give both, or neither.")
        if len(self.symmetric) == 1:
            raise InputError("--symmetric needs two chains at least, such as A,B.")
        if len(set(self.symmetric)) < len(self.symmetric):
            raise InputError("--symmetric names a chain twice.")

    def for_core(
        self,
        perturbation: str,
        step_angstrom: float,
        molecule: Molecule,
        framework: "_core.Framework",
    ) -> Any:
        """The settings of core's motion.

        Raises:
            InputError: a selection matches nothing, or the molecule has no such modes.
        """
        motion = _core.MotionSettings(perturbation, step_angstrom / _ANGSTROM)
        motion.persistence = self.persistence
        motion.hinge_angle = math.radians(self.hinge_degree)
        motion.hinge_share = self.hinge_share
        motion.mode_amplitude = self.mode_amplitude_angstrom / _ANGSTROM
        motion.mode_step = self.mode_step_angstrom / _ANGSTROM
        motion.away_step = self.away_angstrom / _ANGSTROM
        motion.away_spacing = self.away_spacing_angstrom / _ANGSTROM
        motion.set_away(self.away_from)
        motion.thermal_step = self.thermal_step_angstrom / _ANGSTROM
        if perturbation == "thermal":
            self._set_thermal(motion, molecule, framework)
        elif perturbation == "away":
            sites, of_atom = sites_of(molecule.topology, molecule.positions)
            motion.sites, motion.site_of_joint = sites.tolist(), of_atom.tolist()
        elif perturbation == "modes":
            motion.set_modes(self._modes(molecule))
        elif perturbation == "steer":
            self._add_pulls(motion, molecule)
        return motion

    def _set_thermal(self, motion: Any, molecule: Molecule, framework: "_core.Framework") -> None:
        moves = fluctuations(
            molecule,
            framework,
            temperature_kelvin=self.temperature_kelvin,
            count=self.thermal_modes,
        )
        motion.set_modes(moves)
        sites = [site_of(residue) for residue in molecule.topology.residues()]
        motion.sites = [site for site in sites if site is not None]

    def _modes(self, molecule: Molecule) -> np.ndarray:
        numbers = mode_numbers(self.modes)
        found = modes(molecule, count=max(numbers), cutoff_angstrom=self.mode_cutoff_angstrom)
        if len(found) < max(numbers):
            raise InputError(
                f"{molecule.source} has {len(found)} modes, but --modes asks for mode "
                f"{max(numbers)}."
            )
        return np.ascontiguousarray(found.of_atoms()[[number - 1 for number in numbers]])

    def _add_pulls(self, motion: Any, molecule: Molecule) -> None:
        from .atom_selection import select_atoms

        for text in self.steer:
            selection, towards, numbers = _pull_of(text)
            atoms = select_atoms(molecule, selection, f"--steer '{text}'").tolist()
            vector = [number / _ANGSTROM for number in numbers]
            if towards:
                motion.add_pull_towards(atoms, vector, self.steer_angstrom / _ANGSTROM)
            else:
                motion.add_pull(atoms, vector)


def mode_numbers(text: str) -> list[int]:
    """Numbers of modes, from "1-10" or "1,3-5".

    Raises:
        InputError: the text names no modes.
    """
    numbers: list[int] = []
    for part in text.split(","):
        found = re.fullmatch(r"\s*(\d+)\s*(?:-\s*(\d+)\s*)?", part)
        first = int(found[1]) if found else 0
        last = int(found[2] or first) if found else 0
        if not 1 <= first <= last <= _MOST_MODES:
            raise InputError(
                f"--modes must be numbers from 1 to {_MOST_MODES}, such as 1-10 or 1,3, not "
                f"'{text}'."
            )
        numbers.extend(number for number in range(first, last + 1) if number not in numbers)
    return numbers


def _pull_of(text: str) -> tuple[str, bool, list[float]]:
    found = _PULL.match(text)
    try:
        numbers = [float(word) for word in found["numbers"].split()]
    except (TypeError, ValueError):
        numbers = []
    if len(numbers) != 3 or not all(math.isfinite(number) for number in numbers):
        raise InputError(
            f"--steer '{text}' must be 'SELECTION; X Y Z' or 'SELECTION; to X Y Z', three numbers "
            "of angstrom."
        )
    return found["selection"].strip(), found["to"] is not None, numbers


def symmetric_copies(molecule: Molecule, chains: Sequence[str]) -> list[list[int]]:
    """The atoms of chains that move alike, those that correspond at one place.

    Raises:
        InputError: there is no such chain, or the chains differ in residues or atoms.
    """
    found = []
    for name in chains:
        own = [chain for chain in molecule.topology.chains() if chain.id == name]
        if not own:
            known = ", ".join(sorted({chain.id for chain in molecule.topology.chains()}))
            raise InputError(f"--symmetric names chain '{name}'; the chains are {known}.")
        found.append([residue for chain in own for residue in _residues(chain)])
    copies = [[atom.index for residue in found[0] for atom in residue.atoms()]]
    for name, residues in zip(chains[1:], found[1:], strict=True):
        if [r.name for r in residues] != [r.name for r in found[0]]:
            raise InputError(
                f"Chains {chains[0]} and {name} are not alike: they have {len(found[0])} and "
                f"{len(residues)} residues, or other ones."
            )
        copy = []
        for first, own in zip(found[0], residues, strict=True):
            atoms = {atom.name: atom.index for atom in own.atoms()}
            names = [atom.name for atom in first.atoms()]
            if sorted(names) != sorted(atoms):
                raise InputError(
                    f"{first.name} {first.id} of chain {chains[0]} and {own.name} {own.id} of "
                    f"chain {name} have different atoms; complete them first."
                )
            copy.extend(atoms[atom] for atom in names)
        copies.append(copy)
    return copies


def _residues(chain: Chain) -> list:
    return list(chain.residues())
