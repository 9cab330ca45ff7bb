"""Planning a session once more: the same configurations, or as many chosen anew."""

import asyncio
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal, TypeAlias

from fastapi import Response, status
from pydantic import Field

from truepose.analysis.job_queue.tasks import PlanTask, RepeatTask
from truepose.domain.ballbar import BallbarPlan
from truepose.domain.cell import Cell
from truepose.domain.contacts import ContactPlan
from truepose.domain.session import PlannedStop, SessionPlan
from truepose.messages.message import Text, message
from truepose.sessions.ballbar.planning import BallbarPlanRequest, kit_of
from truepose.sessions.ballbar.planning import path_warnings_of_plan as judged_by_bar
from truepose.sessions.tracker.service import path_warnings_of_plan
from truepose.storage.errors import ConflictError
from truepose.storage.records import RequestKey, SessionRecord, SessionSetup
from truepose.web.api.jobs import JobReply, queued_job
from truepose.web.api.sessions.ballbar import queue_plan
from truepose.web.context import Context, Here
from truepose.web.pages.session_results import origin_of
from truepose.web.resources import CHANGE, Id, OptionalKey, Sender, resource
from truepose.web.schemas import NUMBER_LIMIT, VISIBLE, Number, Request, example


class RepeatRequest(Request):
    """A session to plan like an earlier one; planning does not move anything."""

    model_config = example({"name": "left arm, November", "poses": "same"})

    name: str = Field(min_length=1, max_length=200, pattern=VISIBLE, examples=["left arm, November"])
    poses: Literal["same", "anew"] = Field(
        "same",
        description="`same`: the earlier configurations. `anew`: the same number, chosen by the same "
        "rules in the present cell.",
    )
    configurations: list[Annotated[int, Field(ge=0, le=NUMBER_LIMIT)]] | None = Field(
        None,
        min_length=1,
        max_length=10_000,
        description="Numbers of the configurations to measure again; null for all. Ballbar sessions and "
        "tests can only be repeated as a whole.",
        examples=[[12, 17]],
    )
    attachment: Number | None = Field(
        None,
        description="Number of times the tool has been mounted; null for the same as in the earlier session.",
    )


def _in_part(plan: SessionPlan | ContactPlan, numbers: Collection[int]) -> SessionPlan | ContactPlan:
    if isinstance(plan, ContactPlan):
        return replace(plan, stops=tuple(stop for stop in plan.stops if stop.config in numbers))
    stops = (stop for stop in plan.stops if stop.config in numbers)
    return replace(plan, stops=tuple(_alone(stop, numbers) for stop in stops))


def _alone(stop: PlannedStop, numbers: Collection[int]) -> PlannedStop:
    """Return a stop that repeats none which is not measured again."""
    return stop if stop.repeat_of in numbers else replace(stop, repeat_of=None)


AnyPlan: TypeAlias = SessionPlan | BallbarPlan | ContactPlan


@dataclass(frozen=True, slots=True)
class Template:
    """A session that may be planned once more."""

    record: SessionRecord
    then: SessionSetup
    plan: AnyPlan
    asked: Mapping[str, Any]  # of the job that planned it; empty where its stops were given

    @property
    def is_test(self) -> bool:
        """Whether its stops belong together by a rule of their own, and are not chosen anew."""
        return "method" in self.asked or "proves_model_id" in self.asked or self.record.test is not None

    @property
    def can_be_chosen_anew(self) -> bool:
        """Whether as many other stops would do as well."""
        return not self.is_test and not isinstance(self.plan, ContactPlan)

    @property
    def can_be_repeated_in_part(self) -> bool:
        """Whether some of its stops may be measured without the others, whose ways a ballbar follows."""
        return not self.is_test and not isinstance(self.plan, BallbarPlan)

    def of_configurations(self, numbers: Collection[int]) -> "Template":
        """Return the template with these stops alone; raises ConflictError where it cannot have them."""
        if isinstance(self.plan, BallbarPlan) or not self.can_be_repeated_in_part:
            raise ConflictError(message("refused.repeated_whole", session=self.record.id))
        unknown = sorted(set(numbers) - {stop.config for stop in self.plan.stops})
        if unknown:
            raise ConflictError(
                message("refused.no_configuration", session=self.record.id, config=unknown[0])
            )
        plan = _in_part(self.plan, numbers)
        return replace(self, plan=plan, asked={**self.asked, "configurations": len(plan.stops)})

    @property
    def configurations(self) -> int:
        """How many places are measured, revisits not counted."""
        if isinstance(self.plan, SessionPlan):
            return sum(stop.repeat_of is None for stop in self.plan.stops)
        if isinstance(self.plan, BallbarPlan):
            return sum(len(placement.poses) for placement in self.plan.placements)
        return len(self.plan.stops)


async def template_of(here: Context, session_id: int) -> Template:
    """Return a session as a template; raises NotFoundError."""
    origin = await origin_of(here, session_id)
    plan = await here.session_desk.kind_of(origin.record).stored_plan(session_id)
    return Template(origin.record, await here.sessions.setup(session_id), plan, origin.asked)


async def plan_again(
    here: Context, template: Template, wanted: RepeatRequest, key: RequestKey | None, sender: str
) -> int:
    """Queue the session and return the job's number; raises ConflictError where it is of another robot."""
    _require_same_robot(template, here.cell)
    if wanted.configurations is not None:
        template = template.of_configurations(wanted.configurations)
    setup = SessionSetup(_cell(here.cell, template.plan), wanted.attachment or template.then.attachment)
    if wanted.poses == "same":
        return await _same(here, template, setup, wanted.name, key, sender)
    return await _anew(here, template, setup, wanted.name, key, sender)


def _require_same_robot(template: Template, now: Cell) -> None:
    then = template.then.cell.robot.name
    if then != now.robot.name:
        raise ConflictError(
            message("refused.other_robot", session=template.record.id, then=then, now=now.robot.name)
        )


def _cell(now: Cell, plan: AnyPlan) -> Cell:
    """Return the cell of now, with as many cups of the ballbar's base as were measured from."""
    if not isinstance(plan, BallbarPlan) or now.ballbar is None:
        return now
    cups = len(plan.placements[0].cups_mm)
    return replace(now, ballbar=replace(now.ballbar, base_points=3 if cups == 3 else 4))


async def _same(
    here: Context, template: Template, setup: SessionSetup, name: str, key: RequestKey | None, sender: str
) -> int:
    plan = template.plan
    if isinstance(plan, SessionPlan):
        plan = _of_today(plan, setup.cell)

    async def check(again: Any) -> Text:
        return await _what_to_watch(here, setup, again)

    asked = {**template.asked, "role": template.record.role, "repeats_session_id": template.record.id}
    return await here.job_desk.repeat(name, RepeatTask(setup, plan, asked), check, key, sender)


def _of_today(plan: SessionPlan, cell: Cell) -> SessionPlan:
    """Return a plan with the limits that the cell file states now."""
    return replace(
        plan,
        tool_speed_mm_s=cell.limits.tool_speed_mm_s,
        orientation_speed_rad_s=cell.limits.orientation_speed_rad_s,
        reference_limit_mm=cell.limits.reference_mm,
        measures="points" if cell.camera is None else "poses",
    )


async def _what_to_watch(here: Context, setup: SessionSetup, plan: AnyPlan) -> Text:
    """Return what to watch on the ways of a plan; raises PlanRefusedError where the cell cannot do it now."""
    if isinstance(plan, ContactPlan):
        return await here.contact_sessions.what_to_watch(setup, plan)
    if isinstance(plan, BallbarPlan):
        await here.ballbar_sessions.require_possible(setup, plan)
        return await asyncio.to_thread(judged_by_bar, setup.cell, plan, kit_of(setup))
    return await asyncio.to_thread(path_warnings_of_plan, setup.cell, plan)


async def _anew(
    here: Context, template: Template, setup: SessionSetup, name: str, key: RequestKey | None, sender: str
) -> int:
    """Queue the choice of as many stops; the number of the session then is their seed."""
    plan, n, seed = template.plan, template.configurations, template.record.id
    if isinstance(plan, ContactPlan) or not template.can_be_chosen_anew:
        raise ConflictError(message("refused.same_configurations", session=template.record.id))
    if isinstance(plan, BallbarPlan):
        frames = tuple(placement.frame for placement in plan.placements)
        wish = BallbarPlanRequest(frames=frames, poses=n, seed=seed)
        return await queue_plan(here, name, setup, wish, key, sender)
    empty = replace(_of_today(plan, setup.cell), stops=())
    return await here.job_desk.plan(name, PlanTask(setup, empty, n, seed), key, sender=sender)


router = resource("/sessions", tags=["sessions"])


@router.post("/{id}/again", status_code=status.HTTP_202_ACCEPTED, responses=CHANGE)
async def plan_session_again(
    here: Here, id: Id, wanted: RepeatRequest, response: Response, key: OptionalKey, sender: Sender
) -> JobReply:
    """Plan a session like an earlier one of any kind; the result of the job is the session. Nothing moves.

    Robot, kind, configurations, nests and cups are those of the earlier session, unless they are chosen anew;
    the cell, its limits and its instruments are those of the present cell file.
    """
    template = await template_of(here, id)
    return await queued_job(here, await plan_again(here, template, wanted, key, sender), response)
