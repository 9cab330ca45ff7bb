"""What a KRL file declares: values, targets by name and index, tools, bases, and those of inline forms.

Source: KUKA System Software, Operating and Programming Instructions for System Integrators, sections on
the structures E6AXIS, E6POS, FRAME; A, B and C turn about Z, the new Y and the newest X.

A base is given by $BASE, by BAS(#BASE, n), or with every point of an inline form: the point XP1 has its
numbers of tool and base in FP1.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal, TypeAlias

from truepose.exchange.programs.controller_rules import whole_number
from truepose.exchange.programs.parsed_program import (
    COMPUTED,
    ELSEWHERE,
    HOLDS_WORK,
    ArgumentTargets,
    Draft,
    Held,
    InUse,
    among,
)
from truepose.exchange.programs.pose_notation import JOINT_DEGREES, MILLIMETRES, ZYX_DEGREES
from truepose.exchange.programs.program import (
    AT_THE_ORIGIN,
    Configuration,
    Frame,
    Number,
    Pose,
    ProgramTarget,
    Source,
    Written,
)
from truepose.exchange.programs.tokens import (
    Token,
    Tokens,
    bracket,
    display_tokens,
    inside,
    number,
    outside,
    parts,
)
from truepose.messages.message import Message, message

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


def target(source: Source, name: str, words: Tokens) -> ProgramTarget | Message:
    """Return the target that an aggregate is, or why it is none that can be corrected."""
    held = entries(words) or {}
    names = _JOINTS if _JOINTS[0] in held or any(key in held for key in _JOINTS) else _POSE
    absent = [key for key in names if key not in held]
    if absent:
        return message("left.absent_kept", names=", ".join(absent))
    read = [number(source, held[key]) for key in names]
    numbers = tuple(entry for entry in read if entry is not None)
    if len(numbers) < len(read):
        return message("left.named_numbers")
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
    branch = ", ".join(f"{key} {display_tokens(source, held[key])}" for key in _BRANCH if key in held)
    value, turn = Pose.written(position, rotation), _bits(source, held.get("T", ()))
    turns = () if turn is None else (turn,)
    return ProgramTarget(
        name, line, value, (position, rotation), branch=branch, turns=turns, external=external
    )


def _bits(source: Source, words: Tokens) -> Number | None:
    """Return a whole number that may be written as 'B010011' or 'H13'."""
    if len(words) == 1 and words[0].kind == "string":
        value = whole_number(words[0].text)
        base: Literal[2, 16] = 2 if words[0].text[1:2] in "Bb" else 16
        return None if value is None else Number(words[0].start, words[0].end, float(value), 0, base)
    return number(source, words)


Which: TypeAlias = Literal["TOOL", "BASE"]
_NONE_AT_ALL: Final = Frame("$NULLFRAME", AT_THE_ORIGIN)
_MOVED: Final = frozenset({"EK", "EB", "EO"})  # functions that give the base of another kinematic system
NAMES: Final[dict[str, Which]] = {"$TOOL": "TOOL", "$BASE": "BASE"}


@dataclass(frozen=True, slots=True)
class PointData:
    """What an inline form says of a point: tool and base, or why it is left alone."""

    tool: Frame | None
    base: Frame | None
    reason: Message | None = None


class Frames:
    """The frames that a file declares, by name in capitals."""

    def __init__(self, source: Source) -> None:
        self._source = source
        self._poses: dict[str, Pose | None] = {}

    def declare(self, name: str, words: Tokens) -> None:
        """Take down TOOL_DATA[n], BASE_DATA[n] or a variable; given twice, it is only known by its name."""
        again = name in self._poses
        self._poses[name] = None if again else pose(self._source, words)

    def numbered(self, which: Which, number: int | None) -> Frame | None:
        """Return a tool or base by its number."""
        if number is None:
            return None
        return _NONE_AT_ALL if number == 0 else self.named(f"{which}_DATA[{number}]")

    def named(self, name: str) -> Frame:
        """Return a tool or base by its name."""
        return _NONE_AT_ALL if name == _NONE_AT_ALL.name else Frame(name, self._poses.get(name))

    def given(self, name: str, words: Tokens) -> InUse:
        """Return what $TOOL or $BASE becomes by an assignment, of the words behind its sign."""
        if not words:
            return None
        if words[0].upper in _MOVED:
            return message("left.base_moved")
        written = pose(self._source, words)
        if written is not None:
            line = self._source.line(words[0].start)
            spoken = message("left.frame_at", frame=name, place=self._source.place(line))
            return Frame(f"{name} of {self._source.said(line)}", written, spoken)
        return self.named(display_tokens(self._source, words).upper().replace(" ", ""))

    def of_point(self, words: Tokens) -> PointData:
        """Return what a FDAT aggregate says."""
        held = entries(words) or {}
        tool = self.numbered("TOOL", whole(self._source, held.get("TOOL_NO", ())))
        base = self.numbered("BASE", whole(self._source, held.get("BASE_NO", ())))
        on_tool = "#TCP" in display_tokens(self._source, held.get("IPO_FRAME", ())).upper()
        return PointData(tool, base, HOLDS_WORK if on_tool else None)


_TARGETS: Final = frozenset({"E6POS", "POS", "E6AXIS", "AXIS"})
_FRAME: Final = "FRAME"  # of a target, of an offset or of a base
_POINT_DATA: Final = "FDAT"
_IN_FRONT: Final = frozenset({"GLOBAL", "DECL", "CONST", "PUBLIC"})


@dataclass(frozen=True, slots=True)
class _Given:
    """A name, and what a line gives to it; without a value it is only declared."""

    kind: str  # its type, empty where the line does not say it
    name: Token
    index: Tokens
    component: bool  # whether only a part of it
    value: Tokens


class Data:
    """The names of a file."""

    def __init__(self, draft: Draft, lines: Sequence[Tokens]) -> None:
        self._draft = draft
        self._source = draft.source
        self._points: dict[str, PointData] = {}
        self._targets: dict[str, Held] = {}
        self._certain: set[str] = set()  # names of targets, whether or not this file moves to them
        self.frames = Frames(self._source)
        given = [entry for line in lines for entry in _given(line)]
        for entry in given:
            self._take_frame(entry)
        for entry in given:
            if entry.kind == _POINT_DATA:
                self._points[entry.name.upper] = self.frames.of_point(entry.value)
        for entry in given:
            self._take(entry)

    def point_data(self, name: str) -> PointData | None:
        """Return what FDAT says under a name in capitals."""
        return self._points.get(name)

    def chosen(self, words: Tokens) -> ArgumentTargets | Message:
        """Return the targets that a name, with or without index, can be; or why that is not known."""
        name, index = words[0].upper, self._index(words[1:])
        held = self._targets.get(name)
        if held is None:
            return COMPUTED if name.startswith("$") else ELSEWHERE
        targets = among(held, index)
        return ArgumentTargets(targets, index is not None) if targets else COMPUTED

    def targets_in(self, words: Tokens) -> tuple[int, ...]:
        """Return the targets whose names an expression has."""
        found: list[int] = []
        for at, word in enumerate(words):
            if word.upper in self._targets:
                found += among(self._targets[word.upper], self._index(bracket(words, "[", at + 1)))
        return tuple(found)

    def _take_frame(self, given: _Given) -> None:
        """Take down what may be a tool or a base: an aggregate of the type FRAME, or without a type."""
        may_be = given.kind in ("", _FRAME) and not given.component and given.name.upper not in NAMES
        if may_be and entries(given.value) is not None:
            self.frames.declare(f"{given.name.upper}{display_tokens(self._source, given.index)}", given.value)

    def _take(self, given: _Given) -> None:
        name = given.name.upper
        if name.startswith("$") or name.endswith("_DATA"):
            return
        if given.kind in _TARGETS:
            self._certain.add(name)
        if given.kind in _TARGETS or given.kind == _FRAME or _is_place(given):
            self._targets.setdefault(name, {})
        if name in self._targets and given.value:
            self._give(self._targets[name], given)

    def _give(self, held: Held, given: _Given) -> None:
        """Follow what is given to a target: an aggregate is one, all else changes it."""
        index = self._index(given.index)
        if given.component or index is None or entries(given.value) is None:
            self._draft.change(self._source.line(given.name.start), among(held, index))
            return
        name = display_tokens(self._source, [given.name, *given.index])
        if_used = given.name.upper not in self._certain
        data = self._points.get(f"F{name.upper()[1:]}") or PointData(None, None)
        found = data.reason or target(self._source, name, given.value)
        if not isinstance(found, Message):
            framed = replace(found, tool=data.tool, work_object=data.base)
            held.setdefault(index, []).append(self._draft.add(framed, if_used=if_used))
        elif not if_used:
            self._draft.leave(self._source.line(given.name.start), name, found, moves=False)

    def _index(self, words: Tokens) -> str | None:
        """Return an index as text; None where it is computed, empty where none stands."""
        if not words:
            return ""
        read = [number(self._source, entry) for entry in inside(words, "[") or ()]
        known = [f"{entry.value:g}" for entry in read if entry is not None]
        return ",".join(known) if known and len(known) == len(read) else None


def _is_place(given: _Given) -> bool:
    """Whether a value without a type is that of a target, which another file declares."""
    return not given.kind and not {"X", "A1"}.isdisjoint(entries(given.value) or ())


def _given(line: Tokens) -> Iterator[_Given]:
    """Yield what a line gives, or every name that it declares."""
    words = line
    while words and words[0].upper in _IN_FRONT:
        words = words[1:]
    kind = ""
    if len(words) > 1 and words[0].kind == words[1].kind == "word":
        kind, words = words[0].upper, words[1:]
    for entry in parts(words) if kind else [words]:
        if entry and entry[0].kind == "word":
            index = bracket(entry, "[", 1)
            behind = entry[1 + len(index) :]
            given = bool(behind) and behind[0].text in ("=", ".")
            signs = (place for place in outside(behind) if behind[place].text == "=")
            at = next(signs, None) if given else None
            yield _Given(kind, entry[0], index, bool(at), () if at is None else behind[at + 1 :])
