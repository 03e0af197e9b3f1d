"""Posed ligands from SDF, MOL and MOL2 files, plain or gzipped."""

import gzip
import hashlib
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rdkit import Chem
from rdkit.rdBase import BlockLogs

from .errors import InputError
from .residues import WATERS, residue_template

_KINDS = (".sdf", ".sd", ".mol", ".mol2")
_MOL2_MARK = "@<TRIPOS>MOLECULE"
_DEFAULT_NAME = "LIG"
_LONGEST_NAME = 5  # that mmCIF files use; PDB files have room for three letters


@dataclass(frozen=True)
class PosedLigand:
    """A ligand with places for its atoms.

    Attributes:
        mol: one conformer, the explicit hydrogens of the file.
        name: of its residue.
        origin: what messages call it.
        notes: sentences, such as which record of several was read.
        source_hash: SHA-256 of the record's text, hexadecimal; empty without a file.
    """

    mol: Chem.Mol
    name: str
    origin: str
    notes: tuple[str, ...] = ()
    source_hash: str = ""


def read_ligand(given: str | Path | Chem.Mol) -> PosedLigand:
    """A ligand of a file, or RDKit's molecule.

    Args:
        given: ``FILE``, ``FILE:3`` for its third record, ``FILE:NAME`` for the record with this
            title; or a molecule with a conformer.

    Raises:
        InputError: there is no such file or record, it cannot be parsed, or its coordinates are
            missing or flat.
    """
    if isinstance(given, Chem.Mol):
        title = given.GetProp("_Name").strip() if given.HasProp("_Name") else ""
        origin = title or "The ligand"
        _check_places(given, origin)
        return PosedLigand(given, residue_name(title), origin)
    path, wanted = _path_and_record(str(given))
    records = _records(path)
    index, notes = _chosen(records, wanted, path)
    text = records[index]
    origin = f"{path}, record {index + 1}" if len(records) > 1 else str(path)
    mol = _parsed(text, path, origin)
    _check_places(mol, origin)
    return PosedLigand(
        mol,
        residue_name(_title(text, path)),
        origin,
        tuple(notes),
        hashlib.sha256(text.encode()).hexdigest(),
    )


def residue_name(title: str) -> str:
    """What a ligand's residue is called: its title where that may be one, else LIG.

    Titles such as ``1abc_XK2_A_263``, as the PDB gives its ligands, name the middle one.
    """
    parts = title.split("_")
    if len(parts) >= 3 and re.fullmatch(r"\d[A-Za-z0-9]{3}", parts[0]):
        title = parts[1]
    usable = re.fullmatch(r"[A-Za-z0-9]+", title) and len(title) <= _LONGEST_NAME
    # a standard residue's name would stand for other bonds and charges than the file's
    if not usable or title in WATERS or residue_template(title) is not None:
        return _DEFAULT_NAME
    return title


def _path_and_record(text: str) -> tuple[Path, str | None]:
    path = Path(text)
    if path.exists() or ":" not in text:
        return path, None
    name, record = text.rsplit(":", 1)
    if Path(name).suffix == "" or not record:
        return path, None
    return Path(name), record


def _kind(path: Path) -> str:
    kind = Path(path.stem).suffix if path.suffix.lower() == ".gz" else path.suffix
    return kind.lower()


def _records(path: Path) -> list[str]:
    kind = _kind(path)
    if kind not in _KINDS:
        raise InputError(f"{path} is no file of ligands by its name; give .sdf, .mol or .mol2.")
    try:
        data = path.read_bytes()
        if path.suffix.lower() == ".gz":
            data = gzip.decompress(data)
    except (OSError, EOFError) as error:
        reason = getattr(error, "strerror", None) or "it is no gzip file"
        raise InputError(f"{path} cannot be read: {reason}.") from None
    text = data.decode("utf-8", errors="replace").replace("\r\n", "\n").replace("\r", "\n")
    if kind == ".mol2":
        parts = text.split(_MOL2_MARK)[1:]
        records = [_MOL2_MARK + part for part in parts]
    else:
        records = re.split(r"^\$\$\$\$.*\n?", text, flags=re.MULTILINE)
        records = [record for record in records if record.strip()]
    if not records:
        raise InputError(f"{path} has no record; give a ligand in SDF or MOL2 format.")
    return records


def _title(record: str, path: Path) -> str:
    lines = record.split("\n")
    if _kind(path) == ".mol2":
        return lines[1].strip() if len(lines) > 1 else ""
    return lines[0].strip()


def _chosen(records: list[str], wanted: str | None, path: Path) -> tuple[int, list[str]]:
    titles = [_title(record, path) for record in records]
    if wanted is None:
        if len(records) == 1:
            return 0, []
        named = f", {titles[0]}," if titles[0] else ""
        return 0, [
            f"{path} has {len(records)} records; the first{named} was read ({path}:2 or "
            f"{path}:{titles[-1] or len(records)} names another)."
        ]
    if wanted in titles:
        return titles.index(wanted), []
    if wanted.isdigit() and 1 <= int(wanted) <= len(records):
        return int(wanted) - 1, []
    some = ", ".join(title for title in titles[:5] if title)
    raise InputError(
        f"{path} has no record {wanted}; it has {len(records)}"
        + (f", the first are {some}." if some else ", which have no titles.")
    )


def _parsed(text: str, path: Path, origin: str) -> Chem.Mol:
    with BlockLogs():
        try:
            if _kind(path) == ".mol2":
                mol = Chem.MolFromMol2Block(text, sanitize=False, removeHs=False)
            else:
                mol = Chem.MolFromMolBlock(text, sanitize=False, removeHs=False)
        except (RuntimeError, ValueError):
            mol = None
        if mol is None:
            raise InputError(
                f"{origin} cannot be parsed; write it anew in SDF or MOL2 format "
                "(with RDKit or Open Babel, say)."
            )
        if mol.GetNumAtoms() == 0:
            raise InputError(f"{origin} has no atoms; give a molecule.")
        if _kind(path) == ".mol2" and not any(a.GetAtomicNum() == 1 for a in mol.GetAtoms()):
            _fill_valences(mol)
        try:
            Chem.SanitizeMol(mol)
        except (Chem.MolSanitizeException, ValueError, RuntimeError) as error:
            reason = str(error).strip().split("\n")[0].rstrip(".")
            raise InputError(
                f"{origin} is no molecule that makes sense: {reason}; mend its bonds and charges."
            ) from None
    return mol


def _fill_valences(mol: Chem.Mol) -> None:
    """A MOL2 file has all hydrogens or none; without any its atoms are no radicals, and the only
    charges are those of carboxylates, of nitrogen with four bonds, and within nitro groups.
    """
    for atom in mol.GetAtoms():
        atom.SetNoImplicit(False)
        kind = atom.GetProp("_TriposAtomType") if atom.HasProp("_TriposAtomType") else ""
        paired = any(other.GetFormalCharge() > 0 for other in atom.GetNeighbors())
        if atom.GetFormalCharge() < 0 and kind != "O.co2" and not paired:
            atom.SetFormalCharge(0)


def _check_places(mol: Chem.Mol, origin: str) -> None:
    if mol.GetNumAtoms() == 0:
        raise InputError(f"{origin} has no atoms; give a molecule.")
    if mol.GetNumConformers() == 0:
        raise InputError(f"{origin} has no coordinates; give a ligand posed in three dimensions.")
    conformer = mol.GetConformer()
    places = conformer.GetPositions()
    if mol.GetNumAtoms() > 1 and np.ptp(places, axis=0).max() < 1e-3:
        raise InputError(f"{origin} has no coordinates; give a ligand posed in three dimensions.")
    if not conformer.Is3D():
        raise InputError(
            f"{origin} has flat (2-D) coordinates; give a ligand posed in three dimensions."
        )
