"""Data of Staubli controllers in VAL3 from version 7 on (.dtx): points, joints, frames.

Source: Staubli, VAL3 reference manual, "joint type", "trsf type", "frame type", "pointRx type". A rotation
turns about X, the new Y and the newest Z. The motions stand in other files (.pgx), and with them the tool.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final, TypeAlias

from truepose.exchange.programs.parsed_program import Draft
from truepose.exchange.programs.pose_notation import JOINT_DEGREES, MILLIMETRES, XYZ_DEGREES, compose
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
from truepose.exchange.tables.table_reader import is_number, shown
from truepose.messages.message import message

_PIECE: Final = re.compile(
    r"<!--.*?-->|<!\[CDATA\[.*?\]\]>|<\?.*?\?>|<!DOCTYPE[^>]*>"
    r'|<(?P<tag>/?[\w:.-]+)(?P<attributes>(?:[^<>"\']|"[^"<]*"|\'[^\'<]*\')*)>|(?P<open><)',
    re.DOTALL,
)
_ATTRIBUTE: Final = re.compile(
    r"(?<![\w:.-])([\w:.-]++)\s*+=\s*+(?:\"(?P<double>[^\"]*)\"|'(?P<single>[^']*)')"
)
_JOINTS: Final = ("j1", "j2", "j3", "j4", "j5", "j6")
_POSE: Final = ("x", "y", "z", "rx", "ry", "rz")
_BRANCH: Final = ("shoulder", "elbow", "wrist")
_FATHER: Final = "fatherId"
_WORLD: Final = "world[0]"
_MOST_FRAMES: Final = 50  # from a point to the world
_Attributes: TypeAlias = Mapping[str, tuple[int, int]]


@dataclass(frozen=True, slots=True)
class _Entry:
    """A value of a variable."""

    kind: str
    name: str
    at: int
    attributes: _Attributes


def read(draft: Draft) -> None:
    """Read a file of data."""
    entries = list(_entries(draft.source))
    reader = _Reader(draft, entries)
    for entry in entries:
        reader.take(entry)


def _entries(source: Source) -> Iterator[_Entry]:
    kind, name, opened = "", "", 0
    for piece in _PIECE.finditer(source.text, source.start):
        tag = piece["tag"] or ""
        if piece["open"]:
            source.fail("the tag that begins here is not closed", piece.start())
        attributes = dict(_attributes(source, piece))
        opened += (tag == "Database") - (tag == "/Database")
        if tag == "Data":
            kind, name = (source.shown(*attributes.get(key, (0, 0))) for key in ("type", "name"))
        elif tag == "Value":
            index = source.shown(*attributes.get("key", (0, 0)))
            yield _Entry(kind, f"{name}[{index}]", piece.start(), attributes)
    if "<Database" not in source.text:
        source.fail("this is not VAL3 data of version 7 or later: it has no Database", source.start)
    if opened > 0:
        source.fail("the Database has no end; the file is cut off", len(source.text.rstrip()))


def _attributes(source: Source, piece: re.Match[str]) -> Iterator[tuple[str, tuple[int, int]]]:
    if piece["attributes"]:
        for found in _ATTRIBUTE.finditer(source.text, *piece.span("attributes")):
            yield found[1], found.span("double" if found["double"] is not None else "single")


class _Reader:
    """Makes targets of points and joints."""

    def __init__(self, draft: Draft, entries: list[_Entry]) -> None:
        self._draft = draft
        self._source = draft.source
        self._frames = {entry.name: entry for entry in entries if entry.kind == "frame"}

    def take(self, entry: _Entry) -> None:
        """Take a value, if it is a target."""
        if entry.kind not in ("pointRx", "point", "pointRs", "joint", "jointRx", "jointRs"):
            return
        names = _JOINTS if entry.kind.startswith("joint") else _POSE
        line = self._source.line(entry.at)
        if entry.kind.endswith("Rs"):
            self._draft.leave(line, entry.name, message("left.four_axes"), moves=False)
            return
        absent = [name for name in names if name not in entry.attributes]
        if absent:
            reason = message("left.absent", names=", ".join(absent))
            self._draft.leave(line, entry.name, reason, moves=False)
            return
        numbers = tuple(self._number(entry.attributes[name]) for name in names)
        joints = Written(numbers, JOINT_DEGREES)
        if names is _JOINTS:
            self._draft.add(ProgramTarget(entry.name, line, Configuration(joints.read()), (joints,)))
        else:
            self._draft.add(self._point(entry, line, numbers))

    def _point(self, entry: _Entry, line: int, numbers: tuple[Number, ...]) -> ProgramTarget:
        position, rotation = Written(numbers[:3], MILLIMETRES), Written(numbers[3:], XYZ_DEGREES)
        said = [f"{key} {self._text(entry, key)}" for key in _BRANCH if key in entry.attributes]
        return ProgramTarget(
            entry.name,
            line,
            Pose.written(position, rotation),
            (position, rotation),
            branch=", ".join(said),
            work_object=self._frame(self._text(entry, _FATHER)),
        )

    def _frame(self, name: str) -> Frame | None:
        return Frame(name, self._in_world(name, _MOST_FRAMES)) if name else None

    def _in_world(self, name: str, most: int) -> Pose | None:
        """Return a frame in the world; None where it hangs on what is not in the file."""
        if name == _WORLD:
            return AT_THE_ORIGIN
        entry = self._frames.get(name)
        # Frames may hang in a circle; none that a shop uses lies so far from the world.
        if entry is None or most == 0:
            return None
        outer = self._in_world(self._text(entry, _FATHER), most - 1)
        return None if outer is None else compose(outer, self._pose(entry))

    def _pose(self, entry: _Entry) -> Pose:
        """Return the pose of a frame; what it does not say is 0."""
        held = [
            self._number(entry.attributes[key]).value if key in entry.attributes else 0.0 for key in _POSE
        ]
        x, y, z = MILLIMETRES.inward(held[:3])
        a, b, c, d = XYZ_DEGREES.inward(held[3:])
        return Pose((x, y, z), (a, b, c, d))

    def _number(self, span: tuple[int, int]) -> Number:
        if not is_number(self._source.text[slice(*span)]):
            self._source.refuse(f"{shown(self._source.shown(*span))} is not a number", span[0])
        return self._source.number(*span)

    def _text(self, entry: _Entry, key: str) -> str:
        return self._source.shown(*entry.attributes.get(key, (0, 0)))
