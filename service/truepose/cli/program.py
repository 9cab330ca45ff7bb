"""The command's entry point: options, exit status, and the one place where errors become sentences.

Exit status: 0 done, 1 the question was answered with "no", 2 unusable input, 3 a device or the
service failed, 130 interrupted.
"""

import functools
import sys
from collections.abc import Callable, Iterable, Sequence
from importlib import import_module
from typing import Annotated

import typer

from truepose.domain.errors import TrueposeError
from truepose.messages.error_codes import code_of
from truepose.start import begin_lightly, end_lightly, speak_unicode
from truepose.version import __version__

UNUSABLE_INPUT = 2
SERVICE_FAILED = 3
INTERRUPTED = 130
# A database that a service has or whose server is away, workers that cannot be used: no input can mend it.
_OF_SERVICES = frozenset({"TP-5008", "TP-5009", "TP-6004", "TP-6010", "TP-6011"})

_COMMANDS = {
    "demo": "services",
    "serve": "services",
    "plant": "services",
    "simulate": "services",
    "identify": "campaigns",
    "diagnose": "diagnoses",
    "predict": "campaigns",
    "reanalyse": "batch_analysis",
    "fleet": "fleets",
    "resample": "batch_analysis",
    "validate": "validation",
    "plan": "plans",
    "circles": "circles_and_spheres",
    "sphere": "circles_and_spheres",
    "correct": "corrections",
    "export": "models",
    "import": "imports",
    "watch": "batch_analysis",
    "nightly": "services",
    "inspect": "imports",
    "verify": "database",
    "backup": "database",
    "restore": "database",
    "copy": "database",
    "retention": "database",
    "unit": "services",
    "dashboard": "services",
}


_GROUPS = {"people": "people"}  # of commands


def main() -> int:
    """Run the command and return its exit status."""
    begin_lightly()
    speak_unicode()
    try:
        return _run()
    finally:
        end_lightly()


def _run() -> int:
    try:
        application(sys.argv[1:])(prog_name="truepose")
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else 0
    return 0


def application(arguments: Sequence[str] = ()) -> typer.Typer:
    """Return the command line with the command that `arguments` name, or with all commands."""
    app = typer.Typer(
        name="truepose",
        help="Measures, identifies and validates industrial robots, and names what their model gets wrong.",
        no_args_is_help=True,
        pretty_exceptions_enable=False,
        callback=_asked_of_the_program,
    )
    for name in _asked_for(arguments):
        app.command(name)(_exiting(_command(name)))
    for name in _groups_asked_for(arguments):
        app.add_typer(_group(name), name=name)
    return app


def _asked_for(arguments: Sequence[str]) -> Iterable[str]:
    """Return the command that will run, all where none is named: what is not asked for is not imported."""
    return arguments[:1] if arguments and arguments[0] in _COMMANDS else _COMMANDS


def _groups_asked_for(arguments: Sequence[str]) -> Iterable[str]:
    return () if arguments and arguments[0] in _COMMANDS else _GROUPS


def _group(name: str) -> typer.Typer:
    module = import_module(f"truepose.cli.{_GROUPS[name]}")
    group = typer.Typer(help=module.HELP, no_args_is_help=True)
    for command, does in module.COMMANDS.items():
        group.command(command)(_exiting(does))
    return group


def _command(name: str) -> Callable[..., int]:
    module = import_module(f"truepose.cli.{_COMMANDS[name]}")
    command: Callable[..., int] = getattr(module, f"{name}_command")
    return command


def _say_version(asked: bool) -> None:
    if asked:
        sys.stdout.write(f"truepose {__version__}\n")
        raise typer.Exit


def _asked_of_the_program(
    version: Annotated[
        bool, typer.Option("--version", help="Print the version.", callback=_say_version, is_eager=True)
    ] = False,
) -> None:
    """Take the options that stand before a command; each answers by itself."""


def _exiting(command: Callable[..., int]) -> Callable[..., None]:
    """Make a command end with its own status, and with a sentence where the input cannot be used."""

    @functools.wraps(command)
    def ending(*arguments: object, **options: object) -> None:
        try:
            status = command(*arguments, **options)
        except (TrueposeError, OSError) as error:
            code = code_of(error)
            sys.stderr.write(f"{_sentence(error)} [{code}]\n")
            status = SERVICE_FAILED if code in _OF_SERVICES else UNUSABLE_INPUT
        except KeyboardInterrupt:
            sys.stderr.write("Interrupted.\n")
            status = INTERRUPTED
        raise typer.Exit(status)

    return ending


def _sentence(error: Exception) -> str:
    if isinstance(error, OSError) and error.filename:
        return f"{error.filename}: {error.strerror}."
    return str(error)
