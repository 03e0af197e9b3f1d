"""Standard output and error that never end a run: closed, full, or with a reader that went away."""

import os
import sys
from typing import TextIO


class LastingStream:
    """A text stream that takes everything; what cannot be written is dropped.

    Attributes:
        failure: why the first text was dropped, or None.
    """

    def __init__(self, stream: TextIO):
        self._stream = stream
        self.failure: OSError | None = None

    def write(self, text: str) -> int:
        """Write, or drop, the text."""
        if self.failure is None:
            try:
                self._stream.write(text)
            except OSError as error:
                self._give_up(error)
        return len(text)

    def flush(self) -> None:
        """Pass on what is buffered."""
        if self.failure is None:
            try:
                self._stream.flush()
            except OSError as error:
                self._give_up(error)

    def _give_up(self, error: OSError) -> None:
        self.failure = error
        nothing = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nothing, self._stream.fileno())  # for what is still in the buffer
        os.close(nothing)

    def __getattr__(self, name: str):
        """Anything else is the stream's own."""
        return getattr(self._stream, name)


def make_streams_last() -> None:
    """Put LastingStreams in place of sys.stdout and sys.stderr, also of those closed at the start.

    A character that the encoding lacks becomes a question mark.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:  # closed: the next file to be opened would take messages
            os.open(os.devnull, os.O_RDWR)
    for number, name in ((1, "stdout"), (2, "stderr")):
        stream = getattr(sys, name)
        if stream is None:
            stream = os.fdopen(number, "w", closefd=False)
        stream.reconfigure(errors="replace")
        setattr(sys, name, LastingStream(stream))


def complain(sentence: str) -> None:
    """Say on standard error, in one line, what went wrong."""
    words = " ".join(sentence.split())
    sys.stdout.flush()
    print(f"ragdoll: {words}{'' if words.endswith(('.', '!', '?')) else '.'}", file=sys.stderr)
    sys.stderr.flush()
