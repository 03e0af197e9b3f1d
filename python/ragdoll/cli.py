"""The command line: one program, a verb per file in ``commands``."""

import signal
import sys
from typing import Annotated

import typer

from .commands import info, picture, sample
from .errors import InputError
from .exits import FAILED, INTERRUPTED, USAGE
from .trajectory import TrajectoryError
from .version import __version__

app = typer.Typer(
    name="ragdoll",
    help="Ragdoll physics for molecules: geometric simulation as an OpenMM plugin.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)
app.command("sample")(sample.run)
app.command("info")(info.run)
app.command("picture")(picture.run)


def _print_version(asked: bool) -> None:
    if asked:
        typer.echo(__version__)
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, help="Print the version.")
    ] = False,
) -> None:
    pass


def _interrupt(number, frame) -> None:
    raise KeyboardInterrupt


def main() -> None:
    """Run a command; whatever goes wrong ends in one sentence and an exit code."""
    signal.signal(signal.SIGTERM, _interrupt)
    try:
        code = app(standalone_mode=False)
    except typer.Abort:
        code = INTERRUPTED
    except KeyboardInterrupt:
        code = _complain("Interrupted.", INTERRUPTED)
    except InputError as error:
        code = _complain(str(error), USAGE)
    except (TrajectoryError, OSError) as error:
        code = _complain(str(error), FAILED)
    except MemoryError:
        code = _complain("There is not enough memory.", FAILED)
    except Exception as error:  # click's usage errors, or a defect of ours
        show = getattr(error, "format_message", None)
        if show is None:
            code = _complain(f"{type(error).__name__}: {error}", FAILED)
        else:
            code = _complain(show(), getattr(error, "exit_code", USAGE))
    sys.exit(code)


def _complain(sentence: str, code: int) -> int:
    sys.stdout.flush()
    print(f"ragdoll: {' '.join(sentence.split())}", file=sys.stderr)
    return code
