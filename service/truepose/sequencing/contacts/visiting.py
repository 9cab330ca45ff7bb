"""One stop of a session of closed loops: there, slowly, the gauges looked at between; read; and back.

The arm moves with a gauge touched, on purpose. So it creeps, by steps shorter than half a stroke, and after
each of them the gauges are asked whether the next one has room.
"""

from itertools import pairwise
from typing import Final

import numpy as np

from truepose.domain.measurement.contacts import FREE_PLACES, ContactPlan, ContactStop, ContactTaken, Joints
from truepose.domain.measurement.session import Vector
from truepose.sequencing.contacts.cell import ContactCell
from truepose.sequencing.contacts.gauges import Gauges
from truepose.sequencing.contacts.nudges import nudged, straight_mm
from truepose.sequencing.engine.motion.arm import Arm
from truepose.sequencing.engine.motion.interlocks import joint_outside
from truepose.sequencing.engine.motion.limits import binding_speed, motion_limits, slowest
from truepose.sequencing.engine.motion.rest_of_way import rest_of_way
from truepose.sequencing.errors import ReadingRejectedError
from truepose_drivers.api import MotionLimits
from truepose_drivers.errors import MeasurementFailedError

_MOST_NUDGES: Final = 6
_NEAR_RAD: Final = 0.05  # about a stop, hence perhaps in touch with its target


class Visiting:
    """Goes to stops and reads the gauges there."""

    def __init__(self, plan: ContactPlan, cell: ContactCell, arm: Arm, gauges: Gauges) -> None:
        self._plan = plan
        self._cell = cell
        self._arm = arm
        self._gauges = gauges
        self._fast = binding_speed(plan, cell.speed_limits)
        self._slow = slowest(
            self._fast, MotionLimits(plan.touch_speed_mm_s, self._fast.orientation_speed_rad_s)
        )
        self._begin: Joints | None = None  # where nothing is near, while the arm stands there

    def forget(self) -> None:
        """Forget where the arm was left: a person had it since."""
        self._begin = None

    async def visit(self, stop: ContactStop) -> ContactTaken:
        """Return what the gauges read at a stop; raises what the devices and the checks raise."""
        if not self._plan.touches:
            await self._arm.move(stop.joints_rad)
            return await self._read_at(stop, stop.joints_rad)
        await self._go_to_begin(stop)
        try:
            taken = await self._approach_and_read(stop)
        except (ReadingRejectedError, MeasurementFailedError):
            await self._leave(stop)
            raise
        await self._leave(stop)
        return taken

    async def _go_to_begin(self, stop: ContactStop) -> None:
        """Go where nothing is near; from a place that nobody knows slowly, by the way that led there."""
        if self._begin is None:
            await self._leave(stop)
        await self._cell.robot_controller.set_limits(self._fast)
        if self._begin != stop.way_rad[0]:
            await self._arm.move(stop.way_rad[0])

    async def _leave(self, stop: ContactStop) -> None:
        """Go back by the way that led there: slowly, but for its first motion, which nothing is near."""
        here = await self._arm.read()
        allowed_rad = self._plan.joint_tolerance_rad + here.resolution_rad
        *slowly, begin_rad = way_off(stop, here.joints_rad, allowed_rad)
        await self._cell.robot_controller.set_limits(self._slow)
        for joints_rad in slowly:
            await self._arm.move(joints_rad)
        if slowly:
            await self._cell.robot_controller.set_limits(self._fast)
        await self._arm.move(begin_rad)
        self._begin = begin_rad

    async def _approach_and_read(self, stop: ContactStop) -> ContactTaken:
        self._begin = None
        free, touching = stop.way_rad[1:FREE_PLACES], stop.way_rad[FREE_PLACES:]
        for joints_rad in free:
            await self._arm.move(joints_rad)
        await self._cell.robot_controller.set_limits(self._slow)
        for start_rad, end_rad in pairwise((free[-1], *touching)):
            await self._require_room(start_rad, end_rad)
            await self._arm.move(end_rad)
        return await self._read_at(stop, await self._nulled(stop))

    async def _require_room(self, start_rad: Joints, end_rad: Joints) -> None:
        """Raise ReadingRejectedError where the next step could push a gauge in further than is used."""
        if self._plan.loop == "sensor":  # which nothing touches
            return
        step_mm = straight_mm(self._cell.robot, start_rad, end_rad)
        pushed_mm = await self._gauges.furthest_in_mm()
        if pushed_mm + step_mm > self._plan.stroke_mm - self._plan.margin_mm:
            raise ReadingRejectedError(
                f"A gauge is pushed in by {pushed_mm:.3f} mm before a step of {step_mm:.2f} mm: something "
                "stands elsewhere than planned, or it counts up as it comes out. The arm went back."
            )

    async def _nulled(self, stop: ContactStop) -> Joints:
        """Bring a probe to its zero by small motions along its push; return where the arm stands then."""
        joints_rad, null_mm = stop.joints_rad, self._plan.null_mm
        if null_mm is None or stop.push is None:
            return joints_rad
        for _ in range(_MOST_NUDGES):
            await self._cell.clock.sleep(self._plan.settle_s)
            (shown_mm,) = await self._gauges.read()
            if abs(shown_mm) <= null_mm:
                return joints_rad
            joints_rad = await self._nudge(joints_rad, stop.push, shown_mm)
        raise ReadingRejectedError(f"The probe does not come to within {null_mm:g} mm of its zero.")

    async def _nudge(self, joints_rad: Joints, push: Vector, shown_mm: float) -> Joints:
        x, y, z = (-shown_mm * np.array(push)).tolist()
        there_rad = nudged(self._cell.robot, self._cell.base, joints_rad, (x, y, z))
        outside = joint_outside(there_rad, motion_limits(self._cell.robot, self._cell.joint_limits))
        if outside is not None:
            raise ReadingRejectedError(f"The motion to the probe's zero would leave the limits: {outside}.")
        await self._arm.move(there_rad)
        return there_rad

    async def _read_at(self, stop: ContactStop, joints_rad: Joints) -> ContactTaken:
        await self._cell.clock.sleep(self._plan.settle_s)
        arrived = await self._arm.read()
        off = np.abs(np.subtract(arrived.joints_rad, joints_rad))
        if not np.all(off <= self._plan.joint_tolerance_rad + 0.5 * arrived.resolution_rad):
            raise ReadingRejectedError("The robot reports its joints elsewhere than where it was sent.")
        readings_mm = await self._gauges.read()
        return ContactTaken(
            config=stop.config,
            nest=self._plan.nest,
            commanded_rad=joints_rad,
            reported_rad=arrived.joints_rad,
            direction=self._arm.direction,
            time_s=arrived.time_s,
            attachment=self._cell.attachment,
            targets=stop.targets if len(stop.targets) > 1 else stop.targets * len(readings_mm),
            axes=tuple(range(len(readings_mm))) if self._plan.loop == "sensor" else (),
            reading_mm=tuple(-mm for mm in readings_mm) if self._plan.loop == "probe" else readings_mm,
            standard_uncertainty_mm=self._plan.reading_u_mm,
        )


def way_off(stop: ContactStop, here_rad: Joints, allowed_rad: float) -> tuple[Joints, ...]:
    """Return the way from a stop, or from where the arm was halted before it, to where nothing is near.

    From anywhere else that is the one motion to there: nobody knows a better one.
    """
    back = tuple(reversed(stop.way_rad))
    left = rest_of_way(back, here_rad, allowed_rad)
    off_rad = np.abs(np.subtract(here_rad, stop.joints_rad)) if len(here_rad) == len(back[0]) else np.inf
    is_known = len(left) < len(back) or bool(np.max(off_rad) <= _NEAR_RAD)
    return left if is_known else back[-1:]
