"""Sessions that run while nobody is in the cell, as they travel: with a tracker, a camera, gauges."""

import asyncio
from typing import TYPE_CHECKING

from truepose.analysis.campaigns.contacts import readings_of
from truepose.analysis.job_queue.tasks import ContactPlanTask, PlanTask
from truepose.domain.contacts import ContactPlan
from truepose.domain.session import SessionPlan
from truepose.messages.message import Text, message
from truepose.sessions.contact.dry_run import minutes_of
from truepose.sessions.contact.service import ContactSessions
from truepose.sessions.contact.state import Question, open_prompt
from truepose.sessions.tracker.reflector_monitor import Sighting
from truepose.sessions.tracker.service import TrackerSessions, path_warnings_of_plan
from truepose.storage.errors import ConflictError
from truepose.storage.records import SessionSetup
from truepose.web.api.sessions.contact_schemas import (
    ContactPlanReply,
    ContactSessionRequest,
    plan_reply,
    wish_of,
)
from truepose.web.api.sessions.guides import GuidedSceneReply, GuideReply, guide_reply
from truepose.web.api.sessions.kind import KindOfSession, Planned, Planning
from truepose.web.api.sessions.schemas import (
    ChosenStops,
    CircleStops,
    GivenStops,
    PlanReply,
    PoseStops,
    ProvingStops,
    SessionRequest,
    plan_of,
    plan_task,
)
from truepose.web.api.spaces import StopState
from truepose.web.context import Context
from truepose.web.middleware.language import in_words

if TYPE_CHECKING:
    from truepose.reports.plan_3d import Place


class UnattendedKind(KindOfSession):
    """What both share: a tablet guides through them."""

    async def situation(self, here: Context, id: int) -> GuideReply:
        """Return where a session stands."""
        return guide_reply(await here.guided_sessions.guide(id))

    def sample(self, seen: Sighting) -> dict[str, object]:
        """Return where the reflector is, as it is streamed."""
        aim = seen.aim
        return {
            "sampled_at_ms": seen.sampled_at_ms,
            "config": None if aim is None else aim.config,
            "nest": None if aim is None else aim.nest,
            "fixed_nest": None if aim is None else aim.fixed_nest,
            "expected_mm": None if aim is None else aim.expected_mm,
            "tolerance_mm": None if aim is None else aim.tolerance_mm,
            "delta_mm": seen.delta_mm,
            "distance_mm": seen.distance_mm,
            "state": seen.state,
            "is_seen": seen.is_seen,
            "is_moving": seen.is_moving,
        }

    async def scene(self, here: Context, id: int) -> GuidedSceneReply:
        """Return the cell as its instrument sees it."""
        return GuidedSceneReply.of(await here.guided_sessions.scene(id))


class TrackerKind(UnattendedKind):
    """Sessions with a laser tracker or a camera."""

    roles = TrackerSessions.roles
    called = "tracker"

    async def plan(self, here: Context, wanted: SessionRequest, planning: Planning) -> Planned:
        """Plan a session whose configurations are given; else have a job choose them."""
        setup = SessionSetup(here.cell, wanted.attachment)
        plan = plan_of(wanted, here.cell)
        if not isinstance(wanted.plan, GivenStops):
            return Planned(await _queue(here, wanted, setup, plan, planning), by_job=True)
        notice = await asyncio.to_thread(path_warnings_of_plan, here.cell, plan)
        return Planned(await here.sessions.add(wanted.name, setup, plan, planning.key, notice))

    async def places(self, here: Context, id: int) -> "tuple[list[Place], dict[int, StopState]]":
        """Return where the plan sends the arm, and what became of each stop."""
        from truepose.reports.plan_3d import Place

        plan = await here.sessions.plan(id)
        states: dict[int, StopState] = {one.config: "skipped" for one in await here.sessions.skipped(id)}
        states |= {point.config: "measured" for point in await here.readings.points(id)}
        return [Place(stop.config, stop.joints_rad, stop.nest) for stop in plan.stops], states

    async def planned_steps(self, here: Context, id: int) -> PlanReply:
        """Return the configurations and how they are measured."""
        return await asyncio.to_thread(PlanReply.of, await here.sessions.plan(id))


async def _queue(
    here: Context, wanted: SessionRequest, setup: SessionSetup, plan: SessionPlan, planning: Planning
) -> int:
    key, sender = planning.key, planning.sender
    match wanted.plan:
        case ProvingStops(model_id=model_id, targets=targets, seed=seed):
            _require_validation(wanted)
            proved = (await here.results.model(model_id)).model
            task = PlanTask(setup, plan, targets, seed, proved)
            return await here.job_desk.plan(wanted.name, task, key, model_id, sender)
        case ChosenStops(configurations=configurations, seed=seed):
            task = PlanTask(setup, plan, configurations, seed)
            return await here.job_desk.plan(wanted.name, task, key, sender=sender)
        case CircleStops() | PoseStops() as test:
            _require_validation(wanted)
            return await here.job_desk.plan(wanted.name, plan_task(test, setup, plan), key, sender=sender)
    raise AssertionError("given stops are no job")


def _require_validation(wanted: SessionRequest) -> None:
    if wanted.role != "validation":
        raise ConflictError(message("refused.judging_role"))


class ContactKind(UnattendedKind):
    """Sessions with a probe, gauges, wires or a sensor."""

    roles = ContactSessions.roles
    called = "contact"

    async def plan(self, here: Context, wanted: ContactSessionRequest, planning: Planning) -> Planned:
        """Plan a session whose configurations are chosen, here or by a job."""
        setup, wish = SessionSetup(here.cell, wanted.attachment), wish_of(wanted)
        if not planning.later:
            return Planned(await here.contact_sessions.plan(wanted.name, setup, wish, planning.key))

        async def check(plan: ContactPlan) -> Text:
            return await here.contact_sessions.what_to_watch(setup, plan)

        task = ContactPlanTask(setup, wish)
        return Planned(
            await here.job_desk.plan_checked(wanted.name, task, check, planning.key, planning.sender),
            by_job=True,
        )

    async def places(self, here: Context, id: int) -> "tuple[list[Place], dict[int, StopState]]":
        """Return where the plan sends the arm, and what became of each stop."""
        from truepose.reports.plan_3d import Place

        plan = await here.sessions.contact_plan(id)
        taken = readings_of(line.entry for line in await here.session_desk.ledger.whole(id))
        states: dict[int, StopState] = {one.config: "measured" for one in taken}
        return [Place(stop.config, stop.joints_rad, plan.nest) for stop in plan.stops], states

    async def planned_steps(self, here: Context, id: int) -> ContactPlanReply:
        """Return what a session asks and does."""
        plan, cell = await here.sessions.contact_plan(id), (await here.sessions.setup(id)).cell
        minutes = await asyncio.to_thread(minutes_of, plan, cell.robot, cell.base_nominal)
        return plan_reply(plan, [in_words(open_prompt(question, plan)) for question in Question], minutes)
