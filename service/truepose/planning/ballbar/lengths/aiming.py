"""Joint targets at which the legs have wanted lengths under a model: Newton's method on the lengths.

The lengths come from a function, so that any model serves: the nominal robot, or an identified one with cups
where it found them. Derivatives are differences; the function is called once per pass with all of them.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Final, TypeAlias

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.errors import ConfigurationError
from truepose.domain.measurement.ballbar import PlannedPose
from truepose.domain.robot import JointRange
from truepose.planning.ballbar.lengths.coding import coded_lengths
from truepose.planning.errors import AimError

Lengths: TypeAlias = Callable[[FloatArray], FloatArray]  # joints (n, J) -> lengths (n, L) [mm]

_DIFFERENCE_RAD: Final = 1e-5  # lengths of 300 mm are right to 1e-10 mm, so derivatives to 1e-5 mm/rad
_PASSES: Final = 20
_MET_MM: Final = 1e-4  # a fifth of the ballbar's scatter
_FARTHEST_RAD: Final = float(np.radians(8.0))  # any joint from where it started
_FLATTEST: Final = 1e-3  # smallest over largest singular value: beyond, a leg cannot be set on its own


def aimed(
    lengths: Lengths,
    joints_rad: Sequence[float] | FloatArray,
    wanted_mm: Sequence[float] | FloatArray,
    ranges: tuple[JointRange, ...] | None = None,
) -> FloatArray:
    """Return joints near the given ones at which the legs have the wanted lengths.

    Parameters
    ----------
    lengths : callable, (n, J) -> (n, L)
        Lengths of the legs [mm] at joints [rad].
    joints_rad : array_like, shape (J,)
        Where to start: the planned pose.
    wanted_mm : array_like, shape (L,)
    ranges : tuple of JointRange, optional
        That the joints must not leave.

    Returns
    -------
    ndarray, shape (J,)
        On the branch of the start: no joint moved by more than 8 deg, no singular arm on the way.

    Raises
    ------
    AimError
        No such joints are there; it says why.
    ConfigurationError
        The lengths are not as many as those wanted.
    """
    start = np.asarray(joints_rad, dtype=float)
    wanted = np.asarray(wanted_mm, dtype=float)
    joints, side = start, 0.0
    for _ in range(_PASSES):
        now, jacobian = _linearised(lengths, joints)
        if now.shape != wanted.shape:
            raise ConfigurationError(f"{wanted.size} lengths are wanted of {now.size} legs.")
        side = _same_side(jacobian, side)
        if np.max(np.abs(wanted - now)) < _MET_MM:
            return _within(joints, ranges)
        step = np.linalg.lstsq(jacobian, wanted - now, rcond=None)[0]
        joints = joints + step
        if np.max(np.abs(joints - start)) > _FARTHEST_RAD:
            raise AimError(
                f"Joint {int(np.argmax(np.abs(joints - start))) + 1} would have to turn by more than "
                f"{np.degrees(_FARTHEST_RAD):.0f} deg to give the legs these lengths: aim the pose at others."
            )
    raise AimError(
        "No joints near the pose give the legs these lengths: "
        f"{np.max(np.abs(wanted - now)):.3f} mm are left."
    )


def _linearised(lengths: Lengths, joints: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Lengths (L,) and their derivatives (L, J)."""
    steps = _DIFFERENCE_RAD * np.eye(len(joints))
    found = np.asarray(lengths(np.concatenate([joints[None], joints + steps, joints - steps])))
    if not np.all(np.isfinite(found)):
        raise AimError("The model gives no lengths at this pose; check the joints and the cups it knows.")
    plus, minus = np.split(found[1:], 2)
    return found[0], np.asarray((plus - minus).T / (2 * _DIFFERENCE_RAD))


def _same_side(jacobian: FloatArray, before: float) -> float:
    """Sign of the determinant, 0 where there is none; refuses a singular arm and one that went through it."""
    values = np.linalg.svd(jacobian, compute_uv=False)
    if values[-1] < _FLATTEST * values[0]:
        raise AimError(
            "The arm or the legs are singular at this pose: their lengths cannot be set one by one."
        )
    rows, columns = jacobian.shape
    side = float(np.sign(np.linalg.det(jacobian))) if rows == columns else 0.0
    if side * before < 0.0:
        raise AimError("The arm would pass a singularity to give the legs these lengths: aim at others.")
    return side


def _within(joints: FloatArray, ranges: tuple[JointRange, ...] | None) -> FloatArray:
    for number, (angle, limit) in enumerate(zip(joints, ranges or (), strict=False), start=1):
        if not limit.lower_rad <= angle <= limit.upper_rad:
            raise AimError(
                f"Joint {number} would have to turn to {np.degrees(angle):.2f} deg, out of its range "
                f"({np.degrees(limit.lower_rad):g} to {np.degrees(limit.upper_rad):g} deg)."
            )
    return joints


def aimed_pose(
    pose: PlannedPose,
    lengths: Lengths,
    nominal_mm: float,
    ranges: tuple[JointRange, ...] | None = None,
) -> PlannedPose:
    """Return a pose with coded lengths under a model; `lengths` are in the order of its legs.

    Raises
    ------
    AimError
        The code cannot be reached near the pose, whichever leg has which level.
    """
    refusals: list[AimError] = []
    for turn in range(len(pose.legs)):
        code = coded_lengths(len(pose.legs), pose.config + turn)
        wanted = tuple(nominal_mm + offset for offset in code.offsets_mm)
        try:
            joints = aimed(lengths, pose.joints_rad, wanted, ranges)
        except AimError as refusal:
            refusals.append(refusal)
        else:
            return replace(pose, joints_rad=tuple(float(q) for q in joints), aimed_mm=wanted)
    raise AimError(f"Configuration {pose.config} cannot be aimed at coded lengths. {refusals[0]}")
