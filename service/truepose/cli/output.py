"""What a command prints: one JSON document or tables on standard output, all else on standard error."""

import contextlib
import json
import os
import sys
from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING, Any

from truepose.messages.catalogue import english
from truepose.messages.message import Text

if TYPE_CHECKING:
    from rich.console import RenderableType


def print_json(document: Any) -> None:
    """Print one JSON document on standard output."""
    _write(json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False) + "\n")


def print_tables(tables: "RenderableType") -> None:
    """Print tables on standard output, coloured on a terminal only."""
    from rich.console import Console

    console = Console(file=sys.stdout, highlight=False)
    with console.capture() as printed:
        console.print(tables)
    _write(printed.get())


def print_lines(lines: Iterable[str]) -> None:
    """Print sentences on standard output, one a line however long."""
    _write("".join(f"{line}\n" for line in lines))


@contextlib.contextmanager
def progress_bar() -> Iterator[Callable[[float, Text], None]]:
    """Yield what is to be told how far the work is (0 to 1, and what is done); a bar on a terminal only."""
    from rich.console import Console
    from rich.markup import escape
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    console = Console(stderr=True, highlight=False)
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bars:
        bar = bars.add_task("", total=1.0)
        yield lambda fraction, doing: bars.update(bar, completed=fraction, description=escape(english(doing)))


def remark(sentences: Iterable[str]) -> None:
    """Print sentences on standard error."""
    for sentence in sentences:
        sys.stderr.write(f"{sentence}\n")


def _write(text: str) -> None:
    try:
        sys.stdout.write(text)
        sys.stdout.flush()
    except OSError as error:
        # What is left in the buffer would fail once more when the interpreter ends.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        # A reader that has had enough (`| head`) is none of our errors: the exit status still answers.
        if not isinstance(error, BrokenPipeError):
            raise
