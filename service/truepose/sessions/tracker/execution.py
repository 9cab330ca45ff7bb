"""Performs single operations on the devices; when and whether one is due is the runner's business."""

from typing import Final

import numpy as np

from truepose.domain.ledger import EntryKind
from truepose.domain.session import IdentityOf, SessionPlan, Vector, Work
from truepose.messages.message import Message, Text, message
from truepose.sessions.engine.arm import Arm
from truepose.sessions.engine.interlocks import binding_speed, speed_sentence
from truepose.sessions.engine.ledger import Logbook
from truepose.sessions.errors import ReadingRejectedError
from truepose.sessions.tracker import steps as steps
from truepose.sessions.tracker.camera_measurement import Poses
from truepose.sessions.tracker.cell import AtRest, SessionCell
from truepose.sessions.tracker.state import TrackerSituation
from truepose.sessions.tracker.tracker_measurement import Points
from truepose.sessions.tracker.tracking import TrackerIdentityCheck
from truepose_drivers.api import (
    DeviceIdentity,
    JointReading,
    PointTracker,
    PoseTracker,
    RobotController,
)

_REST_S: Final = 1.0  # between two motions that nobody measures


class Execution:
    """Does what an operation says."""

    def __init__(
        self,
        plan: SessionPlan,
        cell: SessionCell,
        arm: Arm,
        logbook: Logbook[TrackerSituation],
        identities: TrackerIdentityCheck,
    ) -> None:
        self._identities = identities
        self._plan = plan
        self._cell = cell
        self._arm = arm
        self._logbook = logbook
        measured: type[Points | Poses] = Points if plan.measures == "points" else Poses
        self._instrument = measured(plan, cell, logbook, identities)
        self._joints: JointReading | None = None
        self._operation: steps.Operation | None = None  # of the present step, that was begun last
        self._fixed_nest: int | None = None
        self._work: Work | None = None
        self._place = 0  # of the work, that comes next

    @property
    def is_moving(self) -> bool:
        """Whether the arm was sent somewhere, and nothing else was begun since."""
        return isinstance(self._operation, steps.Move | steps.KeepWorking)

    @property
    def fixed_nest(self) -> int | None:
        """Which fixed nest was read last in the present step (1-based); None: none."""
        return self._fixed_nest

    def in_world(self, point_mm: Vector) -> Vector | None:
        """Return a point of the instrument's frame in the world; None where that is not known."""
        return self._instrument.in_world(point_mm)

    def begin_step(self) -> None:
        """Forget what belongs to an earlier step."""
        self._operation = None
        self._fixed_nest = None
        self._instrument.begin_step()
        # Joints that were read at another stop must not be kept with a reading here.
        self._joints = None

    async def perform(self, operation: steps.Operation) -> None:
        """Do one operation; raises what the devices and the checks raise."""
        self._operation = operation
        if isinstance(operation, steps.ReadFixedNest):
            self._fixed_nest = operation.fixed_nest
        match operation:
            case steps.OpenDevices():
                await self._open()
            case steps.Move(target_rad):
                await self._move(target_rad)
            case steps.KeepWorking(work):
                await self._keep_working(work)
            case steps.Settle(duration_s):
                await self._cell.clock.sleep(duration_s)
            case steps.ReadJoints(expected_rad):
                await self._read_joints(expected_rad)
            case _:
                await self._instrument.perform(operation, self._at_rest)

    async def _open(self) -> None:
        # Both are asked who they are before either is initialised: a foreign tracker measures nothing, and an
        # initialisation takes a minute.
        await self._note(_introduce("tracker", await self._meet("tracker", self._cell.tracker)))
        await self._note(_introduce("robot", await self._meet("robot", self._cell.robot_controller)))
        await self._cell.tracker.initialise()
        for sentence in await self._instrument.conditions():
            await self._note(sentence)
        # At every opening: a controller that was switched off has forgotten its limits.
        speed = binding_speed(self._plan, self._cell.speed_limits)
        await self._arm.set_limits(speed)
        await self._note(speed_sentence(speed, self._cell.robot_controller.motion_guard))

    async def _move(self, target_rad: tuple[float, ...]) -> None:
        robot = self._cell.robot_controller
        if robot.connected:  # a link that is down is for a person; the interlocks say so
            await self._identities.meet("robot", robot)
        if await self._arm.move(target_rad):
            await self._note(message("session.way.looked_at"))

    async def _keep_working(self, work: Work) -> None:
        """Go round until the stop is due; a round that was begun is ended: only its ways were looked at."""
        if work is not self._work:
            self._work, self._place = work, 0
        clock = self._cell.clock
        left_s = work.until_s - self._logbook.situation.since_first_s
        # From the ledger's time and not from when this began: a killed service goes on working until the same
        # moment (decision 0046).
        end_s = await clock.now_s() + left_s
        while self._place or (self._is_wanted(work) and await clock.now_s() < end_s):
            await self._move(work.places_rad[self._place])
            self._place = (self._place + 1) % len(work.places_rad)
            await clock.sleep(_REST_S)

    def _is_wanted(self, work: Work) -> bool:
        """Whether the stop that the work comes before was not left out meanwhile."""
        return any(stop.work is work for stop in self._logbook.situation.left)

    async def _note(self, text: Text) -> None:
        await self._logbook.write(EntryKind.NOTED, text=text)

    async def _meet(
        self, what: IdentityOf, device: PointTracker | PoseTracker | RobotController
    ) -> DeviceIdentity:
        if not device.connected:
            await device.connect()
        return await self._identities.meet(what, device)

    async def _read_joints(self, expected_rad: tuple[float, ...]) -> None:
        reading = await self._arm.read()
        if len(reading.joints_rad) != len(expected_rad):
            raise ReadingRejectedError(
                message(
                    "session.joints.commanded", reported=len(reading.joints_rad), expected=len(expected_rad)
                )
            )
        off = np.abs(np.subtract(reading.joints_rad, expected_rad))
        # Not the opposite comparison: a NaN is nowhere near.
        if not np.all(off <= self._plan.joint_tolerance_rad + 0.5 * reading.resolution_rad):
            worst = int(np.argmax(np.nan_to_num(off, nan=np.inf)))
            raise ReadingRejectedError(
                message("session.joint.elsewhere", joint=worst + 1, off_deg=np.degrees(off[worst]))
            )
        self._joints = reading

    def _at_rest(self) -> AtRest:
        if self._joints is None:
            raise ReadingRejectedError(message("session.joints.unread"))
        return AtRest(self._joints, self._arm.direction)


def _introduce(what: IdentityOf, identity: DeviceIdentity) -> Message:
    return message(
        "session.identity.is",
        device=what,
        model=f"{identity.manufacturer} {identity.model}",
        serial=identity.serial,
        firmware=identity.firmware,
    )
