"""Literal values of KRL: aggregates in braces, and the targets and frames that they are.

Source: KUKA System Software, Operating and Programming Instructions for System Integrators, sections on
the structures E6AXIS, E6POS, FRAME; A, B and C turn about Z, the new Y and the newest X.
"""

from collections.abc import Mapping
from typing import Final, Literal

from truepose.domain.sentences import Sentence, said
from truepose.exchange.programs.controllers.status_and_turn import whole_number
from truepose.exchange.programs.forms import JOINT_DEGREES, MILLIMETRES, ZYX_DEGREES
from truepose.exchange.programs.program import Configuration, Number, Pose, ProgramTarget, Written
from truepose.exchange.programs.source import Source
from truepose.exchange.programs.tokens import Tokens, inside, number, shown

_POSE: Final = ("X", "Y", "Z", "A", "B", "C")
_JOINTS: Final = ("A1", "A2", "A3", "A4", "A5", "A6")
_EXTERNAL: Final = ("E1", "E2", "E3", "E4", "E5", "E6")
_BRANCH: Final = ("S", "T")


def entries(words: Tokens) -> Mapping[str, Tokens] | None:
    """Return the entries of an aggregate by name in capitals; None for anything else."""
    found = inside(words, "{")
    if found is None:
        return None
    if found and len(found[0]) > 1 and found[0][1].text == ":":  # the type may stand in front
        found[0] = found[0][2:]
    return {part[0].upper: part[1:] for part in found if part}


def target(source: Source, name: str, words: Tokens) -> ProgramTarget | Sentence:
    """Return the target that an aggregate is, or why it is none that can be corrected."""
    held = entries(words) or {}
    names = _JOINTS if _JOINTS[0] in held or any(key in held for key in _JOINTS) else _POSE
    absent = [key for key in names if key not in held]
    if absent:
        return said("left.absent_kept", names=", ".join(absent))
    read = [number(source, held[key]) for key in names]
    numbers = tuple(entry for entry in read if entry is not None)
    if len(numbers) < len(read):
        return said("left.named_numbers")
    line = source.line(words[0].start)
    return _target(source, name, line, numbers, held)


def pose(source: Source, words: Tokens) -> Pose | None:
    """Return the frame that an aggregate is; None where it is not written out."""
    found = target(source, "", words) if entries(words) else None
    return found.value if isinstance(found, ProgramTarget) and isinstance(found.value, Pose) else None


def whole(source: Source, words: Tokens) -> int | None:
    """Return the whole number that stands there, or None."""
    found = number(source, words)
    return None if found is None else int(found.value)


def _target(
    source: Source, name: str, line: int, numbers: tuple[Number, ...], held: Mapping[str, Tokens]
) -> ProgramTarget:
    given = [number(source, held[key]) for key in _EXTERNAL if key in held]
    external = tuple(entry.value for entry in given if entry is not None)
    if _JOINTS[0] in held:
        joints = Written(numbers, JOINT_DEGREES)
        return ProgramTarget(name, line, Configuration(joints.read()), (joints,), external=external)
    position, rotation = Written(numbers[:3], MILLIMETRES), Written(numbers[3:], ZYX_DEGREES)
    branch = ", ".join(f"{key} {shown(source, held[key])}" for key in _BRANCH if key in held)
    value, turn = Pose.written(position, rotation), _bits(source, held.get("T", ()))
    turns = () if turn is None else (turn,)
    return ProgramTarget(
        name, line, value, (position, rotation), branch=branch, turns=turns, external=external
    )


def _bits(source: Source, words: Tokens) -> Number | None:
    """Return a whole number that may be written as 'B010011' or 'H13'."""
    if len(words) == 1 and words[0].kind == "string":
        value = whole_number(words[0].text)
        base: Literal[2, 16] = 2 if words[0].upper[1:2] == "B" else 16
        return None if value is None else Number(words[0].start, words[0].end, float(value), 0, base)
    return number(source, words)
