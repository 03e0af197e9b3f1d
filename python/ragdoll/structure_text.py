"""From the bytes of a PDB or mmCIF file to gemmi's structure, with every coordinate checked.

gemmi turns a coordinate that is no number into zero or NaN without a word, so the numbers are
checked here.
"""

import gzip
import hashlib
import math
import re
import zlib
from dataclasses import dataclass
from pathlib import Path

import gemmi

from .errors import InputError

# PDB columns hold at most 9999.999; writers use that value for atoms that have no place.
LARGEST_COORDINATE = 9999.0  # angstrom
_ELEMENT_AND_CHARGE = re.compile(r"[ A-Za-z][ A-Za-z](?:  |[0-9][+-]|[+-][0-9])")
_ATOM_RECORDS = ("ATOM  ", "HETATM")


@dataclass(frozen=True)
class StructureText:
    """A structure as gemmi reads it.

    Attributes:
        structure: all models, chains cut where the file ends them (TER).
        source_hash: SHA-256 of the file's bytes, hexadecimal.
        notes: sentences on what was left out.
    """

    structure: gemmi.Structure
    source_hash: str
    notes: list[str]


def read_structure_text(path: str | Path) -> StructureText:
    """Read a PDB or mmCIF file, plain or gzipped; the content tells which of them it is.

    Raises:
        InputError: the file cannot be read, is no such file, or has a coordinate that is no number.
    """
    raw, text = _read(Path(path))
    notes: list[str] = []
    structure = _read_mmcif(text, path) if _is_mmcif(text) else _read_pdb(text, path, notes)
    if len(structure) == 0:
        raise InputError(f"{path} contains no atoms; give a PDB or mmCIF file of a molecule.")
    return StructureText(structure, hashlib.sha256(raw).hexdigest(), notes)


def _read(path: Path) -> tuple[bytes, str]:
    try:
        raw = path.read_bytes()
    except FileNotFoundError:
        raise InputError(f"{path} does not exist; check the path.") from None
    except IsADirectoryError:
        raise InputError(f"{path} is a directory; give the path of a PDB or mmCIF file.") from None
    except PermissionError:
        raise InputError(f"{path} may not be read; check its permissions.") from None
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror}.") from None

    content = raw
    zipped = raw[:2] == b"\x1f\x8b"
    if path.suffix == ".gz" and not zipped and raw:
        raise InputError(f"{path} ends in .gz but is not gzipped; rename it or compress it again.")
    if zipped:
        try:
            content = gzip.decompress(raw)
        except (EOFError, OSError, zlib.error) as error:
            raise InputError(f"{path} is a damaged gzip file ({error}); fetch it again.") from None
    if not content.strip():
        raise InputError(f"{path} is empty; give a PDB or mmCIF file with atoms.")
    if b"\0" in content:
        raise InputError(f"{path} is a binary file; give a PDB or mmCIF text file.")
    # Headers of old files hold bytes that are no UTF-8; Latin-1 takes every byte.
    return raw, content.decode("latin-1")


def _is_mmcif(text: str) -> bool:
    for line in text.splitlines():
        if line.strip() and not line.startswith("#"):
            return line.lower().startswith("data_")
    return False


def _read_pdb(text: str, path: str | Path, notes: list[str]) -> gemmi.Structure:
    lines = text.splitlines()
    last = max(number for number, line in enumerate(lines) if line.strip())
    atoms = 0
    for number, line in enumerate(lines):
        if not line.startswith(_ATOM_RECORDS):
            continue
        if len(line.rstrip()) < 54:
            if number != last:
                raise InputError(
                    f"{path}, line {number + 1}: the atom record ends before its coordinates do; "
                    "repair or remove the line."
                )
            notes.append(f"The file ends within line {number + 1}; that atom was left out.")
            lines[number] = ""
            continue
        _check_coordinates((line[30:38], line[38:46], line[46:54]), f"{path}, line {number + 1}")
        atoms += 1
        # gemmi refuses lines without occupancy and B-factor, though coordinates are all it needs.
        line = line.ljust(80)
        if not _ELEMENT_AND_CHARGE.fullmatch(line[76:80]):
            line = line[:76] + "    " + line[80:]  # files before 1996 number their lines there
        lines[number] = line
    if atoms == 0:
        raise InputError(f"{path} contains no atoms; give a PDB or mmCIF file of a molecule.")
    try:
        return gemmi.read_pdb_string("\n".join(lines) + "\n", split_chain_on_ter=True)
    except (RuntimeError, ValueError) as error:
        raise InputError(f"{path} is no valid PDB file: {_one_line(error)}.") from None


def _read_mmcif(text: str, path: str | Path) -> gemmi.Structure:
    try:
        document = gemmi.cif.read_string(text)
    except (RuntimeError, ValueError) as error:
        raise InputError(f"{path} is no valid mmCIF file: {_one_line(error)}.") from None
    columns = ["id", "Cartn_x", "Cartn_y", "Cartn_z"]
    for block in document:
        table = block.find("_atom_site.", columns)
        if len(table) == 0:
            continue
        for row in table:
            _check_coordinates((row[1], row[2], row[3]), f"{path}, atom {row[0]} of _atom_site")
        try:
            structure = gemmi.make_structure_from_block(block)
        except (RuntimeError, ValueError, IndexError) as error:
            reason = _one_line(error) or "a column of _atom_site is missing"
            raise InputError(f"{path} is no valid mmCIF file: {reason}.") from None
        return structure
    raise InputError(
        f"{path} has no atom coordinates (_atom_site.Cartn_x); give the file of a molecule."
    )


def _check_coordinates(fields: tuple[str, str, str], where: str) -> None:
    for axis, field in zip("xyz", fields, strict=True):
        try:
            value = float(field)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise InputError(
                f'{where}: the {axis} coordinate "{field.strip()}" is no finite number; repair it.'
            )
        if abs(value) >= LARGEST_COORDINATE:
            raise InputError(
                f"{where}: the {axis} coordinate {field.strip()} marks an atom without a place; "
                "remove the atom or give it one."
            )


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split()).rstrip(".")
