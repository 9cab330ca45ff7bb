"""The one place from which a ballbar session moves the arm, and what forbids it on top of the interlocks.

A motion takes a person's confirmation that is fresh, a ballbar that is known to be off and no doubt that
waits for an answer. The ballbar's samples are watched to the end: where they show a length while the arm
moves, nothing more is sent. The arm's own interlocks look at state, wishes, age of the robot's statement,
joints and limits, before every segment of the way.
"""

from typing import Final

from truepose.domain.cell.artefacts import BallbarKit
from truepose.domain.measurement.ballbar import ArrivalTaken, BallbarPlan, BallbarStep, StepKind
from truepose.domain.robot import JointRange
from truepose.sequencing.ballbar.arm_at_rest import RestMonitor, joint_away
from truepose.sequencing.ballbar.cell import BallbarCell
from truepose.sequencing.ballbar.measuring.readings import Readings
from truepose.sequencing.ballbar.plan.agenda import steps
from truepose.sequencing.ballbar.plan.dry_run import check_motion
from truepose.sequencing.ballbar.situation import Situation
from truepose.sequencing.engine.halting.halts import Halts
from truepose.sequencing.engine.identity.check import IdentityCheck
from truepose.sequencing.engine.identity.expected import sentence
from truepose.sequencing.engine.logbook import Logbook
from truepose.sequencing.engine.motion.arm import Arm, Permission
from truepose.sequencing.engine.motion.limits import binding_speed
from truepose.sequencing.engine.motion.rest_of_way import rest_of_way
from truepose.sequencing.engine.motion.segments import Joints, MotionSegments
from truepose.sequencing.errors import ForeignRobotError, MotionForbiddenError

_CONFIRMATION_AGE_S: Final = 5.0  # whoever looked at the cell longer ago looks again


class Motion:
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
        self._limits = limits
        self._clock = cell.clock
        self._logbook = logbook
        self._halts = halts
        self._identities = identities
        self._rest = rest
        self._readings = readings
        self._arm = Arm(
            cell.robot_controller,
            cell.clock,
            limits,
            plan.joint_tolerance_rad,
            self._permission,
            plan.state_age_s,
            MotionSegments(cell.robot, binding_speed(plan, cell.speed_limits)),
            before_piece=readings.settle,  # a piece may last longer than a sample of the ballbar counts
        )
        self.saw_ballbar = False  # it read a length when the last motion ended, or was to begin
        self.confirmed_s: float | None = None  # when a person last allowed a motion, cell clock

    def forget(self) -> None:
        """Forget where the arm was left: a person had it since, and confirmed."""
        self._arm.forget()
        self._rest.forget()
        self.confirmed_s = None

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
            raise MotionForbiddenError(f"The step {step.id} has no target.")
        self._halts.moving = True  # before anything is awaited: who asks for a pause now waits for its end
        self._logbook.tell()
        try:
            await self._require_fresh_confirmation()
            await self._require_same_robot()
            left = await self._left_of((*step.via_rad, step.target_rad))
            self._rest.forget()
            await self._require_ballbar_off()
            self._readings.evidence.watch_motion()
            for joints in left:
                await self._arm.move(joints)
                await self._require_ballbar_off()
            await self._clock.sleep(self._plan.settle_s)
            return await self._arrival(step.target_rad)
        finally:
            self.saw_ballbar = self._readings.evidence.proves_attached
            self._readings.evidence.end_motion()
            self._halts.moving = False
            self.confirmed_s = None

    async def _require_same_robot(self) -> None:
        """Ask the robot again who it is: raises ForeignRobotError, the driver's errors."""
        found = self._identities.news("robot", await self._rest.who())
        if found is not None and found.finding == "foreign":
            raise ForeignRobotError(sentence(found))

    async def _left_of(self, way: tuple[Joints, ...]) -> tuple[Joints, ...]:
        """Return what is left of a way on which the arm was halted: none back to its begin is planned."""
        reading = await self._rest.look()
        return rest_of_way(way, reading.joints_rad, self._plan.joint_tolerance_rad + reading.resolution_rad)

    async def _arrival(self, target_rad: tuple[float, ...]) -> ArrivalTaken:
        reading = await self._rest.look()
        away = joint_away(
            reading.joints_rad, target_rad, self._plan.joint_tolerance_rad + 0.5 * reading.resolution_rad
        )
        if away is not None:
            raise MotionForbiddenError(f"The arm did not arrive: {away}")
        return ArrivalTaken(target_rad, reading.joints_rad, self._arm.direction, reading.time_s)

    async def _require_fresh_confirmation(self) -> None:
        now_s = await self._clock.now_s()
        if self.confirmed_s is None or not abs(now_s - self.confirmed_s) <= _CONFIRMATION_AGE_S:
            raise MotionForbiddenError("It is too long ago that somebody looked whether the cell is clear.")

    async def _require_ballbar_off(self) -> None:
        """Look at samples that were taken from now on; raises MotionForbiddenError."""
        await self._readings.settle()
        seen = self._readings.evidence.against_motion(await self._clock.now_s())
        if seen is not None:
            raise MotionForbiddenError(seen)

    def _permission(self, now_s: float) -> Permission:
        return Permission(
            self._logbook.situation.state, self._halts.wish is not None, None, self._obstacle(now_s)
        )

    def _obstacle(self, now_s: float) -> str | None:
        now = self._logbook.situation
        if self._logbook.trouble is not None:
            return self._logbook.trouble
        if now.ballbar.foreign is not None:
            return sentence(now.ballbar.foreign)
        if now.attached:
            return "The ballbar may still be attached; take it off and confirm that, then the arm may move."
        if now.suspicion is not None:
            return "A doubt about a reading waits for its answer; nothing moves before."
        if now.step is None or now.step.kind is not StepKind.MOVE or not now.confirmed:
            return "Nobody has confirmed that the cell is clear for this motion."
        return self._readings.evidence.against_motion(now_s)
