"""Lines of code by room of the product, beside the budget that `docs/architecture.md` states.

`python -m tests.helpers.room_sizes` prints the table as it stands there.
"""

import ast
import collections
import re
import sys
from pathlib import Path

CHECKOUT = Path(__file__).parents[2]
_PACKAGES = ("service", "drivers", "simulators", "migrations")
_DOCUMENT = CHECKOUT / "docs" / "architecture.md"
_ROW = re.compile(r"^\| `([\w/]+)` \| ([\d,]+) \|", re.MULTILINE)
_DOCUMENTED = ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef


def sizes():
    """Return the lines of code of each room."""
    counted = collections.Counter()
    for package in _PACKAGES:
        for path in (CHECKOUT / package).rglob("*.py"):
            counted[_room(path.relative_to(CHECKOUT))] += lines_of_code(path.read_text(encoding="utf-8"))
    return counted


def budget():
    """Return the lines of code of each room as they were measured last."""
    rows = _ROW.findall(_DOCUMENT.read_text(encoding="utf-8"))
    return {room: int(lines.replace(",", "")) for room, lines in rows}


def lines_of_code(source):
    """Count the lines that are neither blank nor a comment nor part of a docstring."""
    written = {n for n, line in enumerate(source.splitlines(), start=1) if _is_written(line)}
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, _DOCUMENTED) and ast.get_docstring(node, clean=False) is not None:
            text = node.body[0]
            written -= set(range(text.lineno, text.end_lineno + 1))
    return len(written)


def _is_written(line):
    return bool(line.strip()) and not line.lstrip().startswith("#")


def _room(path):
    """Return the room of a module: a folder of the service's package, or a package."""
    parts = path.parts
    return "/".join(parts[1:3]) if parts[0] == "service" and len(parts) > 3 else parts[0]


if __name__ == "__main__":
    rows = sizes().most_common()
    sys.stdout.writelines(f"| `{room}` | {lines:,} |\n" for room, lines in rows)
