"""One configuration of a contact session: there, slowly, the gauges looked at between; read; and back.

The arm moves with a gauge touched, on purpose. So it creeps, by steps shorter than half a stroke, and after
each of them the gauges are asked whether the next one has room.
"""

from dataclasses import dataclass, field
from itertools import pairwise
from typing import Final

import numpy as np

from truepose.domain.contacts import FREE_PLACES, ContactPlan, ContactStop, ContactTaken, Joints
from truepose.domain.robot import FramePlacement, Robot
from truepose.domain.session import Vector
from truepose.kinematics.frames import placement_rotation
from truepose.kinematics.inverse import all_branches
from truepose.messages.message import Message, message
from truepose.sessions.engine.arm import Arm, ArmCell
from truepose.sessions.engine.identity_check import reported_serial_number, same_number
from truepose.sessions.engine.interlocks import binding_speed, joint_outside, motion_limits, slowest
from truepose.sessions.engine.nominal_arm import as_vector, nominal_chain
from truepose.sessions.engine.runner import is_interruption
from truepose.sessions.engine.ways import rest_of_way
from truepose.sessions.errors import AttentionNeededError, ReadingRejectedError, WayNotClearError
from truepose_drivers.api import BallbarReading, Clock, FullGauge, MotionLimits
from truepose_drivers.errors import DeviceRefusedError, MeasurementFailedError


@dataclass(frozen=True, slots=True)
class GaugeBox:
    """A gauge, or a box of several, and what the cell file says of it."""

    name: str
    gauge: FullGauge
    serial: str = ""  # that it must tell, where it tells one


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactCell(ArmCell):
    """Devices and nominal robot of one cell."""

    gauges: tuple[GaugeBox, ...]  # in the order in which the targets of a stop are read
    base: FramePlacement = field(default_factory=FramePlacement)  # nominal, in the world
    attachment: int = 1  # how often the tool has been mounted
    robot_serial: str = ""


_BETWEEN_S: Final = 0.1  # of two samples
_UNSTEADY: Final = 5.0  # standard uncertainties of a reading by which samples may scatter


class Gauges:
    """Reads them; each reading is of one channel, in the order of the cell file."""

    def __init__(self, boxes: tuple[GaugeBox, ...], clock: Clock, plan: ContactPlan) -> None:
        self._boxes = boxes
        self._clock = clock
        self._plan = plan

    async def open(self) -> tuple[Message, ...]:
        """Connect them and say which answered; raises AttentionNeededError, and the driver's errors."""
        found = []
        for box in self._boxes:
            if not box.gauge.connected:
                await box.gauge.connect()
            identity = await box.gauge.identify()
            serial = reported_serial_number(identity.serial)
            if serial and box.serial and not same_number(serial, box.serial):
                raise AttentionNeededError(
                    message(
                        "session.identity.gauge",
                        device=box.name,
                        serial=serial,
                        expected=box.serial,
                    )
                )
            model = f"{identity.manufacturer} {identity.model}"
            found.append(
                message("session.identity.gauge_is", device=box.name, model=model, serial=identity.serial)
            )
        # Targets are matched with channels by their order: one too many or too few would shift all of them.
        await self._require_channels()
        return tuple(found)

    async def close(self) -> None:
        """Close their links; never raises."""
        for box in self._boxes:
            await box.gauge.close()

    async def look(self) -> tuple[BallbarReading, ...]:
        """Return what each of them shows now; raises the driver's errors."""
        readings: list[BallbarReading] = []
        for box in self._boxes:
            readings += await box.gauge.read_channels()
        return tuple(readings)

    async def furthest_in_mm(self) -> float:
        """Return the largest deviation of all gauges [mm], within range or not; inwards is positive."""
        return max(self._pushed_mm(reading) for reading in await self.look())

    async def read(self) -> tuple[float, ...]:
        """Return the mean of some samples of each; raises ReadingRejectedError, and the driver's errors."""
        samples = []
        for number in range(self._plan.samples):
            if number:
                await self._clock.sleep(_BETWEEN_S)
            samples.append([self._within_mm(n, one) for n, one in enumerate(await self.look(), start=1)])
        # Over 0.1 s and more: an arm that still swings shows here.
        scatter_mm = float(np.ptp(samples, axis=0).max())
        finest_mm = self._plan.reading_u_mm
        if scatter_mm > _UNSTEADY * finest_mm:
            raise ReadingRejectedError(
                message("session.gauge.unsteady", off_um=1000.0 * scatter_mm, reading_um=1000.0 * finest_mm)
            )
        return tuple(float(mean) for mean in np.mean(samples, axis=0))

    def _pushed_mm(self, reading: BallbarReading) -> float:
        if reading.signal == "none":
            raise ReadingRejectedError(message("session.gauge.silent"))
        return reading.deviation_mm

    def _within_mm(self, number: int, reading: BallbarReading) -> float:
        usable_mm = self._plan.stroke_mm - self._plan.margin_mm
        shown_mm = self._pushed_mm(reading)
        if reading.signal != "good" or abs(shown_mm) > usable_mm:
            amiss = "session.gauge.not_touched" if shown_mm < 0.0 else "session.gauge.pushed"
            raise ReadingRejectedError(message(amiss, number=number, shown_mm=shown_mm, usable_mm=usable_mm))
        return shown_mm

    async def _require_channels(self) -> None:
        there = len(await self.look())
        if there != self._plan.channels:
            raise AttentionNeededError(
                message("session.gauges.count", there=there, wanted=self._plan.channels)
            )


_FURTHEST_RAD = 0.2  # a step of some millimetres that turns a joint further is near a singularity


def nudge(robot: Robot, base: FramePlacement, joints_rad: Joints, by_mm: Vector) -> Joints:
    """Return the joints that put the tool `by_mm` further in the world.

    Parameters
    ----------
    robot, base
        Nominal; the base in the world.
    joints_rad : tuple of float
        Where the arm stands.
    by_mm : tuple of float
        A few millimetres [mm, world].

    Raises
    ------
    ReadingRejectedError
        The arm cannot do that by a small motion.
    """
    here = np.array(joints_rad)
    chain = nominal_chain(robot, FramePlacement(), here[None])
    pose = np.eye(4)
    pose[:3, :3] = chain.rotation[-1][0]
    pose[:3, 3] = chain.origin[-1][0] + placement_rotation(base).T @ np.array(by_mm)
    found = all_branches(robot, pose)
    # Inverse kinematics gives angles within a turn; the joint may stand turns away.
    turned = found - 2 * np.pi * np.round((found - here) / (2 * np.pi))
    away = np.max(np.abs(turned - here), axis=1, initial=0.0)
    away[np.isnan(away)] = np.inf
    nearest = int(np.argmin(away))
    # A millimetre near a singularity may turn a joint far, into something (commit 8e4da3b2).
    if not away[nearest] <= _FURTHEST_RAD:
        raise ReadingRejectedError(message("session.gauge.no_nearer"))
    return tuple(float(angle) for angle in turned[nearest])


def straight_mm(robot: Robot, start_rad: Joints, end_rad: Joints) -> float:
    """Return how far apart two configurations put the flange [mm]."""
    flange = nominal_chain(robot, FramePlacement(), np.array([start_rad, end_rad])).origin[-1]
    return float(np.linalg.norm(flange[1] - flange[0]))


_MOST_NUDGES: Final = 6
_NEAR_RAD: Final = 0.05  # about a stop, hence perhaps in touch with its target


class ContactMeasurement:
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
        # Where nothing is near, while the arm stands there; with wires the stop itself, which has no way.
        self._begin: Joints | None = None

    def is_where_the_next_way_begins(self, stop: ContactStop) -> bool:
        """Whether the arm stands where the planned way from a stop to the one after it begins."""
        return self._begin == stop.way_rad[0]

    def forget(self) -> None:
        """Forget where the arm was left: a person had it since."""
        self._begin = None

    async def visit(self, stop: ContactStop) -> ContactTaken:
        """Return what the gauges read at a stop; raises what the devices and the checks raise."""
        if not self._plan.touches:
            self._begin = None
            await self._arm.move(stop.joints_rad)
            self._begin = stop.joints_rad
            return await self._read_at(stop, stop.joints_rad)
        await self._go_to_begin(stop)
        try:
            taken = await self._approach_and_read(stop)
        # The stop is left out, and the arm must not stay in touch with its target: the next motion goes
        # elsewhere.
        except (ReadingRejectedError, MeasurementFailedError, DeviceRefusedError) as error:
            # After an interruption nothing moves before a person has looked; the stop begins again then.
            if not is_interruption(error):
                await self._leave(stop)
            raise
        await self._leave(stop)
        return taken

    async def _go_to_begin(self, stop: ContactStop) -> None:
        """Go where nothing is near; from a place that nobody knows slowly, by the way that led there."""
        if self._begin is None:
            await self._leave(stop)
        await self._arm.set_limits(self._fast)
        if self._begin != stop.way_rad[0]:
            await self._arm.move(stop.way_rad[0])

    async def _leave(self, stop: ContactStop) -> None:
        """Go back by the way that led there: slowly, but for its first motion, which nothing is near."""
        here = await self._arm.read()
        allowed_rad = self._plan.joint_tolerance_rad + here.resolution_rad
        *slowly, begin_rad = way_off(stop, here.joints_rad, allowed_rad)
        await self._arm.set_limits(self._slow)
        for joints_rad in slowly:
            await self._arm.move(joints_rad)
        if slowly:
            await self._arm.set_limits(self._fast)
        await self._arm.move(begin_rad)
        self._begin = begin_rad

    async def _approach_and_read(self, stop: ContactStop) -> ContactTaken:
        # Forgotten before the first motion towards the target: halted anywhere on the way, the arm has to go
        # back along it.
        self._begin = None
        free, touching = stop.way_rad[1:FREE_PLACES], stop.way_rad[FREE_PLACES:]
        for joints_rad in free:
            await self._arm.move(joints_rad)
        # From here on something may be in touch.
        await self._arm.set_limits(self._slow)
        for start_rad, end_rad in pairwise((free[-1], *touching)):
            # Before each step and with what the gauges show now: the target may stand nearer than the plan
            # has it.
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
                message("session.gauge.before_step", pushed_mm=pushed_mm, step_mm=step_mm)
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
        raise ReadingRejectedError(message("session.probe.no_zero", null_mm=null_mm))

    async def _nudge(self, joints_rad: Joints, push: Vector, shown_mm: float) -> Joints:
        back_mm = as_vector(-shown_mm * np.array(push))
        there_rad = nudge(self._cell.robot, self._cell.base, joints_rad, back_mm)
        # Looked at here, so that the stop is left out. Refused by the interlocks it asked a person the same
        # question for ever: joint 6 at 180.02 deg (commit 34fb5649).
        outside = joint_outside(there_rad, motion_limits(self._cell.robot, self._cell.joint_limits))
        if outside is not None:
            raise ReadingRejectedError(message("session.zero.outside", outside=outside))
        try:
            await self._arm.move(there_rad)
        except WayNotClearError as error:
            raise ReadingRejectedError(error.text) from error
        return there_rad

    async def _read_at(self, stop: ContactStop, joints_rad: Joints) -> ContactTaken:
        await self._cell.clock.sleep(self._plan.settle_s)
        arrived = await self._arm.read()
        off = np.abs(np.subtract(arrived.joints_rad, joints_rad))
        if not np.all(off <= self._plan.joint_tolerance_rad + 0.5 * arrived.resolution_rad):
            raise ReadingRejectedError(message("session.robot.elsewhere"))
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
            # A probe that is pushed in shows more, and the target is nearer: its reading counts the other
            # way.
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
