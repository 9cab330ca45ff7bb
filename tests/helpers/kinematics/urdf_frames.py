"""Frames of a URDF, read from the format's specification alone: nothing of the service, in metres.

wiki.ros.org/urdf/XML/joint: a joint's <origin> places the child in the parent, `rpy` about the fixed axes
x, y, z; then it turns about <axis>, given in the joint's own frame, which is the child's.
"""

import math
import xml.etree.ElementTree as ElementTree
from functools import cache

import numpy as np


def _numbers(element, name, absent):
    return np.array([float(x) for x in element.get(name, absent).split()]) if element is not None else None


def _about(axis, angle):
    """Rodrigues' formula about a unit vector."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross


def _origin(joint):
    frame, origin = np.eye(4), joint.find("origin")
    if origin is not None:
        roll, pitch, yaw = _numbers(origin, "rpy", "0 0 0")
        turn = _about((0, 0, 1), yaw) @ _about((0, 1, 0), pitch) @ _about((1, 0, 0), roll)
        frame[:3, :3], frame[:3, 3] = turn, _numbers(origin, "xyz", "0 0 0")
    return frame


def frames(text, joints):
    """Where every link is in the root link [m], moving joints at these angles in the file's order."""
    links, placed = _read(text)
    angles = iter(joints)
    motions = {}
    for parent, child, origin, axis in placed:
        motion = origin
        if axis is not None:
            turn = np.eye(4)
            turn[:3, :3] = _about(axis, next(angles))
            motion = origin @ turn
        motions[child] = (parent, motion)
    return {link: _placed(link, motions) for link in links}


@cache
def _read(text):
    """Names of links; of each joint parent, child, origin and, where it moves, the direction of its axis."""
    root = ElementTree.fromstring(text)
    joints = [
        (joint.find("parent").get("link"), joint.find("child").get("link"), _origin(joint), _axis(joint))
        for joint in root.findall("joint")
    ]
    return [link.get("name") for link in root.findall("link")], joints


def _axis(joint):
    if joint.get("type") == "fixed":
        return None
    axis = joint.find("axis")
    direction = np.array([1.0, 0, 0]) if axis is None else _numbers(axis, "xyz", "1 0 0")
    return direction / np.linalg.norm(direction)


def _placed(link, motions):
    frame = np.eye(4)
    while link in motions:
        link, motion = motions[link]
        frame = motion @ frame
    return frame
