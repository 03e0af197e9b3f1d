"""Conformers after sampling: minimised, ranked, within a window of energy, and no two alike."""

import time
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from rdkit import Chem
from rdkit.Chem import rdForceFieldHelpers, rdMolAlign

from ..errors import InputError
from .rdkit_messages import rdkit_messages

FORCE_FIELDS = ("mmff94s", "uff")
MOST_ITERATIONS = 1000
_MOST_MATCHES = 2000  # of symmetric atoms on each other that RMSDs try


def minimize(
    mol: Chem.Mol, force_field: str, end: float
) -> tuple[NDArray[np.float64], list[int], list[str]]:
    """Minimise conformers in place, by RDKit, one after the other until the time is over.

    Args:
        mol: with hydrogens and conformers.
        force_field: "mmff94s" (UFF where MMFF94s has no parameters) or "uff".
        end: when to stop, of time.monotonic().

    Returns:
        Energies in kcal/mol of the conformers that were minimised and kept the configuration of
        the molecule (K,), their ids, and notes.

    Raises:
        InputError: neither force field has parameters.
    """
    notes = []
    with rdkit_messages():
        properties = None
        if force_field == "mmff94s":
            properties = rdForceFieldHelpers.MMFFGetMoleculeProperties(mol, mmffVariant="MMFF94s")
            if properties is None:
                notes.append("MMFF94s has no parameters for it; minimised by UFF")
        if properties is None and not rdForceFieldHelpers.UFFHasAllMoleculeParams(mol):
            raise InputError("neither MMFF94s nor UFF has parameters to minimise it with")
        work = Chem.Mol(mol, True)  # without conformers
        work.AddConformer(mol.GetConformer(), assignId=True)
        place = work.GetConformer()
        # it keeps pointers to the places of this one conformer, which is filled anew each time
        if properties is not None:
            field = rdForceFieldHelpers.MMFFGetMoleculeForceField(
                work, properties, ignoreInterfragInteractions=False
            )
        else:
            field = rdForceFieldHelpers.UFFGetMoleculeForceField(
                work, ignoreInterfragInteractions=False
            )
        if field is None:
            raise InputError("RDKit makes no force field for it")
        field.Initialize()
        expected = configuration(mol, mol.GetConformer().GetId())
        energies, ids, changed, unfinished = [], [], 0, 0
        for conformer in mol.GetConformers():
            if time.monotonic() > end and ids:
                notes.append(f"time was up after {len(ids)} minimisations")
                break
            place.SetPositions(conformer.GetPositions())
            unfinished += bool(field.Minimize(maxIts=MOST_ITERATIONS))
            places = place.GetPositions()
            energy = field.CalcEnergy()
            if not np.isfinite(energy) or not np.isfinite(places).all():
                changed += 1
                continue
            conformer.SetPositions(places)
            if configuration(mol, conformer.GetId()) != expected:
                changed += 1
                continue
            energies.append(energy)
            ids.append(conformer.GetId())
    if changed:
        notes.append(f"{changed} lost their configuration when minimised and were dropped")
    if unfinished:
        notes.append(f"{unfinished} were not at a minimum after {MOST_ITERATIONS} iterations")
    return np.array(energies), ids, notes


def configuration(mol: Chem.Mol, conformer: int) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Hands of centres and sides of double bonds in a conformer, for comparison."""
    copy = Chem.Mol(mol, False, conformer)
    Chem.AssignStereochemistryFrom3D(copy, conformer)
    return (
        tuple(int(atom.GetChiralTag()) for atom in copy.GetAtoms()),
        tuple(int(bond.GetStereo()) for bond in copy.GetBonds()),
    )


def distinct(mol: Chem.Mol, ids: Sequence[int], least: float) -> list[int]:
    """The ids of conformers that differ from each one before by at least an RMSD.

    Args:
        mol: with these conformers.
        ids: the best first.
        least: angstrom, of heavy atoms, superposed, the least over symmetric atoms.
    """
    if least <= 0 or len(ids) < 2:
        return list(ids)
    heavy = Chem.Mol(mol, True)
    for number, identifier in enumerate(ids):
        conformer = Chem.Conformer(mol.GetConformer(identifier))
        conformer.SetId(number)
        heavy.AddConformer(conformer)
    with rdkit_messages():
        heavy = Chem.RemoveAllHs(heavy, sanitize=False)
    if heavy.GetNumAtoms() < 2:
        return list(ids[:1]) if heavy.GetNumAtoms() == 1 else list(ids)
    flat = rdMolAlign.GetAllConformerBestRMS(heavy, numThreads=1, maxMatches=_MOST_MATCHES)
    distances = np.zeros((len(ids), len(ids)))
    rows, columns = np.tril_indices(len(ids), -1)
    distances[rows, columns] = distances[columns, rows] = list(flat)
    kept: list[int] = []
    for number in range(len(ids)):
        if all(distances[number, other] >= least for other in kept):
            kept.append(number)
    return [ids[number] for number in kept]
