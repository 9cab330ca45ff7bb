"""The digest of a model file: whether it still says what truepose wrote.

It is SHA-256 over the document without its key `digest`, as JSON with sorted keys, no blanks, ASCII only and
every number as the shortest text of its double. Another program may therefore store and print the file in
its own way; a changed value shows.
"""

import hashlib
import json
import math
from collections.abc import Mapping
from enum import StrEnum
from typing import Final

from truepose.exchange.document import Node
from truepose.exchange.errors import EditedFileError

KEY: Final = "digest"


class Integrity(StrEnum):
    """What the digest of a model file says."""

    INTACT = "intact"
    EDITED = "edited"
    NO_DIGEST = "no digest"  # a version before there were digests wrote it, or somebody took it out


def digest_of(document: Mapping[str, object]) -> str:
    """Return the digest of a model document, with or without its own."""
    # Without itself; and keys of later versions count as well, so that an addition by hand shows too.
    content = {key: _canonical(value) for key, value in document.items() if key != KEY}
    text = json.dumps(content, sort_keys=True, separators=(",", ":"))
    return f"sha256:{hashlib.sha256(text.encode()).hexdigest()}"


def integrity_of(document: Mapping[str, object]) -> Integrity:
    """Return whether a model document is as it was written."""
    if document.get(KEY) is None:
        return Integrity.NO_DIGEST
    return Integrity.INTACT if document[KEY] == digest_of(document) else Integrity.EDITED


def require_unedited(root: Node) -> Integrity:
    """Return what the digest says; raises EditedFileError."""
    found = integrity_of(root.entries())
    if found is Integrity.EDITED:
        root.key(KEY).fail(
            "the model was edited after truepose wrote it: its digest does not match its values; restore "
            "the original file, or identify again",
            EditedFileError,
        )
    return found


def _canonical(value: object) -> object:
    if isinstance(value, Mapping):
        return {key: _canonical(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_canonical(entry) for entry in value]
    if isinstance(value, int) and not isinstance(value, bool):
        return _double(value)  # JSON has one kind of number, and some programs print 2.0 as 2
    return value


def _double(number: int) -> float:
    try:
        return float(number)
    except OverflowError:  # what no double holds truepose never wrote, and whoever reads the key refuses it
        return math.inf
