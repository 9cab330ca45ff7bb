"""Lists of targets as JSON (.json): `{"targets": [{"target": "p1", "x_mm": 1.0, ...}]}`, or only the list.

A row is a pose of the tool in the world (`x_mm, y_mm, z_mm, qw, qx, qy, qz`), or of one of its nests where
`nest` says which, with `q1_deg ..` as the nominal answer; or only a configuration (`q1_deg ..`).
"""

import json
import re
from collections.abc import Collection, Iterator, Mapping
from itertools import count, takewhile
from math import hypot
from typing import Final

from truepose.exchange.document import Node, json_document
from truepose.exchange.json_text import KeyPath
from truepose.exchange.programs.parsed_program import Draft
from truepose.exchange.programs.pose_notation import JOINT_DEGREES, MILLIMETRES, QUATERNION, is_orientation
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
from truepose.messages.message import message

NAME: Final = "target"
NEST: Final = "nest"
POSITION: Final = ("x_mm", "y_mm", "z_mm")
ROTATION: Final = ("qw", "qx", "qy", "qz")
_WORLD: Final = Frame("world", AT_THE_ORIGIN)
_FLANGE: Final = Frame("flange", AT_THE_ORIGIN)


def joint_names(names: Collection[str]) -> tuple[str, ...]:
    """Return the names of joint angles among `names`, from q1_deg on without a gap."""
    return tuple(takewhile(lambda name: name in names, (f"q{joint}_deg" for joint in count(1))))


def required_fields(names: Collection[str]) -> tuple[str, ...]:
    """Return what a row must have, by what there is: a pose, or a configuration."""
    is_pose = not joint_names(names) or any(name in names for name in (*POSITION, *ROTATION))
    return (*POSITION, *ROTATION) if is_pose else joint_names(names)


def nest_frame(nest: int) -> Frame:
    """Return a tool nest as a program names a tool; where it is, the model knows."""
    return Frame(f"nest {nest}", spoken=message("left.nest", nest=nest))


def target_of(
    source: Source, name: str, line: int, held: Mapping[str, Number], nest: int | None
) -> ProgramTarget:
    """Return the target that the numbers of a row are; raises BadValueError for what is no orientation."""
    near = tuple(held[joint] for joint in joint_names(held))
    joints = Written(near, JOINT_DEGREES)
    if POSITION[0] not in held:
        return ProgramTarget(name, line, Configuration(joints.read()), (joints,))
    position = Written(tuple(held[key] for key in POSITION), MILLIMETRES)
    rotation = Written(tuple(held[key] for key in ROTATION), QUATERNION)
    if not is_orientation(rotation.values):
        norm = hypot(*rotation.values)
        source.refuse(
            f"qw to qz have the norm {norm:g}; that of an orientation is 1", rotation.numbers[0].start
        )
    return ProgramTarget(
        name,
        line,
        Pose.written(position, rotation),
        (position, rotation),
        near_rad=joints.read() if near else None,
        tool=nest_frame(nest) if nest else _FLANGE,
        work_object=_WORLD,
    )


_TARGETS: Final = "targets"
_TOKEN: Final = re.compile(r'(?P<text>"(?:[^"\\]|\\.)*+")|(?P<value>[-+.\w]+)|(?P<sign>[\[\]{},:])')


def read(draft: Draft) -> None:
    """Read a list of targets; raises InputFileError as any document does, with the key."""
    source = draft.source
    root = json_document(source.name, source.data)
    entries = root.key(_TARGETS) if isinstance(root.value, dict) else root
    # Two readings of one text: the first says what is there and refuses what is wrong, the second where each
    # number stands.
    places = {path: span for path, span in _values(source) if path[: len(entries.path)] == entries.path}
    for entry in entries.items():
        _read_entry(draft, entry, places)


def _read_entry(draft: Draft, entry: Node, places: dict[KeyPath, tuple[int, int]]) -> None:
    held = {}
    names = entry.entries()
    for name in dict.fromkeys((*required_fields(names), *joint_names(names))):
        node = entry.key(name)
        node.number()
        held[name] = draft.source.number(*places[node.path])
    named, nest = entry.optional(NAME), entry.optional(NEST)
    start = min(number.start for number in held.values())
    line = draft.source.line(start)
    name = named.text() if named else f"line {line}"
    draft.add(target_of(draft.source, name, line, held, nest.whole() if nest else None))


def _values(source: Source) -> Iterator[tuple[KeyPath, tuple[int, int]]]:
    """Yield path and place of every number, true, false and null of a document that is sound."""
    path: list[str | int] = []
    is_key = False
    for token in _TOKEN.finditer(source.text, source.start):
        match token["sign"]:
            case "{" | "[" as opening:
                path.append(0 if opening == "[" else "")
                is_key = opening == "{"
            case "}" | "]":
                path.pop()
            case ",":
                last = path[-1]
                path[-1] = last + 1 if isinstance(last, int) else last
                is_key = isinstance(last, str)
            case None if token["text"] and is_key:
                path[-1] = json.loads(token["text"])
                is_key = False
            case None if token["value"]:
                yield tuple(path), token.span()
