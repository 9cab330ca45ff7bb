"""JSON as people read it: where a key stands in the text, and one row of numbers a line."""

import json
import math
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import TypeAlias

from truepose.exchange.errors import UnreadableFileError

Json: TypeAlias = "bool | int | float | str | Sequence[Json] | Mapping[str, Json] | None"
KeyPath: TypeAlias = tuple[str | int, ...]
# `\ud83d` alone is half a character: JSON lets it pass, and no screen or database can take it.
_HALF_A_CHARACTER = re.compile(r"\\u[dD][89a-fA-F]")
_DEEPEST = 100  # no document nests deeper than ten
_BLANK = re.compile(r"[ \t\r\n]*")


def parse_json(file: str, data: bytes) -> tuple[object, str]:
    """Return the value and the text of a JSON document; NaN, Infinity and repeated keys are refused.

    Raises
    ------
    UnreadableFileError
        Not UTF-8, not JSON, cut off, or nested beyond reason.
    """
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise UnreadableFileError("the text is not UTF-8; save the file as UTF-8", file=file) from error
    try:
        value = json.loads(text, object_pairs_hook=_unique, parse_constant=_refuse_constant)
        if _HALF_A_CHARACTER.search(text):
            json.dumps(value, ensure_ascii=False).encode()
        _require_shallow(value)
    except json.JSONDecodeError as error:
        what = "the text ends too early" if error.pos >= len(text.rstrip()) else error.msg
        raise UnreadableFileError(
            f"this is not a complete JSON document ({what})", file=file, line=error.lineno
        ) from error
    except RecursionError as error:
        raise UnreadableFileError(
            "this is not a usable JSON document (nested too deeply)", file=file
        ) from error
    except ValueError as error:
        raise UnreadableFileError(f"this is not a usable JSON document ({error})", file=file) from error
    return value, text


def _require_shallow(value: object) -> None:
    """Raise RecursionError, as parsers do, for what nests deeper than whoever walks through it can follow."""
    level = [value]
    for _ in range(_DEEPEST):
        level = [entry for one in level for entry in _entries(one)]
        if not level:
            return
    raise RecursionError(_DEEPEST)


def _entries(value: object) -> Iterable[object]:
    if isinstance(value, dict):
        return value.values()
    return value if isinstance(value, list) else ()


def line_of(text: str, path: KeyPath) -> int:
    """Return the 1-based line on which the value at `path` begins; `path` exists in `text`."""
    # The text is walked through again: only a fault asks for a line, and sound files pay nothing for it.
    at = _skip(text, 0)
    for step in path:
        at = _entry(text, at, step)
    return text.count("\n", 0, at) + 1


def render_json(value: Json, indent: str = "") -> str:
    """Return JSON text in which a list or small object of plain values takes one line.

    Raises ValueError for a number that is not finite.
    """
    if isinstance(value, Mapping):
        inner = indent + " "
        entries = [f"{inner}{json.dumps(key)}: {render_json(entry, inner)}" for key, entry in value.items()]
        return "{\n" + ",\n".join(entries) + f"\n{indent}}}" if entries else "{}"
    if isinstance(value, Sequence) and not isinstance(value, str):
        if all(_is_short(entry) for entry in value):
            return json.dumps(value, allow_nan=False, ensure_ascii=False)
        inner = indent + " "
        return "[\n" + ",\n".join(inner + _row(entry, inner) for entry in value) + f"\n{indent}]"
    return json.dumps(value, allow_nan=False, ensure_ascii=False)


def number_or_null(number: float) -> float | None:
    """Return the number, or None (JSON null) where it is not finite."""
    return float(number) if math.isfinite(number) else None


def _row(entry: Json, indent: str) -> str:
    """Render an entry of a list: an object of plain values on one line."""
    if isinstance(entry, Mapping) and all(_is_plain(value) or _is_vector(value) for value in entry.values()):
        return json.dumps(entry, allow_nan=False, ensure_ascii=False)
    return render_json(entry, indent)


def _is_short(value: Json) -> bool:
    """Whether the value may share its line: a number, or text shorter than a sentence."""
    return not isinstance(value, Mapping | list | tuple) and len(str(value)) < 40


def _is_plain(value: Json) -> bool:
    return isinstance(value, str | int | float | None)


def _is_vector(value: Json) -> bool:
    return isinstance(value, Sequence) and all(_is_plain(entry) for entry in value)


def _unique(pairs: list[tuple[str, object]]) -> dict[str, object]:
    entries = dict(pairs)
    if len(entries) < len(pairs):
        # Programs differ in which of two entries they take, so a file that has both means two things.
        counts = Counter(name for name, _ in pairs)
        twice = next(name for name, count in counts.items() if count > 1)
        raise ValueError(f"key {twice} appears twice in one object")
    return entries


def _refuse_constant(name: str) -> None:
    raise ValueError(f"{name} is not a finite number")


def _skip(text: str, at: int) -> int:
    found = _BLANK.match(text, at)
    return found.end() if found else at


def _entry(text: str, at: int, step: str | int) -> int:
    """Return where the value of one entry of the object or list at `at` begins."""
    # Whoever asks has parsed the text before: nothing here fails, and no entry is missing.
    decoder = json.JSONDecoder()
    index = 0
    at = _skip(text, at + 1)
    while True:
        key: object = index
        if isinstance(step, str):
            key, at = decoder.raw_decode(text, at)
            at = _skip(text, _skip(text, at) + 1)
        if key == step:
            return at
        _, at = decoder.raw_decode(text, at)
        at = _skip(text, _skip(text, at) + 1)
        index += 1
