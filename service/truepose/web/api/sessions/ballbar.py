"""Ballbar sessions as they travel: how one is planned, where it stands, its samples, its ledger."""

import asyncio
from collections import defaultdict
from dataclasses import asdict, replace
from typing import TYPE_CHECKING

from truepose.domain.ballbar import BallbarPlan, BallbarStep, Leg, StepKind, Suspicion
from truepose.domain.cell import Bars
from truepose.messages.message import message
from truepose.sessions.ballbar import step_ids
from truepose.sessions.ballbar.live import LiveSample
from truepose.sessions.ballbar.planning import BallbarPlanRequest, kit_of, plan_task
from truepose.sessions.ballbar.scene import scene_of
from truepose.sessions.ballbar.service import BallbarSessions, BallbarView
from truepose.sessions.ballbar.situation import Situation
from truepose.sessions.ballbar.state import Outcome
from truepose.storage.records import LedgerRecord, RequestKey, SessionSetup
from truepose.web.api.sessions.ballbar_replies import (
    ActingReply,
    BallbarProgressReply,
    BallbarSessionReply,
    EntryReply,
    LastOutcomeReply,
    ListedStepReply,
    PresentStepReply,
    SceneReply,
    StepReply,
    StepsReply,
    SuspicionReply,
)
from truepose.web.api.sessions.ballbar_requests import BallbarSessionRequest, wanted_plan
from truepose.web.api.sessions.kind import KindOfSession, Planned, Planning
from truepose.web.api.sessions.situations import situation_reply
from truepose.web.api.spaces import StopState
from truepose.web.context import Context
from truepose.web.middleware.language import in_words
from truepose.web.resources import while_present

if TYPE_CHECKING:
    from truepose.reports.plan_3d import Place


class BallbarKind(KindOfSession):
    """Sessions in which a person in the cell connects the ballbar."""

    roles = BallbarSessions.roles
    called = "ballbar"
    tablet_page = "ballbar_session.html"

    async def plan(self, here: Context, wanted: BallbarSessionRequest, planning: Planning) -> Planned:
        """Plan a session; where its poses are to be chosen, that takes up to a minute or is a job.

        One plan is made at a time and a few wait (503 for further ones). It ends with the connection; with a
        key it goes on for half a minute, in which the same request finds it again.
        """
        kit = kit_of(SessionSetup(here.cell))
        if wanted.base_points is not None:
            kit = replace(kit, base_points=wanted.base_points)
        setup, wish = SessionSetup(replace(here.cell, ballbar=kit)), await _wish(here, wanted)
        if planning.later and wish.given is None:
            return Planned(
                await queue_plan(here, wanted.name, setup, wish, planning.key, planning.sender), by_job=True
            )
        choosing = here.ballbar_sessions.plan(wanted.name, setup, wish, planning.key)
        return Planned(await while_present(planning.request, choosing))

    async def situation(self, here: Context, id: int) -> BallbarSessionReply:
        """Return where a session stands."""
        return ballbar_session_reply(await here.ballbar_sessions.view(id))

    def sample(self, seen: LiveSample) -> dict[str, object]:
        """Return the newest value of the ballbar, as it is streamed."""
        return asdict(seen)

    async def planned_steps(self, here: Context, id: int) -> StepsReply:
        """Return all steps, in order, with what became of them."""
        return steps_reply(await here.ballbar_sessions.view(id))

    async def places(self, here: Context, id: int) -> "tuple[list[Place], dict[int, StopState]]":
        """Return where the plan sends the arm, and what became of each pose of which no leg is to come."""
        from truepose.reports.plan_3d import ballbar_places

        view = await here.ballbar_sessions.view(id)
        return list(ballbar_places(view.plan)), _states_of_poses(view.situation)

    async def scene(self, here: Context, id: int) -> SceneReply:
        """Return the geometry of the present step: cups, nests, arm, and where the person stands."""
        view = await here.ballbar_sessions.view(id)
        return SceneReply.of(await asyncio.to_thread(scene_of, view))


def _states_of_poses(found: Situation) -> dict[int, StopState]:
    kinds: dict[int, set[str]] = defaultdict(set)
    for step in found.steps:
        if step.kind is StepKind.CONNECT_LEG and step.config is not None:
            kinds[step.config].add(found.outcomes[step.id].kind)
    ended = {config: kept for config, kept in kinds.items() if "open" not in kept}
    return {config: "skipped" if kept == {"skipped"} else "measured" for config, kept in ended.items()}


async def queue_plan(
    here: Context,
    name: str,
    setup: SessionSetup,
    wish: BallbarPlanRequest,
    key: RequestKey | None,
    sender: str,
) -> int:
    """Queue the choice of a session's poses and return the job's number."""

    async def check(plan: BallbarPlan) -> str:
        await here.ballbar_sessions.require_possible(setup, plan)
        return ""  # the chooser keeps the ways clear

    return await here.job_desk.plan_checked(name, plan_task(setup, wish), check, key, sender)


async def _wish(here: Context, wanted: BallbarSessionRequest) -> BallbarPlanRequest:
    if wanted.plan is None or wanted.plan.model_id is None:
        return wanted_plan(wanted)
    return wanted_plan(wanted, (await here.results.model(wanted.plan.model_id)).model)


def ballbar_session_reply(view: BallbarView) -> BallbarSessionReply:
    """Return a ballbar session as it travels."""
    found = view.situation
    suspicion = None if found.suspicion is None else found.suspicion.suspicion
    return situation_reply(
        BallbarSessionReply,
        view.id,
        view.setup,
        found,
        view.attendance,
        kind="ballbar",
        name=view.name,
        result_url=f"/sessions/{view.id}/result" if view.plan.test else f"/sessions/{view.id}",
        step=_present_step(view),
        suspicion=None if suspicion is None else suspicion_reply(suspicion, _artefact(found)),
        main_answer=None if found.suspicion is None else found.suspicion.main_answer,
        swaps_can_be_seen=view.sight.sees_swaps(found),
        legs_alike=[[_leg(first), _leg(second)] for first, second in view.sight.alike(found)],
        unseen_swaps_poses=list(unseen := view.sight.unseen(found)),
        unseen_swaps=_unseen_swaps(unseen),
        ballbar_attached=found.attached,
        progress=BallbarProgressReply.of(found.progress),
        acting=None if found.acting is None else ActingReply.of(found.acting),
        last_outcome=_last_outcome(found),
        ballbar_in_question=found.ballbar.foreign,
    )


def _leg(leg: Leg) -> list[str]:
    return [f"B{leg[0]}", f"T{leg[1]}"]


def _unseen_swaps(poses: tuple[int, ...]) -> str:
    if not poses:
        return ""
    return in_words(message("session.unseen_swaps", n=len(poses), poses=tuple(map(str, poses))))


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
        _step(view, step), outcome=outcome.kind, length_mm=_stored_mm(outcome), text=in_words(outcome.text)
    )


def _last_outcome(found: Situation) -> LastOutcomeReply | None:
    if found.last is None:
        return None
    step_id, outcome = found.last
    return LastOutcomeReply(
        step_id=step_id, kind=outcome.kind, length_mm=_stored_mm(outcome), text=in_words(outcome.text)
    )


def _stored_mm(outcome: Outcome) -> float | None:
    return None if outcome.length is None else outcome.length.length_mm
