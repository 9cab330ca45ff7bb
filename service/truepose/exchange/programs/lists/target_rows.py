"""Rows of a list of targets: the keys of an object.

A row is a pose of the tool in the world (`x_mm, y_mm, z_mm, qw, qx, qy, qz`), or of one of its nests where
`nest` says which, with `q1_deg ..` as the nominal answer; or only a configuration (`q1_deg ..`).
"""

from collections.abc import Collection, Mapping
from itertools import count, takewhile
from math import hypot
from typing import Final

from truepose.domain.sentences import said
from truepose.exchange.programs.forms import JOINT_DEGREES, MILLIMETRES, QUATERNION
from truepose.exchange.programs.program import (
    AT_THE_ORIGIN,
    Configuration,
    Frame,
    Number,
    Pose,
    ProgramTarget,
    Written,
)
from truepose.exchange.programs.rotations import is_orientation
from truepose.exchange.programs.source import Source

NAME: Final = "target"
NEST: Final = "nest"
POSITION: Final = ("x_mm", "y_mm", "z_mm")
ROTATION: Final = ("qw", "qx", "qy", "qz")
_WORLD: Final = Frame("world", AT_THE_ORIGIN)
_FLANGE: Final = Frame("flange", AT_THE_ORIGIN)


def joint_names(names: Collection[str]) -> tuple[str, ...]:
    """Return the names of joint angles among `names`, from q1_deg on without a gap."""
    return tuple(takewhile(lambda name: name in names, (f"q{joint}_deg" for joint in count(1))))


def required(names: Collection[str]) -> tuple[str, ...]:
    """Return what a row must have, by what there is: a pose, or a configuration."""
    is_pose = not joint_names(names) or any(name in names for name in (*POSITION, *ROTATION))
    return (*POSITION, *ROTATION) if is_pose else joint_names(names)


def nest_frame(nest: int) -> Frame:
    """Return a tool nest as a program names a tool; where it is, the model knows."""
    return Frame(f"nest {nest}", spoken=said("left.nest", nest=nest))


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
