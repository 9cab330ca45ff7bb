"""What follows loads and moves without a name: bearings that tilt, friction that grows, joints that lag.

With M_i the moment of all weights beyond joint i about its origin, tau_i that about its axis:

    tilt     the link's body turns by       c (M_x, M_y)                in the link's axes
    mount    the tool turns by c (M_x, M_y), and shifts by k (F_x, F_y)        about one axis or both
    rub      theta_i moves by               -r sign_i dir_i |tau_i|     friction that follows the load
    lag      theta_i moves by               -share sign_i move_i        move: since the stop before

Own derivations: each is the simplest law that is linear in one parameter.
"""

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.effects.arm.backlash import from_both_sides
from truepose.effects.arm.compliance import known_torque
from truepose.effects.causes import SPRING, Limits, Scene
from truepose.effects.names import joint_subject
from truepose.effects.ports import Port, PortKind, Rows, motion_port
from truepose.effects.unclassified.kinds import (
    ALONE,
    STEADY,
    Key,
    Kind,
    Moves,
    Part,
    Place,
    Size,
    Variants,
    once,
)
from truepose.kinematics.chain import Chain
from truepose.kinematics.gravity import gravity_moments
from truepose.messages.message import Message, message

# Belief: a bearing stands moments across its axis several times better than its gear does those about it.
_TILT = 1e-6  # rad/(N mm)
_RUB = 1e-6  # rad/(N mm), belief: friction that holds a joint off as far as its gearbox winds up
_FRICTION = Limits(0.0, np.inf, message("limits.friction"))
_SHIFT = 2e-3  # mm/N, belief: what shifts visibly by hand
_FIRST_BEARING = 2  # what the first one carries tilts with the base
_FIRST_TURN = 3  # components 3..5 of a motion
_SMALLEST_LOAD_N_MM = 1.0
# Axes of the flange frame about which a mount is soft; it shifts along the other one, as a cantilever does.
_SOFT_ABOUT = {"any": (0, 1), "x": (0,), "y": (1,)}


def _bearings(scene: Scene) -> list[Place]:
    robot = scene.setting.robot
    if not robot.masses:
        return []
    moments = gravity_moments(scene.chain, robot.masses, np.array(scene.gravity_m_s2))
    joints = range(_FIRST_BEARING, robot.n_joints)  # what the last one carries tilts with the flange
    return [(j,) for j in joints if _largest(_across(scene.chain, j, moments)) > _SMALLEST_LOAD_N_MM]


def _tilts(key: Key, rows: Rows) -> Moves:
    joint = key.place[0]
    moments = gravity_moments(rows.chain, rows.robot.masses, rows.gravity_m_s2)
    across = _across(rows.chain, joint, moments)
    return [(motion_port(joint, _FIRST_TURN + axis), across[:, axis]) for axis in range(2)]


def _across(chain: Chain, joint: int, moments: FloatArray) -> FloatArray:
    """Return the moment on a bearing along the two axes of its link across its own.

    Parameters
    ----------
    chain : Chain
        n configurations.
    joint : int
        1-based.
    moments : ndarray, shape (J, n, 3)
        In the world [N mm], as of `gravity_moments`.

    Returns
    -------
    ndarray, shape (n, 2)
        [N mm]
    """
    in_link: FloatArray = np.einsum("nij,ni->nj", chain.rotation[joint - 1], moments[joint - 1])
    return in_link[:, :2]


def _mount(scene: Scene) -> list[Place]:
    """Return the flange where the weight of a tool turns it."""
    robot = scene.setting.robot
    carried = gravity_moments(scene.chain, robot.masses, np.array(scene.gravity_m_s2))
    return [ALONE] if _largest(_across(scene.chain, robot.n_joints, carried)) > _SMALLEST_LOAD_N_MM else []


def _axes(_scene: Scene) -> Variants:
    # A plate gives about both axes, a bracket about one: which, nobody knows before.
    return [("any", 0.0), ("x", 1.0), ("y", 2.0)]


def _gives(key: Key, rows: Rows) -> Moves:
    """Tilt the tool about axes of the flange frame by the moment of its weight; shift it by that weight.

    A mount that is soft about x gives along y, and the other way round, as a cantilever along z does.
    """
    body, soft = rows.robot.n_joints, _SOFT_ABOUT[key.variant]
    if key.part == "tilt":
        moments = gravity_moments(rows.chain, rows.robot.masses, rows.gravity_m_s2)
        about = _across(rows.chain, body, moments)
        return [(motion_port(body, _FIRST_TURN + axis), about[:, axis]) for axis in soft]
    weight_n = _tool_weight_n(rows)
    return [(motion_port(body, 1 - axis), weight_n[:, 1 - axis]) for axis in soft]


def _tool_weight_n(rows: Rows) -> FloatArray:
    """Return the weight of the tool in the axes of the flange frame, shape (n, 3) [N]."""
    mass_kg = sum(link.mass_kg for link in rows.robot.masses if link.frame == rows.robot.n_joints)
    weight: FloatArray = np.einsum("nij,i->nj", rows.chain.rotation[-1], mass_kg * rows.gravity_m_s2)
    return weight


def _largest(loads: FloatArray) -> float:
    """Return the largest norm of loads (n, ..), NaN as 0."""
    return float(np.linalg.norm(np.nan_to_num(loads), axis=-1).max())


def _rubbing(scene: Scene) -> list[Place]:
    if scene.torque_n_mm is None or scene.stops.direction is None:
        return []
    load, known = np.abs(scene.torque_n_mm), np.isfinite(scene.torque_n_mm)
    largest = np.max(load, axis=0, where=known, initial=0.0)
    least = np.min(load, axis=0, where=known, initial=np.inf)
    loaded = largest - least > _SMALLEST_LOAD_N_MM  # an even load is backlash
    return [(joint + 1,) for joint in from_both_sides(scene.stops.direction) if loaded[joint]]


def _rubs(key: Key, rows: Rows) -> Moves:
    """Return -sign dir |tau| [N mm] on the joint's theta: friction holds it off on the side it came from."""
    joint = key.place[0] - 1
    port = Port(PortKind.THETA, joint)
    if rows.stops.direction is None:
        return [(port, np.zeros(len(rows.stops)))]
    way = rows.robot.joints[joint].sign * np.sign(rows.stops.direction[:, joint])
    # Friction follows the size of the load, whichever way it points, and always holds the joint back.
    return [(port, -way * np.abs(known_torque(rows, joint)))]


def _of_tilt(key: Key, size: Size, scene: Scene) -> Message:
    masses = scene.setting.robot.masses
    moments = gravity_moments(scene.chain, masses, np.array(scene.gravity_m_s2))
    most_deg = float(np.rad2deg(size.amplitude * _largest(_across(scene.chain, key.place[0], moments))))
    joint = joint_subject(key.place[0] - 1)
    return message("causes.bearing_tilts", joint=joint, compliance=size.amplitude, most_deg=most_deg)


def _of_mount(key: Key, size: Size, scene: Scene) -> Message:
    robot = scene.setting.robot
    moments = gravity_moments(scene.chain, robot.masses, np.array(scene.gravity_m_s2))
    soft = list(_SOFT_ABOUT[key.variant])
    largest = _largest(_across(scene.chain, robot.n_joints, moments)[:, soft])
    return message(
        "causes.flange_gives",
        about=message("causes.flange_gives.about", axis=key.variant) if len(soft) == 1 else "",
        compliance=size.amplitude,
        most_deg=float(np.rad2deg(size.amplitude * largest)),
    )


def _of_rub(key: Key, size: Size, scene: Scene) -> Message:
    joint = key.place[0] - 1
    largest = 0.0 if scene.torque_n_mm is None else float(np.nanmax(np.abs(scene.torque_n_mm[:, joint])))
    most_deg = float(np.rad2deg(size.amplitude * largest))
    return message("causes.friction", joint=joint_subject(joint), most_deg=most_deg)


_OF_LOADS = (
    Kind(
        "tilt", "line", (Part("tilt", "rad/(N*mm)", _TILT),), lambda place: f"link {place[0]}",
        once("load"), _bearings, lambda _scene: STEADY, _tilts, _of_tilt, limits=SPRING,
    ),
    Kind(
        "mount", "line", (Part("tilt", "rad/(N*mm)", _TILT), Part("shift", "mm/N", _SHIFT)),
        once("flange"), once("load"), _mount, _axes, _gives, _of_mount, limits=SPRING,
    ),
    Kind(
        "rub", "sign", (Part("turn", "rad/(N*mm)", _RUB),), lambda place: joint_subject(place[0] - 1),
        lambda place: f"torque of joint {place[0]}", _rubbing, lambda _scene: STEADY, _rubs, _of_rub,
        limits=_FRICTION, needs=frozenset({"torque", "direction"}),
    ),
)  # fmt: skip


_SHARE = 1e-3  # belief: 0.05 deg after 50 deg, five times what an operator sees creeping
_SMALLEST_MOVE_RAD = np.deg2rad(5.0)  # root mean square; over less, a share of a move is nothing


def _moving(scene: Scene) -> list[Place]:
    if scene.stops.move_rad is None:
        return []
    # Over the moves that are known: others, counted as 0, would hide a joint that moves far now and then.
    known = np.isfinite(scene.stops.move_rad).sum(axis=0)
    usual = np.sqrt(np.nansum(scene.stops.move_rad**2, axis=0) / np.maximum(known, 1))
    return [(joint,) for joint in (np.flatnonzero(usual >= _SMALLEST_MOVE_RAD) + 1).tolist()]


def _lags(key: Key, rows: Rows) -> Moves:
    """Return -sign move [rad] on the joint's theta: a joint that lags stays behind by a share of its move."""
    joint = key.place[0] - 1
    port = Port(PortKind.THETA, joint)
    if rows.stops.move_rad is None:
        return [(port, np.zeros(len(rows.stops)))]
    return [(port, -rows.robot.joints[joint].sign * np.nan_to_num(rows.stops.move_rad[:, joint]))]


def _of_lag(key: Key, size: Size, scene: Scene) -> Message:
    joint, moves = key.place[0] - 1, scene.stops.move_rad
    largest = 0.0 if moves is None else float(np.nanmax(np.abs(moves[:, joint])))
    most_deg = float(np.rad2deg(size.amplitude * largest))
    return message("causes.lag", joint=joint_subject(joint), share=size.amplitude, most_deg=most_deg)


_OF_MOVES = (
    Kind(
        "lag", "line", (Part("share", "1", _SHARE),), lambda place: joint_subject(place[0] - 1),
        once("last move"), _moving, lambda _scene: STEADY, _lags, _of_lag, needs=frozenset({"move"}),
    ),
)  # fmt: skip

KINDS = _OF_LOADS + _OF_MOVES
