"""What happens to an answer on a wire: one function a fault, from the pieces of an answer to what arrives.

Each is told the random generator, the answer and one that the same device gave earlier.
"""

import re
from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np

from truepose_drivers.contract.wire import HangUp, Pause, Piece, Silence

Pieces: TypeAlias = Sequence[Piece]
Fault: TypeAlias = Callable[[np.random.Generator, Pieces, bytes], Pieces]

_DIGITS = re.compile(rb"\d")


def whole(pieces: Pieces) -> bytes:
    """Return the bytes of an answer, however they come."""
    return b"".join(piece for piece in pieces if isinstance(piece, bytes))


def flip(rng: np.random.Generator, pieces: Pieces, earlier: bytes) -> Pieces:
    """One bit of it, anywhere."""
    data = bytearray(whole(pieces))
    data[rng.integers(len(data))] ^= 1 << int(rng.integers(8))
    return [bytes(data)]


def other_digit(rng: np.random.Generator, pieces: Pieces, earlier: bytes) -> Pieces:
    """One digit is read as another."""
    data = bytearray(whole(pieces))
    place = _digit_place(rng, data)
    if place is not None:
        data[place] = ord(b"0") + (data[place] - ord(b"0") + int(rng.integers(1, 10))) % 10
    return [bytes(data)]


def double_digit(rng: np.random.Generator, pieces: Pieces, earlier: bytes) -> Pieces:
    """One digit comes twice."""
    data = bytearray(whole(pieces))
    place = _digit_place(rng, data)
    if place is not None:
        data.insert(place, data[place])
    return [bytes(data)]


def lose_byte(rng: np.random.Generator, pieces: Pieces, earlier: bytes) -> Pieces:
    """One byte is lost."""
    data = bytearray(whole(pieces))
    del data[rng.integers(len(data))]
    return [bytes(data), Silence()]


def truncate(rng: np.random.Generator, pieces: Pieces, earlier: bytes) -> Pieces:
    """The end never comes."""
    data = whole(pieces)
    return [data[: rng.integers(len(data))], Silence()]


def cut(rng: np.random.Generator, pieces: Pieces, earlier: bytes) -> Pieces:
    """The link breaks in the middle."""
    data = whole(pieces)
    return [data[: rng.integers(len(data))], HangUp()]


def split(rng: np.random.Generator, pieces: Pieces, earlier: bytes) -> Pieces:
    """It comes in pieces, with stalls of 50 ms between them, also inside numbers."""
    data = whole(pieces)
    places = sorted({int(place) for place in rng.integers(1, max(2, len(data)), 3)})
    parts = [data[a:b] for a, b in zip([0, *places], [*places, len(data)], strict=True)]
    return [thing for part in parts if part for thing in (part, Pause())]


def late(rng: np.random.Generator, pieces: Pieces, earlier: bytes) -> Pieces:
    """It comes after the time-out: before the answer to the next question, where the wire remembers it."""
    return [Silence(), *pieces]


def half_late(rng: np.random.Generator, pieces: Pieces, earlier: bytes) -> Pieces:
    """Its second half comes after the time-out, where the wire remembers it."""
    data = whole(pieces)
    place = int(rng.integers(1, max(2, len(data))))
    return [data[:place], Silence(), data[place:]]


def repeat(rng: np.random.Generator, pieces: Pieces, earlier: bytes) -> Pieces:
    """It comes twice."""
    return [*pieces, *pieces]


def replay(rng: np.random.Generator, pieces: Pieces, earlier: bytes) -> Pieces:
    """An earlier answer comes before it."""
    return [earlier, *pieces] if rng.integers(2) else [earlier + whole(pieces)]


def merge(rng: np.random.Generator, pieces: Pieces, earlier: bytes) -> Pieces:
    """The beginning of an earlier answer runs into it."""
    return [earlier[: rng.integers(1, len(earlier) + 1)] + whole(pieces)]


def garbage(rng: np.random.Generator, pieces: Pieces, earlier: bytes) -> Pieces:
    """Noise comes before it, or in its place."""
    noise = rng.bytes(int(rng.integers(1, 60)))
    return [noise, *pieces] if rng.integers(2) else [noise, Silence()]


def huge(rng: np.random.Generator, pieces: Pieces, earlier: bytes) -> Pieces:
    """A line without end."""
    return [(b"0", b"x", b"\0", b"{", b"1 ")[rng.integers(5)] * 100_000, *pieces]


def silence(rng: np.random.Generator, pieces: Pieces, earlier: bytes) -> Pieces:
    """Nothing comes."""
    return [Silence()]


def hang_up(rng: np.random.Generator, pieces: Pieces, earlier: bytes) -> Pieces:
    """The device closes the link."""
    return [HangUp()]


GENERAL: tuple[Fault, ...] = (
    flip, other_digit, double_digit, lose_byte, truncate, cut, split, late, half_late, repeat, replay, merge,
    garbage, huge, silence, hang_up,
)  # fmt: skip
# What leaves a whole frame in its place: neither form nor order tells it, only a value out of range.
WITHIN_A_FRAME = frozenset({"flip", "other_digit"})
# Nor do these where numbers may have any number of digits.
WITHIN_FREE_NUMBERS = WITHIN_A_FRAME | {"double_digit", "lose_byte"}


def _digit_place(rng: np.random.Generator, data: bytearray) -> int | None:
    places = [match.start() for match in _DIGITS.finditer(bytes(data))]
    return int(rng.choice(places)) if places else None
