"""Robots and instruments of a plant by serial number, and what was measured and made of it."""

import json
from datetime import UTC, date, datetime
from typing import Annotated, Any, Final, Literal, TypeAlias

from fastapi import Path
from pydantic import Field

from truepose.domain.cell import Standing
from truepose.messages.message import message
from truepose.plant.calibration_due import latest_day
from truepose.storage.errors import NotInPlantError
from truepose.storage.plant.certificates import CertificateRecord
from truepose.storage.plant.queries import ResultKind
from truepose.web.plant.context import PlantHere
from truepose.web.resources import LIST, LIST_OF_RECORD, READ, Id, Paged, resource
from truepose.web.schemas import RecordId, Reply

_DAY = "A day, by the cell's clock; empty: nobody said it."


class SeenRobotReply(Reply):
    """A robot that some cell measured."""

    serial_number: str
    robot: str = Field(description="Its type.")
    cell: str = Field(description="Where it was measured last; empty: nothing came of it yet.")
    results: int = Field(description="What was measured and made of it.", examples=[12])
    last_measured_on: str = Field(description=_DAY, examples=["2026-05-04"])


class SeenInstrumentReply(Reply):
    """An instrument that measured in some cell."""

    serial_number: str
    results: int = Field(description="What was made of its readings.", examples=[12])
    last_measured_on: str = Field(description=_DAY, examples=["2026-05-04"])


class DayReply(Reply):
    """How much was measured on one day."""

    cell: str = Field(examples=["left arm"])
    measured_on: str = Field(description=_DAY, examples=["2026-05-04"])
    robot_serial_number: str
    instrument_serial_number: str = Field(examples=["391234"])
    readings: int = Field(examples=[50])


class PlantResultReply(Reply):
    """A campaign, what was made of it, or a report."""

    id: RecordId
    cell: str = Field(examples=["left arm"])
    kind: ResultKind
    record_id: int = Field(description="Its number in the cell.", examples=[3])
    name: str
    robot: str = Field(description="Its type.")
    robot_serial_number: str
    instrument_serial_number: str = Field(examples=["391234"])
    measured_on: str = Field(description=_DAY, examples=["2026-05-04"])
    clock_offset_s: float | None = Field(
        description="The cell's clock less the plant's when it was collected.", examples=[-1.25]
    )


class RobotLifeReply(Reply):
    """A robot, and what was measured and made of it, newest day first."""

    robot: SeenRobotReply
    days: list[DayReply]
    results: list[PlantResultReply]


class StatedCertificateReply(Reply):
    """A certificate that a cell stated, and how it stands today."""

    what: str = Field(description="Of what it is, as the cell calls it.", examples=["tracker"])
    certificate: str = Field(examples=["ISO 10360-10 report 2026-0815"])
    expires: str = Field(description="ISO date; empty: nobody said it.", examples=["2027-03-31"])
    standing: Standing = Field(description="`ends soon`: 30 days or less are left.")
    cell: str = Field(description="Which stated it first.", examples=["left arm"])
    stated_on: str = Field(description=_DAY, examples=["2026-05-04"])


class InstrumentLifeReply(Reply):
    """An instrument, and what was measured with it, newest day first."""

    instrument: SeenInstrumentReply
    certificates: list[StatedCertificateReply] = Field(description="The one that holds longest first.")
    days: list[DayReply]
    results: list[PlantResultReply]


def certificate_reply(stated: CertificateRecord, today: date) -> StatedCertificateReply:
    """Return a certificate as it travels."""
    return StatedCertificateReply.of(
        stated, stated.paper, what=stated.paper.of, standing=stated.standing(today)
    )


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


@router.get("/robots", responses=LIST)
async def list_seen_robots(here: PlantHere, paging: Paged) -> list[SeenRobotReply]:
    """List the robots of all cells, in the order in which they were first seen."""
    return paging.shown(await here.looks.robots(paging.page, _upto()), SeenRobotReply.of)


@router.get("/robots/{serial:path}", responses=READ)
async def get_robot_life(here: PlantHere, serial: Serial) -> RobotLifeReply:
    """Show the life of a robot: what was measured of it on which day, and what was made of that."""
    return RobotLifeReply.of(
        robot=await here.looks.robot(serial, _upto()),
        days=await here.looks.days_of_robot(serial),
        results=await here.looks.life_of_robot(serial),
    )


@router.get("/instruments", responses=LIST)
async def list_seen_instruments(here: PlantHere, paging: Paged) -> list[SeenInstrumentReply]:
    """List the instruments of all cells, in the order in which they were first seen."""
    return paging.shown(await here.looks.instruments(paging.page, _upto()), SeenInstrumentReply.of)


@router.get("/instruments/{serial:path}", responses=READ)
async def get_instrument_life(here: PlantHere, serial: Serial) -> InstrumentLifeReply:
    """Show the life of an instrument: what it measured on which day, in which cell."""
    return InstrumentLifeReply.of(
        instrument=await here.looks.instrument(serial, _upto()),
        certificates=[
            certificate_reply(stated, datetime.now(UTC).date())
            for stated in await here.certificates.of_instrument(serial)
        ],
        days=await here.looks.days_of_instrument(serial),
        results=await here.looks.life_of_instrument(serial),
    )


@router.get("/{kind}", responses=LIST_OF_RECORD)
async def list_plant_results(here: PlantHere, kind: Kinds, paging: Paged) -> list[PlantResultReply]:
    """List what was measured or made, in the order in which it was collected."""
    return paging.shown(await here.looks.results(_TABLES[kind], paging.page), PlantResultReply.of)


@router.get("/{kind}/{id}/record", responses=READ)
async def get_plant_record(here: PlantHere, kind: Kinds, id: Id) -> dict[str, Any]:
    """Give a record as it came from the cell, every value with its kind."""
    result = await here.looks.result(id)
    content = await here.journal.content(result.branch_id, kind, result.record_id)
    if result.kind != _TABLES[kind] or content is None:
        raise NotInPlantError(message("refused.no_plant_record", number=id, kind=str(kind)))
    found: dict[str, Any] = json.loads(content)
    return found


def _upto() -> date:
    # A clock that was wrong once would make a robot doubtful for ever: what is dated later counts only where
    # there is nothing else (commit 3dbd1d75).
    return latest_day(datetime.now(UTC).date())
