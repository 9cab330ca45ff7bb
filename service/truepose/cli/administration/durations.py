"""Durations as people type them: `90s`, `30m`, `24h`, `7d`."""

import re
from typing import Final

import typer

_SECONDS: Final = {"": 1.0, "s": 1.0, "m": 60.0, "h": 3600.0, "d": 86400.0}
_FORM: Final = re.compile(r"(\d+(?:\.\d+)?)([smhd]?)")


def seconds(text: str) -> float:
    """Return a duration [s]; raises BadParameter."""
    found = _FORM.fullmatch(str(text).strip().lower())
    if found is None or float(found[1]) == 0:
        raise typer.BadParameter(f"'{text}' is no duration; write 90s, 30m, 24h or 7d.")
    return float(found[1]) * _SECONDS[found[2]]
