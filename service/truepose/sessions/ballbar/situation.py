"""The present situation of a session: a pure function of its plan and its ledger.

Nothing else is remembered, so a restart shows the same step and nothing can be done twice. The present
step is the first one that is open, in the order of the agenda, but for those that come before it where
they must: the ballbar is taken off before the arm moves, the setting ball is in its nest before a cup is
clamped (again), and a ballbar that was without supply is put on the calibrator before it is read again.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

from truepose.domain.ballbar import (
    ArrivalTaken,
    BallbarPlan,
    BallbarStep,
    BarSet,
    LengthTaken,
    PoseForecast,
    StepKind,
)
from truepose.domain.cell import BallbarKit
from truepose.domain.ledger import LedgerEntry
from truepose.domain.session import IdentityTaken, SessionState
from truepose.messages.message import Text, is_said_in, together
from truepose.sessions.ballbar import step_ids
from truepose.sessions.ballbar.allowed_commands import acts_allowed
from truepose.sessions.ballbar.dry_run import BallbarProgress, pace_s_per_reading, remaining_s
from truepose.sessions.ballbar.plan import MAX_ATTEMPTS, Course, Joints, Ways, forecast_of, steps, ways
from truepose.sessions.ballbar.state import READINGS, BallbarRecord, OpenSuspicion, Outcome
from truepose.sessions.engine.commands import CommandName
from truepose.sessions.engine.identity_check import KnownDevice, sentence
from truepose.sessions.engine.progress import ActingTablet
from truepose.sessions.engine.prompts import CELL_CLEAR
from truepose.sessions.engine.states import ASKS


@dataclass(frozen=True, slots=True)
class Situation:
    """Where a session stands."""

    state: SessionState
    reason: Text  # why this state was entered; of a person who is waited for: the question
    steps: tuple[BallbarStep, ...]  # the whole agenda as it is now, done and skipped ones included
    outcomes: Mapping[str, Outcome]  # of every step of `steps`
    step: BallbarStep | None  # the present one; None: nothing is left to do
    index: int  # of the present step in `steps`, or of the one that it must come before
    shown: bool  # its prompt is on record
    confirmed: bool  # of a motion: a person has just said that the cell is clear
    attached: bool  # the ballbar, as far as known
    exchanged: bool  # another ballbar may answer than the one that may be attached
    suspicion: OpenSuspicion | None
    answered: tuple[OpenSuspicion, ...]  # doubts about the present step for which it was put on anew
    acting: ActingTablet | None
    initialisations: int  # so far
    zero: LengthTaken | None  # the initialisation that the present reading counts from
    zero_before: LengthTaken | None  # of an initialisation: the last one with the same bars
    zeroed: tuple[BarSet, LengthTaken] | None  # the bars that are on, and their zero; None: not known
    forecast: PoseForecast | None  # of the present configuration
    has_no_way: bool  # the present motion: the last pre-calibration found no clear way to its pose
    arm_at: str | None  # the step that brought the arm where it stands; None: not known
    last_stop: str | None  # the step that brought the arm to rest last, wherever it is now
    course: tuple[Joints, ...]  # of the present motion, from there to its target
    halted: tuple[tuple[Joints, ...], ...]  # courses from there on which the arm was sent since, newest first
    arrival: ArrivalTaken | None
    back_to: str | None  # the step that Back reopens; None: there is no way back
    acts: frozenset[CommandName]
    progress: BallbarProgress
    last: tuple[str, Outcome] | None  # the step that ended last, and how
    ballbar: KnownDevice
    robot: KnownDevice
    identities: tuple[IdentityTaken, ...]  # which devices answered, oldest first

    @property
    def question(self) -> Text | None:
        """What a person is asked to look at before the robot may move, or the session go on."""
        if self.state in ASKS:
            return together(self._about_the_ballbar, self.reason, CELL_CLEAR)
        asked = self.step is not None and self.step.kind is StepKind.MOVE and not self.confirmed
        return CELL_CLEAR if asked and self.state is SessionState.RUNNING else None

    @property
    def leads_to(self) -> tuple[int, ...]:
        """The pose to which the arm may go once the question is answered."""
        goes = self.step is not None and self.step.kind is StepKind.MOVE
        return () if not goes or self.step is None or self.step.config is None else (self.step.config,)

    @property
    def _about_the_ballbar(self) -> Text:
        """Say that another ballbar waits to be accepted, where the reason does not say so already."""
        if self.ballbar.foreign is None:
            return ""
        asked = sentence(self.ballbar.foreign)
        return "" if is_said_in(asked, self.reason) else asked

    @property
    def busy(self) -> bool:
        """Whether the robot moves, or the service computes, as soon as nothing forbids it."""
        if self.state is not SessionState.RUNNING or self.step is None or self.suspicion is not None:
            return False
        return self.confirmed or self.step.kind is StepKind.PRECALIBRATE

    @property
    def stop(self) -> str | None:
        """The motion to the stop at which the present step is done; None where the arm plays no part."""
        if self.step is None or self.step.kind is StepKind.MOVE or not step_ids.is_of_a_stop(self.step.id):
            return None
        return self.arm_at

    def legs_of_the_pose(self) -> int:
        """Return how many legs the pose of the present step has."""
        group = step_ids.group_of(self.step.id) if self.step else ""
        legs = (step for step in self.steps if step.kind is StepKind.CONNECT_LEG)
        return sum(step_ids.group_of(step.id) == group for step in legs)

    def earlier_legs(self) -> dict[tuple[int, int], float]:
        """Return the lengths [mm] of the group of the present step that count already, by their points."""
        if self.step is None:
            return {}
        group = step_ids.group_of(self.step.id)
        return {
            step.points: outcome.length.length_mm
            for step in self.steps
            if step.points is not None and step_ids.group_of(step.id) == group
            if (outcome := self.outcomes[step.id]).length is not None
        }


def situation(plan: BallbarPlan, kit: BallbarKit, entries: Iterable[LedgerEntry]) -> Situation:
    """Return where a session stands after these lines of its ledger, oldest first."""
    return situation_of(plan, kit, BallbarRecord.of(entries))


def situation_of(plan: BallbarPlan, kit: BallbarKit, record: BallbarRecord) -> Situation:
    """Return where a session stands after what is on record."""
    agenda = tuple(steps(plan, kit, _course(record)))
    outcomes = {step.id: record.outcome(step.id) for step in agenda}
    index = _present_index(agenda, outcomes, record)
    known = ways(plan, agenda, record.stood_at)
    step = _present(plan, agenda, index, record, known)
    moves = step is not None and step.kind is StepKind.MOVE
    back_to = _back_to(agenda, index, record)
    return Situation(
        state=record.state,
        reason=record.reason,
        steps=agenda,
        outcomes=MappingProxyType(outcomes),
        step=step,
        index=index,
        shown=step is not None and record.shown == step.id,
        confirmed=step is not None and record.confirmed == step.id,
        attached=record.attached,
        exchanged=record.exchanged,
        suspicion=record.suspicion,
        answered=() if step is None else record.answered.get(step.id, ()),
        acting=record.acting,
        initialisations=record.initialisations,
        zero=_zero(plan, step, record),
        zero_before=_zero_before(step, record),
        zeroed=_zeroed(record),
        forecast=forecast_of(record.precalibration, step.config if step else None),
        has_no_way=step is not None and _has_no_way(step, record),
        arm_at=record.arm_at,
        last_stop=record.last_stop,
        course=known.course(record.last_stop, step.id) if step is not None and moves else (),
        halted=tuple(
            known.course(record.last_stop, begun) for begun in reversed(record.begun) if begun in known.moves
        ),
        arrival=record.arrival,
        back_to=back_to,
        acts=acts_allowed(
            record.state,
            step,
            confirmed=step is not None and record.confirmed == step.id,
            suspected=record.suspicion is not None,
            can_go_back=back_to is not None,
        ),
        progress=_progress(agenda, outcomes, record),
        last=record.last,
        ballbar=record.known("ballbar"),
        robot=record.known("robot"),
        identities=tuple(record.identities),
    )


def _course(record: BallbarRecord) -> Course:
    """Return what of the past shapes the agenda."""
    return Course(record.skipped_poses, record.found)


def _present_index(
    agenda: tuple[BallbarStep, ...], outcomes: Mapping[str, Outcome], record: BallbarRecord
) -> int:
    """Return the place of the first open step, or of the one whose reading is under suspicion."""
    if record.suspicion is not None:
        suspected = step_ids.listed_step(
            record.suspicion.step_id
        )  # a zero in between is no step of the agenda
        return next(i for i, step in enumerate(agenda) if step.id == suspected)
    return next((i for i, step in enumerate(agenda) if outcomes[step.id].kind == "open"), len(agenda))


def _present(
    plan: BallbarPlan, agenda: tuple[BallbarStep, ...], index: int, record: BallbarRecord, known: Ways
) -> BallbarStep | None:
    if index == len(agenda):
        return None
    step = agenda[index]
    if record.suspicion is not None and record.suspicion.step_id == step.id:
        return step
    # First of all that must come before: no motion is ever the present step while the bar may be attached.
    if step.kind is StepKind.MOVE and record.attached:
        return _before(step, step_ids.detach(step.id), StepKind.DETACH)
    is_of_a_cup = step.base_point is not None and step.kind in {StepKind.MOVE, StepKind.CLAMP_CUP}
    if is_of_a_cup and not record.ball_fitted:
        return _before(step, step_ids.ball(step.id), StepKind.FIT_BALL)
    # A step of its own between the others, which the agenda does not list: whether it is needed shows only at
    # the reading.
    if _lacks_zero(plan, step, record):
        again = _before(step, step_ids.initialise(step.id), StepKind.INITIALISE)
        return replace(again, artefact=step.artefact or "base")
    if step.kind is not StepKind.MOVE:
        return step
    # From where the arm came to rest last, by ways that were looked at; nobody has looked whether a direct
    # way is clear.
    return replace(step, via_rad=known.between(record.last_stop, step.id))


def _lacks_zero(plan: BallbarPlan, step: BallbarStep, record: BallbarRecord) -> bool:
    """Whether the ballbar is to be put on the calibrator before a length is read."""
    if step.kind not in {StepKind.MEASURE_SIDE, StepKind.CONNECT_LEG}:
        return False
    return record.zero_lost or (plan.test == "sphere" and _zero(plan, step, record) is None)


def _before(step: BallbarStep, step_id: str, kind: StepKind) -> BallbarStep:
    """Return the step that has to come before another one."""
    return BallbarStep(step_id, kind, step.placement, step.config, attempt=step.attempt)


def _back_to(agenda: tuple[BallbarStep, ...], index: int, record: BallbarRecord) -> str | None:
    """Return the step that Back reopens: the last one a person ended, or the motion to its stop.

    There is no way back behind a pre-calibration, which rests on what came before it, nor to a placement
    whose fixture has been taken up.
    """
    if index < len(agenda) and _begins_a_later_placement(agenda[index], agenda):
        return None
    for step in reversed(agenda[:index]):
        if step.kind is StepKind.PRECALIBRATE:
            return None
        if record.outcome(step.id).kind != "skipped":
            return _with_its_stop(step.id, record)
        if record.skipped_at(step.id) == step.id:
            return _with_its_stop(step.id, record)
    return None


def _begins_a_later_placement(step: BallbarStep, agenda: tuple[BallbarStep, ...]) -> bool:
    if step.kind is not StepKind.PLACE_BASE:
        return False
    return any(other.placement not in {None, step.placement} for other in agenda[: agenda.index(step)])


def _with_its_stop(step_id: str, record: BallbarRecord) -> str:
    """Return the step, or the motion to its stop where the arm stands elsewhere by now."""
    group = step_ids.group_of(step_id)
    needs_stop = step_ids.is_of_a_stop(step_id)
    motion = step_ids.move(group)
    if not needs_stop or record.arm_at == motion or record.outcome(motion).kind == "skipped":
        return step_id
    return motion


def _zero(plan: BallbarPlan, step: BallbarStep | None, record: BallbarRecord) -> LengthTaken | None:
    """Return the zero of the stop; of a sphere test, whose stops share one, the last there was."""
    if step is None or step.kind not in READINGS or step.kind is StepKind.INITIALISE:
        return None
    own = record.zeros.get(step_ids.group_of(step.id))
    if own is not None or plan.test != "sphere" or record.last_zero is None:
        return own
    return record.last_zero[1]


def _zero_before(step: BallbarStep | None, record: BallbarRecord) -> LengthTaken | None:
    zeroed = _zeroed(record)
    if step is None or step.kind is not StepKind.INITIALISE or zeroed is None:
        return None
    bars, taken = zeroed
    return taken if bars == _bars_at(step.id) else None


def _zeroed(record: BallbarRecord) -> tuple[BarSet, LengthTaken] | None:
    if record.last_zero is None:
        return None
    step_id, taken = record.last_zero
    return _bars_at(step_id), taken


def _bars_at(step_id: str) -> BarSet:
    return "tool" if step_id.startswith(step_ids.TOOL) else "base"


def _skipped_poses(agenda: tuple[BallbarStep, ...], record: BallbarRecord) -> int:
    """Return how many poses there are whose last attempt ended with a skip."""
    return sum(group in record.skipped_poses for group in _last_attempts(agenda))


def _last_attempts(agenda: tuple[BallbarStep, ...]) -> set[str]:
    """Return the group of the last attempt at each pose."""
    motions = (step for step in agenda if step.kind is StepKind.MOVE and step.config is not None)
    return set({step.config: step_ids.group_of(step.id) for step in motions}.values())


def _has_no_way(step: BallbarStep, record: BallbarRecord) -> bool:
    found = record.precalibration
    if found is None or step.kind is not StepKind.MOVE or step.config is None:
        return False
    return step.config not in {pose.config for pose in found.poses}


def _progress(
    agenda: tuple[BallbarStep, ...], outcomes: Mapping[str, Outcome], record: BallbarRecord
) -> BallbarProgress:
    """Return how far the session is: what was left out for good is planned no longer."""
    measured = sum(outcomes[step.id].kind == "measured" for step in agenda if step.kind in READINGS)
    ahead = [step.kind for step in agenda if outcomes[step.id].kind == "open"]
    # A skipped pose stays planned as long as it will be offered again; otherwise the number of readings to
    # come would fall and rise.
    ahead += _to_be_tried_again(agenda, outcomes, record)
    return BallbarProgress(
        readings=measured,
        planned=measured + sum(kind in READINGS for kind in ahead),
        skipped_poses=_skipped_poses(agenda, record),
        elapsed_s=record.times.elapsed_s,
        remaining_s=remaining_s(record.times, ahead),
        pace_s_per_reading=pace_s_per_reading(record.times),
    )


def _to_be_tried_again(
    agenda: tuple[BallbarStep, ...], outcomes: Mapping[str, Outcome], record: BallbarRecord
) -> list[StepKind]:
    """Return the steps of skipped poses that the next pre-calibration will bring back."""
    due = {
        step.placement
        for step in agenda
        if step.kind is StepKind.PRECALIBRATE and outcomes[step.id].kind == "open"
    }
    again = _last_attempts(agenda) & record.skipped_poses
    return [
        step.kind
        for step in agenda
        if step.placement in due and step.attempt < MAX_ATTEMPTS and step_ids.group_of(step.id) in again
    ]
