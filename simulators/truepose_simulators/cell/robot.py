"""The robot as its controller moves it: joint state, limits, how long a motion takes, where it stops."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from truepose_simulators.errors import SimulatorError
from truepose_simulators.physics.arm import Arm, Bodies, place_bodies
from truepose_simulators.physics.rigid import FloatArray

# A joint target crosses the wire with at most five decimals of a degree, 9e-8 rad.
_LIMIT_TOLERANCE_RAD = 1e-6
# Enough samples of a motion that no reflector can turn away and back unseen between two of them.
_PATH_SAMPLES = 9
# Two equal pieces of a motion differ by this at most: a target crosses the wire with five decimals.
_SAME_PIECE_RAD = 1e-6


class TargetOutOfRangeError(SimulatorError):
    """A joint target is outside what the controller accepts."""


@dataclass(frozen=True, slots=True)
class SpeedLimits:
    """Upper limits of a motion, as the controller's speed data states them."""

    tool_mm_s: float = 100.0
    orientation_rad_s: float = 0.8726646  # 50 deg/s
    joint_share: float = 1.0  # of the greatest speed of each joint
    at_least_s: float = 0.0  # that the motion takes


@dataclass(frozen=True, slots=True)
class JointMotion:
    """A motion under way or done: all joints start and stop together."""

    path_rad: FloatArray  # (m, J) from start to target
    start_s: float
    duration_s: float

    def joints_at(self, time_s: float) -> FloatArray:
        """Joint angles at a cell time, shape (J,)."""
        target: FloatArray = self.path_rad[-1]
        if time_s >= self.start_s + self.duration_s:
            return target
        share = max(0.0, time_s - self.start_s) / self.duration_s * (len(self.path_rad) - 1)
        low = int(share)
        between: FloatArray = self.path_rad[low] + (share - low) * (
            self.path_rad[low + 1] - self.path_rad[low]
        )
        return between


class Robot:
    """The joint state of the arm; geometry here is nominal, as in any controller."""

    def __init__(self, arm: Arm, home_rad: FloatArray, scatter_mm: float, rng: np.random.Generator) -> None:
        self.arm = arm
        self.direction = np.zeros(arm.n_joints)  # sign of each joint's last motion, 0 before the first
        self.stop_number = 0
        self._scatter_mm = scatter_mm
        self._rng = rng
        self._draw_scatter()
        check_range(arm, home_rad)
        self.motion = JointMotion(home_rad[np.newaxis], 0.0, 0.0)

    @property
    def target_rad(self) -> FloatArray:
        """Where the arm is going or has stopped, shape (J,)."""
        target: FloatArray = self.motion.path_rad[-1]
        return target

    def moving(self, time_s: float) -> bool:
        """Whether the arm is under way."""
        return time_s < self.motion.start_s + self.motion.duration_s

    def start(
        self, waypoints_rad: Sequence[FloatArray], limits: SpeedLimits, tool_mm: FloatArray, time_s: float
    ) -> JointMotion:
        """Set off along waypoints, which are within range; the scatter of the stop is drawn now.

        A move to where the arm already stands is no motion: same stop, same scatter.
        """
        path = self._sampled_path(waypoints_rad)
        if np.array_equal(path[0], path[-1]) and len(waypoints_rad) == 1:
            return JointMotion(path[-1:], time_s, 0.0)
        self._note_direction(path)
        goes_on = self._goes_on(path)
        self.motion = JointMotion(path, time_s, self._duration_s(path, limits, tool_mm))
        self.stop_number += 1
        if not goes_on:
            self._draw_scatter()
        return self.motion

    def _goes_on(self, path: FloatArray) -> bool:
        """Whether a motion is the next of several equal pieces of one, which has one scatter, at its end."""
        before, now = self.motion.path_rad[-1] - self.motion.path_rad[0], path[-1] - path[0]
        return bool(before.any() and np.all(np.abs(now - before) <= _SAME_PIECE_RAD))

    def halt(self, time_s: float) -> None:
        """Stop where the arm is now; the rest of the motion is given up."""
        if not self.moving(time_s):
            return
        motion = self.motion
        here = motion.joints_at(time_s)[np.newaxis]
        past = [motion.joints_at(at) for at in np.linspace(motion.start_s, time_s, _PATH_SAMPLES)[:-1]]
        self.motion = JointMotion(np.concatenate([past, here]), motion.start_s, time_s - motion.start_s)
        self.stop_number += 1

    def _sampled_path(self, waypoints_rad: Sequence[FloatArray]) -> FloatArray:
        if len(waypoints_rad) > 1:
            return np.array([self.target_rad, *waypoints_rad])
        share = np.linspace(0.0, 1.0, _PATH_SAMPLES)[:, np.newaxis]
        start, target = self.target_rad, waypoints_rad[0]
        path: FloatArray = start + share * (target - start)
        # To the last bit: start + (target - start) may miss the target, and the same target sent again would
        # then be another motion, with another scatter.
        path[-1] = target
        return path

    def _note_direction(self, path: FloatArray) -> None:
        for step in np.diff(path, axis=0):
            self.direction = np.where(step == 0.0, self.direction, np.sign(step))

    def _draw_scatter(self) -> None:
        self.scatter_mm = self._scatter_mm * self._rng.standard_normal(3)

    def _duration_s(self, path: FloatArray, limits: SpeedLimits, tool_mm: FloatArray) -> float:
        """Time that the slowest of joints, tool point and tool orientation needs."""
        speeds_rad_s = limits.joint_share * self.arm.speeds_rad_s
        joints_s = float(np.max(np.abs(np.diff(path, axis=0)).sum(axis=0) / speeds_rad_s))
        frames = nominal_flange(self.arm, path)
        points = frames[:, :3, :3] @ tool_mm + frames[:, :3, 3]
        length_mm = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
        turns = np.swapaxes(frames[:-1, :3, :3], 1, 2) @ frames[1:, :3, :3]
        cosines = (np.trace(turns, axis1=1, axis2=2) - 1.0) / 2.0
        turned_rad = float(np.arccos(np.clip(cosines, -1.0, 1.0)).sum())
        tool_s = max(length_mm / limits.tool_mm_s, turned_rad / limits.orientation_rad_s)
        return max(joints_s, tool_s, limits.at_least_s)


def check_range(arm: Arm, target_rad: FloatArray) -> None:
    """Raise TargetOutOfRangeError when a joint would leave its range."""
    lower, upper = arm.limits_rad.T
    outside = (target_rad < lower - _LIMIT_TOLERANCE_RAD) | (target_rad > upper + _LIMIT_TOLERANCE_RAD)
    if outside.any():
        joint = int(np.argmax(outside))
        raise TargetOutOfRangeError(
            f"joint {joint + 1} cannot go to {np.degrees(target_rad[joint]):.3f} deg: its range is"
            f" {np.degrees(lower[joint]):.0f} to {np.degrees(upper[joint]):.0f}"
        )


def nominal_bodies(arm: Arm, joints_rad: FloatArray) -> Bodies:
    """Place the bodies of the arm as its maker means it to be, of joints (n, J)."""
    return place_bodies(arm, np.broadcast_to(np.eye(4), (arm.n_joints + 2, 4, 4)), joints_rad)


def nominal_flange(arm: Arm, joints_rad: FloatArray) -> FloatArray:
    """Flange frame of the arm as its maker means it to be, (n, J) -> (n, 4, 4)."""
    return nominal_bodies(arm, joints_rad).last_frame
