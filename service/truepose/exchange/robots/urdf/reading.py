"""A URDF as a nominal robot: its table, and what is fixed before the first axis and behind the last one."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.robot import FramePlacement, JointRange, LinkMass, Robot
from truepose.exchange.input_file import read_bytes
from truepose.exchange.robots.urdf.arm import arm_of, fixed_to
from truepose.exchange.robots.urdf.description import Description, Joint, read_description
from truepose.kinematics.frames import placement_of
from truepose.kinematics.joint_axes import JointAxis, table_of

_MOST_BYTES: Final = 16 * 2**20  # a thousand times what describes an arm without its meshes
_ENDLESS: Final = JointRange(-2.0 * math.pi, 2.0 * math.pi)  # of a continuous joint: one turn either way
_AGAINST_Z: Final = (0.0, 0.0, -1.0)


@dataclass(frozen=True, slots=True)
class DescribedRobot:
    """A robot of a URDF, and where it is in the frames of that file."""

    robot: Robot
    base_link: str
    tip_link: str
    base: FramePlacement  # of the table's frame 0 in the base link
    tip: FramePlacement  # of the tip link in the table's last frame


def read_urdf(path: Path, *, base: str | None = None, tip: str | None = None) -> DescribedRobot:
    """Read a serial arm of revolute joints.

    Parameters
    ----------
    path : Path
    base, tip : str, optional
        Links at its ends, see `arm_of`.

    Returns
    -------
    DescribedRobot
        Joint angles are those of the URDF. A mass is given to the frame that it moves with; what its base and
        other arms weigh is left out.

    Raises
    ------
    InputFileError
        With file and line.
    """
    return urdf_from_text(path.name, read_bytes(path, most=_MOST_BYTES), base=base, tip=tip)


def urdf_from_text(
    file: str, data: bytes, *, base: str | None = None, tip: str | None = None
) -> DescribedRobot:
    """Read a serial arm from the content of a file, as `read_urdf` does."""
    description = read_description(file, data)
    arm = arm_of(description, base, tip)
    poses = _poses(arm.joints)
    turning = [(joint, pose) for joint, pose in zip(arm.joints, poses, strict=True) if joint.turns]
    end = poses[-1]
    table = table_of([_axis(joint, pose) for joint, pose in turning], np.eye(4), end)
    robot = Robot(
        name=description.name,
        joints=table.rows,
        masses=tuple(_masses(description, turning, table.frames)),
        source=f"URDF, {file}",
        joint_limits=_limits([joint for joint, _ in turning]),
    )
    return DescribedRobot(
        robot, arm.base, arm.tip, _placement(table.base), _placement(np.linalg.inv(table.frames[-1]) @ end)
    )


def _poses(joints: Sequence[Joint]) -> list[FloatArray]:
    """Return where the children of joints in series are while all read zero, shape (4, 4) each."""
    pose, poses = np.eye(4), []
    for joint in joints:
        pose = pose @ joint.origin
        poses.append(pose)
    return poses


def _axis(joint: Joint, pose: FloatArray) -> JointAxis:
    """Return a joint's axis; one that counts against the z of its frame keeps that z."""
    sign = -1 if tuple(joint.axis) == _AGAINST_Z else 1
    return JointAxis(pose[:3, 3], sign * (pose[:3, :3] @ joint.axis), sign)


def _limits(joints: Sequence[Joint]) -> tuple[JointRange, ...] | None:
    """Return the limits of an arm's joints, None where one has none in the file or all turn without end."""
    known = [_ENDLESS if joint.kind == "continuous" else joint.limits for joint in joints]
    given = tuple(limits for limits in known if limits is not None)
    endless = all(joint.kind == "continuous" for joint in joints)
    return None if endless or len(given) < len(joints) else given


def _masses(
    description: Description, turning: Sequence[tuple[Joint, FloatArray]], frames: FloatArray
) -> Iterator[LinkMass]:
    """Yield the mass of every link that moves with a joint, in the frame of that joint."""
    for number, ((joint, pose), frame) in enumerate(zip(turning, frames, strict=True), start=1):
        for way in fixed_to(description, joint.child):
            link = description.links[way[-1].child if way else joint.child]
            if link.mass_kg > 0.0:
                place = np.linalg.inv(frame) @ pose @ _along(way) @ [*link.centre_of_gravity_mm, 1.0]
                x, y, z = place[:3].tolist()
                yield LinkMass(number, link.mass_kg, (x, y, z))


def _along(way: Sequence[Joint]) -> FloatArray:
    return _poses(way)[-1] if way else np.eye(4)


def _placement(frame: FloatArray) -> FramePlacement:
    return placement_of(frame[:3, :3], frame[:3, 3])
