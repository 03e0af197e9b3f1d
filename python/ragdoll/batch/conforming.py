"""Conformers of one molecule: a start, sampling by core, refinement."""

import math
import signal
import time
import warnings
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from openmm import unit
from rdkit import Chem

from .. import _core
from ..errors import InputError
from ..framework import core_molecule
from ..molecule import Molecule
from ..torsion_terms import torsion_terms
from .refining import FORCE_FIELDS, distinct, minimize
from .starting import place

_ANGSTROM = 10.0  # per nm
_KILOJOULES = 4.184  # per kcal
_ROUNDS = 3  # of sampling, where minimised conformers become alike
_SHARE_OF_START = 0.5  # of a molecule's time
STARTS = ("input", "embed")
FRAGMENTS = ("all", "largest")


@dataclass(frozen=True)
class ConformerOptions:
    """How conformers of a molecule are made.

    Attributes:
        count: conformers of each molecule.
        seed: decides all random numbers.
        start: "input": from the given coordinates where they are in three dimensions, else from an
            embedding by RDKit; "embed": from an embedding always.
        relax_start: minimise embedded starts by MMFF94s (UFF where it has no parameters), for its
            bonds and angles.
        fragments: of molecules that are not bonded throughout, such as salts: "all" or "largest",
            by heavy atoms.
        stereo_isomers: how many of the configurations that are left open are made, each with
            ``count`` conformers; 0: the one that the embedding chooses.
        rmsd_prune_angstrom: least RMSD of any two conformers: of heavy atoms, superposed, the
            least over symmetric atoms. 0: alike ones stay.
        energy_window_kcal: most energy above the lowest, in kcal/mol; None: any. Of minimised
            conformers the force field's, else the score of their torsions.
        minimize: None, "mmff94s" or "uff": minimise by RDKit and rank by energy.
        seconds_per_molecule: after which a molecule is given up.
    """

    count: int = 50
    seed: int = 0
    start: str = "input"
    relax_start: bool = False
    fragments: str = "all"
    stereo_isomers: int = 0
    rmsd_prune_angstrom: float = 0.0
    energy_window_kcal: float | None = None
    minimize: str | None = None
    seconds_per_molecule: float = 60.0

    def check(self) -> None:
        """Refuse what makes no sense.

        Raises:
            InputError: a sentence that names the option.
        """
        if not 1 <= self.count <= 1_000_000:
            raise InputError(f"--count must be from 1 to 1000000, not {self.count}.")
        if not 0 <= self.seed < 2**63:
            raise InputError(f"--seed must be from 0 to 2^63 - 1, not {self.seed}.")
        if self.start not in STARTS:
            raise InputError(f"--start must be {' or '.join(STARTS)}, not {self.start!r}.")
        if self.fragments not in FRAGMENTS:
            raise InputError(
                f"--fragments must be {' or '.join(FRAGMENTS)}, not {self.fragments!r}."
            )
        if not 0 <= self.stereo_isomers <= 1024:
            raise InputError(f"--stereo-isomers must be from 0 to 1024, not {self.stereo_isomers}.")
        if not 0 <= self.rmsd_prune_angstrom < math.inf:  # refuses NaN too
            raise InputError(
                f"--rmsd-prune-angstrom must be 0 or more, not {self.rmsd_prune_angstrom}."
            )
        window = self.energy_window_kcal
        if window is not None and not 0 < window < math.inf:
            raise InputError(f"--energy-window-kcal must be above 0, not {window}.")
        if self.minimize is not None and self.minimize not in FORCE_FIELDS:
            raise InputError(
                f"--minimize must be {' or '.join(FORCE_FIELDS)}, not {self.minimize!r}."
            )
        if not 0 < self.seconds_per_molecule <= 1e6:
            raise InputError(
                f"--seconds-per-molecule must be above 0 and at most 1000000, not "
                f"{self.seconds_per_molecule}."
            )


@dataclass
class MadeConformers:
    """Conformers of one molecule.

    Attributes:
        mol: with hydrogens and the conformers, ids from 0; the best first where they are ranked.
        energies: (K,) in kcal/mol.
        energy_name: whose energies these are: "MMFF94s", "UFF" or "torsions".
        reason: why there are fewer than asked; empty where there are as many.
        notes: on the start and the minimisation.
        start: the molecule with the one conformer that sampling started from.
    """

    mol: Chem.Mol
    energies: NDArray[np.float64]
    energy_name: str
    reason: str = ""
    notes: list[str] = field(default_factory=list)
    start: Chem.Mol | None = None


def record_seed(seed: int, record: int) -> int:
    """The seed of molecule ``record`` (from 0) of a file that is run with ``seed``."""
    return _core.record_seed(seed, record)


def make_conformers(mol: Chem.Mol, options: ConformerOptions, seed: int) -> MadeConformers:
    """Make conformers of a molecule.

    Args:
        mol: sanitized.
        options: what is asked for; its own seed is not used.
        seed: of this molecule.

    Raises:
        InputError: there is no start, or the molecule cannot be used; a clause that says why.
    """
    begin = time.monotonic()
    end = begin + 0.9 * options.seconds_per_molecule
    left_out = ""
    if options.fragments == "largest":
        mol, left_out = largest_fragment(mol)
    seconds = _SHARE_OF_START * options.seconds_per_molecule
    started, notes = place(mol, options.start, seed, seconds, options.relax_start)
    if options.minimize is None:
        made = _sampled(started, options, seed, end)
    else:
        made = _minimized(started, options, seed, end)
    made.notes = ([f"left out: {left_out}"] if left_out else []) + notes + made.notes
    made.start = started
    for note in made.notes:
        if note.startswith("time was up"):
            made.reason = note if made.reason else ""
    if made.mol.GetNumConformers() < options.count and not made.reason:
        made.reason = "no more were found"
    return made


def _sampled(mol: Chem.Mol, options: ConformerOptions, seed: int, end: float) -> MadeConformers:
    """Sample; again where the molecule is found to have alike ones among them."""
    window = options.energy_window_kcal
    least = options.rmsd_prune_angstrom
    result = without_conformers(mol)
    energies: list[float] = []
    best: list[int] = []
    reason, asked = "", options.count
    for number in range(_ROUNDS):
        found = _sampled_in_time(
            mol,
            end,
            count=asked,
            seed=seed + number,
            prune_rmsd=least / _ANGSTROM,
            energy_window=0.0 if window is None else window * _KILOJOULES,
        )
        add_conformers(result, found["positions"])
        energies.extend(np.asarray(found["energies"]) / _KILOJOULES)
        reason = _clause(found["reason"])
        before, best = len(best), distinct(result, range(result.GetNumConformers()), least)
        is_done = reason or (number and len(best) == before) or time.monotonic() > end
        if least == 0 or len(best) >= options.count or is_done:
            break
        asked = 2 * options.count
    if not best:  # the start is a conformer at least
        result.AddConformer(mol.GetConformer(), assignId=True)
        energies, best = [0.0], [0]
        reason = f"the start alone: {reason or 'no others were found'}"
    elif not reason:
        reason = f"all others that were sampled are within {least:g} Å of one of these"
    best = best[: options.count]
    final = without_conformers(mol)
    for identifier in best:
        final.AddConformer(result.GetConformer(identifier), assignId=True)
    kept = np.array([energies[identifier] for identifier in best])
    is_short = len(best) < options.count
    return MadeConformers(final, kept, "torsions", reason if is_short else "")


def _minimized(mol: Chem.Mol, options: ConformerOptions, seed: int, end: float) -> MadeConformers:
    """Sample and minimise, again where too many become alike or are high in energy."""
    result = without_conformers(mol)
    energies: list[float] = []
    notes: list[str] = []
    reason, asked, candidates = "", options.count, 0
    best: list[int] = []
    for number in range(_ROUNDS):
        found = _sampled_in_time(
            mol,
            end,
            count=asked,
            seed=seed + number,
            prune_rmsd=options.rmsd_prune_angstrom / _ANGSTROM,
            energy_window=0.0,
        )
        batch = without_conformers(mol)
        add_conformers(batch, found["positions"])
        if batch.GetNumConformers() == 0:
            batch.AddConformer(mol.GetConformer(), assignId=True)
        candidates += batch.GetNumConformers()
        values, ids, said = minimize(batch, str(options.minimize), end)
        notes.extend(note for note in said if note not in notes)
        for value, identifier in zip(values, ids, strict=True):
            result.AddConformer(batch.GetConformer(identifier), assignId=True)
            energies.append(float(value))
        before = len(best)
        best, reason = _chosen(result, np.array(energies), options, candidates)
        is_late = time.monotonic() > end or any(note.startswith("time was up") for note in said)
        if len(best) >= options.count or is_late or (number and len(best) == before):
            break
        asked = 2 * (options.count - len(best)) + 8
    final = without_conformers(mol)
    for identifier in best[: options.count]:
        final.AddConformer(result.GetConformer(identifier), assignId=True)
    name = "UFF" if options.minimize == "uff" or any("by UFF" in n for n in notes) else "MMFF94s"
    kept = np.array([energies[identifier] for identifier in best[: options.count]])
    is_short = len(kept) < options.count
    return MadeConformers(final, kept, name, reason if is_short else "", notes)


def _chosen(
    mol: Chem.Mol, energies: NDArray[np.float64], options: ConformerOptions, candidates: int
) -> tuple[list[int], str]:
    """Ids by energy of those in the window and not alike, and why others were left out."""
    if len(energies) == 0:
        return [], "none kept its configuration when minimised"
    order = [int(k) for k in np.argsort(energies, kind="stable")]
    within = order
    window = options.energy_window_kcal
    if window is not None:
        lowest = energies[order[0]]
        within = [k for k in order if energies[k] - lowest <= window]
    kept = distinct(mol, within, options.rmsd_prune_angstrom)
    parts = []
    if len(within) < len(order):
        parts.append(f"{len(order) - len(within)} are above the energy window")
    if len(kept) < len(within):
        parts.append(
            f"{len(within) - len(kept)} are within {options.rmsd_prune_angstrom:g} Å of another"
        )
    return kept, f"of {candidates} minimised, " + (" and ".join(parts) or "these are all")


def _clause(sentence: str) -> str:
    """A sentence of core's as a part of another."""
    return " ".join(str(sentence).split()).removesuffix(".")


def sample(mol: Chem.Mol, *, count: int, seed: int, prune_rmsd: float, energy_window: float):
    """Core's conformers of a molecule with hydrogens and one conformer; see sample_conformers."""
    try:
        return _core.sample_conformers(
            core_molecule(Molecule.from_rdkit(mol)),
            *torsion_terms(mol),
            count=count,
            seed=seed,
            prune_rmsd=prune_rmsd,
            energy_window=energy_window,
        )
    except ValueError as error:  # of core, or InputError
        raise InputError(_clause(str(error))) from None


def _sampled_in_time(mol: Chem.Mol, end: float, **options) -> dict[str, Any]:
    """What ``sample`` gives, or nothing with the reason where it takes longer.

    The time is watched in worker processes alone (``watch_time``): it takes a signal, which is the
    caller's elsewhere.
    """
    if not _time_is_watched:
        return sample(mol, **options)
    signal.setitimer(signal.ITIMER_REAL, max(end - time.monotonic(), 1e-3))
    try:
        return sample(mol, **options)
    except KeyboardInterrupt:
        shape = (0, mol.GetNumAtoms(), 3)
        reason = "sampling took too long"
        return {"positions": np.empty(shape), "energies": np.empty(0), "reason": reason}
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)


_time_is_watched = False


def watch_time() -> None:
    """Let sampling end when a molecule's time is over; for processes that do nothing else."""
    global _time_is_watched
    _time_is_watched = True
    signal.signal(signal.SIGALRM, _interrupt)


def _interrupt(number, frame) -> None:
    raise KeyboardInterrupt  # which core looks out for


def largest_fragment(mol: Chem.Mol) -> tuple[Chem.Mol, str]:
    """The bonded part with the most heavy atoms, then atoms, and the SMILES of the others."""
    parts = list(Chem.GetMolFrags(mol, asMols=True))
    if len(parts) < 2:
        return mol, ""
    sizes = [(part.GetNumHeavyAtoms(), part.GetNumAtoms(), -k) for k, part in enumerate(parts)]
    kept = parts.pop(sizes.index(max(sizes)))
    for name, value in mol.GetPropsAsDict(includePrivate=False).items():
        kept.SetProp(name, str(value))
    return kept, ".".join(Chem.MolToSmiles(Chem.RemoveHs(part)) for part in parts)


def without_conformers(mol: Chem.Mol) -> Chem.Mol:
    """A copy with properties, but no conformers."""
    copy = Chem.Mol(mol)
    copy.RemoveAllConformers()
    return copy


def add_conformers(mol: Chem.Mol, positions: NDArray[np.float64]) -> None:
    """Add conformers (K, N, 3), in nm, to a molecule that has none."""
    for places in np.asarray(positions, dtype=np.float64):
        conformer = Chem.Conformer(len(places))
        conformer.Set3D(True)
        conformer.SetPositions(np.ascontiguousarray(places * _ANGSTROM))
        mol.AddConformer(conformer, assignId=True)


def conformers(
    mol: Chem.Mol,
    n: int = 50,
    *,
    seed: int = 0,
    start: str = "input",
    relax_start: bool = False,
    fragments: str = "all",
    prune_rmsd: float | unit.Quantity = 0.0,
    energy_window: float | unit.Quantity | None = None,
    minimize: str | None = None,
    seconds: float | unit.Quantity = 60.0,
) -> Chem.Mol:
    """Conformers of an RDKit molecule.

    A start is taken from the molecule or embedded; core samples from it by turns about bonds and
    through rings. Bond lengths and angles are the start's, the configuration is kept.

    Args:
        mol: sanitized; hydrogens are added where they are missing, after the other atoms.
        n: conformers asked for.
        seed: decides all random numbers; the same seed and start give the same conformers.
        start: "input": the molecule's conformer where it has one in three dimensions, else an
            embedding; "embed": an embedding.
        relax_start: minimise an embedded start by MMFF94s or UFF, for its bonds and angles.
        fragments: of salts and the like: "all" or "largest".
        prune_rmsd: least RMSD of any two, a Quantity or nm: of heavy atoms, superposed, the least
            over symmetric atoms.
        energy_window: most energy above the lowest, a Quantity or kJ/mol; None: any. Of
            minimised conformers the force field's, else the score of their torsions.
        minimize: "mmff94s" or "uff": minimise by RDKit and rank by energy.
        seconds: a Quantity or numbers; the start gets at most half of it, and no further
            minimisation begins after nine tenths.

    Returns:
        A new molecule with hydrogens and at most n conformers, ids from 0. Its properties:
        "ragdoll_reason" why there are fewer, where there are (a UserWarning says it as well);
        "ragdoll_notes" on the start. Each conformer has the property "energy_kcal_mol", and the
        molecule "ragdoll_energy" tells whose it is: "MMFF94s", "UFF" or "torsions".

    Raises:
        InputError: an argument makes no sense, or there is no start.
    """
    if not isinstance(mol, Chem.Mol):
        raise InputError(f"Give an RDKit molecule, not {type(mol).__name__}.")
    window = None if energy_window is None else _plain(energy_window, unit.kilojoule_per_mole)
    options = ConformerOptions(
        count=n,
        seed=seed,
        start=start,
        relax_start=relax_start,
        fragments=fragments,
        rmsd_prune_angstrom=_plain(prune_rmsd, unit.nanometer) * _ANGSTROM,
        energy_window_kcal=None if window is None else window / _KILOJOULES,
        minimize=minimize,
        seconds_per_molecule=_plain(seconds, unit.second),
    )
    options.check()
    name = mol.GetProp("_Name") if mol.HasProp("_Name") else ""
    name = name or "The molecule"
    if mol.GetNumAtoms() == 0:
        raise InputError(f"{name} has no atoms.")
    mol = Chem.Mol(mol)
    try:
        Chem.SanitizeMol(mol)
        made = make_conformers(mol, options, seed)
    except (InputError, Chem.MolSanitizeException) as error:
        raise InputError(f"{name}: {_clause(str(error))}.") from None
    result = made.mol
    for conformer, energy in zip(result.GetConformers(), made.energies, strict=True):
        conformer.SetDoubleProp("energy_kcal_mol", float(energy))
    result.SetProp("ragdoll_energy", made.energy_name)
    if made.notes:
        result.SetProp("ragdoll_notes", "; ".join(made.notes))
    if made.reason:
        result.SetProp("ragdoll_reason", made.reason)
        warnings.warn(
            f"{name}: {result.GetNumConformers()} of {n} conformers: {made.reason}.", stacklevel=2
        )
    return result


def _plain(value: float | unit.Quantity, wanted: unit.Unit) -> float:
    return float(value.value_in_unit(wanted) if unit.is_quantity(value) else value)
