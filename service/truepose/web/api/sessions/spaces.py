"""Sessions in space: where the plan sends the arm, what was measured there, and what comes next."""

import asyncio
from typing import TYPE_CHECKING, Final

from truepose.domain.cell import Cell
from truepose.web.api.sessions.kinds import kind_of
from truepose.web.api.spaces import PlanSpaceReply, StopState
from truepose.web.context import Here
from truepose.web.resources import ACT, Id, resource

if TYPE_CHECKING:
    from truepose.reports.plan_3d import Place

router = resource("/sessions", tags=["spaces"])
_MOST: Final = 120  # stops, of which a picture is still read


@router.get("/{id}/space", responses=ACT)
async def get_session_space(here: Here, id: Id) -> PlanSpaceReply:
    """Return the nominal arm, tool and bars in 3D at each configuration, measured or still to come."""
    record = await here.sessions.get(id)
    cell = (await here.sessions.setup(id)).cell
    places, states = await kind_of(record).places(here, id)
    registration = await here.sessions.registration(id)
    seen_from = None if registration is None else tuple(registration.translation_mm.tolist())
    return await asyncio.to_thread(_drawn, cell, places, states, seen_from)


def _drawn(
    cell: Cell,
    places: "list[Place]",
    states: dict[int, StopState],
    instrument_mm: tuple[float, float, float] | None,
) -> PlanSpaceReply:
    from truepose.reports.plan_3d import plan_space

    space = plan_space(cell, _selected(places, states), states, instrument_mm)
    coming = None if space.next is None else space.stops[space.next].config
    return PlanSpaceReply.of(space, next_config=coming)


def _selected(places: "list[Place]", states: dict[int, StopState]) -> "list[Place]":
    """Return an even selection of many stops, the next one always among them."""
    every = -(-len(places) // _MOST)
    coming = next((place for place in places if place.config not in states), None)
    return [place for row, place in enumerate(places) if row % every == 0 or place is coming]
