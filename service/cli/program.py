"""The command's entry point: options, exit status, and the one place where errors become sentences.

Exit status: 0 done, 1 the question was answered with "no", 2 unusable input, 3 a device or the
service failed, 130 interrupted.
"""

import sys

import typer

from service.cli.campaigns import identify_command, predict_command, validate_command
from service.cli.cells import demo_command, nightly_command, serve_command, simulate_command
from service.domain.errors import TrueposeError
from service.exchange.errors import ExchangeError

UNUSABLE_INPUT = 2
INTERRUPTED = 130

app = typer.Typer(
    name="truepose",
    help="Measures, identifies and validates industrial robots.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
app.command("demo")(demo_command)
app.command("serve")(serve_command)
app.command("simulate")(simulate_command)
app.command("identify")(identify_command)
app.command("predict")(predict_command)
app.command("validate")(validate_command)
app.command("nightly")(nightly_command)


def main() -> int:
    """Run the command and return its exit status."""
    try:
        status = app(standalone_mode=False)
    except typer.TyperException as error:
        error.show(sys.stderr)
        return UNUSABLE_INPUT
    except (TrueposeError, ExchangeError, OSError) as error:
        sys.stderr.write(f"{_sentence(error)}\n")
        return UNUSABLE_INPUT
    except (KeyboardInterrupt, typer.Abort):
        sys.stderr.write("Interrupted.\n")
        return INTERRUPTED
    return status if isinstance(status, int) else 0


def _sentence(error: Exception) -> str:
    if isinstance(error, OSError) and error.filename:
        return f"{error.filename}: {error.strerror}."
    return str(error)
