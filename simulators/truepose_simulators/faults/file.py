"""Faults as tables with a `kind`, and a file of nothing but `[[fault]]` tables (docs/faults.md)."""

import re
import tomllib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final

from truepose_simulators.errors import ScenarioError
from truepose_simulators.faults.kinds import KINDS
from truepose_simulators.faults.times import Fault
from truepose_simulators.scenarios.table import read_table, read_text


def read_fault(table: object, where: str) -> Fault:
    """Build a fault from a table; raises ScenarioError."""
    kind = table.get("kind") if isinstance(table, Mapping) else None
    if not isinstance(table, Mapping) or not isinstance(kind, str) or kind not in KINDS:
        raise ScenarioError(f'{where}: key "kind" must be one of {", ".join(KINDS)}')
    rest = {key: value for key, value in table.items() if key != "kind"}
    return read_table(KINDS[kind], rest, where)


_HEADER: Final = re.compile(r"\s*\[\[\s*fault\s*\]\]")
_NAMED: Final = re.compile(r'key "(\w+)"')


def read_faults(path: Path, check: Callable[[Fault], None]) -> tuple[Fault, ...]:
    """Read a file of faults, each of which `check` takes; raises ScenarioError with file and line."""
    text = _text(path)
    tables = _tables(text, path)
    return tuple(_fault(table, _Place(path, text, number), check) for number, table in enumerate(tables))


def _text(path: Path) -> str:
    try:
        return read_text(path)
    except (OSError, UnicodeDecodeError) as error:
        raise ScenarioError(f"{path} cannot be read: {error}") from error


def _tables(text: str, path: Path) -> list[Any]:
    try:
        document = tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # its text names line and column
        raise ScenarioError(f"{path} is not TOML: {error}") from error
    tables = document.pop("fault", [])
    for key in document:
        at = _line(text.splitlines(), rf"\s*\[*\s*{re.escape(key)}\b", 0)
        raise ScenarioError(
            f'{path}, line {at}: unknown key "{key}"; a fault file contains only [[fault]] tables'
        )
    if not isinstance(tables, list):
        at = _line(text.splitlines(), r"\s*\[?\s*fault\b", 0)
        raise ScenarioError(f"{path}, line {at}: write [[fault]] with double brackets")
    return tables


def _fault(table: object, place: "_Place", check: Callable[[Fault], None]) -> Fault:
    try:
        fault = read_fault(table, "")
        check(fault)
    except ScenarioError as error:
        raise place.said(str(error).removeprefix(": ")) from error
    return fault


class _Place:
    """Where in its file a table stands."""

    def __init__(self, path: Path, text: str, number: int) -> None:
        self._path = path
        self._lines = text.splitlines()
        headers = [at for at, line in enumerate(self._lines) if _HEADER.match(line)]
        # Tables written in one line have no headers: then it is looked for from the top.
        self._begin = headers[number] if number < len(headers) else 0
        self._end = headers[number + 1] if number + 1 < len(headers) else len(self._lines)

    def said(self, sentence: str) -> ScenarioError:
        """Return an error with file and line: of the key that the sentence names, else of the table."""
        named = _NAMED.search(sentence)
        at = self._begin + 1
        if named is not None:
            at = _line(self._lines[: self._end], rf"\s*{named[1]}\s*=", self._begin)
        return ScenarioError(f"{self._path}, line {at}: {sentence}")


def _line(lines: list[str], pattern: str, begin: int) -> int:
    """Return the number of the first line from `begin` (0-based) on that matches, else that of `begin`."""
    found = (at for at in range(begin, len(lines)) if re.match(pattern, lines[at]))
    return next(found, begin) + 1
