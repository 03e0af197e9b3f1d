"""The exceptions that users see."""


class InputError(ValueError):
    """Input that cannot be used: a missing file, an atom without a place, an unknown chain.

    The message is one sentence that names the file, line or atom and says what to do. The command
    line prints it and exits with code 2.
    """
