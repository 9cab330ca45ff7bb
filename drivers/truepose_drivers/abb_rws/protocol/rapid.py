"""Values of RAPID variables as Robot Web Services write them: numbers in brackets."""

import re
import struct
from collections.abc import Sequence
from typing import Final

from truepose_drivers.abb_rws.protocol.errors import RwsProtocolError

# Two digits of exponent stay finite; RAPID itself goes to 38.
_NUMBER: Final = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,2})?", re.ASCII)
_DIGITS: Final = range(6, 10)  # nine tell every single float from its neighbours
NO_AXIS: Final = 9e9  # of an external axis that is not there


def number(text: object) -> float:
    """Read a number; raises RwsProtocolError."""
    if not isinstance(text, str) or _NUMBER.fullmatch(text.strip()) is None:
        raise RwsProtocolError(f"{str(text)[:40]!r} is no number of RAPID: connect again")
    return float(text)


def numbers(text: object, count: int) -> tuple[float, ...]:
    """Read an array of `count` numbers; raises RwsProtocolError."""
    stripped = text.strip() if isinstance(text, str) else ""
    words = stripped[1:-1].split(",")
    if not (stripped.startswith("[") and stripped.endswith("]") and len(words) == count):
        raise RwsProtocolError(f"{str(text)[:80]!r} is no array of {count} numbers: connect again")
    return tuple(map(number, words))


def array_text(values: Sequence[float]) -> str:
    """Return an array as RAPID reads it."""
    return f"[{','.join(map(number_text, values))}]"


def number_text(value: float) -> str:
    """Return the shortest text of the single float that RAPID keeps of a value; raises OverflowError."""
    kept = single(value)
    texts = (f"{kept:.{digits}G}" for digits in _DIGITS)
    return next(text for text in texts if single(float(text)) == kept)


def single(value: float) -> float:
    """Return the single float that RAPID keeps of a value; raises OverflowError."""
    (kept,) = struct.unpack("<f", struct.pack("<f", value))
    return float(kept)
