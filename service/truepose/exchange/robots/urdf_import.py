"""A URDF as a nominal robot: the arm in it, its table, and what is fixed before and behind it."""

import math
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, NoReturn

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.robot import FramePlacement, JointRange, LinkMass, Robot
from truepose.exchange.document import read_bytes
from truepose.exchange.errors import BadValueError
from truepose.exchange.robots.urdf_description import FIXED, Description, Joint, read_description
from truepose.kinematics.frames import placement_of
from truepose.kinematics.joint_axes import JointAxis, table_of

_TOOL_FRAME: Final = "tool0"  # what the tool frame of a controller is called in ROS-Industrial


@dataclass(frozen=True, slots=True)
class Arm:
    """The joints from a base to a tip, fixed ones among them, in order."""

    base: str
    tip: str
    joints: tuple[Joint, ...]


def arm_of(description: Description, base: str | None = None, tip: str | None = None) -> Arm:
    """Return the serial arm of a description.

    Parameters
    ----------
    description : Description
    base : str, optional
        Link that the arm stands on; by default the one that no joint holds.
    tip : str, optional
        Link at its end; by default `tool0`, else the only link at the end of what the last joint turns, else
        the link of the last joint.

    Raises
    ------
    BadValueError
        Links hang in a circle or on two others, the arm branches, a joint slides or follows another one.
    """
    tree = _Tree(description)
    base = tree.root if base is None else tree.known(base)
    tip = tree.tip(base) if tip is None else tree.known(tip)
    joints = tree.between(base, tip)
    _require_turning(joints, description)
    return Arm(base, tip, joints)


def fixed_to(description: Description, link: str) -> Iterator[tuple[Joint, ...]]:
    """Yield the ways along fixed joints from a link to every link that moves with it, the empty one first."""
    held = _held(description)
    ways: list[tuple[Joint, ...]] = [()]
    while ways:
        way = ways.pop()
        yield way
        end = way[-1].child if way else link
        ways += [(*way, joint) for joint in held[end] if joint.kind == FIXED]


def _held(description: Description) -> Mapping[str, list[Joint]]:
    held: defaultdict[str, list[Joint]] = defaultdict(list)
    for joint in description.joints:
        held[joint.parent].append(joint)
    return held


class _Tree:
    """Who holds whom."""

    def __init__(self, description: Description) -> None:
        self._description = description
        self._holder = self._holders()
        self._held = _held(description)
        self.root = self._only_root()
        self._require_one_piece()

    def _holders(self) -> dict[str, Joint]:
        holders: dict[str, Joint] = {}
        for joint in self._description.joints:
            other = holders.setdefault(joint.child, joint)
            if other is not joint:
                joint.element.fail(
                    f"link {joint.child!r} has two parent joints, {other.name!r} and {joint.name!r}: a loop, "
                    "which URDF does not allow"
                )
        return holders

    def _only_root(self) -> str:
        """Return the link that no joint holds."""
        roots = [name for name in self._description.links if name not in self._holder]
        if not roots:
            self._refuse("every link has a parent: the joints form a loop")
        if len(roots) > 1:
            self._refuse(f"links {roots[0]!r} and {roots[1]!r} have no parent: these are two robots")
        return roots[0]

    def _require_one_piece(self) -> None:
        """Refuse joints that go round in a circle beside the arm."""
        # A circle hangs on nothing and holds nothing, so that a walk from the root never comes to it.
        found, waiting = {self.root}, [self.root]
        while waiting:
            children = [joint.child for joint in self._held[waiting.pop()]]
            found.update(children)
            waiting += children
        astray = next((name for name in self._description.links if name not in found), None)
        if astray is not None:
            self._refuse(f"link {astray!r} is in a loop of joints, not connected to link {self.root!r}")

    def known(self, name: str) -> str:
        """Return the name of a link that is there."""
        if name not in self._description.links:
            self._refuse(f"there is no link {name!r}; it has {', '.join(self._description.links)}")
        return name

    def between(self, base: str, tip: str) -> tuple[Joint, ...]:
        """Return the joints from a link to one that hangs on it, in order."""
        joints: list[Joint] = []
        link = tip
        while link != base:
            joint = self._holder.get(link)
            if joint is None:
                self._refuse(f"link {tip!r} is not a descendant of link {base!r}")
            joints.append(joint)
            link = joint.parent
        return tuple(reversed(joints))

    def tip(self, base: str) -> str:
        """Return the end of the only arm on a link."""
        link, following = base, self._moving_on(base)
        while following:
            if len(following) > 1:
                one, other = following[:2]
                other.element.fail(
                    f"the arm branches into joints {one.name!r} and {other.name!r}; name the link at its "
                    f"tip, as in {other.element.file}#{other.child}"
                )
            link = following[0].child
            following = self._moving_on(link)
        ends = [way[-1].child if way else link for way in fixed_to(self._description, link)]
        leaves = [end for end in ends if not self._held[end]]
        if _TOOL_FRAME in ends:
            return _TOOL_FRAME
        return leaves[0] if len(leaves) == 1 else link

    def _moving_on(self, link: str) -> list[Joint]:
        """Return the joints that move against a link and hang on it, directly or behind fixed joints."""
        ends = [way[-1].child if way else link for way in fixed_to(self._description, link)]
        return [joint for end in ends for joint in self._held[end] if joint.kind != FIXED]

    def _refuse(self, sentence: str) -> NoReturn:
        raise BadValueError(sentence, file=self._description.element.file)


def _require_turning(joints: Sequence[Joint], description: Description) -> None:
    for joint in joints:
        if joint.kind != FIXED and not joint.turns:
            joint.element.fail(
                f"joint {joint.name!r} is {joint.kind}; only arms of revolute joints are supported"
            )
        if joint.follows is not None:
            joint.element.fail(
                f"joint {joint.name!r} follows joint {joint.follows!r}; only arms whose joints turn "
                "independently are supported"
            )
    if not any(joint.turns for joint in joints):
        description.element.fail("there is no revolute joint between base and tip")


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
    tip: FramePlacement  # of the tip link in the table's flange frame


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
