"""Files of molecules, cut into the texts of single molecules; what a text means is not judged."""

import csv
import re
import unicodedata
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from ..errors import InputError
from .text_lines import BrokenText, Line, TextLines

LONGEST_RECORD = 16_000_000  # characters of one molecule
_HEADER = re.compile(r'^[#"\']?(canonical|isomeric)?[ _-]?smiles?\b', re.IGNORECASE)
_NAME_COLUMNS = ("name", "title", "id", "compound", "molecule", "compound_id", "molecule_id")


@dataclass(frozen=True)
class Record:
    """The text of one molecule.

    Attributes:
        number: place among the molecules of the file, from 0.
        line: where it starts, from 1.
        kind: "smiles", "mol" or "mol2".
        title: its name in the file, else one from its line or number.
        text: the SMILES or the block.
        error: why the text cannot be used; empty where nothing is known against it.
    """

    number: int
    line: int
    kind: str
    title: str
    text: str
    error: str = ""


class MoleculeFile:
    """The molecules of a file, one after the other; a context manager."""

    def __init__(self, path: Path):
        """Open a file: .smi, .smiles, .txt, .csv, .tsv, .sdf, .sd, .mol or .mol2, also .gz.

        Raises:
            InputError: the file cannot be read or is none of these.
        """
        self.path = path
        suffixes = [suffix.lower() for suffix in path.suffixes]
        if suffixes and suffixes[-1] == ".gz":
            suffixes.pop()
        suffix = suffixes[-1] if suffixes else ""
        if suffix not in _CUTTERS:
            raise InputError(
                f"{path} has no name that tells its format; give a file {', '.join(_CUTTERS)}, "
                "also .gz."
            )
        self._cut, self._is_plausible, self._what = _CUTTERS[suffix]
        self.lines = TextLines(path)
        if not self._is_plausible(self.lines.start):
            self.lines.close()
            raise InputError(f"{path} is no {self._what}; name it after what it is.")

    def __iter__(self) -> Iterator[Record]:
        """Give the records; one with an error where the file breaks off."""
        number, line = -1, 0
        try:
            for number, (line, kind, title, text, error) in enumerate(self._cut(self.lines)):
                where = f"line {line}" if kind == "smiles" else f"molecule {number + 1}"
                yield Record(number, line, kind, clean_title(title) or where, text, error)
        except BrokenText as broken:
            yield Record(number + 1, line, "smiles", f"after line {line}", "", str(broken))

    def close(self) -> None:
        """Close the file."""
        self.lines.close()

    def __enter__(self) -> "MoleculeFile":
        return self

    def __exit__(self, kind, error, traceback) -> None:
        self.close()


def clean_title(title: str) -> str:
    """A title that fits the one line it has in an SD file: control characters become spaces."""
    if not title.isprintable():
        title = "".join(
            " " if unicodedata.category(letter) in ("Cc", "Cs", "Zl", "Zp") else letter
            for letter in title
        )
    title = title.strip()
    # a line that starts so would end the record
    return f"'{title}'" if title.startswith("$$$$") else title


# line, kind, title, text, error
_Cut = Iterator[tuple[int, str, str, str, str]]


def _cut_smiles(lines: Iterable[Line]) -> _Cut:
    """A molecule a line: SMILES, perhaps an extension in bars, and the title."""
    is_first = True
    for line in lines:
        text = line.text.strip().strip("\0\ufeff")
        if not text or text.startswith("#"):
            continue
        if is_first and _HEADER.match(text):
            is_first = False
            continue
        is_first = False
        if line.is_cut:
            yield line.number, "smiles", "", "", _too_long(line)
            continue
        smiles, _, rest = _split(text)
        title = rest
        if rest.startswith("|"):  # ChemAxon's extension
            extension, bar, title = rest[1:].partition("|")
            if bar:
                smiles = f"{smiles} |{extension}|"
            else:
                title = rest
        yield line.number, "smiles", title, smiles, ""


def _split(text: str) -> tuple[str, str, str]:
    parts = text.split(None, 1)
    return parts[0], " ", parts[1] if len(parts) > 1 else ""


def _too_long(line: Line) -> str:
    return f"the line has more than {len(line.text)} characters"


def _cut_table(delimiter: str) -> Callable[[Iterable[Line]], _Cut]:
    """A cutter of tables with a column of SMILES, by its name or the first."""

    def cut(lines: Iterable[Line]) -> _Cut:
        smiles_column, title_column = 0, 1
        is_first = True
        for line in lines:
            if not line.text.strip():
                continue
            if line.is_cut:
                yield line.number, "smiles", "", "", _too_long(line)
                continue
            try:
                cells = next(csv.reader([line.text], delimiter=delimiter), [])
            except csv.Error as error:
                yield line.number, "smiles", "", "", f"the line is no row of a table: {error}"
                continue
            cells = [cell.strip() for cell in cells]
            if is_first:
                is_first = False
                names = [cell.lower() for cell in cells]
                found = [k for k, name in enumerate(names) if "smiles" in name]
                if found:
                    smiles_column = found[0]
                    others = [k for k, name in enumerate(names) if name in _NAME_COLUMNS]
                    rest = [k for k in range(len(names)) if k != smiles_column]
                    title_column = (others or rest or [len(names)])[0]
                    continue
            if smiles_column >= len(cells) or not cells[smiles_column]:
                yield line.number, "smiles", "", "", "the row has no SMILES"
                continue
            title = cells[title_column] if title_column < len(cells) else ""
            yield line.number, "smiles", title, cells[smiles_column], ""

    return cut


def _cut_blocks(lines: Iterable[Line], ends: Callable[[str], bool], begins: Callable[[str], bool]):
    """Groups of lines, in bounded memory: (first line's number, lines, error)."""
    block: list[str] = []
    size, first, error = 0, 1, ""
    for line in lines:
        if begins(line.text) and block:
            yield first, block, error
            block, size, error = [], 0, ""
        if not block:
            first = line.number
        if ends(line.text):
            yield first, block, error
            block, size, error = [], 0, ""
            continue
        size += len(line.text) + 1
        if line.is_cut or size > LONGEST_RECORD:
            error = _too_long(line) if line.is_cut else f"it has more than {LONGEST_RECORD} bytes"
            block = block[:1] or [""]  # the title is all that is of use
            size = LONGEST_RECORD if not line.is_cut else size
            if line.is_cut:
                size = LONGEST_RECORD + 1
            continue
        block.append(line.text)
    if any(text.strip() for text in block) or error:
        yield first, block, error


def _cut_sd(lines: Iterable[Line]) -> _Cut:
    """Records that end with a line $$$$."""
    for first, block, error in _cut_blocks(
        lines, lambda text: text.startswith("$$$$"), lambda text: False
    ):
        if not error and not any(text.strip() for text in block):
            error = "the record is empty"
        title = block[0] if block else ""
        yield first, "mol", title, "\n".join(block) + "\n", error


def _cut_mol2(lines: Iterable[Line]) -> _Cut:
    """Records that begin with @<TRIPOS>MOLECULE."""

    def begins(text: str) -> bool:
        return text.startswith("@<TRIPOS>MOLECULE")

    for first, block, error in _cut_blocks(lines, lambda text: False, begins):
        if block and begins(block[0]):
            title = block[1] if len(block) > 1 else ""
            yield first, "mol2", title, "\n".join(block) + "\n", error


def _is_sd(start: str) -> bool:
    """Whether the fourth line counts atoms, or a line further on ends a record or a block."""
    lines = start.splitlines()
    counts = lines[3] if len(lines) > 3 else ""
    return bool(
        re.match(r"^[ \d]{3}[ \d]{3}", counts)
        or re.search(r"^(M  END|\$\$\$\$|>  ?<)", start, re.MULTILINE)
    )


def _is_text(start: str) -> bool:
    return True


def _is_mol2(start: str) -> bool:
    return "@<TRIPOS>" in start


_SMILES = (_cut_smiles, _is_text, "file of SMILES")
_SD = (_cut_sd, _is_sd, "SD file")
_CUTTERS = {
    ".smi": _SMILES,
    ".smiles": _SMILES,
    ".txt": _SMILES,
    ".csv": (_cut_table(","), _is_text, "table"),
    ".tsv": (_cut_table("\t"), _is_text, "table"),
    ".sdf": _SD,
    ".sd": _SD,
    ".mol": _SD,
    ".mol2": (_cut_mol2, _is_mol2, "MOL2 file"),
}
