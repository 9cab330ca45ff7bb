"""Statements of a RAPID module, and the literal values of its data types.

Source: ABB, Technical reference manual, RAPID overview, "Basic RAPID programming". A routine ends with its
own word, not with a semicolon, and so do the branches of an IF: a statement here is what stands between
two semicolons or such words.

Source: ABB, Technical reference manual, RAPID Instructions, Functions and Data types, section "Data types".
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, TypeAlias

from truepose.exchange.programs.pose_notation import (
    JOINT_DEGREES,
    MILLIMETRES,
    QUATERNION,
    compose,
    is_orientation,
)
from truepose.exchange.programs.program import (
    Configuration,
    Frame,
    Number,
    Pose,
    ProgramTarget,
    Source,
    Written,
)
from truepose.exchange.programs.tokens import (
    Language,
    Token,
    Tokens,
    closing,
    inside,
    numbers,
    outside,
    statements,
    tokens,
)
from truepose.messages.message import Message, message

_LANGUAGE: Final = Language(
    skipped=r"[ \t\f\v\r\n]+|![^\r\n]*", string=r'"(?:[^"\r\n]|"")*"', lines=False, sign=r":=|."
)
_CLOSED_BY: Final = {"MODULE": "ENDMODULE", "PROC": "ENDPROC", "FUNC": "ENDFUNC", "TRAP": "ENDTRAP"}
_ROUTINES: Final = frozenset({"PROC", "FUNC", "TRAP"})
_NAMES_BEHIND: Final = {"MODULE": 1, "PROC": 1, "FUNC": 2, "TRAP": 1}  # of a function also its type
_BRANCHES: Final = frozenset({
    "IF", "THEN", "ELSEIF", "ELSE", "ENDIF", "FOR", "DO", "ENDFOR", "WHILE", "ENDWHILE", "TEST", "CASE",
    "DEFAULT", "ENDTEST", "ERROR", "UNDO", "BACKWARD", "RECORD", "ENDRECORD",
})  # fmt: skip
_BEHIND_CONDITIONS: Final = frozenset({"THEN", "DO"})
_WORDS: Final = frozenset({*_CLOSED_BY, *_CLOSED_BY.values(), *_BRANCHES})


@dataclass(frozen=True, slots=True)
class Routine:
    """A routine, or the module around it; `arguments` in capitals."""

    number: int = 0
    arguments: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True)
class Statement:
    """The words of a statement, without what ended it."""

    words: Tokens
    routine: Routine
    branches: bool  # whether a branch or a routine begins or ends behind it
    is_condition: bool


def read_statements(source: Source) -> Iterator[Statement]:
    """Yield the statements of a module.

    Raises
    ------
    UnreadableFileError
        A module, a routine or a statement does not end.
    """
    routine, count, behind = Routine(), 0, ""
    opened: list[Token] = []
    for found in statements(source, tokens(source, _LANGUAGE), _ends):
        end = found[-1]
        if not _ends(end):
            source.fail("the statement that begins here does not end with ;", found[0].start)
        head, words = _head(behind, found[:-1])
        # Names in a routine may be its arguments, of which the file says no value; what else it declares
        # holds there alone.
        if behind in _ROUTINES:
            count += 1
            routine = Routine(count, frozenset(token.upper for token in head))
        yield Statement(words, routine, end.text != ";", end.upper in _BEHIND_CONDITIONS)
        behind = end.upper
        if end.upper in _CLOSED_BY:
            opened.append(end)
        elif end.upper in _CLOSED_BY.values():
            _close(source, end, opened)
            routine = Routine()
    if opened:
        _refuse_open(source, opened[-1])


def assignment_at(words: Tokens) -> int | None:
    """Return where the sign of an assignment stands; that of an option of a call is none."""
    for index in outside(words):
        if words[index].text == "\\":
            return None
        if words[index].text == ":=":
            return index
    return None


def _ends(token: Token) -> bool:
    return token.text == ";" if token.kind == "sign" else token.kind == "word" and token.upper in _WORDS


def _head(begin: str, words: Tokens) -> tuple[Tokens, Tokens]:
    """Return what is said of a routine or module behind the word that begins it, and its first statement.

    Among the arguments of a routine are the words of their types, which do no harm.
    """
    names = _NAMES_BEHIND.get(begin, 0)
    opening = words[names] if len(words) > names else None
    has_brackets = names > 0 and opening is not None and opening.text == "("
    end = closing(words, names) + 1 if has_brackets else names
    return words[:end], words[end:]


def _close(source: Source, end: Token, opened: list[Token]) -> None:
    if not opened:
        source.fail(f"{end.text} has no matching beginning", end.start)
    begin = opened.pop()
    if _CLOSED_BY[begin.upper] != end.upper:
        _refuse_open(source, begin)


def _refuse_open(source: Source, begin: Token) -> None:
    end = _CLOSED_BY[begin.upper]
    source.fail(f"the {begin.text} that begins here has no {end}; the file is cut off", begin.start)


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


def target(source: Source, kind: str, name: str, words: Tokens) -> ProgramTarget | Message:
    """Return the target that a literal is, or why it is none that can be corrected.

    Raises
    ------
    BadValueError
        The literal has not as many parts as its type.
    """
    groups = _groups(source, kind, words)
    if groups is None:
        return message("left.named_numbers")
    line = source.line(words[0].start)
    external = tuple(number.value for number in groups[-1])
    if kind == JOINTTARGET:
        joints = Written(groups[0], JOINT_DEGREES)
        return ProgramTarget(name, line, Configuration(joints.read()), (joints,), external=external)
    position, rotation = Written(groups[0], MILLIMETRES), Written(groups[1], QUATERNION)
    pose = _pose(position, rotation)
    if pose is None:
        return message("left.no_orientation")
    branch = ", ".join(f"{number.value:g}" for number in groups[2])
    return ProgramTarget(
        name, line, pose, (position, rotation), branch=branch, turns=groups[2][:3], external=external
    )


def tool(source: Source, name: str, words: Tokens) -> Frame | Message:
    """Return the tool that a tooldata literal is, or why targets with it are left alone."""
    match inside(words, "["):
        case [holds, frame, _] if _says(holds, "TRUE"):
            return Frame(name, _pose_of(source, frame))
        # A tool that stands in the cell: the robot brings the work to it, and what the target places is no
        # tool at the flange.
        case [holds, _, _] if _says(holds, "FALSE"):
            return message("left.tool_stands", tool=name)
    return Frame(name)


def work_object(source: Source, name: str, words: Tokens) -> Frame | Message:
    """Return the work object that a wobjdata literal is, or why targets in it are left alone."""
    match inside(words, "["):
        # The robot holds the work: its frame moves with the flange.
        case [holds, _, _, _, _] if _says(holds, "TRUE"):
            return message("left.object_held", frame=name)
        # A mechanical unit moves the user frame (ufprog FALSE): where it is stands in no text.
        case [_, fixed, _, _, _] if _says(fixed, "FALSE"):
            return message("left.object_moved", frame=name)
        case [_, _, _, user, of_object]:
            outer, inner = _pose_of(source, user), _pose_of(source, of_object)
            return Frame(name, compose(outer, inner) if outer and inner else None)
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
    source.refuse(f"{what.lower()} has {count} parts, {stand} found", at.start)


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
