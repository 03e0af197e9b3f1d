"""Conformers as records of an SD file."""

import gzip
import io
from typing import Any

from rdkit import Chem

from .conforming import MadeConformers
from .records import Record

_OURS = "ragdoll_"  # with which the names of our own data begin


def sd_records(record: Record, made: MadeConformers, run: dict[str, Any]) -> bytes:
    """One record for each conformer: the input's title and data, and ours beside it.

    Blocks are V2000, and V3000 for more than 999 atoms or bonds. Coordinates are in angstrom.

    Args:
        record: of the input.
        made: its conformers.
        run: plain values that every record carries, by name.
    """
    mol = made.mol
    mol.SetProp("_Name", record.title)
    for name in list(mol.GetPropNames()):
        if name.startswith(_OURS):
            mol.ClearProp(name)
    stream = io.StringIO()
    writer = Chem.SDWriter(stream)
    writer.SetKekulize(True)
    lowest = float(made.energies.min()) if len(made.energies) else 0.0
    for number, conformer in enumerate(mol.GetConformers()):
        mol.SetIntProp(f"{_OURS}conformer", number + 1)
        if made.energy_name != "torsions":
            energy = float(made.energies[number])
            mol.SetProp(f"{_OURS}energy_kcal_mol", f"{energy:.4f}")
            mol.SetProp(f"{_OURS}relative_energy_kcal_mol", f"{energy - lowest:.4f}")
            mol.SetProp(f"{_OURS}energy_by", made.energy_name)
        for name, value in run.items():
            mol.SetProp(f"{_OURS}{name}", str(value))
        writer.write(mol, confId=conformer.GetId())
    writer.close()
    return stream.getvalue().encode()


def packed(data: bytes) -> bytes:
    """A gzip member; members in a row are one gzip file. The same data give the same bytes."""
    return gzip.compress(data, compresslevel=4, mtime=0)
