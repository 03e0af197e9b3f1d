"""Lines of text files as people have them: gzipped, in any encoding, with lines of any length."""

import codecs
import gzip
import io
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from ..errors import InputError

LONGEST_LINE = 1_000_000  # characters; what is longer is cut, and said to be
_GZIP = b"\x1f\x8b"
_SAMPLE = 4096  # bytes that tell the encoding


class BrokenText(Exception):
    """A file that cannot be read to its end; the message says why."""


@dataclass(frozen=True)
class Line:
    """A line without its end.

    Attributes:
        number: from 1.
        text: the characters; control characters as they are.
        is_cut: whether the line was longer than LONGEST_LINE.
    """

    number: int
    text: str
    is_cut: bool = False


class TextLines:
    """The lines of a file, one after the other, in bounded memory; a context manager.

    UTF-8 and UTF-16 are told by their marks or by their zero bytes; a line that is not UTF-8 is
    taken as Latin-1. A file that starts as gzip does is unpacked, whatever it is called. Lines end
    with LF, CR LF or CR.
    """

    def __init__(self, path: Path):
        """Open a file.

        Raises:
            InputError: there is no such file, it is empty, or it is no text.
        """
        self.path = path
        self._raw = _open(path)
        try:
            self._text, self.start = self._decoded()
        except BaseException:
            self._raw.close()
            raise

    def _decoded(self) -> tuple[io.TextIOWrapper, str]:
        packed = self._raw.peek(2)[:2] == _GZIP
        data = gzip.GzipFile(fileobj=self._raw, mode="rb") if packed else self._raw
        buffered = io.BufferedReader(data, _SAMPLE * 16)
        try:
            sample = buffered.peek(_SAMPLE)[:_SAMPLE]
        except (EOFError, OSError, zlib.error):
            raise InputError(
                f"{self.path} is no whole gzip file; copy it again, or unpack it."
            ) from None
        if not sample:
            raise InputError(f"{self.path} is empty; give a file with molecules.")
        encoding = _encoding_of(sample)
        if encoding is None:
            raise InputError(f"{self.path} is no text, but data; give a file with molecules.")
        # bytes that are not UTF-8 come as surrogates, so that they can be had back
        errors = "surrogateescape" if encoding.startswith("utf-8") else "replace"
        text = io.TextIOWrapper(buffered, encoding=encoding, errors=errors, newline=None)
        return text, sample.decode(encoding, "replace")

    def __iter__(self) -> Iterator[Line]:
        """Give the lines.

        Raises:
            BrokenText: the file breaks off.
        """
        number = 0
        while True:
            number += 1
            text, is_cut = self._line()
            if text is None:
                return
            yield Line(number, _repaired(text), is_cut)

    def _line(self) -> tuple[str | None, bool]:
        try:
            text = self._text.readline(LONGEST_LINE + 1)
            if not text:
                return None, False
            is_cut = False
            if len(text) > LONGEST_LINE and not text.endswith("\n"):
                is_cut = True
                rest = text
                while rest and not rest.endswith("\n"):
                    rest = self._text.readline(LONGEST_LINE)
                text = text[:LONGEST_LINE]
        except (EOFError, OSError, zlib.error, UnicodeError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            raise BrokenText(f"the file cannot be read on: {reason}") from None
        return text.removesuffix("\n"), is_cut

    @property
    def share_read(self) -> float:
        """How much of the file has been read, from 0 to 1."""
        try:
            return self._raw.tell() / max(self._size, 1)
        except (OSError, ValueError):
            return 0.0

    @property
    def _size(self) -> int:
        return self.path.stat().st_size

    def close(self) -> None:
        """Close the file."""
        self._text.close()
        self._raw.close()

    def __enter__(self) -> "TextLines":
        return self

    def __exit__(self, kind, error, traceback) -> None:
        self.close()


def _open(path: Path) -> BinaryIO:
    if path.is_dir():
        raise InputError(f"{path} is a folder; give a file with molecules.")
    try:
        return open(path, "rb")
    except FileNotFoundError:
        raise InputError(f"There is no file {path}; give one with molecules.") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"{path} cannot be read: {reason}.") from None


def _encoding_of(sample: bytes) -> str | None:
    """The encoding that the first bytes of a file show; None where it is no text."""
    if sample.startswith(codecs.BOM_UTF8):
        return "utf-8-sig"
    if sample.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    even, odd = sample[0::2].count(0), sample[1::2].count(0)
    if even + odd == 0:
        return None if sample.startswith(b"%PDF-") else "utf-8"
    half = len(sample) // 2
    if odd > 0.4 * half and even == 0:
        return "utf-16-le"
    if even > 0.4 * half and odd == 0:
        return "utf-16-be"
    # a zero byte or two in a text are an accident; a file full of control characters is none
    controls = sum(sample.count(code) for code in range(32) if code not in b"\t\n\r\f\v")
    return None if controls > max(8, 0.03 * len(sample)) else "utf-8"


def _repaired(text: str) -> str:
    """The text, with bytes that were not UTF-8 read as Latin-1."""
    if text.isascii():
        return text
    try:
        text.encode("utf-8")
    except UnicodeEncodeError:
        return text.encode("utf-8", "surrogateescape").decode("latin-1")
    return text
