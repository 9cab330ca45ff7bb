"""Joints over the whole range of a robot, and models of robots that are off."""

import numpy as np

from tests.helpers.exchange import other_controller as other
from tests.helpers.identification.models import model_of, parameters_of

_NEAR = np.radians(0.3)
_SINGULAR = 0.06
_HALF = np.pi / 4
# Where no limits are known: those of a FANUC LR Mate, with joint 3 counted from the upper arm.
_USUAL = np.radians([[-170, 170], [-60, 140], [-100, 100], [-190, 190], [-120, 120], [-360, 360]])


def erring_model(robot, seed, size=1.0):
    """A robot that is off by some tenths of a degree and millimetres, softly sprung."""
    rng = np.random.default_rng(seed)
    kinds = (("alpha", 1.5e-3, "rad"), ("a", 0.4, "mm"), ("theta", 3e-3, "rad"), ("d", 0.4, "mm"))
    names = [(f"{kind}_{row}", width, unit) for row in range(2, 7) for kind, width, unit in kinds]
    geometry = [(name, size * width * rng.standard_normal(), unit) for name, width, unit in names]
    parameters = parameters_of("geometry", geometry)
    return model_of(robot, *parameters)


def drawn_joints(robot, n, seed, *, hard=True):
    """Joints over the whole range; if hard, six tenths at singularities, borders of turns and limits."""
    rng = np.random.default_rng(seed)
    low, high = _limits(robot)
    joints = rng.uniform(low, high, (n, 6))
    kind = rng.integers(0, 10, n) if hard else np.full(n, 9)
    joints[kind == 0, 4] = rng.uniform(-_SINGULAR, _SINGULAR, (kind == 0).sum())  # the wrist stretched
    stretched = _stretched(robot) + rng.uniform(-_SINGULAR, _SINGULAR, n)
    joints[kind == 1, 2] = stretched[kind == 1]
    axis = rng.choice([0, 3, 5], n)
    border = np.clip(rng.integers(-4, 5, n) * other.QUARTER, low[axis], high[axis])
    some = np.isin(kind, (2, 3))
    joints[some, axis[some]] = (border + rng.uniform(-_NEAR, _NEAR, n))[some]
    at = np.where(rng.random((n, 6)) < 0.5, low, high)
    joints[kind == 4] = np.where(rng.random((n, 6)) < 0.3, at, joints)[kind == 4]
    over = _over_axis_1(robot, joints)
    joints[kind == 5] = over[kind == 5]
    exactly = np.where(rng.random((n, 6)) < 0.5, np.round(joints / _HALF) * _HALF, joints)
    joints[kind == 6] = exactly[kind == 6]  # zeros and right angles, as people teach them
    return np.clip(joints, low, high)


def _limits(robot):
    if robot.joint_limits is None:
        return _USUAL.T
    return np.array([(r.lower_rad, r.upper_rad) for r in robot.joint_limits]).T


def _stretched(robot):
    """Joint 3 at which forearm and upper arm are one line."""
    angles = np.linspace(-np.pi, np.pi, 3601)
    joints = np.zeros((len(angles), 6))
    joints[:, 2] = angles
    frames = [other.transform(robot, joints, 0, k)[:, :3, 3] for k in (2, 4)]
    return angles[np.argmax(np.linalg.norm(frames[1] - frames[0], axis=1))]


def _over_axis_1(robot, joints):
    """The same with joint 2 so that the wrist is nearest to axis 1, within some millimetres."""
    best = joints.copy()
    away = np.full(len(joints), np.inf)
    for angle in np.linspace(-np.pi, np.pi, 181):
        tried = joints.copy()
        tried[:, 1] = angle
        now = np.linalg.norm(other.transform(robot, tried, 0, 4)[:, :2, 3], axis=1)
        best[now < away], away = tried[now < away], np.minimum(now, away)
    return best
