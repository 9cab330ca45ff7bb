"""The command's entry point: options, exit status, and the one place where errors become sentences.

Exit status: 0 done, 1 the question was answered with "no", 2 unusable input, 3 a device or the
service failed, 130 interrupted.
"""

import functools
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Annotated, Final

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

# In the order of the work, as help lists them: the module of each command, below the heading of its group.
_BY_STEP: Final[Mapping[str, Mapping[str, str]]] = {
    "Measure": {
        "plan": "plans",
        "serve": "services",
        "import": "imports",
        "watch": "batch_analysis",
        "inspect": "imports",
    },
    "Identify": {
        "identify": "campaigns",
        "resample": "batch_analysis",
        "predict": "campaigns",
    },
    "Diagnose": {
        "diagnose": "diagnoses",
        "circles": "circles_and_spheres",
        "sphere": "circles_and_spheres",
    },
    "Validate": {"validate": "validation"},
    "Correct": {"correct": "corrections", "export": "models"},
    "Many robots": {"fleet": "fleets", "reanalyse": "batch_analysis", "plant": "services"},
    "Look after the service": {
        "people": "people",
        "backup": "database",
        "restore": "database",
        "copy": "database",
        "verify": "database",
        "retention": "database",
        "unit": "services",
        "dashboard": "services",
    },
    "Try it": {"demo": "services", "simulate": "services", "nightly": "services"},
}
_OF_SEVERAL: Final = frozenset({"people"})  # commands that have commands of their own
_MODULES: Final = {name: module for commands in _BY_STEP.values() for name, module in commands.items()}


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
        help="Measures, identifies and validates industrial robots, and finds the causes of their errors.",
        invoke_without_command=True,
        pretty_exceptions_enable=False,
        callback=_asked_of_the_program,
    )
    for step, names in _BY_STEP.items():
        for name in _asked_for(arguments, names):
            _add(app, name, step)
    return app


def _asked_for(arguments: Sequence[str], names: Iterable[str]) -> Iterable[str]:
    """Return the command that will run, all where none is named: what is not asked for is not imported."""
    if not arguments or arguments[0] not in _MODULES:
        return names
    return [name for name in names if name == arguments[0]]


def _add(app: typer.Typer, name: str, step: str) -> None:
    if name in _OF_SEVERAL:
        app.add_typer(_group(name), name=name, rich_help_panel=step)
    else:
        app.command(name, rich_help_panel=step)(_exiting(_command(name)))


def _group(name: str) -> typer.Typer:
    module = import_module(f"truepose.cli.{_MODULES[name]}")
    group = typer.Typer(help=module.HELP, no_args_is_help=True)
    for command, does in module.COMMANDS.items():
        group.command(command)(_exiting(does))
    return group


def _command(name: str) -> Callable[..., int]:
    module = import_module(f"truepose.cli.{_MODULES[name]}")
    command: Callable[..., int] = getattr(module, f"{name}_command")
    return command


def _say_version(asked: bool) -> None:
    if asked:
        sys.stdout.write(f"truepose {__version__}\n")
        raise typer.Exit


def _asked_of_the_program(
    context: typer.Context,
    version: Annotated[
        bool, typer.Option("--version", help="Print the version.", callback=_say_version, is_eager=True)
    ] = False,
) -> None:
    """Take the options that stand before a command; say what to do next where no command is named."""
    if context.invoked_subcommand is None:
        from truepose.cli.next_command import introduction

        sys.stdout.write(introduction(Path()))


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
