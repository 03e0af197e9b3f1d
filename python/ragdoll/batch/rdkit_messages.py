"""What RDKit says while it works, caught instead of printed."""

import logging
import re
from collections.abc import Iterator
from contextlib import contextmanager

from rdkit import rdBase

_CLOCK = re.compile(r"^\[\d\d:\d\d:\d\d\] ")


class _Keeper(logging.Handler):
    """Keeps messages in a list."""

    def __init__(self) -> None:
        super().__init__()
        self.messages: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        """Keep one."""
        text = _CLOCK.sub("", record.getMessage()).strip()
        if text:
            self.messages.append(text)


@contextmanager
def rdkit_messages() -> Iterator[list[str]]:
    """The messages that RDKit logs meanwhile, as a list that grows.

    Afterwards RDKit logs to standard error, its own default, what it logged before.
    """
    states = [line.split(":") for line in rdBase.LogStatus().split()]
    logger = logging.getLogger("rdkit")
    keeper = _Keeper()
    before, propagates, level = logger.handlers[:], logger.propagate, logger.level
    logger.handlers[:], logger.propagate = [keeper], False
    logger.setLevel(logging.INFO)
    rdBase.LogToPythonLogger()
    try:
        yield keeper.messages
    finally:
        rdBase.LogToCppStreams()
        for name, state in states:
            (rdBase.EnableLog if state == "enabled" else rdBase.DisableLog)(name)
        logger.handlers[:], logger.propagate = before, propagates
        logger.setLevel(level)
