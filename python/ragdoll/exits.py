"""Exit codes of the command line."""

DONE = 0
FAILED = 1
USAGE = 2
INCOMPLETE = 3  # it ran, but a result is not converged or frames are missing
INTERRUPTED = 130
