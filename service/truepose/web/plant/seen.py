"""What a plant has seen: robots and instruments by serial number, and what was measured and made of it."""

import json
from datetime import UTC, date, datetime
from typing import Annotated, Any, Final, Literal, TypeAlias

from fastapi import Path

from truepose.plant.due import latest_day
from truepose.storage.errors import NotInPlantError
from truepose.storage.plant.looking import ResultKind
from truepose.web.plant.context import PlantHere
from truepose.web.plant.schemas import (
    InstrumentLifeReply,
    PlantResultReply,
    RobotLifeReply,
    SeenInstrumentReply,
    SeenRobotReply,
    certificate_reply,
    day_reply,
    instrument_reply,
    result_reply,
    robot_reply,
)
from truepose.web.problems import problems
from truepose.web.requests.paging import Paged, listing
from truepose.web.requests.parameters import Id
from truepose.web.resources import resource

router = resource("/plant", tags=["plant"])
Kinds: TypeAlias = Literal[
    "campaigns",
    "identifications",
    "diagnoses",
    "validations",
    "models",
    "corrections",
    "reports",
    "closings",
]
_TABLES: Final[dict[Kinds, ResultKind]] = {
    "campaigns": "campaign",
    "identifications": "identification",
    "diagnoses": "diagnosis",
    "validations": "validation",
    "models": "model",
    "corrections": "correction",
    "reports": "report",
    "closings": "closing",
}
Serial = Annotated[str, Path(min_length=1, max_length=200, description="Serial number.")]


@router.get("/robots", responses=listing(422, 503))
async def list_seen_robots(here: PlantHere, paging: Paged) -> list[SeenRobotReply]:
    """List the robots of all cells, in the order in which they were first seen."""
    return paging.shown(await here.looks.robots(paging.page, _upto()), robot_reply)


@router.get("/robots/{serial:path}", responses=problems(404, 422, 503))
async def get_robot_life(here: PlantHere, serial: Serial) -> RobotLifeReply:
    """Show the life of a robot: what was measured of it on which day, and what was made of that."""
    return RobotLifeReply(
        robot=robot_reply(await here.looks.robot(serial, _upto())),
        days=[day_reply(day) for day in await here.looks.days_of_robot(serial)],
        results=[result_reply(result) for result in await here.looks.life_of_robot(serial)],
    )


@router.get("/instruments", responses=listing(422, 503))
async def list_seen_instruments(here: PlantHere, paging: Paged) -> list[SeenInstrumentReply]:
    """List the instruments of all cells, in the order in which they were first seen."""
    return paging.shown(await here.looks.instruments(paging.page, _upto()), instrument_reply)


@router.get("/instruments/{serial:path}", responses=problems(404, 422, 503))
async def get_instrument_life(here: PlantHere, serial: Serial) -> InstrumentLifeReply:
    """Show the life of an instrument: what it measured on which day, in which cell."""
    return InstrumentLifeReply(
        instrument=instrument_reply(await here.looks.instrument(serial, _upto())),
        certificates=[
            certificate_reply(stated, datetime.now(UTC).date())
            for stated in await here.certificates.of_instrument(serial)
        ],
        days=[day_reply(day) for day in await here.looks.days_of_instrument(serial)],
        results=[result_reply(result) for result in await here.looks.life_of_instrument(serial)],
    )


@router.get("/{kind}", responses=listing(404, 422, 503))
async def list_plant_results(here: PlantHere, kind: Kinds, paging: Paged) -> list[PlantResultReply]:
    """List what was measured or made, in the order in which it was collected."""
    return paging.shown(await here.looks.results(_TABLES[kind], paging.page), result_reply)


@router.get("/{kind}/{id}/record", responses=problems(404, 422, 503))
async def get_plant_record(here: PlantHere, kind: Kinds, id: Id) -> dict[str, Any]:
    """Give a record as it came from the cell, every value with its kind."""
    result = await here.looks.result(id)
    content = await here.journal.content(result.branch_id, kind, result.record_id)
    if result.kind != _TABLES[kind] or content is None:
        raise NotInPlantError(f"There is no record {id} among the {kind}.")
    found: dict[str, Any] = json.loads(content)
    return found


def _upto() -> date:
    return latest_day(datetime.now(UTC).date())
