"""What changed since a week ago: robot by robot, and certificates that ended."""

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, date, datetime, timedelta
from typing import Final, Literal

from pydantic import Field

from truepose.messages.catalogue import english
from truepose.plant.calibration_due import latest_day
from truepose.plant.changes import (
    CertificateEnded,
    RecordedChange,
    RobotChanged,
    certificates_ended,
)
from truepose.storage.plant.certificates import CertificateRecord
from truepose.storage.plant.overview import PlantResults, RobotMeasured
from truepose.storage.plant.result_projections import ToldKind
from truepose.web.plant.context import PlantContext, PlantHere
from truepose.web.plant.links import Places, places_of
from truepose.web.resources import LIST, Counted, resource
from truepose.web.schemas import Reply


class PlantChangeReply(Reply):
    """A change of a robot, or an expired certificate."""

    what: Literal["error", "cause_named", "cause_gone", "model", "certificate"]
    sentence: str = Field(
        description="Description of the change with its figures, in English.",
        examples=[
            "Mean error of the identified model rose from 0.041 mm on 2026-04-02 to 0.055 mm on 2026-05-04 "
            "(identification 12)."
        ],
    )
    robot_serial_number: str = Field(
        description="Serial number of the robot; empty if no robot is concerned."
    )
    instrument_serial_number: str = Field(
        description="Serial number of the instrument, for a certificate.", examples=[""]
    )
    cell: str = Field(examples=["left arm"])
    kind: ToldKind | None = Field(description="Kind of record that shows the change; null for a certificate.")
    record_id: int | None = Field(description="Record number within the cell.", examples=[12])
    page: str = Field(
        description="Page of the record in the cell; empty if there is none.",
        examples=["https://cell-3.example:8443/identifications/12"],
    )
    before_mm: float | None = Field(
        description="Earlier error; null if there is no earlier error or the change is not a change in "
        "error.",
        examples=[0.041],
    )
    after_mm: float | None = Field(description="Present error.", examples=[0.055])


router = resource("/plant/changes", tags=["plant"])
_WEEK: Final = timedelta(days=7)


@dataclass(frozen=True, slots=True)
class SinceThen:
    """What changed since the beginning of a day."""

    since: date
    robots: list[RobotChanged]  # the one whose error grew most first
    ended: list[CertificateEnded]


async def read_ahead(told: PlantResults, today: date) -> None:
    """Have what results tell read, as it is now and as it was known a week ago: once a day, and no more."""
    # Else the plant's first page waits for it (commit ed736077).
    await told.newest(latest_day(today))
    await told.before(today - _WEEK)


async def since_a_week(
    here: PlantContext, papers: list[CertificateRecord], robots: list[RobotMeasured], today: date
) -> SinceThen:
    """Return what is known against what was known when the day a week ago began, by the plant's clock."""
    since, upto = today - _WEEK, latest_day(today)
    now = await here.told.newest(upto)
    read_up_to = here.told.read_up_to
    changed = here.changed.found(await here.told.before(since), now, upto, read_up_to)
    return SinceThen(since, changed, certificates_ended(papers, robots, since, today))


@router.get("", responses=LIST)
async def list_plant_changes(here: PlantHere, paging: Counted) -> list[PlantChangeReply]:
    """List the changes since the start of the day one week ago (UTC), largest increase in error first."""
    today = datetime.now(UTC).date()
    papers, robots = await here.certificates.that_count(), await here.overview.robots(latest_day(today))
    found = await since_a_week(here, papers, robots, today)
    places, every = await places_of(here), [*_each(found)]
    return paging.of(every, lambda one: _reply(one, places))


def _each(found: SinceThen) -> Iterator[tuple[RobotChanged, RecordedChange] | CertificateEnded]:
    for robot in found.robots:
        for change in robot.changes:
            yield robot, change
    yield from found.ended


def _reply(one: tuple[RobotChanged, RecordedChange] | CertificateEnded, places: Places) -> PlantChangeReply:
    return _of_certificate(one) if isinstance(one, CertificateEnded) else _of_robot(*one, places)


def _of_robot(robot: RobotChanged, change: RecordedChange, places: Places) -> PlantChangeReply:
    return PlantChangeReply(
        what=change.what.value,
        sentence=english(change.sentence),
        robot_serial_number=robot.serial_number,
        instrument_serial_number="",
        cell=change.record.cell,
        kind=change.record.kind,
        record_id=change.record.record_id,
        page=places.of(change.record),
        before_mm=change.before_mm,
        after_mm=change.after_mm,
    )


def _of_certificate(ended: CertificateEnded) -> PlantChangeReply:
    return PlantChangeReply(
        what="certificate",
        sentence=english(ended.sentence),
        robot_serial_number="",
        instrument_serial_number=ended.stated.paper.serial_number,
        cell=ended.stated.cell,
        kind=None,
        record_id=None,
        page="",
        before_mm=None,
        after_mm=None,
    )
