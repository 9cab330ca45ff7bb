"""Sessions in space: where the plan sends the arm, what was measured there, and what comes next."""

import asyncio
from collections import defaultdict
from typing import TYPE_CHECKING, Final

from truepose.analysis.campaigns.contacts import taken_of
from truepose.domain.cell.description import Cell
from truepose.domain.measurement.ballbar import StepKind
from truepose.operation.ballbar.view import BallbarView
from truepose.storage.records import SessionRecord
from truepose.web.context import Context, Here
from truepose.web.problems import problems
from truepose.web.requests.parameters import Id
from truepose.web.resources import resource
from truepose.web.schemas.calibration.spaces import PlanSpaceReply, StopState, plan_space_reply

if TYPE_CHECKING:
    from truepose.reports.spaces.plan import Place

router = resource("/sessions", tags=["spaces"])
_MOST: Final = 120  # stops, of which a picture is still read


@router.get("/{id}/space", responses=problems(404, 409, 422, 503))
async def get_session_space(here: Here, id: Id) -> PlanSpaceReply:
    """Show a session in space by the nominal robot: arm, tool and bars at each stop, measured or to come."""
    record = await here.sessions.get(id)
    cell = (await here.sessions.setup(id)).cell
    places, states = await _planned(here, record)
    registration = await here.sessions.registration(id)
    seen_from = None if registration is None else tuple(registration.translation_mm.tolist())
    return await asyncio.to_thread(_drawn, cell, places, states, seen_from)


def _drawn(
    cell: Cell,
    places: "list[Place]",
    states: dict[int, StopState],
    instrument_mm: tuple[float, float, float] | None,
) -> PlanSpaceReply:
    from truepose.reports.spaces.plan import plan_space

    return plan_space_reply(plan_space(cell, _selected(places, states), states, instrument_mm))


def _selected(places: "list[Place]", states: dict[int, StopState]) -> "list[Place]":
    """Return an even selection of many stops, the next one always among them."""
    every = -(-len(places) // _MOST)
    coming = next((place for place in places if place.config not in states), None)
    return [place for row, place in enumerate(places) if row % every == 0 or place is coming]


async def _planned(here: Context, record: SessionRecord) -> "tuple[list[Place], dict[int, StopState]]":
    if record.role == "ballbar":
        return await _by_ballbar(here, record.id)
    if record.role == "contacts":
        return await _by_contacts(here, record.id)
    return await _by_tracker(here, record.id)


async def _by_tracker(here: Context, number: int) -> "tuple[list[Place], dict[int, StopState]]":
    from truepose.reports.spaces.plan import Place

    plan = await here.sessions.plan(number)
    states: dict[int, StopState] = {
        skipped.config: "skipped" for skipped in await here.sessions.skipped(number)
    }
    states |= {point.config: "measured" for point in await here.readings.points(number)}
    return [Place(stop.config, stop.joints_rad, stop.nest) for stop in plan.stops], states


async def _by_contacts(here: Context, number: int) -> "tuple[list[Place], dict[int, StopState]]":
    from truepose.reports.spaces.plan import Place

    plan = await here.sessions.contact_plan(number)
    kept = await here.session_desk.ledger.whole(number)
    taken = taken_of(line.entry for line in kept)
    states: dict[int, StopState] = {one.config: "measured" for one in taken}
    return [Place(stop.config, stop.joints_rad, plan.nest) for stop in plan.stops], states


async def _by_ballbar(here: Context, number: int) -> "tuple[list[Place], dict[int, StopState]]":
    from truepose.reports.spaces.plan import ballbar_places

    view = await here.ballbar_sessions.view(number)
    return list(ballbar_places(view.plan)), _states_of_poses(view)


def _states_of_poses(view: BallbarView) -> dict[int, StopState]:
    """Return what became of each pose of which no leg is to come."""
    kinds: dict[int, set[str]] = defaultdict(set)
    for step in view.situation.steps:
        if step.kind is StepKind.CONNECT_LEG and step.config is not None:
            kinds[step.config].add(view.situation.outcomes[step.id].kind)
    ended = {config: kept for config, kept in kinds.items() if "open" not in kept}
    return {config: "skipped" if kept == {"skipped"} else "measured" for config, kept in ended.items()}
