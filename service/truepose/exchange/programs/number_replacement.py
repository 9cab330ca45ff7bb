"""A program with other numbers in its targets; every other byte as it was."""

from collections.abc import Iterator, Mapping, Sequence
from math import hypot, isfinite
from typing import Final, TypeAlias

from truepose.exchange.programs.pose_notation import near_quaternion, normalise
from truepose.exchange.programs.program import (
    Configuration,
    Number,
    Pose,
    Program,
    ProgramTarget,
    Quaternion,
    Value,
    Written,
)

_SAME: Final = 1e-12  # mm, rad or part of a quaternion: what conversions there and back may lose
_MOST_OFF_UNIT: Final = 1e-6  # of a norm: what a computation may lose
_MOST_DECIMALS: Final = 15
_Replacement: TypeAlias = tuple[Number, bytes]


_SAME_TURNS: Final[Mapping[int, Sequence[int]]] = {}


def rewritten(
    program: Program, values: Mapping[int, Value], turns: Mapping[int, Sequence[int]] = _SAME_TURNS
) -> bytes:
    """Return the file with new numbers of some targets.

    A number is written with the decimals that it had, or with more where the format takes them; one that
    is the same to its last decimal keeps its text.

    Parameters
    ----------
    program : Program
        As it was read.
    values : mapping of int to Configuration or Pose
        New values by the index of the target; of the same kind, and a configuration of as many joints.
    turns : mapping of int to sequence of int
        New numbers that count turns, as many as `ProgramTarget.turns`, by the index of the target.

    Raises
    ------
    ValueError
        A value is of another kind than its target, not finite, or no rotation.
    """
    replaced = [
        replacement
        for index, value in values.items()
        for replacement in _replacements(program.targets[index], value)
    ]
    for index, numbers in turns.items():
        replaced += _counted(program.targets[index].turns, numbers)
    # In one pass: to move the rest of the file for each number took minutes from 100,000 targets on.
    return b"".join(_pieces(program.data, sorted(replaced, key=lambda entry: entry[0].start)))


def _pieces(data: bytes, replaced: Sequence[_Replacement]) -> Iterator[bytes]:
    """Yield the text between the numbers and the numbers, in their order."""
    at = 0
    for number, text in replaced:
        yield data[at : number.start]
        yield text
        at = number.end
    yield data[at:]


def _replacements(target: ProgramTarget, value: Value) -> Iterator[_Replacement]:
    stood, groups = _groups(target.value), _groups(value)
    if type(value) is not type(target.value) or list(map(len, groups)) != list(map(len, stood)):
        raise ValueError(f"{target.name} is {target.value}, and cannot become {value}")
    if not all(isfinite(part) for group in groups for part in group):
        raise ValueError(f"{target.name}: {value} is not finite")
    if isinstance(value, Pose):
        # Both signs of a quaternion are one rotation; the other one would change all four numbers, and
        # whoever compares the files would look for a reason.
        groups = value.position_mm, _rotation(target, value.quaternion, stood[1])
    for written, before, after in zip(target.written, stood, groups, strict=True):
        if not _same(before, after):
            yield from _changed_numbers(written, after)


def _rotation(target: ProgramTarget, quaternion: Quaternion, stood: tuple[float, ...]) -> tuple[float, ...]:
    """Return the quaternion that is nearest to the one that stood, of the two that are the same rotation."""
    if abs(hypot(*quaternion) - 1.0) > _MOST_OFF_UNIT:
        raise ValueError(f"{target.name}: {quaternion} is not a unit quaternion")
    return tuple(near_quaternion(normalise(quaternion), stood))


def _groups(value: Value) -> tuple[tuple[float, ...], ...]:
    """Return the numbers of a value as `ProgramTarget.written` divides them."""
    match value:
        case Configuration(joints_rad):
            return (joints_rad,)
        case Pose(position_mm, quaternion):
            return position_mm, quaternion


def _same(stood: tuple[float, ...], new: tuple[float, ...]) -> bool:
    return all(abs(a - b) <= _SAME for a, b in zip(stood, new, strict=True))


def _changed_numbers(written: Written, group: tuple[float, ...]) -> Iterator[_Replacement]:
    outward = written.form.outward(group, written.values)
    for number, value in zip(written.numbers, outward, strict=True):
        decimals = min(max(number.decimals, written.form.decimals), _MOST_DECIMALS)
        if abs(value - number.value) > 0.5 * 10.0**-decimals:
            yield number, _text(value, decimals, number.decimals).encode("ascii")


def _counted(stood: Sequence[Number], numbers: Sequence[int]) -> Iterator[_Replacement]:
    for place, number in zip(stood, numbers, strict=True):
        if number != place.value:
            yield place, _in_base(number, place).encode("ascii")


def _in_base(number: int, place: Number) -> str:
    """Return a whole number as it is written in its base, with as many digits as stood there at least."""
    if place.base == 10:
        return str(number)
    letter, form = ("B", "b") if place.base == 2 else ("H", "X")
    return f"'{letter}{number:0{place.end - place.start - 3}{form}}'"


def _text(value: float, decimals: int, least: int) -> str:
    """Return a number with at most `decimals` and at least `least` places, without idle zeros between."""
    whole, _, places = f"{value:.{decimals}f}".partition(".")
    kept = places.rstrip("0").ljust(min(least, decimals), "0")
    text = f"{whole}.{kept}" if kept else whole
    return text.removeprefix("-") if not float(text) else text
