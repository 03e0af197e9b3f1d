"""Lines of journals, of which the last one may be torn."""

import json
from typing import Any


def line_of(entry: dict[str, Any]) -> bytes:
    """An entry as a line."""
    return json.dumps(entry, separators=(",", ":")).encode() + b"\n"


def entry_of(line: bytes, name: str) -> dict[str, Any] | None:
    """The entry of a whole line: one that has ``name``, or a run's fingerprint; None for others."""
    if not line.endswith(b"\n"):
        return None
    try:
        entry = json.loads(line)
    except ValueError:
        return None
    is_whole = isinstance(entry, dict) and (name in entry or "fingerprint" in entry)
    return entry if is_whole else None
