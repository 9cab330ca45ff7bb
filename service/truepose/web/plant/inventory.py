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

_DAY = "A date by the cell's clock; empty if not stated."


class SeenRobotReply(Reply):
    """A robot measured in some cell."""

    serial_number: str
    robot: str = Field(description="Robot type.")
    cell: str = Field(description="Cell with the latest measurement; empty if there is no result yet.")
    results: int = Field(description="Number of measurements and results.", examples=[12])
    last_measured_on: str = Field(description=_DAY, examples=["2026-05-04"])


class SeenInstrumentReply(Reply):
    """An instrument used in some cell."""

    serial_number: str
    results: int = Field(description="Number of results from the readings of this instrument.", examples=[12])
    last_measured_on: str = Field(description=_DAY, examples=["2026-05-04"])


class DayReply(Reply):
    """Measurements of one day."""

    cell: str = Field(examples=["left arm"])
    measured_on: str = Field(description=_DAY, examples=["2026-05-04"])
    robot_serial_number: str
    instrument_serial_number: str = Field(examples=["391234"])
    readings: int = Field(examples=[50])


class PlantResultReply(Reply):
    """A campaign, a result or a report."""

    id: RecordId
    cell: str = Field(examples=["left arm"])
    kind: ResultKind
    record_id: int = Field(description="Record number within the cell.", examples=[3])
    name: str
    robot: str = Field(description="Robot type.")
    robot_serial_number: str
    instrument_serial_number: str = Field(examples=["391234"])
    measured_on: str = Field(description=_DAY, examples=["2026-05-04"])
    clock_offset_s: float | None = Field(
        description="Cell clock minus plant clock at the time of collection.", examples=[-1.25]
    )


class RobotLifeReply(Reply):
    """A robot with its measurements and results, newest day first."""

    robot: SeenRobotReply
    days: list[DayReply]
    results: list[PlantResultReply]


class StatedCertificateReply(Reply):
    """A certificate stated by a cell, and its present state."""

    what: str = Field(description="Artefact or instrument, as named by the cell.", examples=["tracker"])
    certificate: str = Field(examples=["ISO 10360-10 report 2026-0815"])
    expires: str = Field(description="Expiry date (ISO); empty if not stated.", examples=["2027-03-31"])
    standing: Standing = Field(description="`ends soon`: 30 days or less remain.")
    cell: str = Field(description="Cell that first reported the certificate.", examples=["left arm"])
    stated_on: str = Field(description=_DAY, examples=["2026-05-04"])


class InstrumentLifeReply(Reply):
    """An instrument with its measurements, newest day first."""

    instrument: SeenInstrumentReply
    certificates: list[StatedCertificateReply] = Field(description="Certificates, latest expiry date first.")
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
    """Return the history of a robot: its measurements by day, and the results."""
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
    """Return the history of an instrument: its measurements by day and cell."""
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
    """List measurements and results in the order in which they were collected."""
    return paging.shown(await here.looks.results(_TABLES[kind], paging.page), PlantResultReply.of)


@router.get("/{kind}/{id}/record", responses=READ)
async def get_plant_record(here: PlantHere, kind: Kinds, id: Id) -> dict[str, Any]:
    """Return a record as collected from the cell, each value with its type."""
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
