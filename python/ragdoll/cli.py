"""The command line: one program, a verb per file in ``commands``."""

import signal
import sys
from typing import Annotated

from .exits import DONE, FAILED, INTERRUPTED, USAGE, EndedShort


def main() -> None:
    """Run a command; whatever goes wrong ends in one sentence and an exit code."""
    _catch_signals()
    try:
        code = _run()
    except KeyboardInterrupt:
        # it came while the modules were loaded
        print("ragdoll: Interrupted.", file=sys.stderr)
        code = INTERRUPTED
    sys.exit(code)


def _catch_signals() -> None:
    """Signals that ask for an end raise KeyboardInterrupt, unless the caller ignores them."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _interrupt)


def _interrupt(number, frame) -> None:
    raise KeyboardInterrupt


def _run() -> int:
    import typer

    from .commands.streams import complain, make_streams_last
    from .errors import InputError
    from .trajectory import TrajectoryError

    make_streams_last()
    sentence, code = "", DONE
    try:
        code = _make_app()(standalone_mode=False)
        if code == INTERRUPTED:  # typer's, for an interruption
            sentence = "Interrupted."
    except EndedShort as short:
        sentence, code = str(short), short.code
    except (typer.Abort, KeyboardInterrupt):
        sentence, code = "Interrupted.", INTERRUPTED
    except InputError as error:
        sentence, code = str(error), USAGE
    except (TrajectoryError, OSError) as error:
        sentence, code = str(error), FAILED
    except MemoryError:
        sentence, code = "There is not enough memory.", FAILED
    except Exception as error:  # a usage error of the command line, or a defect of ours
        show = getattr(error, "format_message", None)
        if show is None:
            sentence, code = f"{type(error).__name__}: {error}", FAILED
        else:
            sentence, code = show(), getattr(error, "exit_code", USAGE)
    sys.stdout.flush()
    lost = sys.stdout.failure
    if code == DONE and lost is not None and not isinstance(lost, BrokenPipeError):
        sentence, code = f"Standard output takes no more: {lost.strerror}.", FAILED
    if sentence:
        complain(sentence)
    return code


def _make_app():
    import typer

    from .commands import (
        classify,
        conformers,
        experiment,
        generate,
        info,
        modes,
        order,
        picture,
        prepare,
        quality,
        resolve,
        rigidity,
        sample,
        target,
    )
    from .errors import InputError

    app = typer.Typer(
        name="ragdoll",
        help="Ragdoll physics for molecules: geometric simulation as an OpenMM plugin.",
        add_completion=False,
        rich_markup_mode=None,
        pretty_exceptions_enable=False,
    )
    app.command("sample")(sample.run)
    app.command("target")(target.run)
    app.command("conformers")(conformers.run)
    app.command("modes")(modes.run)
    app.command("info")(info.run)
    app.command("picture")(picture.run)
    app.command("prepare")(prepare.run)
    app.command("quality")(quality.run)
    app.command("rigidity")(rigidity.run)
    app.add_typer(generate.app, name="generate")
    app.command("classify")(classify.run)
    app.command("order")(order.run)
    app.command("resolve")(resolve.run)
    app.command("experiment")(experiment.run)

    def print_version(asked: bool) -> None:
        if asked:
            from .version import __version__

            typer.echo(__version__)
            raise typer.Exit

    @app.callback(invoke_without_command=True)
    def options(
        context: typer.Context,
        version: Annotated[
            bool, typer.Option("--version", callback=print_version, help="Print the version.")
        ] = False,
    ) -> None:
        if context.invoked_subcommand is None:
            typer.echo(context.get_help())
            raise InputError("Give a command.")

    return app
