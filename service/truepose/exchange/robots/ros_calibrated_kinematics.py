"""`calibrated_kinematics.yaml`, in which ROS keeps the table of one arm of Universal Robots, in and out.

Six places of joints, each in the frame of the joint before, in m and rad. The description of the arm
(ur_description) takes them as the origins of URDF joints: RotZ(yaw) RotY(pitch) RotX(roll). What reads a
factory calibration out of a controller (ur_calibration) writes RotX RotY RotZ under the same names; the two
agree for the nominal arm and are some 0.1 mm apart for a calibrated one. A file is read and written as the
description takes it, which is what every other program then sees.
Source: UniversalRobots/Universal_Robots_ROS2_Description, urdf/ur_macro.xacro and config/ur10e.
"""

import hashlib
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np
import yaml

from truepose.domain.arrays import FloatArray
from truepose.domain.errors import UnsuitableModelError
from truepose.domain.robot import Robot
from truepose.exchange.document import Node, read_bytes
from truepose.exchange.errors import UnreadableFileError
from truepose.exchange.models.rigid_arm import Subject, remarks
from truepose.exchange.models.urdf_export import joint_origin, roll_pitch_yaw
from truepose.exchange.quantities import limits_of
from truepose.exchange.tables.table_reader import is_number
from truepose.kinematics.frames import rotation_x, rotation_y, rotation_z
from truepose.kinematics.joint_axes import JointAxis, table_of
from truepose.messages.catalogue import english
from truepose.messages.message import Message, message

LINKS: Final = ("shoulder", "upper_arm", "forearm", "wrist_1", "wrist_2", "wrist_3")
_MOST_BYTES: Final = 64 * 2**10  # a hundred times such a file; what is longer is none
_DEEPEST: Final = 10  # such a file has three levels
_M_PER_MM: Final = 1e-3
_TWISTS_DEG: Final = (0.0, 90.0, 0.0, 0.0, 90.0, -90.0)
_TWISTED_RAD: Final = math.radians(2.0)  # more than any arm is built wrong by


def read_calibrated_kinematics(path: Path) -> Robot:
    """Read an arm of Universal Robots; raises InputFileError."""
    return kinematics_from_text(path.name, read_bytes(path, most=_MOST_BYTES))


def kinematics_from_text(file: str, data: bytes) -> Robot:
    """Read an arm from the content of a file called `file`; raises InputFileError that names the key."""
    root = Node(file, _loaded(file, data), (), lambda path: None)
    kinematics = root.key("kinematics")
    pose, axes = np.eye(4), []
    for name in LINKS:
        pose = pose @ _origin(kinematics.key(name))
        axes.append(JointAxis(pose[:3, 3], pose[:3, 2]))
    stated = kinematics.optional("hash")
    called = "" if stated is None else f", {stated.text()}"
    table = table_of(axes, np.eye(4), pose)
    return Robot(f"Universal Robots arm{called}", table.rows, source=f"calibrated kinematics, {file}")


class _PlainLoader(yaml.SafeLoader):
    """Refuses aliases, with which a few lines stand for billions of values, and endless nesting."""

    _depth = 0

    def compose_node(self, parent: Any, index: Any) -> Any:
        """Return the node that comes next."""
        if self.check_event(yaml.AliasEvent) or self._depth > _DEEPEST:
            raise yaml.MarkedYAMLError(
                problem="it has aliases or is nested too deeply, which no such file needs",
                problem_mark=self.get_event().start_mark,  # type: ignore[no-untyped-call]
            )
        self._depth += 1
        node = super().compose_node(parent, index)
        self._depth -= 1
        return node


def _loaded(file: str, data: bytes) -> object:
    try:
        # Plain values only: other loaders make whatever objects a file names, and run code of it.
        return yaml.load(data.decode("utf-8-sig"), _PlainLoader)
    except UnicodeDecodeError as error:
        raise UnreadableFileError("the text is not UTF-8; save the file as UTF-8", file=file) from error
    except (yaml.YAMLError, RecursionError, ValueError) as error:
        mark = getattr(error, "problem_mark", None)
        line = None if mark is None else mark.line + 1
        reason = getattr(error, "problem", None) or "it cannot be read"
        raise UnreadableFileError(f"this is not YAML: {reason}", file=file, line=line) from error


def _origin(node: Node) -> FloatArray:
    x, y, z, roll, pitch, yaw = (_number(node.key(name)) for name in ("x", "y", "z", "roll", "pitch", "yaw"))
    frame = np.eye(4)
    # As the description of the arm composes them, which every other program then sees.
    frame[:3, :3] = rotation_z(yaw) @ rotation_y(pitch) @ rotation_x(roll)
    frame[:3, 3] = np.array([x, y, z]) / _M_PER_MM
    limits = limits_of("x_mm")
    for value in frame[:3, 3].tolist():
        if not limits.accepts(value):
            node.fail(limits.fault(value, f"{value:g}"))
    return frame


def _number(node: Node) -> float:
    """Return the number here; of 1e-05, which YAML 1.1 takes for text, too."""
    if isinstance(node.value, str) and is_number(node.value):
        return Node(node.file, float(node.value), node.path, node.locate).number()
    return node.number()


def is_of_that_structure(robot: Robot) -> bool:
    """Whether a robot has the axes of an arm of Universal Robots: six, 2 to 4 parallel, 5 and 6 across."""
    if robot.n_joints != len(LINKS) or any(row.sign != 1 for row in robot.joints):
        return False
    twists = zip(robot.joints, map(math.radians, _TWISTS_DEG), strict=True)
    return all(math.cos(row.alpha_rad - twist) > math.cos(_TWISTED_RAD) for row, twist in twists)


def kinematics_document(origins: list[tuple[list[float], tuple[float, float, float]]], marked: str) -> str:
    """Return the content of a file: place [mm] and roll, pitch, yaw [rad] of each joint, and its hash."""
    kinematics: dict[str, object] = {}
    for name, (place_mm, (roll, pitch, yaw)) in zip(LINKS, origins, strict=True):
        x, y, z = (_M_PER_MM * value for value in place_mm)
        kinematics[name] = {"x": x, "y": y, "z": z, "roll": roll, "pitch": pitch, "yaw": yaw}
    return yaml.safe_dump({"kinematics": kinematics | {"hash": marked}}, sort_keys=False)


def kinematics_text(subject: Subject) -> str:
    """Return the content of the file.

    Raises
    ------
    UnsuitableModelError
        The model is of another kind of arm.
    """
    if not is_of_that_structure(subject.model.robot):
        raise UnsuitableModelError(
            f"{subject.model.robot.name} does not have the axes of a Universal Robots arm, which this format "
            "describes: export it as URDF."
        )
    frames = [joint_origin(row) for row in subject.arm.robot.joints]
    origins = [(frame[:3, 3].tolist(), roll_pitch_yaw(frame[:3, :3])) for frame in frames]
    comment = "".join(f"# {english(sentence)}\n" for sentence in kinematics_remarks(subject))
    return comment + kinematics_document(origins, _hash(origins))


def kinematics_remarks(subject: Subject) -> Iterator[Message]:
    """Yield what the file does not hold."""
    yield from remarks(subject)
    yield message("exports.ros.arm_only")
    yield message("exports.ros.hash")


def _hash(origins: object) -> str:
    """Return a mark that changes with the numbers; a controller's own is made otherwise."""
    return "truepose_" + hashlib.sha256(repr(origins).encode()).hexdigest()[:16]
