"""What a command prints: one JSON document on standard output, or tables; everything else on standard error."""

import json
import sys
from collections.abc import Iterable
from typing import Any

from rich.console import Console


def print_json(document: Any) -> None:
    """Print one JSON document on standard output."""
    sys.stdout.write(json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False) + "\n")


def console() -> Console:
    """Return the console for tables on standard output."""
    return Console(file=sys.stdout, highlight=False)


def remark(sentences: Iterable[str]) -> None:
    """Print sentences on standard error."""
    for sentence in sentences:
        sys.stderr.write(f"{sentence}\n")
