"""A file that a user names, a strict cursor on its JSON or TOML, and keys that are read and written alike.

A pipe or a terminal gives nothing until somebody writes, a device gives for ever: neither is opened.
"""

import math
import os
import re
import stat
import tomllib
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any, BinaryIO, Final, NoReturn, TypeVar

from truepose.exchange.errors import (
    BadValueError,
    InputFileError,
    MissingEntryError,
    MissingFileError,
    UnreadableFileError,
    WrongUnitError,
)
from truepose.exchange.json_text import Json, KeyPath, line_of, number_or_null, parse_json
from truepose.exchange.quantities import in_other_unit, limits_of, unit, unit_sentence

# 200,000 rows of a table with everything that the format knows come to 100 MB.
GREATEST_BYTES: Final = 128 * 2**20
_PIECE_BYTES: Final = 2**20
_KINDS: Final = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)
# Not to wait for the other end of what became a pipe since it was looked at; Windows knows neither.
_AT_ONCE: Final = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOCTTY", 0)


def read_bytes(path: Path, *, most: int = GREATEST_BYTES) -> bytes:
    """Return the content of a file.

    Parameters
    ----------
    path : Path
        A regular file, or a link to one.
    most : int
        Bytes that are read; a file that has more is refused.

    Raises
    ------
    MissingFileError, UnreadableFileError
        With the name of the file.
    """
    try:
        # Looked at before it is opened: to open some devices already does something.
        _require_regular(path, path.stat())
        with open(path, "rb", opener=_open_at_once) as file:
            _require_regular(path, os.fstat(file.fileno()))
            data = b"".join(_pieces(file, most))
    except FileNotFoundError as error:
        raise MissingFileError("there is no such file", file=path.name) from error
    except (OSError, ValueError) as error:  # a name with a zero byte is no name
        reason = error.strerror if isinstance(error, OSError) else error
        raise UnreadableFileError(f"the file cannot be read ({reason})", file=path.name) from error
    # Refused and not cut: the rest of a table that is read in part looks like a whole one.
    if len(data) > most:
        raise UnreadableFileError(
            f"the file has more than {most // 2**20} MB, which is the limit", file=path.name
        )
    return data


def _pieces(file: BinaryIO, most: int) -> Iterator[bytes]:
    """Yield what a file holds, up to one byte more than is taken: it may grow, so its size says nothing."""
    # Asked for all at once, a small file would be given the room of the largest.
    left = most + 1
    while piece := file.read(min(left, _PIECE_BYTES)):
        left -= len(piece)
        yield piece


def _open_at_once(path: str, flags: int) -> int:
    return os.open(path, flags | _AT_ONCE)


def _require_regular(path: Path, found: os.stat_result) -> None:
    if not stat.S_ISREG(found.st_mode):
        kind = next((words for is_kind, words in _KINDS if is_kind(found.st_mode)), "something else")
        raise UnreadableFileError(f"this is {kind}, not a file; name a file", file=path.name or str(path))


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
            self.fail(f"{len(self.value)} entries found where {count} are required")
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
        # A key in another unit is a slip and no key that was left out: its default would count, and nobody
        # would be told.
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
        # To Python true is a whole number; in a document it is a slip.
        if isinstance(self.value, bool) or not isinstance(self.value, int | float):
            self.fail(f"{_shown(self.value)} is not a number")
        try:
            # A whole number of JSON or TOML has no limit of size; a float has one.
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
        # Blanks under `robot` or `name` would stand on every page as nothing at all.
        if not self.value.strip():
            self.fail("the text is empty")
        if len(self.value) > _LONGEST_TEXT:
            self.fail(f"the text has more than {_LONGEST_TEXT} characters")
        return self.value

    def truth(self) -> bool:
        """Return true or false."""
        if not isinstance(self.value, bool):
            self.fail(f"{_shown(self.value)} must be true or false")
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


# Names with points between them nest without a bracket, and tomllib takes for them their square in memory.
_DEEP_NAME: Final = re.compile(r"""(?:\.[ \t]*+[\w"'-]++[ \t]*+){100}""")


def toml_document(file: str, data: bytes) -> Node:
    """Return the root of a TOML document; raises UnreadableFileError (tomllib says the line in its words)."""
    try:
        text = data.decode("utf-8-sig")
        if _DEEP_NAME.search(text):
            raise UnreadableFileError("this is not TOML: nested too deeply", file=file)
        value = tomllib.loads(text)
    except UnicodeDecodeError as error:
        raise UnreadableFileError("the text is not UTF-8; save the file as UTF-8", file=file) from error
    except RecursionError as error:
        raise UnreadableFileError("this is not TOML: nested too deeply", file=file) from error
    except ValueError as error:  # also of a number of thousands of digits
        raise UnreadableFileError(f"this is not TOML: {error}", file=file) from error
    # tomllib keeps no places: errors in TOML name the key and no line.
    return Node(file, value, (), lambda path: None)


def _shown(value: object) -> str:
    try:
        shown = "null" if value is None else repr(value)
    except ValueError:  # of a whole number that Python does not print
        return "a number of thousands of digits"
    return shown if len(shown) <= 40 else shown[:37] + "..."


T = TypeVar("T")
S = TypeVar("S", bound=StrEnum)
_REQUIRED: Final = object()


@dataclass(frozen=True, slots=True)
class Form:
    """How a value stands in a document; `read` refuses what cannot be meant."""

    read: Callable[[Node], Any]
    write: Callable[[Any], Json] = lambda value: value


@dataclass(frozen=True, slots=True)
class Key:
    """A key of a document and the field that it holds; one with `absent` may be missing or null."""

    name: str
    field: str
    form: Form
    absent: object = _REQUIRED

    def read(self, node: Node) -> Any:
        """Return the value of the field."""
        if self.absent is _REQUIRED:
            return self.form.read(node.key(self.name))
        found = node.optional(self.name)
        return self.absent if found is None else self.form.read(found)

    def written(self, value: object) -> Json:
        """Return what stands under the key; null where the field is None."""
        held = getattr(value, self.field)
        return None if held is None else self.form.write(held)


def read_keys(node: Node, keys: Sequence[Key]) -> dict[str, Any]:
    """Return the fields that the keys hold; raises an InputFileError that names key and line."""
    return {key.field: key.read(node) for key in keys}


def written_keys(value: object, keys: Sequence[Key]) -> dict[str, Json]:
    """Return the keys that the fields of `value` are written under."""
    return {key.name: key.written(value) for key in keys}


def record(kind: type[T], keys: Sequence[Key]) -> Form:
    """Return the form of an object that is one dataclass."""
    return Form(lambda node: kind(**read_keys(node, keys)), lambda value: written_keys(value, keys))


def each(form: Form, count: int | None = None) -> Form:
    """Return the form of a list, `count` long where that is given."""
    return Form(
        lambda node: tuple(form.read(entry) for entry in node.items(count)),
        lambda values: [form.write(value) for value in values],
    )


def or_null(form: Form, unknown: object = None) -> Form:
    """Return the form of what may be null; `unknown` is what that means."""
    return Form(lambda node: unknown if node.is_null else form.read(node), form.write)


def number(*, above: float = -math.inf, least: float = -math.inf) -> Form:
    """Return the form of a finite number within limits."""
    return Form(lambda node: node.number(above=above, least=least))


def whole(*, least: float = -math.inf, greatest: float = math.inf) -> Form:
    """Return the form of a whole number within limits."""
    return Form(lambda node: node.whole(least=least, greatest=greatest))


def word(kind: type[S]) -> Form:
    """Return the form of a word that is one of a few."""

    def read(node: Node) -> S:
        if node.text() not in set(kind):
            node.fail(f"{_shown(node.value)} must be one of {', '.join(kind)}")
        return kind(node.text())

    return Form(read, lambda member: member.value)


def degrees(angle_rad: float) -> float:
    """Return an angle in degrees with 15 significant digits.

    The conversion there and back is off in the 16th digit; without the rounding a table of round
    numbers would come back as 33.00000000000001. What is lost is 5e-16 of the value.
    """
    return float(f"{math.degrees(angle_rad):.15g}")


NUMBER: Final = number()
UNKNOWN_OR_NUMBER: Final = Form(or_null(NUMBER, math.nan).read, number_or_null)
TEXT: Final = Form(Node.text)
TRUTH: Final = Form(Node.truth)
VECTOR: Final = Form(Node.vector, list)
ANGLE: Final = Form(lambda node: math.radians(node.number()), degrees)
