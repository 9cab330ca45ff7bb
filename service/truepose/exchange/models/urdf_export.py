"""An identified arm as URDF: links, joints with full digits, tool and nests as fixed frames.

A row of the table is TransX(a) RotX(alpha) RotY(beta) TransZ(d) RotZ(theta_offset), the origin of its joint,
and then the turn about z. Bodies are drawn as sticks from joint to joint, so that a viewer shows an arm.
Source of the format: wiki.ros.org/urdf/XML.
"""

import math
import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterable, Iterator
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.robot import JointRange, JointRow, LinkMass
from truepose.exchange.models.rigid_arm import Subject, remarks
from truepose.kinematics.frames import (
    angles_xyz,
    placement_rotation,
    placement_translation,
    rotation_x,
    rotation_xyz,
    rotation_y,
    rotation_z,
)
from truepose.messages.catalogue import english
from truepose.messages.message import Message, message

_M_PER_MM: Final = 1e-3
_WORLD, _BASE, _TOOL = "world", "base_link", "tool0"
_STICK_SHARE: Final = 0.04  # radius of a stick, of the longest one
_NEST_RADIUS_M: Final = 0.00635  # a reflector of half an inch
_SHORTEST_STICK_M: Final = 1e-3


def urdf_text(subject: Subject) -> str:
    """Return the content of a URDF."""
    root = ElementTree.Element("robot", name=_legal(subject.model.robot.name))
    root.append(ElementTree.Comment(_comment(subject)))
    root.extend(_links(subject))
    root.extend(_joints(subject))
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="utf-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def urdf_remarks(subject: Subject) -> Iterator[Message]:
    """Yield what a URDF of a model does not say."""
    yield from remarks(subject)
    yield message("exports.urdf.unknown")
    if subject.model.robot.joint_limits is None:
        yield message("exports.urdf.no_limits")


def _comment(subject: Subject) -> str:
    lines = (subject.model.robot.name, *map(english, urdf_remarks(subject)))
    printable = ("".join(letter for letter in line if letter.isprintable()) for line in lines)
    # Two dashes would end a comment.
    return "\n" + "".join(f"    {re.sub('-(?=-)', '- ', line)}\n" for line in printable) + "  "


def _legal(name: str) -> str:
    """Return a name of letters, digits and underscores, as ROS takes it."""
    plain = re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_")
    return plain if plain[:1].isalpha() else f"robot_{plain}".rstrip("_")


def _links(subject: Subject) -> Iterator[ElementTree.Element]:
    origins = [joint_origin(row) for row in subject.arm.robot.joints]
    steps = [origin[:3, 3] * _M_PER_MM for origin in origins]
    radius = _STICK_SHARE * max(float(np.linalg.norm(step)) for step in steps)
    yield ElementTree.Element("link", name=_WORLD)
    for number in range(len(steps) + 1):
        link = ElementTree.Element("link", name=_link(number))
        if number < len(steps):
            link.extend(_stick(steps[number], radius))
        link.extend(_inertial([mass for mass in subject.model.robot.masses if mass.frame == number]))
        yield link
    yield ElementTree.Element("link", name=_TOOL)
    for nest in subject.arm.nests:
        link = ElementTree.Element("link", name=_nest(nest.nest))
        _drawn(link, "sphere", radius=_number(_NEST_RADIUS_M))
        yield link


def _stick(step_m: FloatArray, radius_m: float) -> Iterator[ElementTree.Element]:
    """Draw a cylinder from a link's origin to the joint that it carries."""
    length = float(np.linalg.norm(step_m))
    if length < _SHORTEST_STICK_M:
        return
    x, y, z = step_m.tolist()
    body = ElementTree.Element("body")
    visual = _drawn(body, "cylinder", radius=_number(radius_m), length=_number(length))
    visual.insert(0, _placed(step_m / 2.0, (0.0, math.acos(z / length), math.atan2(y, x))))
    yield visual


def _drawn(link: ElementTree.Element, shape: str, **sizes: str) -> ElementTree.Element:
    visual = ElementTree.SubElement(link, "visual")
    ElementTree.SubElement(ElementTree.SubElement(visual, "geometry"), shape, sizes)
    return visual


def _inertial(masses: list[LinkMass]) -> Iterator[ElementTree.Element]:
    """Yield the mass of a link and its centre; there is none of a link without masses."""
    total = sum(mass.mass_kg for mass in masses)
    if not total:
        return
    centre = sum(mass.mass_kg * np.array(mass.centre_of_gravity_mm) for mass in masses) / total
    inertial = ElementTree.Element("inertial")
    inertial.append(_placed(_M_PER_MM * np.asarray(centre), (0.0, 0.0, 0.0)))
    ElementTree.SubElement(inertial, "mass", value=_number(total))
    ElementTree.SubElement(
        inertial, "inertia", dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), "0")
    )
    yield inertial


def _joints(subject: Subject) -> Iterator[ElementTree.Element]:
    arm = subject.arm
    base = _frame(placement_rotation(arm.base), placement_translation(arm.base))
    yield _joint("base_joint", "fixed", (_WORLD, _BASE), base)
    limits: Iterable[JointRange | None] = subject.model.robot.joint_limits or (None,) * arm.robot.n_joints
    for number, (row, limit) in enumerate(zip(arm.robot.joints, limits, strict=True), start=1):
        yield _turning(number, row, limit)
    last = _link(arm.robot.n_joints)
    tool = _frame(rotation_xyz(*arm.tool_rotation_rad), np.zeros(3))
    yield _joint("tool_joint", "fixed", (last, _TOOL), tool)
    for nest in arm.nests:
        frame = _frame(np.eye(3), np.array(nest.centre_mm))
        yield _joint(f"{_nest(nest.nest)}_joint", "fixed", (last, _nest(nest.nest)), frame)


def _turning(number: int, row: JointRow, limit: JointRange | None) -> ElementTree.Element:
    kind = "continuous" if limit is None else "revolute"
    joint = _joint(f"joint_{number}", kind, (_link(number - 1), _link(number)), joint_origin(row))
    ElementTree.SubElement(joint, "axis", xyz=f"0 0 {row.sign}")
    if limit is not None:
        ends = {"lower": _number(limit.lower_rad), "upper": _number(limit.upper_rad)}
        ElementTree.SubElement(joint, "limit", ends | {"effort": "0", "velocity": "0"})
    return joint


def _joint(name: str, kind: str, ends: tuple[str, str], frame: FloatArray) -> ElementTree.Element:
    joint = ElementTree.Element("joint", name=name, type=kind)
    joint.append(_placed(_M_PER_MM * frame[:3, 3], roll_pitch_yaw(frame[:3, :3])))
    for which, link in zip(("parent", "child"), ends, strict=True):
        ElementTree.SubElement(joint, which, link=link)
    return joint


def _placed(place_m: FloatArray, angles_rad: Iterable[float]) -> ElementTree.Element:
    xyz, rpy = (" ".join(map(_number, values)) for values in (place_m.tolist(), angles_rad))
    return ElementTree.Element("origin", xyz=xyz, rpy=rpy)


def joint_origin(row: JointRow) -> FloatArray:
    """Return where a joint is in the frame before it while it reads zero, shape (4, 4) [mm]."""
    leaning = rotation_x(row.alpha_rad) @ rotation_y(row.beta_rad)
    place = np.array([row.a_mm, 0.0, 0.0]) + row.d_mm * leaning[:, 2]
    return _frame(leaning @ rotation_z(row.theta_offset_rad), place)


def roll_pitch_yaw(rotation: FloatArray) -> tuple[float, float, float]:
    """Return the angles about fixed x, y, z [rad] of a rotation RotZ(yaw) RotY(pitch) RotX(roll)."""
    roll, pitch, yaw = angles_xyz(rotation.T)
    return -roll, -pitch, -yaw


def _frame(rotation: FloatArray, place_mm: FloatArray) -> FloatArray:
    frame = np.eye(4)
    frame[:3, :3], frame[:3, 3] = rotation, place_mm
    return frame


def _link(number: int) -> str:
    return f"link_{number}" if number else _BASE


def _nest(number: int) -> str:
    return f"nest_{number}"


def _number(value: float) -> str:
    """Return a number with all its digits; no zero has a sign."""
    return repr(float(value) + 0.0)
