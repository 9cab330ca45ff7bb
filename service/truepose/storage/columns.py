"""Nouns with long columns: a JSON document, and its arrays beside it as they stand in memory.

Blocks of NumPy's own format (NEP 1) follow each other. The first holds the document in UTF-8, in which
`{"column": 2}` stands in the place of the array that is the second block after it.
"""

import io
import json
from typing import Any, Final, TypeVar

import numpy as np

from truepose.storage.documents import Array, from_document, to_document
from truepose.storage.errors import DamagedDatabaseError

T = TypeVar("T")
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

    text = json.dumps(to_document(value, beside)).encode()
    stream = io.BytesIO()
    for block in (np.frombuffer(text, dtype=np.uint8), *columns):
        np.save(stream, block, allow_pickle=False)
    return stream.getvalue()


def unpack(kind: type[T], data: bytes) -> T:
    """Return the dataclass `kind` that `data` hold; raises DamagedDatabaseError where they do not."""
    try:
        blocks = _blocks(data)
        document = json.loads(blocks[0].tobytes(), object_hook=lambda entry: _entry(entry, blocks))
    except (EOFError, LookupError, ValueError) as error:
        raise DamagedDatabaseError(
            f"A stored {kind.__name__} cannot be read ({error}); 'truepose verify' says what else is damaged."
        ) from error
    return from_document(kind, document)


def _blocks(data: bytes) -> list[Array]:
    stream, blocks = io.BytesIO(data), []
    while stream.tell() < len(data):
        blocks.append(np.load(stream, allow_pickle=False))
    return blocks


def _entry(entry: dict[str, Any], blocks: list[Array]) -> Any:
    return blocks[entry[_COLUMN]] if entry.keys() == {_COLUMN} else entry
