"""The page of a plant that compares the robots of a type: robot, type or instrument, and since when."""

import hashlib
from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import UTC, date, datetime
from typing import Annotated, Final

from fastapi import APIRouter, Query
from fastapi.responses import HTMLResponse
from markupsafe import Markup

from truepose.analysis.errors import ClusterError
from truepose.domain.errors import TrueposeError, text_of
from truepose.fleet.outcome import fleet_missing
from truepose.plant.calibration_due import latest_day
from truepose.storage.plant.queries import ResultRecord
from truepose.web.pages.rendering import Visit, Visited, Whole, render_part
from truepose.web.plant.context import PlantContext, PlantHere
from truepose.web.plant.figures import LIMIT_MM, FleetDrawing, draw_fleet

router = APIRouter(include_in_schema=False)
_MOST: Final = 400  # campaigns of a type that are compared, the latest
_FEWEST_ROBOTS: Final = 2
OfType = Annotated[str | None, Query(alias="type", max_length=200)]
LimitMm = Annotated[float, Query(gt=0.0, le=100.0, allow_inf_nan=False)]


@dataclass(frozen=True, slots=True)
class TypeMeasured:
    """What the campaigns of a type are enough for."""

    name: str
    usable: tuple[ResultRecord, ...]  # of which robot, instrument and a day that has come are known; by day
    unusable: int
    robots: int
    repeated: int  # robots that were measured on two days at least

    @property
    def is_enough(self) -> bool:
        """Whether robots can be compared."""
        return self.robots >= _FEWEST_ROBOTS and self.repeated > 0


@dataclass(frozen=True, slots=True)
class FleetChoice:
    """What is compared."""

    robot: str  # the type
    campaigns: tuple[ResultRecord, ...]
    limit_mm: float

    @property
    def named(self) -> str:
        """All that the comparison follows from."""
        numbers = " ".join(str(one.id) for one in self.campaigns)
        return f"fleet {self.robot} {hashlib.sha256(numbers.encode()).hexdigest()} {self.limit_mm}"


@dataclass(frozen=True, slots=True)
class FleetContent:
    """A comparison, or why there is none."""

    content: Markup | None = None
    why: str = ""
    away: str = ""  # why workers were not asked
    missing: int = 0  # campaigns that wait for them
    is_drawn: bool = True  # nothing more comes


@router.get("/fleet", response_class=HTMLResponse)
async def fleet_page(
    visit: Visited, here: PlantHere, of_type: OfType = None, limit: LimitMm = LIMIT_MM, whole: Whole = False
) -> HTMLResponse:
    """Compare the robots of a type from all that was collected, or say what is missing."""
    types = _types(await here.fleets.campaigns(), latest_day(datetime.now(UTC).date()))
    chosen = next((one for one in types if one.name == of_type), types[0] if types else None)
    shown = FleetContent()
    if chosen is not None and chosen.is_enough:
        shown = await _content(visit, here, FleetChoice(chosen.name, chosen.usable, limit), whole=whole)
    return visit.page(
        "plant/fleet.html",
        types=types,
        chosen=chosen,
        shown=shown,
        missing=fleet_missing(limit),
        most=_MOST,
    )


async def _content(visit: Visit, here: PlantContext, wanted: FleetChoice, *, whole: bool) -> FleetContent:
    """Return the comparison; where workers are away that of the campaigns that were read before."""
    away = await here.fleets.away()
    if not away:
        try:
            return await _compared(visit, here, wanted, FleetContent(), whole=whole)
        except ClusterError as error:
            away = visit.words.spoken(text_of(error))
    known = await here.fleets.known(wanted.campaigns)
    missing = len(wanted.campaigns) - len(known)
    shown = FleetContent(away=away, missing=missing) if missing else FleetContent()
    if not known:
        return shown
    fewer = replace(wanted, campaigns=tuple(one.seen for one in known))
    return await _compared(visit, here, fewer, shown, whole=whole)


async def _compared(
    visit: Visit, here: PlantContext, wanted: FleetChoice, shown: FleetContent, *, whole: bool
) -> FleetContent:
    """Return what is shown with the comparison, or why there is none; raises ClusterError."""
    try:
        part = await render_part(visit, wanted.named, lambda: _draw(visit, here, wanted), whole=whole)
    except ClusterError:
        raise
    except TrueposeError as error:
        return replace(shown, why=visit.words.spoken(text_of(error)))
    return replace(shown, content=part, is_drawn=part is not None)


def _types(campaigns: Sequence[ResultRecord], last: date) -> list[TypeMeasured]:
    """Return the types of robots as campaigns up to a day measured them, that with the most first."""
    by_type: defaultdict[str, list[ResultRecord]] = defaultdict(list)
    for campaign in campaigns:
        by_type[campaign.robot].append(campaign)
    return sorted((_measured(*one, last) for one in by_type.items()), key=lambda one: -len(one.usable))


def _measured(name: str, campaigns: Sequence[ResultRecord], last: date) -> TypeMeasured:
    # A day that has not come yet is a wrong clock's; it would stand for a change of the robot since.
    known = [
        one
        for one in campaigns
        if one.robot_serial_number
        and one.instrument_serial_number
        and "" < one.measured_on <= last.isoformat()
    ]
    latest = tuple(sorted(known, key=lambda one: (one.measured_on, one.id))[-_MOST:])
    days = Counter(robot for robot, _ in {(one.robot_serial_number, one.measured_on) for one in latest})
    repeated = sum(count > 1 for count in days.values())
    return TypeMeasured(name, latest, len(campaigns) - len(known), len(days), repeated)


async def _draw(visit: Visit, here: PlantContext, wanted: FleetChoice) -> bytes:
    told = await here.fleets.told(wanted.campaigns)
    computed_at = f"{datetime.now(UTC):%Y-%m-%d %H:%M} UTC"
    asked = FleetDrawing(wanted.robot, told, wanted.limit_mm, visit.words.tag, computed_at)
    foretold, _, content = (await here.drawing_desk.draw(draw_fleet, asked)).partition(b"\n")
    await here.comparisons.keep(foretold)
    return content
