"""The arm stretched out level: the configuration in which sagging is quoted."""

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.measurement.campaign import Stops
from truepose.domain.robot import Robot
from truepose.effects.ports import Rows, known_frames
from truepose.kinematics.chain import nominal_chain

_UPRIGHT_M_S2 = (0.0, 0.0, -9.81)  # the base stands upright for this figure, however it stands in the cell
_DEGREES = np.arange(-179.0, 181.0)
_ANGLES_RAD = np.deg2rad(_DEGREES[np.argsort(np.abs(_DEGREES), kind="stable")])  # 0 first: joints that do
_SAME_MM = 1e-6  # not matter stay there
_SWEEPS = 10  # joint by joint; of arms with two or three long links the last ones change nothing


def stretched_rows(robot: Robot) -> Rows:
    """Return one row with the flange of the nominal robot as far out as its joints let it be."""
    joints = np.zeros(robot.n_joints)
    for _ in range(_SWEEPS):
        for joint in range(2, robot.n_joints):
            joints = _farthest(robot, joints, joint, level=False)
    joints = _farthest(robot, joints, 1, level=True)
    stops = Stops(np.zeros(1, dtype=np.int64), joints[None])
    return Rows(
        stops=stops,
        nest=np.ones(1, dtype=np.int64),
        torque_n_mm=None,
        turn_rad=joints[None] * np.array([row.sign for row in robot.joints]),
        frames=known_frames(nominal_chain(robot, joints[None])),
        gravity_m_s2=np.array(_UPRIGHT_M_S2),
        robot=robot,
    )


def _farthest(robot: Robot, joints_rad: FloatArray, joint: int, *, level: bool) -> FloatArray:
    """Turn one joint (0-based) so that the flange is farthest from joint 2, or farthest out."""
    tried = np.repeat(joints_rad[None], len(_ANGLES_RAD), axis=0)
    tried[:, joint] = _ANGLES_RAD
    chain = nominal_chain(robot, tried)
    away = chain.end_origin - chain.origin[1]
    distance = np.linalg.norm(away[:, :2] if level else away, axis=1)
    farthest: FloatArray = tried[int(np.argmax(distance >= distance.max() - _SAME_MM))]
    return farthest
