"""Files that a user names, and their TOML and JSON tables as dataclasses; a mistake is one sentence."""

import dataclasses
import errno
import os
import stat
import sys
from collections.abc import Mapping
from pathlib import Path
from types import UnionType
from typing import Any, Final, TypeVar, get_args, get_origin, get_type_hints

from truepose_simulators.errors import ScenarioError

_SHOWN_DIGITS: Final = 40  # of a number that is refused
_GREATEST_BYTES: Final = 128 * 2**20
# Not to wait for the other end of what became a pipe since it was looked at; Windows has no such thing.
_AT_ONCE: Final = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOCTTY", 0)


def read_file(path: Path) -> bytes:
    """Return the content of a file; raises OSError, also for a pipe, a device or a folder."""
    # Looked at before it is opened: to open some devices already does something.
    _require_regular(path, path.stat())
    with open(path, "rb", opener=lambda name, flags: os.open(name, flags | _AT_ONCE)) as file:
        _require_regular(path, os.fstat(file.fileno()))
        data = file.read(_GREATEST_BYTES + 1)
    if len(data) > _GREATEST_BYTES:
        raise OSError(errno.EFBIG, f"it has more than {_GREATEST_BYTES // 2**20} MB", str(path))
    return data


def read_text(path: Path) -> str:
    """Return the text of a file, with or without a byte order mark; raises OSError, UnicodeDecodeError."""
    return read_file(path).decode("utf-8-sig")


def _require_regular(path: Path, found: os.stat_result) -> None:
    if not stat.S_ISREG(found.st_mode):
        raise OSError(errno.EINVAL, "it is not a file but a folder, a pipe or a device", str(path))


T = TypeVar("T")


def read_table(cls: type[T], table: object, where: str) -> T:
    """Build the dataclass `cls` from a table whose keys are its fields.

    Parameters
    ----------
    cls : type
        A dataclass with fields of float, int, bool, str, or fixed and open tuples of these.
    table : object
        What the file has there.
    where : str
        The place for the error's sentence, such as "my.toml: [tracker]".

    Raises
    ------
    ScenarioError
        The table is none, a key is unknown, missing or of the wrong kind, or `cls` refuses a value.
    """
    if not isinstance(table, Mapping):
        raise ScenarioError(f"{where} must be a table of keys, not {_kind(table)}")
    # Written here, and not pydantic's: to load that would cost each start of a cell 60 ms.
    fields = {field.name: field for field in dataclasses.fields(cls)}  # type: ignore[arg-type]
    hints = get_type_hints(cls)
    for key in table:
        if key not in fields:
            raise ScenarioError(f'{where}: unknown key "{key}"; known: {", ".join(fields)}')
    for field in fields.values():
        if field.name not in table and _required(field):
            raise ScenarioError(f'{where}: key "{field.name}" is missing')
    values = {key: convert(hints[key], value, f'{where}: key "{key}"') for key, value in table.items()}
    try:
        return cls(**values)
    except ScenarioError as error:  # the class does not know whose values it refuses
        raise ScenarioError(f"{where}: {error}") from error


def convert(hint: Any, value: object, where: str) -> Any:
    """Check one value against a type hint and return it as that type; raises ScenarioError."""
    if get_origin(hint) is UnionType:  # an optional key: present means the other type
        return convert(get_args(hint)[0], value, where)
    if get_origin(hint) is tuple:
        return _convert_tuple(get_args(hint), value, where)
    if hint is float:
        return _number(value, where)
    if type(value) is not hint:
        raise ScenarioError(f"{where} must be {_NAMES[hint]}, not {_kind(value)}")
    return value


_NAMES: Mapping[type, str] = {int: "a whole number", bool: "true or false", str: "a text"}


def _convert_tuple(hints: tuple[Any, ...], value: object, where: str) -> tuple[Any, ...]:
    if not isinstance(value, list | tuple):
        raise ScenarioError(f"{where} must be a list, not {_kind(value)}")
    if hints[-1] is Ellipsis:
        hints = (hints[0],) * len(value)
    if len(value) != len(hints):
        raise ScenarioError(f"{where} must have {len(hints)} entries, not {len(value)}")
    return tuple(convert(hint, item, where) for hint, item in zip(hints, value, strict=True))


def _number(value: object, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ScenarioError(f"{where} must be a number, not {_kind(value)}")
    # Compared, since a whole number beyond a double's range cannot even be asked whether it is finite.
    if not -sys.float_info.max <= value <= sys.float_info.max:
        raise ScenarioError(f"{where} must be a finite number, not {str(value)[:_SHOWN_DIGITS]}")
    return float(value)


def require_at_least_0(table: object, *names: str) -> None:
    """Raise ScenarioError where one of these values of a table is below 0."""
    for name in names:
        if getattr(table, name) < 0.0:
            raise ScenarioError(f'key "{name}" must be 0 or more, not {getattr(table, name)}')


def require_above_0(table: object, *names: str) -> None:
    """Raise ScenarioError where one of these values of a table is not above 0."""
    for name in names:
        if getattr(table, name) <= 0.0:
            raise ScenarioError(f'key "{name}" must be above 0, not {getattr(table, name)}')


def _required(field: dataclasses.Field[Any]) -> bool:
    missing = dataclasses.MISSING
    return field.default is missing and field.default_factory is missing


def _kind(value: object) -> str:
    return f"{value!r}" if isinstance(value, str | int | float) else f"a {type(value).__name__}"
