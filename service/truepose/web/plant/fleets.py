"""The page of a plant that compares the robots of a type: robot, type or instrument, and since when."""

from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Annotated, Final

from fastapi import APIRouter, Query
from fastapi.responses import HTMLResponse

from truepose.domain.errors import TrueposeError
from truepose.storage.plant.looking import ResultSeen
from truepose.web.plant.context import PlantContext, PlantHere
from truepose.web.plant.fleet_drawn import FleetAsked, drawn_fleet
from truepose.web.visiting.drawn import Whole, drawn_part
from truepose.web.visiting.visits import Visit, Visited

router = APIRouter(include_in_schema=False)
_MOST: Final = 400  # campaigns of a type that are compared, the latest
_LIMIT_MM: Final = 0.1
_FEWEST_ROBOTS: Final = 2
OfType = Annotated[str | None, Query(alias="type", max_length=200)]
LimitMm = Annotated[float, Query(gt=0.0, le=100.0, allow_inf_nan=False)]


@dataclass(frozen=True, slots=True)
class Standing:
    """What the campaigns of a type are enough for."""

    name: str
    usable: tuple[ResultSeen, ...]  # of which robot, instrument and day are known; by day
    unusable: int
    robots: int
    repeated: int  # robots that were measured on two days at least

    @property
    def is_enough(self) -> bool:
        """Whether robots can be compared."""
        return self.robots >= _FEWEST_ROBOTS and self.repeated > 0


@router.get("/fleet", response_class=HTMLResponse)
async def fleet_page(
    visit: Visited, here: PlantHere, of_type: OfType = None, limit: LimitMm = _LIMIT_MM, whole: Whole = False
) -> HTMLResponse:
    """Compare the robots of a type from all that was collected, or say what is missing."""
    types = _types(await here.fleets.campaigns())
    chosen = next((one for one in types if one.name == of_type), types[0] if types else None)
    content, why = None, ""
    if chosen is not None and chosen.is_enough:
        of = f"fleet {chosen.name} {len(chosen.usable)} {max(one.id for one in chosen.usable)} {limit}"
        try:
            content = await drawn_part(visit, of, lambda: _drawn(visit, here, chosen, limit), whole=whole)
        except TrueposeError as error:
            why = str(error)
    return visit.page(
        "plant/fleet.html", types=types, chosen=chosen, content=content, why=why, limit=limit, most=_MOST
    )


def _types(campaigns: Sequence[ResultSeen]) -> list[Standing]:
    """Return the types of robots, that with the most campaigns first."""
    by_type: defaultdict[str, list[ResultSeen]] = defaultdict(list)
    for campaign in campaigns:
        by_type[campaign.robot].append(campaign)
    return sorted((_standing(*one) for one in by_type.items()), key=lambda one: -len(one.usable))


def _standing(name: str, campaigns: Sequence[ResultSeen]) -> Standing:
    known = [
        one
        for one in campaigns
        if one.robot_serial_number and one.instrument_serial_number and one.measured_on
    ]
    latest = tuple(sorted(known, key=lambda one: (one.measured_on, one.id))[-_MOST:])
    days = Counter(robot for robot, _ in {(one.robot_serial_number, one.measured_on) for one in latest})
    repeated = sum(count > 1 for count in days.values())
    return Standing(name, latest, len(campaigns) - len(known), len(days), repeated)


async def _drawn(visit: Visit, here: PlantContext, of: Standing, limit_mm: float) -> str:
    told = await here.fleets.told(of.usable)
    computed_at = f"{datetime.now(UTC):%Y-%m-%d %H:%M} UTC"
    asked = FleetAsked(of.name, told, limit_mm, visit.words.tag, computed_at)
    return await here.drawing_desk.draw(drawn_fleet, asked)
