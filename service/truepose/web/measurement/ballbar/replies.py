"""From ballbar sessions to what travels."""

from truepose.domain.cell.artefacts import Bars
from truepose.domain.measurement.ballbar import (
    BallbarStep,
    Leg,
    StepKind,
    Suspicion,
)
from truepose.domain.sentences import said
from truepose.operation.ballbar.view import BallbarView
from truepose.sequencing.ballbar.plan import step_ids
from truepose.sequencing.ballbar.situation import Situation
from truepose.sequencing.ballbar.state_so_far import Outcome
from truepose.storage.records import LedgerRecord
from truepose.web.schemas.measurement.ballbar_sessions import (
    ActingReply,
    BallbarProgressReply,
    BallbarSessionReply,
    EntryReply,
    LastOutcomeReply,
    ListedStepReply,
    PresentStepReply,
    StepReply,
    StepsReply,
    SuspicionReply,
)
from truepose.web.schemas.measurement.identities import identity_reply
from truepose.words.catalogue import english


def ballbar_session_reply(view: BallbarView) -> BallbarSessionReply:
    """Return a ballbar session as it travels."""
    found = view.situation
    suspicion = None if found.suspicion is None else found.suspicion.suspicion
    return BallbarSessionReply(
        id=view.id,
        name=view.name,
        state=found.state,
        reason=found.reason,
        result_url=f"/sessions/{view.id}/result" if view.plan.test else f"/sessions/{view.id}",
        simulated=view.setup.simulated,
        robot=view.setup.cell.robot.name,
        question=view.question,
        prompt_id=view.prompt_id,
        trouble=view.trouble,
        motion_notice=view.motion_notice,
        people=list(view.people),
        ledger_number=view.newest_entry,
        step=_present_step(view),
        suspicion=None if suspicion is None else suspicion_reply(suspicion, _artefact(found)),
        swaps_can_be_seen=view.sight.sees_swaps(found),
        legs_alike=[[_leg(first), _leg(second)] for first, second in view.sight.alike(found)],
        unseen_swaps_poses=list(unseen := view.sight.unseen(found)),
        unseen_swaps=_unseen_swaps(unseen),
        ballbar_attached=found.attached,
        robot_moving=view.robot_moving,
        acts=sorted(found.acts),
        progress=BallbarProgressReply.of(found.progress),
        acting=None if found.acting is None else ActingReply.of(found.acting),
        watching=view.watching,
        last_outcome=_last_outcome(found),
        ballbar_in_question=None if found.ballbar.foreign is None else identity_reply(found.ballbar.foreign),
        identities=[identity_reply(taken) for taken in found.identities],
    )


def _leg(leg: Leg) -> list[str]:
    return [f"B{leg[0]}", f"T{leg[1]}"]


def _unseen_swaps(poses: tuple[int, ...]) -> str:
    if not poses:
        return ""
    key = "session.unseen_swaps.one" if len(poses) == 1 else "session.unseen_swaps.several"
    return english(said(key, poses=tuple(map(str, poses))))


def steps_reply(view: BallbarView) -> StepsReply:
    """Return all steps as they travel."""
    found = view.situation
    return StepsReply(steps=[_listed(view, step, found.outcomes[step.id]) for step in found.steps])


def entry_reply(record: LedgerRecord) -> EntryReply:
    """Return an entry of the ledger as it travels."""
    entry, suspicion = record.entry, record.entry.suspicion
    artefact = _artefact_of_id(entry.step_id)
    return EntryReply.of(
        record,
        entry,
        number=record.id,
        text=entry.told,
        suspicion=None if suspicion is None else suspicion_reply(suspicion, artefact),
        identity=None if entry.identity is None else identity_reply(entry.identity),
    )


def suspicion_reply(suspicion: Suspicion, artefact: str | None) -> SuspicionReply:
    """Return a suspicion as it travels; `artefact` is the triangle that is measured, None for a leg."""
    suspected = suspicion.suspected
    return SuspicionReply.of(
        suspicion,
        asked=point_names(suspicion.asked, artefact),
        suspected=None if suspected is None else point_names(suspected, artefact),
    )


def point_names(points: tuple[int, int], artefact: str | None) -> list[str]:
    """Return the names of two points: of one triangle, or of base and tool."""
    first = "T" if artefact == "tool" else "B"
    second = "B" if artefact == "base" else "T"
    return [f"{first}{points[0]}", f"{second}{points[1]}"]


def _artefact(found: Situation) -> str | None:
    return None if found.step is None else _side_of(found.step)


def _artefact_of_id(step_id: str) -> str | None:
    if step_ids.kind_of(step_id) is not StepKind.MEASURE_SIDE:
        return None
    return "tool" if step_id.startswith(step_ids.TOOL) else "base"


def _side_of(step: BallbarStep) -> str | None:
    return step.artefact if step.kind is StepKind.MEASURE_SIDE else None


def _present_step(view: BallbarView) -> PresentStepReply | None:
    found, step = view.situation, view.situation.step
    if step is None:
        return None
    number, count = _place_among_legs(found, step)
    return PresentStepReply.of(
        _step(view, step),
        index=found.index + 1,
        count=len(found.steps),
        confirmed=found.confirmed,
        leg_number=number,
        leg_count=count,
    )


def _place_among_legs(found: Situation, step: BallbarStep) -> tuple[int | None, int | None]:
    if step.kind is not StepKind.CONNECT_LEG:
        return None, None
    group = step_ids.group_of(step.id)
    legs = [
        other.id
        for other in found.steps
        if other.kind is StepKind.CONNECT_LEG and step_ids.group_of(other.id) == group
    ]
    return legs.index(step.id) + 1, len(legs)


def _step(view: BallbarView, step: BallbarStep) -> StepReply:
    bars = _bars(view, step)
    return StepReply.of(
        step,
        points=None if step.points is None else point_names(step.points, _side_of(step)),
        bars_mm=None if bars is None else bars.bars_mm,
        nominal_mm=None if bars is None else bars.nominal_mm,
    )


def _bars(view: BallbarView, step: BallbarStep) -> Bars | None:
    """Return what the ballbar is made up with at a step; None where it takes no part."""
    if step.kind is StepKind.CONNECT_LEG or step.artefact == "base":
        return view.kit.base_bars
    return view.kit.tool_bars if step.artefact == "tool" else None


def _listed(view: BallbarView, step: BallbarStep, outcome: Outcome) -> ListedStepReply:
    return ListedStepReply.of(
        _step(view, step), outcome=outcome.kind, length_mm=_stored_mm(outcome), text=outcome.text
    )


def _last_outcome(found: Situation) -> LastOutcomeReply | None:
    if found.last is None:
        return None
    step_id, outcome = found.last
    return LastOutcomeReply(
        step_id=step_id, kind=outcome.kind, length_mm=_stored_mm(outcome), text=outcome.text
    )


def _stored_mm(outcome: Outcome) -> float | None:
    return None if outcome.length is None else outcome.length.length_mm
