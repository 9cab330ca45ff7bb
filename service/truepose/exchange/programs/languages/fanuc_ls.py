"""Programs of FANUC controllers as text (.ls).

Source: FANUC Robotics, SYSTEM R-30iA and R-30iB Handling Tool, Setup and Operations Manual, chapters on
program elements and on ASCII programs; positions as controllers print them. W, P and R turn about the
fixed X, Y and Z. The text has three decimals, and a controller reads no more. The third joint is counted
as the controller does it, from the horizontal.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from truepose.exchange.programs.parsed_program import (
    ARC,
    CHOSEN,
    COMPUTED,
    DISPLACED,
    ELSEWHERE,
    RELATIVE,
    Draft,
)
from truepose.exchange.programs.pose_notation import degrees_of_joints, millimetres, turns_in_degrees
from truepose.exchange.programs.program import (
    AT_THE_ORIGIN,
    Configuration,
    Frame,
    Number,
    Path,
    Pose,
    ProgramTarget,
    Source,
    Written,
)
from truepose.exchange.programs.tokens import plain_digits
from truepose.messages.message import Message, message

_DECIMALS: Final = 3
_POSITION: Final = millimetres(_DECIMALS)
_ROTATION: Final = turns_in_degrees("fixed xyz", _DECIMALS)
_JOINTS: Final = degrees_of_joints(_DECIMALS)
_SECTION: Final = re.compile(r"^/(MN|POS|END)\b[^\r\n]*", re.MULTILINE)
_ENTRY: Final = re.compile(r'P\[\s*(?P<number>[0-9]+)\s*(?::\s*"(?P<comment>[^"\r\n]*)"\s*)?\]\s*\{')
_GROUP: Final = re.compile(r"GP([0-9]+)\s*:")
_FRAME: Final = re.compile(r"\b(UF|UT)\s*:\s*([0-9]+|F)")
_BRANCH: Final = re.compile(r"CONFIG\s*:\s*'([^']*)'")
_COMPONENT: Final = re.compile(
    r"\b([XYZWPRJE][0-9]*)\s*=\s*+([-+]?\s*+(?:[0-9]++(?:\.[0-9]*+)?|\.[0-9]++)|\*++)\s*+(mm|deg)"
)
_POSE: Final = ("X", "Y", "Z", "W", "P", "R")
_STATEMENT: Final = re.compile(r"^[ \t]*+(?:[0-9]++[ \t]*+)?:", re.MULTILINE)
_MOTION: Final = re.compile(
    r"\s*(?P<kind>[JLCAS])\s+(?P<register>PR?)\[(?P<which>[^\]]*)\]?(?P<rest>.*)", re.DOTALL
)
_NUMBERED: Final = re.compile(r"\s*([0-9]+)\s*(?::.*)?", re.DOTALL)
_REMARKS: Final = ("!", "//", "--")
_POINT: Final = re.compile(r"(?<![A-Z])P\[\s*([0-9]+)")
_ASSIGNED: Final = re.compile(r"\s*P\[\s*([0-9]++)[^=\]]*+\]\s*=")
# All else may jump, call or wait for a motion; its words are those of the controller's language.
_STANDS_STILL: Final = re.compile(
    r"\s*(?:$|(?:R|DO|RO|GO|AO|F|PR|SR|P|TIMER)\[[^\]]*\]\s*=|WAIT\b|UFRAME_NUM|UTOOL_NUM|PAYLOAD|OVERRIDE)"
)
_PATHS: Final[Mapping[str, Path]] = {"J": "joints", "L": "line"}
_DISPLACED: Final = (
    (re.compile(r"\bINC\b"), RELATIVE),
    (re.compile(r"\b(?:V?OFFSET|TOOL_OFFSET)\b", re.IGNORECASE), DISPLACED),
    (re.compile(r"\bCOORD\b"), message("left.work_moves")),
    (re.compile(r"\bSEARCH\b", re.IGNORECASE), message("left.search")),
)


def read(draft: Draft) -> None:
    """Read a FANUC program."""
    source = draft.source
    sections = _sections(source)
    if "END" not in sections:
        source.fail("the program has no /END; the file is cut off", len(source.text.rstrip()))
    targets: dict[str, int] = {}
    if "POS" in sections:
        _Positions(draft, targets).read(*sections["POS"])
    if "MN" in sections:
        for span in _statements(source, *sections["MN"]):
            _Statement(draft, targets, span).follow()


def _sections(source: Source) -> dict[str, tuple[int, int]]:
    """Return where the sections begin and end that tell of motions."""
    heads = list(_SECTION.finditer(source.text))
    return {head.group(1): (head.end(), end) for head, end in _with_ends(heads, len(source.text))}


def _statements(source: Source, at: int, end: int) -> Iterator[tuple[int, int]]:
    """Yield where the text of each statement begins and ends; one without ; at its end is none."""
    while head := _STATEMENT.search(source.text, at, end):
        at = source.text.find(";", head.end(), end)
        if at < 0:
            return
        yield head.end(), at


def _with_ends(heads: Sequence[re.Match[str]], end: int) -> Iterator[tuple[re.Match[str], int]]:
    """Yield every head, and where what is under it ends."""
    for at, head in enumerate(heads, start=1):
        yield head, heads[at].start() if at < len(heads) else end


class _Positions:
    """The section /POS."""

    def __init__(self, draft: Draft, targets: dict[str, int]) -> None:
        self._draft = draft
        self._source = draft.source
        self._targets = targets

    def read(self, start: int, end: int) -> None:
        """Read every position."""
        at = start
        while found := _ENTRY.search(self._source.text, at, end):
            at = self._source.text.find("}", found.end(), end)
            following = _ENTRY.search(self._source.text, found.end(), end)
            if at < 0 or (following and following.start() < at):
                self._source.fail("the position that begins here is not closed by }", found.start())
            self._entry(found, at)

    def _entry(self, found: re.Match[str], end: int) -> None:
        comment = f": {self._source.shown(*found.span('comment'))}" if found["comment"] else ""
        name = f"P[{found['number']}{comment}]"
        groups = list(_GROUP.finditer(self._source.text, found.end(), end))
        spans = {plain_digits(group[1]): (group.end(), stop) for group, stop in _with_ends(groups, end)}
        line = self._source.line(found.start())
        if "1" not in spans:
            self._draft.leave(line, name, message("left.no_first_group"), moves=False)
            return
        first = spans.pop("1")
        others = [number for span in spans.values() for number in self._numbers(*span)]
        target = self._target(name, line, first, others)
        if isinstance(target, Message):
            self._draft.leave(line, name, target, moves=False)
        else:
            self._targets[plain_digits(found["number"])] = self._draft.add(target)

    def _target(
        self, name: str, line: int, span: tuple[int, int], others: list[tuple[str, Number, str]]
    ) -> ProgramTarget | Message:
        if any(key == "X" for key, _, _ in others):
            return message("left.second_arm")
        if "*" in self._source.text[slice(*span)]:
            return message("left.never_taught")
        read = {key: (number, unit) for key, number, unit in self._numbers(*span)}
        external = [number for key, (number, _) in read.items() if key.startswith("E")]
        kept = tuple(number.value for number in (*external, *(number for _, number, _ in others)))
        if "J1" in read:
            joints = [entry for key, entry in read.items() if key.startswith("J")]
            if any(unit != "deg" for _, unit in joints):
                return message("left.length")
            written = Written(tuple(number for number, _ in joints), _JOINTS)
            return ProgramTarget(name, line, Configuration(written.read()), (written,), external=kept)
        absent = [key for key in _POSE if key not in read]
        if absent:
            self._source.refuse(f"{name} has no {absent[0]}", span[0])
        return self._pose(name, line, span, tuple(read[key][0] for key in _POSE), kept)

    def _pose(
        self,
        name: str,
        line: int,
        span: tuple[int, int],
        numbers: tuple[Number, ...],
        external: tuple[float, ...],
    ) -> ProgramTarget:
        frames = dict(_FRAME.findall(self._source.text[slice(*span)]))
        branch = _BRANCH.search(self._source.text, *span)
        position, rotation = Written(numbers[:3], _POSITION), Written(numbers[3:], _ROTATION)
        return ProgramTarget(
            name,
            line,
            Pose.written(position, rotation),
            (position, rotation),
            branch=self._source.shown(*branch.span(1)) if branch else "",
            external=external,
            tool=_numbered("UTOOL", frames.get("UT")),
            work_object=_numbered("UFRAME", frames.get("UF")),
        )

    def _numbers(self, start: int, end: int) -> Iterator[tuple[str, Number, str]]:
        for found in _COMPONENT.finditer(self._source.text, start, end):
            if "*" not in found[2]:
                yield found[1], self._source.number(*found.span(2)), found[3]


class _Statement:
    """A statement of the section /MN."""

    def __init__(self, draft: Draft, targets: Mapping[str, int], span: tuple[int, int]) -> None:
        self._draft = draft
        self._targets = targets
        start, end = span
        self._text = draft.source.text[start:end]
        blanks = len(self._text) - len(self._text.lstrip())
        self._line = draft.source.line(start + blanks)
        self._shown = draft.source.shown(start, end)

    def follow(self) -> None:
        """Say what the statement does with the robot and with positions."""
        if self._text.lstrip().startswith(_REMARKS):
            return
        motion = _MOTION.match(self._text)
        assigned = _ASSIGNED.match(self._text)
        if motion is not None:
            self._move(motion)
        elif assigned is not None:
            self._draft.change(self._line, self._known(assigned[1]))
        elif self._points():
            self._leave(COMPUTED, moves=False)
        if motion is None and not _STANDS_STILL.match(self._text):
            self._draft.interrupt()

    def _move(self, motion: re.Match[str]) -> None:
        displaced = (reason for sign, reason in _DISPLACED if sign.search(motion["rest"]))
        reason = next(displaced, None)
        which = _NUMBERED.fullmatch(motion["which"])
        if motion["kind"] not in _PATHS:
            reason = ARC
        elif motion["register"] == "PR":
            reason = message("left.register")
        elif which is None:
            reason = CHOSEN
        elif not self._known(which[1]):
            reason = reason or ELSEWHERE
        if reason is not None or which is None:
            self._leave(reason or CHOSEN, moves=True)
        else:
            self._draft.visit(self._line, self._known(which[1]), _PATHS[motion["kind"]])

    def _leave(self, reason: Message, *, moves: bool) -> None:
        self._draft.leave(self._line, self._shown, reason, self._points(), moves=moves)

    def _points(self) -> tuple[int, ...]:
        return tuple(target for found in _POINT.findall(self._text) for target in self._known(found))

    def _known(self, number: str) -> tuple[int, ...]:
        target = self._targets.get(plain_digits(number))
        return () if target is None else (target,)


def _numbered(which: str, number: str | None) -> Frame | None:
    """Return a frame by its number; 0 is the world or the flange, F the one that is in use."""
    if number is None or number == "F":
        return None
    return Frame(f"{which} {number}", AT_THE_ORIGIN if plain_digits(number) == "0" else None)
