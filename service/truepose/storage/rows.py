"""Rows of tables as frozen dataclasses and back: a column is the field of its name."""

import dataclasses
from collections.abc import Hashable
from enum import Enum
from functools import cache
from typing import TYPE_CHECKING, Any, Final, TypeVar, cast, get_type_hints

from sqlalchemy import Table

from truepose.storage.documents import from_document, to_document

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

R = TypeVar("R")
_AS_KEPT: Final = frozenset({str, int, float, bytes, str | None, int | None, float | None})


def from_row(kind: type[R], row: Any, /, **given: Any) -> R:
    """Return the dataclass `kind` of a row; what is `given` is not looked for in a column.

    Raises DamagedDatabaseError where a column does not hold what its field is.
    """
    read = {
        name: _read(hint, getattr(row, name))
        for name, hint in _hints(cast(Hashable, kind))
        if name not in given
    }
    return kind(**read, **given)


@cache
def _hints(kind: Any) -> tuple[tuple[str, Any], ...]:
    hints = get_type_hints(kind)
    return tuple((field.name, hints[field.name]) for field in dataclasses.fields(kind))


def _read(hint: Any, value: Any) -> Any:
    if hint in _AS_KEPT:
        return value
    # Tables have no truth values: both engines keep 0 and 1.
    return bool(value) if hint is bool else from_document(hint, value)


def to_row(noun: "DataclassInstance", table: Table) -> dict[str, Any]:
    """Return the fields of a dataclass for which a table has a column, as the column takes them."""
    named = (field.name for field in dataclasses.fields(noun) if field.name in table.c)
    return {name: _written(getattr(noun, name)) for name in named}


def _written(value: Any) -> Any:
    match value:
        case Enum():
            return value.value
        case bool():
            return int(value)
        case str() | int() | float() | bytes() | None:
            return value
        case _:
            return to_document(value)
