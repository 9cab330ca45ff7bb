"""Texts of people in a table: none of them is a formula to the program that opens it.

A spreadsheet computes a cell that begins with one of a few signs, whoever wrote it. Such a text is written
with an apostrophe before it, as OWASP has it, and a number never is. What is read loses the apostrophe again
exactly where one is written, so that every text comes back as it was.
"""

import re
from typing import Final

_BEGINS_FORMULA: Final = re.compile(
    "'*[=+\\-@\t\r\n\uff1d\uff0b\uff0d\uff20]"
)  # the wide ones compute as well
_NUMBER: Final = re.compile(r"\s*[+-]?(?:[0-9]+[.,]?[0-9]*|[.,][0-9]+)(?:[eE][+-]?[0-9]+)?\s*")


def written_text(text: str) -> str:
    """Return a text as a cell that no spreadsheet computes."""
    return f"'{text}" if _is_formula(text) else text


def read_text(cell: str) -> str:
    """Return the text of a cell as `written_text` took it."""
    return cell[1:] if cell[:1] == "'" and _is_formula(cell[1:]) else cell


def _is_formula(text: str) -> bool:
    """Whether a text begins one, also behind apostrophes that it has itself."""
    return _BEGINS_FORMULA.match(text) is not None and _NUMBER.fullmatch(text.lstrip("'")) is None
