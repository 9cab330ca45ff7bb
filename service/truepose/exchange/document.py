"""A cursor on a JSON or TOML document that reads strictly and knows where it stands."""

import math
import tomllib
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final, NoReturn

from truepose.exchange.errors import (
    BadValueError,
    InputFileError,
    MissingEntryError,
    UnreadableFileError,
    WrongUnitError,
)
from truepose.exchange.input_file import read_bytes
from truepose.exchange.json_text import KeyPath, line_of, parse_json
from truepose.exchange.plausible import limits_of
from truepose.exchange.unit_suffix import in_other_unit, unit, unit_sentence

_LONGEST_TEXT: Final = 4000  # two pages: the longest note that anybody writes


@dataclass(frozen=True, slots=True)
class Node:
    """One value of a document, with its place."""

    file: str
    value: object
    path: KeyPath
    locate: Callable[[KeyPath], int | None]  # line of a path that exists

    def fail(self, sentence: str, kind: type[InputFileError] = BadValueError) -> NoReturn:
        """Raise `kind` at this place."""
        raise kind(sentence, file=self.file, line=self.locate(self.path), key=self.name)

    @property
    def name(self) -> str:
        """The path in words: `dhm_nominal[2].a_mm`."""
        steps = "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in self.path)
        return steps.removeprefix(".")

    @property
    def _last_word(self) -> str:
        """The last key on the way here: the numbers of a list are what its key says."""
        return next((step for step in reversed(self.path) if isinstance(step, str)), "")

    @property
    def is_null(self) -> bool:
        """Whether the document says null here."""
        return self.value is None

    def child(self, step: str | int, value: object) -> "Node":
        """Return the node of an entry."""
        return Node(self.file, value, (*self.path, step), self.locate)

    def entries(self) -> Mapping[str, object]:
        """Return the object here; refuses anything else."""
        if not isinstance(self.value, dict):
            self.fail("an object with keys is required")
        return self.value

    def items(self, count: int | None = None) -> tuple["Node", ...]:
        """Return the entries of the list here, `count` of them where that is given."""
        if not isinstance(self.value, list):
            self.fail("a list is required")
        if count is not None and len(self.value) != count:
            self.fail(f"{len(self.value)} entries stand where {count} are required")
        return tuple(self.child(index, entry) for index, entry in enumerate(self.value))

    def key(self, name: str) -> "Node":
        """Return a required entry of the object here; it may be null."""
        entries = self.entries()
        if name not in entries:
            self._refuse_absent(name, entries)
        return self.child(name, entries[name])

    def optional(self, name: str) -> "Node | None":
        """Return an entry of the object here, or None where it is absent or null."""
        entries = self.entries()
        if name in entries:
            return None if entries[name] is None else self.child(name, entries[name])
        rival = in_other_unit(name, entries)
        if rival is not None and unit(rival):
            self.child(rival, None).fail(unit_sentence("key", rival, name), WrongUnitError)
        return None

    def _refuse_absent(self, name: str, entries: Mapping[str, object]) -> NoReturn:
        rival = in_other_unit(name, entries)
        if rival is not None:
            self.child(rival, None).fail(unit_sentence("key", rival, name), WrongUnitError)
        self.fail(f"key {name} is missing; it is required", MissingEntryError)

    def unlisted(self, known: Collection[str]) -> Iterator["Node"]:
        """Yield the entries of the object here whose keys are not `known`."""
        for name, value in self.entries().items():
            if name not in known:
                yield self.child(name, value)

    def number(
        self, *, above: float = -math.inf, least: float = -math.inf, greatest: float = math.inf
    ) -> float:
        """Return the finite number here; greater than `above`, between `least` and `greatest`."""
        if isinstance(self.value, bool) or not isinstance(self.value, int | float):
            self.fail(f"{_shown(self.value)} is not a number")
        try:
            number = float(self.value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            self.fail("the number is not finite")
        limits = limits_of(self._last_word)
        if not limits.accepts(number):
            self.fail(limits.fault(number, f"{number:g}"))
        if number <= above:
            self.fail(f"{number:g} must be greater than {above:g}")
        if not least <= number <= greatest:
            self.fail(f"{number:g} must lie between {least:g} and {greatest:g}")
        return number

    def whole(self, *, least: float = -math.inf, greatest: float = math.inf) -> int:
        """Return the whole number here."""
        number = self.number(least=least, greatest=greatest)
        if number != round(number):
            self.fail(f"{number:g} must be a whole number")
        return round(number)

    def text(self) -> str:
        """Return the text here, which is not empty."""
        if not isinstance(self.value, str):
            self.fail(f"{_shown(self.value)} is not text")
        if not self.value.strip():
            self.fail("the text is empty")
        if len(self.value) > _LONGEST_TEXT:
            self.fail(f"the text has more than {_LONGEST_TEXT} characters")
        return self.value

    def truth(self) -> bool:
        """Return true or false."""
        if not isinstance(self.value, bool):
            self.fail(f"{_shown(self.value)} is neither true nor false")
        return self.value

    def vector(self) -> tuple[float, float, float]:
        """Return three finite numbers."""
        x, y, z = (entry.number() for entry in self.items(3))
        return x, y, z

    def numbers(self, count: int | None = None) -> tuple[float, ...]:
        """Return a list of finite numbers, `count` of them where that is given."""
        return tuple(entry.number() for entry in self.items(count))


def json_document(file: str, data: bytes) -> Node:
    """Return the root of a JSON document; raises UnreadableFileError."""
    value, text = parse_json(file, data)
    return Node(file, value, (), lambda path: line_of(text, path))


def file_document(path: Path) -> Node:
    """Return the root of a file that is TOML, or JSON by its ending; raises UnreadableFileError."""
    read = json_document if path.suffix.lower() == ".json" else toml_document
    return read(path.name, read_bytes(path))


def toml_document(file: str, data: bytes) -> Node:
    """Return the root of a TOML document; raises UnreadableFileError (tomllib says the line in its words)."""
    try:
        value = tomllib.loads(data.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        raise UnreadableFileError("the text is not UTF-8; save the file as UTF-8", file=file) from error
    except RecursionError as error:
        raise UnreadableFileError("this is not TOML: nested too deep", file=file) from error
    except ValueError as error:  # also of a number of thousands of digits
        raise UnreadableFileError(f"this is not TOML: {error}", file=file) from error
    return Node(file, value, (), lambda path: None)


def _shown(value: object) -> str:
    shown = "null" if value is None else repr(value)
    return shown if len(shown) <= 40 else shown[:37] + "..."
