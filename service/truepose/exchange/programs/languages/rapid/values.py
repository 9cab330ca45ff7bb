"""Literal values of RAPID's data types: robtarget, jointtarget, tooldata, wobjdata.

Source: ABB, Technical reference manual, RAPID Instructions, Functions and Data types, section "Data types".
"""

from collections.abc import Iterator
from typing import Final, TypeAlias

from truepose.domain.sentences import Sentence, said
from truepose.exchange.programs.forms import JOINT_DEGREES, MILLIMETRES, QUATERNION
from truepose.exchange.programs.program import Configuration, Frame, Number, Pose, ProgramTarget, Written
from truepose.exchange.programs.rotations import is_orientation, placed
from truepose.exchange.programs.source import Source
from truepose.exchange.programs.tokens import Token, Tokens, inside, numbers

ROBTARGET: Final = "ROBTARGET"
JOINTTARGET: Final = "JOINTTARGET"
_COUNTS: Final = {ROBTARGET: (3, 4, 4, 6), JOINTTARGET: (6, 6)}
Element: TypeAlias = tuple[tuple[int, ...], Tokens]  # index in the array, counted from 1, and its words


def elements(
    source: Source, words: Tokens, dimensions: int, index: tuple[int, ...] = ()
) -> Iterator[Element]:
    """Yield the elements of an array of literals; of no array the value itself."""
    entries = inside(words, "[") if dimensions else None
    if entries is None:
        yield index, words
        return
    for count, entry in enumerate(entries, start=1):
        if not entry:
            source.refuse("an element of this array is missing", words[0].start)
        yield from elements(source, entry, dimensions - 1, (*index, count))


def target(source: Source, kind: str, name: str, words: Tokens) -> ProgramTarget | Sentence:
    """Return the target that a literal is, or why it is none that can be corrected.

    Raises
    ------
    BadValueError
        The literal has not as many parts as its type.
    """
    groups = _groups(source, kind, words)
    if groups is None:
        return said("left.named_numbers")
    line = source.line(words[0].start)
    external = tuple(number.value for number in groups[-1])
    if kind == JOINTTARGET:
        joints = Written(groups[0], JOINT_DEGREES)
        return ProgramTarget(name, line, Configuration(joints.read()), (joints,), external=external)
    position, rotation = Written(groups[0], MILLIMETRES), Written(groups[1], QUATERNION)
    pose = _pose(position, rotation)
    if pose is None:
        return said("left.no_orientation")
    branch = ", ".join(f"{number.value:g}" for number in groups[2])
    return ProgramTarget(
        name, line, pose, (position, rotation), branch=branch, turns=groups[2][:3], external=external
    )


def tool(source: Source, name: str, words: Tokens) -> Frame | Sentence:
    """Return the tool that a tooldata literal is, or why targets with it are left alone."""
    match inside(words, "["):
        case [holds, frame, _] if _says(holds, "TRUE"):
            return Frame(name, _pose_of(source, frame))
        case [holds, _, _] if _says(holds, "FALSE"):
            return said("left.tool_stands", tool=name)
    return Frame(name)


def work_object(source: Source, name: str, words: Tokens) -> Frame | Sentence:
    """Return the work object that a wobjdata literal is, or why targets in it are left alone."""
    match inside(words, "["):
        case [holds, _, _, _, _] if _says(holds, "TRUE"):
            return said("left.object_held", frame=name)
        case [_, fixed, _, _, _] if _says(fixed, "FALSE"):
            return said("left.object_moved", frame=name)
        case [_, _, _, user, of_object]:
            outer, inner = _pose_of(source, user), _pose_of(source, of_object)
            return Frame(name, placed(outer, inner) if outer and inner else None)
    return Frame(name)


def _groups(source: Source, kind: str, words: Tokens) -> list[tuple[Number, ...]] | None:
    entries = inside(words, "[")
    if entries is None:
        return None
    counts = _COUNTS[kind]
    if len(entries) != len(counts):
        _refuse(source, words[0], kind, len(counts), len(entries))
    read = [
        _group(source, kind, entry, count, words[0]) for entry, count in zip(entries, counts, strict=True)
    ]
    groups = [group for group in read if group is not None]
    return groups if len(groups) == len(read) else None


def _group(source: Source, kind: str, words: Tokens, count: int, at: Token) -> tuple[Number, ...] | None:
    entries = inside(words, "[")
    if entries is None:
        return None
    if len(entries) != count:
        _refuse(source, words[0] if words else at, f"this part of a {kind}", count, len(entries))
    return numbers(source, entries, count)


def _refuse(source: Source, at: Token, what: str, count: int, stand: int) -> None:
    source.refuse(f"{what.lower()} has {count} parts, {stand} stand here", at.start)


def _pose_of(source: Source, words: Tokens) -> Pose | None:
    match inside(words, "["):
        case [trans, rot]:
            position = numbers(source, inside(trans, "["), 3)
            rotation = numbers(source, inside(rot, "["), 4)
            if position and rotation:
                return _pose(Written(position, MILLIMETRES), Written(rotation, QUATERNION))
    return None


def _pose(position: Written, rotation: Written) -> Pose | None:
    if not is_orientation(rotation.values):
        return None
    return Pose.written(position, rotation)


def _says(words: Tokens, wanted: str) -> bool:
    return len(words) == 1 and words[0].upper == wanted
