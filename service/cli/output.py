"""What a command prints: one JSON document or tables on standard output, all else on standard error."""

import json
import os
import sys
from collections.abc import Iterable
from typing import Any

from rich.console import Console, RenderableType


def print_json(document: Any) -> None:
    """Print one JSON document on standard output."""
    _write(json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False) + "\n")


def print_tables(tables: RenderableType) -> None:
    """Print tables on standard output, coloured on a terminal only."""
    console = Console(file=sys.stdout, highlight=False)
    with console.capture() as printed:
        console.print(tables)
    _write(printed.get())


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
