"""The one place from which a ballbar session moves the arm, and what forbids it on top of the interlocks.

A motion takes a person's confirmation that is fresh, a ballbar that is known to be off and no doubt that
waits for an answer. The ballbar's samples are watched to the end: where they show a length while the arm
moves, nothing more is sent. The arm's own interlocks look at state, wishes, age of the robot's statement,
joints and limits, before every segment of the way.
"""

import asyncio
from typing import Final

import numpy as np

from truepose.domain.ballbar import ArrivalTaken, BallbarPlan, BallbarStep, StepKind
from truepose.domain.cell import BallbarKit
from truepose.domain.robot import JointRange
from truepose.messages.message import Message, Text, message
from truepose.planning.workspace.path_clearance import Ways
from truepose.sessions.ballbar.cell import BallbarCell
from truepose.sessions.ballbar.dry_run import check_motion
from truepose.sessions.ballbar.plan import steps
from truepose.sessions.ballbar.readings import Readings
from truepose.sessions.ballbar.situation import Situation
from truepose.sessions.engine.arm import Arm, Permission
from truepose.sessions.engine.halts import Halts
from truepose.sessions.engine.identity_check import sentence
from truepose.sessions.engine.interlocks import binding_speed
from truepose.sessions.engine.ledger import IdentityCheck, Logbook
from truepose.sessions.engine.ways import Joints, KnownWays, rest_of_way
from truepose.sessions.errors import ForeignRobotError, MotionForbiddenError
from truepose_drivers.api import DeviceIdentity, JointReading

_RECENT_S: Final = 2.0  # an older statement says nothing of now


class RestMonitor:
    """Asks the robot where it is, one question at a time."""

    def __init__(self, cell: BallbarCell, plan: BallbarPlan) -> None:
        self._controller = cell.robot_controller
        self._plan = plan
        self._turn = asyncio.Lock()
        self._seen: tuple[JointReading, ...] = ()  # the last two

    async def open(self) -> None:
        """Open the link where it is down; raises the driver's errors."""
        if not self._controller.connected:
            await self._controller.connect()
            await self._controller.identify()  # a driver may know more of its controller from then on

    async def close(self) -> None:
        """Close the link; the next opening begins a new conversation."""
        self.forget()
        await self._controller.close()

    async def who(self) -> DeviceIdentity:
        """Ask the robot who it is; raises the driver's errors."""
        # One question at a time: not every protocol says which question an answer is to.
        async with self._turn:
            return await self._controller.identify()

    async def look(self) -> JointReading:
        """Ask where the joints are; raises the driver's errors."""
        async with self._turn:
            reading = await self._controller.read_joints()
        # Two looks that agree are rest; one shows no motion.
        self._seen = (*self._seen[-1:], reading)
        return reading

    def forget(self) -> None:
        """Forget what was seen: the arm has moved since, or may have."""
        self._seen = ()

    def is_still(self, now_s: float) -> bool:
        """Whether the last two looks agree and the last one is recent."""
        if len(self._seen) < 2 or not self._controller.connected:
            return False
        before, after = self._seen
        if abs(now_s - after.time_s) > _RECENT_S:
            return False
        off = np.abs(np.subtract(after.joints_rad, before.joints_rad))
        return bool(np.all(off <= after.resolution_rad))

    def moved_from(self, arrival: ArrivalTaken, reading: JointReading) -> Message | None:
        """Return which joint is not where it came to rest, as a sentence; None where all are."""
        return joint_away(
            reading.joints_rad, arrival.reported_rad, self._plan.joint_tolerance_rad + reading.resolution_rad
        )


def joint_away(reported: tuple[float, ...], wanted: tuple[float, ...], allowed_rad: float) -> Message | None:
    """Return which joint is elsewhere, as a sentence; None where all are where they should be."""
    if len(reported) != len(wanted):
        return message("session.joints.instead", reported=len(reported), expected=len(wanted))
    off = np.abs(np.subtract(reported, wanted))
    if np.all(off <= allowed_rad):  # a NaN is not
        return None
    worst = int(np.argmax(np.nan_to_num(off, nan=np.inf)))
    return message("session.joint.away", joint=worst + 1, off_deg=np.degrees(off[worst]))


_CONFIRMATION_AGE_S: Final = 5.0  # whoever looked at the cell longer ago looks again


class InterlockedMotion:
    """Moves the arm to the stop of a step and reads where it came to rest."""

    def __init__(
        self,
        plan: BallbarPlan,
        kit: BallbarKit,
        cell: BallbarCell,
        limits: tuple[JointRange, ...],
        logbook: Logbook[Situation],
        halts: Halts,
        identities: IdentityCheck,
        rest: RestMonitor,
        readings: Readings,
    ) -> None:
        self._plan = plan
        self._kit = kit
        self._robot = cell.robot
        self._speed = binding_speed(plan, cell.speed_limits)
        self._limits = limits
        self._clock = cell.clock
        self._logbook = logbook
        self._halts = halts
        self._identities = identities
        self._rest = rest
        self._readings = readings
        self._cell = cell
        self._ways = KnownWays(cell.look_at_ways, self._look_past_fixture)
        self._arm = Arm(
            cell.robot_controller,
            cell.clock,
            cell.robot,
            limits,
            plan.joint_tolerance_rad,
            self._permission,
            self._ways,
            plan.state_age_s,
            before_piece=readings.settle,  # a piece may last longer than a sample of the ballbar counts
        )
        self.saw_ballbar = False  # it read a length when the last motion ended, or was to begin
        self.confirmed_s: float | None = None  # when a person last allowed a motion, cell clock

    def go_on(self, question: Text) -> None:
        """Forget where the arm was left: a person had it since, and confirmed what they were asked."""
        self._ways.confirm(question)
        self._arm.forget()
        self._rest.forget()
        self.confirmed_s = None

    async def set_speed(self) -> None:
        """Set the speed of the motions that follow; raises the driver's errors."""
        await self._arm.set_limits(self._speed)

    def require_plan_within_limits(self) -> None:
        """Raise PlanRefusedError for the first planned motion that is left and leaves what binds it now."""
        now = self._logbook.situation
        for step in steps(self._plan, self._kit):
            outcome = now.outcomes.get(step.id)
            if outcome is not None and outcome.kind == "open":
                self.require_within_limits(step)

    def require_within_limits(self, step: BallbarStep) -> None:
        """Raise PlanRefusedError where the motion of a step leaves what binds it now."""
        check_motion(step, self._robot, self._limits)

    async def perform(self, step: BallbarStep) -> ArrivalTaken:
        """Move along the way of a step and come to rest; raises MotionForbiddenError, the driver's errors."""
        if step.target_rad is None:
            raise MotionForbiddenError(message("session.no_target", step=step.id))
        self._halts.moving = True  # before anything is awaited: who asks for a pause now waits for its end
        self._logbook.tell()
        try:
            # Cheap and certain first. The order of the rest follows from what each may let grow old: the
            # ballbar comes last, since its samples count for a second.
            await self._require_fresh_confirmation()
            # Before each motion: a controller may be exchanged behind an address without the link going down
            # (decision 0020).
            await self._require_same_robot()
            # Asked of the arm and not of the ledger: it may have been halted anywhere on the way.
            left = await self._left_of((*step.via_rad, step.target_rad))
            await self._require_planned_ways(step)
            self._rest.forget()
            await self._require_ballbar_off()
            self._readings.evidence.watch_motion()
            for joints in left:
                await self._arm.move(joints)
                # After each piece of the way, with samples taken since: a length that persists ends the
                # motion here and is no arrival, even at the target (decision 0018).
                await self._require_ballbar_off()
            await self._clock.sleep(self._plan.settle_s)
            return await self._arrival(step.target_rad)
        finally:
            # Read before the watch ends, which forgets it; the runner then has the bar taken off again, on
            # record.
            self.saw_ballbar = self._readings.evidence.proves_attached
            self._readings.evidence.end_motion()
            self._halts.moving = False
            # One confirmation lets one motion pass, whatever became of it.
            self.confirmed_s = None

    async def _require_same_robot(self) -> None:
        """Ask the robot again who it is: raises ForeignRobotError, the driver's errors."""
        found = self._identities.news("robot", await self._rest.who())
        if found is not None and found.finding == "foreign":
            raise ForeignRobotError(sentence(found))

    async def _left_of(self, way: tuple[Joints, ...]) -> tuple[Joints, ...]:
        """Return what is left of a way, or of the way back to its begin from another that was halted."""
        now, reading = self._logbook.situation, await self._rest.look()
        allowed_rad = self._plan.joint_tolerance_rad + reading.resolution_rad
        for course in (now.course, *((*reversed(halted), *way) for halted in now.halted)):
            left = rest_of_way(course, reading.joints_rad, allowed_rad)
            if len(left) < len(course):
                return left
        return way

    async def _require_planned_ways(self, step: BallbarStep) -> None:
        """Look at the planned ways ahead, by what the cell forbids now; raises WayNotClearError."""
        now = self._logbook.situation
        name = message("room.way.steps", begin=now.last_stop or step.id, end=step.id)
        for course in (now.course, *now.halted):
            await self._ways.require_planned(course, name)

    async def _look_past_fixture(self, ways: Ways) -> Text:
        step, of_sphere = self._logbook.situation.step, self._plan.test is not None
        place = next((one for one in self._plan.placements if step and one.number == step.placement), None)
        if step is None or place is None or of_sphere:  # of the fixture of a sphere test only cup 1 is known
            return await self._cell.look_at_ways(ways)
        return await self._cell.look_past_fixture(place, step.base_point, ways)

    async def _arrival(self, target_rad: tuple[float, ...]) -> ArrivalTaken:
        reading = await self._rest.look()
        away = joint_away(
            reading.joints_rad, target_rad, self._plan.joint_tolerance_rad + 0.5 * reading.resolution_rad
        )
        if away is not None:
            raise MotionForbiddenError(message("session.not_arrived", why=away))
        return ArrivalTaken(target_rad, reading.joints_rad, self._arm.direction, reading.time_s)

    async def _require_fresh_confirmation(self) -> None:
        now_s = await self._clock.now_s()
        if self.confirmed_s is None or not abs(now_s - self.confirmed_s) <= _CONFIRMATION_AGE_S:
            raise MotionForbiddenError(message("session.look_too_old"))

    async def _require_ballbar_off(self) -> None:
        """Look at samples that were taken from now on; raises MotionForbiddenError."""
        await self._readings.settle()
        seen = self._readings.evidence.against_motion(await self._clock.now_s())
        if seen is not None:
            raise MotionForbiddenError(seen)

    def _permission(self, now_s: float) -> Permission:
        # No open question here: the situation asks before every motion, and the confirmation of it is
        # among the obstacles.
        return Permission(
            self._logbook.situation.state, self._halts.wish is not None, None, self._obstacle(now_s)
        )

    def _obstacle(self, now_s: float) -> Text | None:
        now = self._logbook.situation
        # Where the disk refuses, neither the arrival nor a halt could be kept.
        if self._logbook.trouble is not None:
            return self._logbook.trouble
        # By the ledger: a robot that was asked about is no news to whoever asks it again before a motion.
        foreign = now.ballbar.foreign or now.robot.foreign
        if foreign is not None:
            return sentence(foreign)
        if now.attached:
            return message("session.bar.maybe_attached")
        if now.suspicion is not None:
            return message("session.doubt_open")
        if now.step is None or now.step.kind is not StepKind.MOVE or not now.confirmed:
            return message("session.not_confirmed")
        # Last, and by the newest sample: this is asked with nothing awaited before the motion is sent.
        return self._readings.evidence.against_motion(now_s)
