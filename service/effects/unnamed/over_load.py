"""What follows loads without a name: bearings that tilt, friction that grows with the load."""

import numpy as np

from service.domain.arrays import FloatArray
from service.effects.backlash import from_both_sides
from service.effects.causes import SPRING, Limits, Scene
from service.effects.compliance import known_torque
from service.effects.names import joint_subject
from service.effects.ports import Port, PortKind, Rows, motion_port
from service.effects.unnamed.kinds import STEADY, Key, Kind, Moves, Part, Place, Size, once
from service.kinematics.chain import Chain
from service.kinematics.gravity import gravity_moments

# Belief: a bearing stands moments across its axis several times better than its gear does those about it.
_TILT = 1e-6  # rad/(N mm)
_RUB = 1e-6  # rad/(N mm), belief: friction that holds a joint off as far as its gearbox winds up
_FRICTION = Limits(0.0, np.inf, "friction cannot push")
_FIRST_BEARING = 2  # what the first one carries tilts with the base
_FIRST_TURN = 3  # components 3..5 of a motion
_SMALLEST_LOAD_N_MM = 1.0


def _bearings(scene: Scene) -> list[Place]:
    robot = scene.setting.robot
    if not robot.masses:
        return []
    moments = gravity_moments(scene.chain, robot.masses, np.array(scene.gravity_m_s2))
    joints = range(_FIRST_BEARING, robot.n_joints + 1)
    return [(j,) for j in joints if _largest(_across(scene.chain, j, moments)) > _SMALLEST_LOAD_N_MM]


def _tilts(key: Key, rows: Rows) -> Moves:
    joint = key.place[0]
    moments = gravity_moments(rows.chain, rows.robot.masses, rows.gravity_m_s2)
    across = _across(rows.chain, joint, moments)
    return [(motion_port(joint, _FIRST_TURN + axis), across[:, axis]) for axis in range(2)]


def _across(chain: Chain, joint: int, moments: FloatArray) -> FloatArray:
    """Return the moment on a bearing along the two axes of its link across its own, shape (n, 2) [N mm]."""
    in_link: FloatArray = np.einsum("nij,ni->nj", chain.rotation[joint - 1], moments[joint - 1])
    return in_link[:, :2]


def _largest(loads: FloatArray) -> float:
    return float(np.linalg.norm(np.nan_to_num(loads), axis=-1).max())


def _rubbing(scene: Scene) -> list[Place]:
    if scene.torque_n_mm is None or scene.stops.direction is None:
        return []
    load = np.nan_to_num(scene.torque_n_mm)
    loaded = np.ptp(np.abs(load), axis=0) > _SMALLEST_LOAD_N_MM  # an even load is backlash
    return [(joint + 1,) for joint in from_both_sides(scene.stops.direction) if loaded[joint]]


def _rubs(key: Key, rows: Rows) -> Moves:
    joint = key.place[0] - 1
    port = Port(PortKind.THETA, joint)
    if rows.stops.direction is None:
        return [(port, np.zeros(len(rows.stops)))]
    way = rows.robot.joints[joint].sign * np.sign(rows.stops.direction[:, joint])
    return [(port, -way * np.abs(known_torque(rows, joint)))]


def _of_tilt(key: Key, size: Size, scene: Scene) -> str:
    masses = scene.setting.robot.masses
    moments = gravity_moments(scene.chain, masses, np.array(scene.gravity_m_s2))
    largest = np.rad2deg(size.amplitude * _largest(_across(scene.chain, key.place[0], moments)))
    return (
        f"The bearing of joint {key.place[0]} tilts under the moment across its axis, by "
        f"{size.amplitude:.1e} rad/(N*mm): up to {largest:.4f} deg in these configurations."
    )


def _of_rub(key: Key, size: Size, scene: Scene) -> str:
    joint = key.place[0] - 1
    largest = 0.0 if scene.torque_n_mm is None else float(np.nanmax(np.abs(scene.torque_n_mm[:, joint])))
    return (
        f"Joint {joint + 1} stops short of where it is sent, the farther the larger its load: by "
        f"up to {np.rad2deg(size.amplitude * largest):.4f} deg, as friction that follows the load does."
    )


KINDS = (
    Kind(
        "tilt", "line", (Part("tilt", "rad/(N*mm)", _TILT),), lambda place: f"link {place[0]}",
        once("load"), _bearings, lambda _scene: STEADY, _tilts, _of_tilt, limits=SPRING,
    ),
    Kind(
        "rub", "sign", (Part("turn", "rad/(N*mm)", _RUB),), lambda place: joint_subject(place[0] - 1),
        lambda place: f"torque of joint {place[0]}", _rubbing, lambda _scene: STEADY, _rubs, _of_rub,
        limits=_FRICTION, needs=frozenset({"torque", "direction"}),
    ),
)  # fmt: skip
