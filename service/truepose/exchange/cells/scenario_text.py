"""Scenarios that extend another one, as text: TOML writes words, numbers and lists as JSON does."""

import json
from collections.abc import Iterable, Mapping

from truepose.domain.cell.description import Detail


def scenario_text(base: str, kind: str, tables: Iterable[Mapping[str, Detail]]) -> str:
    """Return a scenario that is `base` (shipped, or a file) with further tables of a kind, e.g. `effect`."""
    lines = [f"extends = {json.dumps(base)}"]
    for table in tables:
        lines += [
            f"[[{kind}]]",
            *(f"{json.dumps(key)} = {json.dumps(value)}" for key, value in table.items()),
        ]
    return "\n".join([*lines, ""])
