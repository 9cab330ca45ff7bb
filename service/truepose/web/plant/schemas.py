"""What a plant's service takes and gives."""

from datetime import date
from typing import Any, Literal

from pydantic import Field

from truepose.domain.cell.certificates import Standing
from truepose.storage.plant.certificates import StatedPaper
from truepose.storage.plant.lines import JournalLine
from truepose.storage.plant.looking import DayMeasured, ResultKind, ResultSeen, SeenInstrument, SeenRobot
from truepose.storage.plant.records import HandDownRecord, VisitRecord
from truepose.storage.plant.telling import ToldKind
from truepose.web.schemas.base import VISIBLE, FreeDocument, PersonName, RecordedAt, RecordId, Reply, Request

_DAY = "A day, by the cell's clock; empty: nobody said it."


class PlantHealth(Reply):
    """Whether the plant works."""

    status: Literal["ok", "degraded"]
    fault: str | None
    doing: str | None = Field(
        description="What is done before cells are visited; null: they are.",
        examples=["Records that an earlier version collected are read again, 120 of 7200 so far."],
    )
    version: str = Field(examples=["0.1.0"])
    schema_revision: str = Field(alias="schema", examples=["0014"])
    cells: int = Field(description="How many stand in the cells file.", examples=[2])
    newest_copy_age_s: float | None = Field(
        description="How old the newest copy of its database is; null: there is none, or none is wanted.",
        examples=[3600.0],
    )


class VisitReply(Reply):
    """What came of a visit to a cell."""

    id: RecordId
    recorded_at: RecordedAt
    found_at: str = Field(
        description="When a visit found this last, since the start of the plant; else as `recorded_at`.",
        examples=["2026-05-04T09:42:31.007+00:00"],
    )
    outcome: Literal["whole", "unreachable", "refused", "another_chain"]
    sentence: str = Field(description="What is amiss and what to do; empty: nothing is.", examples=[""])
    collected: int = Field(description="Links that it brought.", examples=[120])
    newest: int | None = Field(description="Newest link there; null: no answer.", examples=[4711])
    head: str | None = Field(
        description="Head of what was collected, as the cell's reports print it.",
        examples=["4711-K3QF-7ZWD-M2PA-XY5R"],
    )
    clock_offset_s: float | None = Field(description="The cell's clock less the plant's.", examples=[-1.25])
    clock_bound_s: float | None = Field(description="It is known within so much.", examples=[0.004])
    version: str | None = Field(description="Of the cell's program.", examples=["0.1.0"])


class PlantCellReply(Reply):
    """A cell of the plant."""

    name: str = Field(examples=["left arm"])
    visited: bool = Field(description="False: it stands in the cells file no more; what was collected stays.")
    newest_visit: VisitReply | None


class VisitsReply(Reply):
    """A cell and the latest visits to it."""

    cell: PlantCellReply
    visits: list[VisitReply]


class BranchRequest(Request):
    """Who accepts another chain of a cell, and why."""

    person: PersonName
    reason: str = Field(
        min_length=1, max_length=1000, pattern=VISIBLE, examples=["The disk was exchanged on Monday."]
    )


class HandDownRequest(Request):
    """A plan or a model for a cell."""

    cell: str = Field(min_length=1, max_length=200, examples=["left arm"])
    kind: Literal["plan", "model"]
    name: str = Field(min_length=1, max_length=200, pattern=VISIBLE, examples=["monthly check"])
    person: PersonName
    document: FreeDocument = Field(
        description="Of a plan, what `POST /sessions` of the cell takes; of a model, the model.",
        examples=[{"name": "monthly check"}],
    )


class HandDownReply(Reply):
    """A plan or a model for a cell, and whether the cell has it."""

    id: RecordId
    recorded_at: RecordedAt
    cell: str = Field(examples=["left arm"])
    kind: Literal["plan", "model"]
    name: str = Field(examples=["monthly check"])
    person: str
    document: dict[str, Any] = Field(examples=[{"name": "monthly check"}])
    state: Literal["waiting", "delivered", "refused"]
    sentence: str = Field(description="What the cell said; empty: nothing.", examples=[""])
    state_since: RecordedAt
    number_in_cell: int | None = Field(description="Its number there; null: it is not there.", examples=[3])


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


class PlantChangeReply(Reply):
    """What changed of a robot, or a certificate that ended."""

    what: Literal["error", "cause_named", "cause_gone", "model", "certificate"]
    sentence: str = Field(
        description="With its figures, in English.",
        examples=[
            "Mean error of the identified model rose from 0.041 mm on 2026-04-02 to 0.055 mm on 2026-05-04 "
            "(identification 12)."
        ],
    )
    robot_serial_number: str = Field(description="Empty: it is of no robot.")
    instrument_serial_number: str = Field(description="Of a certificate.", examples=[""])
    cell: str = Field(examples=["left arm"])
    kind: ToldKind | None = Field(description="Of the record that says so; null: of a certificate.")
    record_id: int | None = Field(description="Its number in the cell.", examples=[12])
    page: str = Field(
        description="Where the cell shows it; empty: nowhere.",
        examples=["https://cell-3.example:8443/identifications/12"],
    )
    before_mm: float | None = Field(
        description="The error before; null: there is none to compare with, or it is of something else.",
        examples=[0.041],
    )
    after_mm: float | None = Field(description="The error now.", examples=[0.055])


class PlantRecordReply(Reply):
    """A link of a cell's chain with its record, as it was collected."""

    id: RecordId
    recorded_at: RecordedAt
    branch: int = Field(
        description="Of the cell's chain; another one since a copy was put back.", examples=[1]
    )
    link: int = Field(description="Its number in the cell's chain.", examples=[4711])
    stream: int = Field(description="Number of its session; 0: it belongs to none.", examples=[3])
    record: str = Field(description="What kind of record it is.", examples=["readings"])
    record_id: int = Field(description="Its number in the cell.", examples=[3])
    hash: str = Field(
        description="Of the link, in hexadecimal.",
        examples=["9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08"],
    )
    row: dict[str, Any] | None = Field(
        description="The record, every value with its kind; null: it never leaves the cell.",
        examples=[{"id": 3, "time_s": {"float": "0.1"}}],
    )
    verified: bool = Field(description="Whether the hash is that of the record.")


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


def visit_reply(record: VisitRecord) -> VisitReply:
    """Return a visit as it travels."""
    visit, clock = record.visit, record.visit.clock
    return VisitReply(
        id=record.id,
        recorded_at=record.recorded_at,
        found_at=record.found_at,
        outcome=visit.outcome.value,
        sentence=visit.sentence,
        collected=visit.collected,
        newest=visit.newest,
        head=visit.head,
        clock_offset_s=None if clock is None else clock.offset_s,
        clock_bound_s=None if clock is None else clock.bound_s,
        version=visit.version,
    )


def record_reply(line: JournalLine) -> PlantRecordReply:
    """Return a line of a journal as it travels."""
    told = {name: getattr(line, name) for name in PlantRecordReply.model_fields}
    return PlantRecordReply(**(told | {"hash": line.hash.hex()}))


def hand_down_reply(record: HandDownRecord) -> HandDownReply:
    """Return what was handed down, as it travels."""
    told = record.hand_down
    return HandDownReply(
        id=record.id,
        recorded_at=record.recorded_at,
        cell=told.cell,
        kind=told.kind.value,
        name=told.name,
        person=told.person,
        document=dict(told.document),
        state=record.state.value,
        sentence=record.sentence,
        state_since=record.state_since,
        number_in_cell=record.number_in_cell,
    )


def robot_reply(seen: SeenRobot) -> SeenRobotReply:
    """Return a robot as it travels."""
    return SeenRobotReply(**{name: getattr(seen, name) for name in SeenRobotReply.model_fields})


def instrument_reply(seen: SeenInstrument) -> SeenInstrumentReply:
    """Return an instrument as it travels."""
    return SeenInstrumentReply(**{name: getattr(seen, name) for name in SeenInstrumentReply.model_fields})


def certificate_reply(stated: StatedPaper, today: date) -> StatedCertificateReply:
    """Return a certificate as it travels."""
    return StatedCertificateReply(
        what=stated.paper.of,
        certificate=stated.paper.certificate,
        expires=stated.paper.expires,
        standing=stated.standing(today),
        cell=stated.cell,
        stated_on=stated.stated_on,
    )


def day_reply(day: DayMeasured) -> DayReply:
    """Return a day as it travels."""
    return DayReply(**{name: getattr(day, name) for name in DayReply.model_fields})


def result_reply(result: ResultSeen) -> PlantResultReply:
    """Return a result as it travels."""
    return PlantResultReply(**{name: getattr(result, name) for name in PlantResultReply.model_fields})
