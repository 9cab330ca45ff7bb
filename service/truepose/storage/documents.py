"""Frozen dataclasses as JSON documents and back, guided by their type hints; long columns beside them.

Storage keeps whole nouns (plans, readings, results) in one column each, under their own field
names. JSON has no word for NaN and infinity: they become null and "inf". A field that an older
document lacks takes its default, so nouns may grow.

Nouns with long columns are packed as blocks of NumPy's own format (NEP 1), one after the other. The first
holds the document in UTF-8, in which `{"column": 2}` stands in the place of the array that is the second
block after it.
"""

import dataclasses
import functools
import io
import json
import math
import tokenize
import types
from collections.abc import Callable, Hashable, Mapping
from datetime import date
from enum import Enum
from typing import Any, Final, Literal, TypeAlias, TypeVar, Union, cast, get_args, get_origin, get_type_hints

import numpy as np

from truepose.messages.message import Message, Text, Value
from truepose.storage.errors import DamagedDatabaseError

T = TypeVar("T")
Array: TypeAlias = "np.ndarray[Any, Any]"
_AS_IN_JSON: Final = frozenset({str, int, bool, object})


def to_list(values: Array) -> Any:
    """Return an array as lists."""
    # Long columns of ordinary numbers need no look at each; a session under way waits meanwhile.
    plain = values.dtype.kind in "if" and bool(np.all(np.isfinite(values)))
    return values.tolist() if plain else to_document(values.tolist())


def to_document(value: object, array: Callable[[Array], Any] = to_list) -> Any:
    """Return `value` as what `json.dumps` takes; raises TypeError for a type that has no JSON form.

    `array` says what stands for an array.
    """
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {f.name: to_document(getattr(value, f.name), array) for f in dataclasses.fields(value)}
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, Mapping):
        return {str(key): to_document(entry, array) for key, entry in value.items()}
    if isinstance(value, np.ndarray):
        return array(value)
    if isinstance(value, (tuple, list)):
        return [to_document(entry, array) for entry in value]
    return _scalar(value)


def _scalar(value: object) -> Any:
    # Numbers of NumPy are no JSON, and `bool_` is no `bool` to the checks below.
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float):
        return value if math.isfinite(value) else _not_finite(value)
    if isinstance(value, date):
        return value.isoformat()
    if value is None or isinstance(value, (str, int, bool)):
        return value
    raise TypeError(f"{type(value).__name__} has no JSON form")


def _not_finite(value: float) -> str | None:
    # "inf" and "-inf" are what `float` reads back; a bare `Infinity`, which Python's json writes by itself,
    # is no JSON to other programs and none to PostgreSQL.
    return None if math.isnan(value) else str(value)


# What reading a document raises that does not have the form of its noun.
_UNLIKE: Final = (ArithmeticError, AttributeError, LookupError, TypeError, ValueError)
# What NumPy raises besides, of a block that is none: it reads the header as Python, and takes memory by it.
_NO_BLOCKS: Final = (EOFError, MemoryError, SyntaxError, tokenize.TokenError)


def from_document(kind: type[T], document: Any) -> T:
    """Return the dataclass `kind` that `document` holds; raises DamagedDatabaseError where they differ."""
    try:
        # Whatever goes wrong here is a stored document that does not have the form of its noun: damage, or
        # another version's record. A traceback would be called a fault of the program, and end the session.
        return cast(T, _decoder(cast(Hashable, kind))(document))
    except _UNLIKE as error:
        raise _unreadable(getattr(kind, "__name__", str(kind)), error) from error


def _unreadable(what: str, error: Exception) -> DamagedDatabaseError:
    return DamagedDatabaseError(
        f"A stored {what} cannot be read ({error}); 'truepose verify' shows what else is damaged."
    )


def from_json(text: str) -> Any:
    """Return what a stored text holds; raises DamagedDatabaseError for what is no JSON."""
    try:
        return json.loads(text)
    except ValueError as error:
        raise _unreadable("document", error) from error


Decoder: TypeAlias = Callable[[Any], Any]


@functools.cache
def _decoder(hint: Any) -> Decoder:
    """Return what reads a value of a type: hints are looked up once, not once a document."""
    origin = get_origin(hint)
    if origin in {Union, types.UnionType}:
        return _union_decoder(get_args(hint))
    if origin is tuple:
        return _tuple_decoder(get_args(hint))
    if origin is np.ndarray:
        return _array_decoder(hint)
    if origin is Literal or hint is Any:
        return _as_it_is
    if origin in {dict, Mapping}:
        entry = _decoder(get_args(hint)[1])
        return lambda document: {key: entry(value) for key, value in document.items()}
    return _plain_decoder(origin or hint)


def _as_it_is(document: Any) -> Any:
    return document


def _plain_decoder(kind: Any) -> Decoder:
    # Before dataclasses, of which a message is one: its values are of several kinds, which type hints do not
    # tell apart.
    if kind is Message:
        return _message
    if dataclasses.is_dataclass(kind):
        return _noun_decoder(kind)
    if isinstance(kind, type) and issubclass(kind, Enum):
        return kind
    if kind is float:
        return _float
    if kind is date:
        return date.fromisoformat
    if kind in _AS_IN_JSON:
        return _as_it_is
    # Handed on as it is, an unknown form would fail later, and elsewhere.
    raise TypeError(f"nothing says how {kind} is read")


def _noun_decoder(kind: Any) -> Decoder:
    hints = get_type_hints(kind)

    # Asked for when it is met, as a noun may hold others of its kind.
    @functools.cache
    def of_field(name: str) -> Decoder:
        return _decoder(hints[name])

    return lambda document: kind(**{name: of_field(name)(entry) for name, entry in document.items()})


def _float(document: Any) -> float:
    # JSON writes 3.0 as it likes: some programs write 3, which comes back as an int.
    return math.nan if document is None else float(document)


def _union_decoder(hints: tuple[Any, ...]) -> Decoder:
    concrete = [hint for hint in hints if hint is not types.NoneType]
    # A union of plain scalars (dict values) is already what JSON gave.
    only = _decoder(concrete[0]) if len(concrete) == 1 else _as_it_is

    def decode(document: Any) -> Any:
        if document is None and types.NoneType in hints:
            return None
        # A text is a message or somebody's own words; only the former is an object (decision 0078).
        return _message(document) if Message in concrete and isinstance(document, dict) else only(document)

    return decode


def text_from(document: Any) -> Text:
    """Return a message, or somebody's own words, that a document holds."""
    return _message(document) if isinstance(document, dict) else cast(str, document)


_INFINITE: Final = ("inf", "-inf")  # as `_not_finite` writes them


def _message(document: Any) -> Message:
    return Message(document["key"], tuple((name, _value(value)) for name, value in document["values"]))


def _value(document: Any) -> Value:
    if isinstance(document, list):
        return tuple(map(_value, document))
    if document is None:
        return math.nan
    # Said in words, a text of these letters and the number are one.
    if document in _INFINITE:
        return float(document)
    return _message(document) if isinstance(document, dict) else cast(Value, document)


def _tuple_decoder(hints: tuple[Any, ...]) -> Decoder:
    if len(hints) == 2 and hints[1] is Ellipsis:
        entry = _decoder(hints[0])
        return lambda document: tuple(map(entry, document))
    entries = [_decoder(hint) for hint in hints]
    return lambda document: tuple(read(value) for read, value in zip(entries, document, strict=True))


def _array_decoder(hint: Any) -> Decoder:
    (dtype,) = get_args(get_args(hint)[1])

    def decode(document: Any) -> Array:
        # Comes from `unpack`, where the array has replaced its reference already.
        if isinstance(document, np.ndarray):
            return document.astype(dtype, copy=False)
        entries = np.array(document, dtype=object)
        entries[entries == None] = np.nan  # noqa: E711 - elementwise on an object array
        return entries.astype(dtype)

    return decode


_BLOCK: Final = b"\x93NUMPY"  # begins one
_COLUMN: Final = "column"


def is_packed(data: bytes) -> bool:
    """Whether `data` are such blocks."""
    return data.startswith(_BLOCK)


def pack(value: object) -> bytes:
    """Return a frozen dataclass with its arrays; raises TypeError for a type that has no JSON form."""
    columns: list[Array] = []

    def beside(values: Array) -> dict[str, int]:
        columns.append(values)
        return {_COLUMN: len(columns)}

    # First, so that the arrays are counted while the document is made: the reference in it is the place of
    # their block.
    text = json.dumps(to_document(value, beside)).encode()
    stream = io.BytesIO()
    for block in (np.frombuffer(text, dtype=np.uint8), *columns):
        # Pickle would run code of whoever wrote the file. Refused on both sides, so that an array of objects
        # fails here and not when it is read in a year.
        np.save(stream, block, allow_pickle=False)
    return stream.getvalue()


def unpack(kind: type[T], data: bytes) -> T:
    """Return the dataclass `kind` that `data` hold; raises DamagedDatabaseError where they do not."""
    try:
        blocks = _blocks(data)
        document = json.loads(blocks[0].tobytes(), object_hook=lambda entry: _entry(entry, blocks))
    except (*_UNLIKE, *_NO_BLOCKS) as error:
        raise _unreadable(kind.__name__, error) from error
    return from_document(kind, document)


def _blocks(data: bytes) -> list[Array]:
    stream, blocks = io.BytesIO(data), []
    while stream.tell() < len(data):
        blocks.append(np.load(stream, allow_pickle=False))
    return blocks


def _entry(entry: dict[str, Any], blocks: list[Array]) -> Any:
    return blocks[entry[_COLUMN]] if entry.keys() == {_COLUMN} else entry
