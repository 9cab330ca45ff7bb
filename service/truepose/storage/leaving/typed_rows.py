"""A record as JSON from which its hash can be computed anew: every value with the kind that the chain sees.

Text and whole numbers are JSON's own. A float is `{"float": "0.1"}`, the shortest decimal that is exactly it,
bytes are `{"base64": "..."}`. JSON itself does not tell 3.0 from 3, and to the chain they are two values.
"""

import base64
import binascii
from collections.abc import Mapping
from typing import Any, Final, TypeAlias

from truepose.storage.errors import UnreadableRowError

Value: TypeAlias = str | int | float | bytes | None
WHOLE_NUMBERS: Final = range(-(2**63), 2**63)  # that a database holds
_FLOAT: Final = "float"
_BYTES: Final = "base64"


def typed(row: Mapping[str, Any]) -> dict[str, Any]:
    """Return a row of the database as JSON can hold it, without columns that are null."""
    return {name: _written(value) for name, value in row.items() if value is not None}


def untyped(document: Any) -> dict[str, Value]:
    """Return the row that a document holds; raises UnreadableRowError where it holds none."""
    if not isinstance(document, dict):
        raise UnreadableRowError(f"A record is an object with a value for each column, not {document!r:.60}.")
    return {name: _read(name, value) for name, value in document.items()}


def _written(value: Any) -> Any:
    match value:
        case float():
            return {_FLOAT: repr(value)}
        case bytes() | bytearray() | memoryview():
            return {_BYTES: base64.b64encode(value).decode()}
        case _:
            return value


def _read(name: str, value: Any) -> Value:
    match value:
        case bool() | float():
            pass
        case str():
            return value
        case int() if value in WHOLE_NUMBERS:
            return value
        case {"float": str(decimal)} if len(value) == 1:
            return _float(name, decimal)
        case {"base64": str(text)} if len(value) == 1:
            return _bytes(name, text)
    raise UnreadableRowError(f"The column {name} holds {value!r:.60}, which is no value of a record.")


def _float(name: str, decimal: str) -> float:
    try:
        return float(decimal)
    except ValueError as error:
        raise UnreadableRowError(f"The column {name} holds {decimal!r:.60}, which is no number.") from error


def _bytes(name: str, text: str) -> bytes:
    try:
        return base64.b64decode(text, validate=True)
    except binascii.Error as error:
        raise UnreadableRowError(f"The column {name} holds bytes that cannot be read ({error}).") from error
