"""Exit codes of the command line."""

DONE = 0
FAILED = 1
USAGE = 2
INCOMPLETE = 3  # it ran, but a result is not converged or frames are missing
INTERRUPTED = 130


class EndedShort(Exception):
    """A command wrote what it has, which is less than was asked for; the message says why."""

    def __init__(self, sentence: str, code: int):
        super().__init__(sentence)
        self.code = code
