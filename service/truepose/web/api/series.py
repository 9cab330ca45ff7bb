"""Series: readings that a program of one's own delivers as they come."""

from typing import Annotated, Final

from fastapi import Response, status
from pydantic import Field, field_validator

from truepose.analysis.drafts import draft_of_series
from truepose.domain.campaign import Delivery, Series
from truepose.exchange.results.document import FieldSource
from truepose.web.api.drafts import DraftReply
from truepose.web.context import Here
from truepose.web.resources import CHANGE, LIST, LIST_OF_RECORD, READ, Id, Paged, problems, resource
from truepose.web.schemas import NUMBER_LIMIT, VISIBLE, RecordedAt, RecordId, Reply, Request, example

_MOST_COLUMNS: Final = 64
_MOST_READINGS: Final = 1000  # of one delivery: a second of the fastest instrument
Column = Annotated[str, Field(min_length=1, max_length=80, pattern=VISIBLE)]
Columns = Annotated[
    list[Column],
    Field(
        min_length=1,
        max_length=_MOST_COLUMNS,
        description="Meaning of each value with its unit, as in the header of a table.",
        examples=[["q1 [deg]", "q2 [deg]", "x [mm]", "y [mm]", "z [mm]"]],
    ),
]
Values = Annotated[
    list[float | None],
    Field(
        min_length=1,
        max_length=_MOST_COLUMNS,
        description="One value per column; null if not measured.",
        examples=[[0.0, -30.0, 512.4, -33.1, 640.2]],
    ),
]
First = Annotated[
    int,
    Field(
        ge=1,
        le=NUMBER_LIMIT,
        description="Number of the first of these readings: 1 at the start, then `next_number` of the last "
        "reply.",
        examples=[1],
    ),
]


class SeriesRequest(Request):
    """A series of readings that a program will deliver."""

    model_config = example({"name": "left arm", "columns": ["q1 [deg]", "x [mm]", "y [mm]", "z [mm]"]})
    name: str = Field(min_length=1, max_length=200, pattern=VISIBLE, examples=["left arm"])
    columns: Columns

    @field_validator("columns")
    @classmethod
    def _each_once(cls, columns: list[str]) -> list[str]:
        if len(set(columns)) < len(columns):
            raise ValueError("column names must be unique")
        return columns

    def series(self) -> Series:
        """Return what is asked for."""
        return Series(self.name, tuple(self.columns))


class DeliveryRequest(Request):
    """Readings, in the order in which they were taken."""

    model_config = example({"first": 1, "readings": [[0.0, 512.4, -33.1, 640.2]]})
    first: First
    readings: list[Values] = Field(min_length=1, max_length=_MOST_READINGS)


class SeriesReply(Reply):
    """A series and its progress."""

    id: RecordId
    recorded_at: RecordedAt
    name: Annotated[str, FieldSource("series.name")]
    columns: Annotated[Columns, FieldSource("series.columns")]
    readings: int = Field(description="Number of readings in the series.")
    next_number: Annotated[int, FieldSource("readings", lambda count: count + 1)] = Field(
        description="Number of the next reading to deliver."
    )


class DeliveredReply(Reply):
    """Confirmation that the readings are on disk."""

    next_number: int = Field(description="Number of the next reading to deliver.", examples=[2])


class DeliveredReadingReply(Reply):
    """A reading of a series."""

    number: int = Field(examples=[1])
    recorded_at: RecordedAt
    values: Values


router = resource("/series", tags=["series"])


@router.post("", status_code=status.HTTP_201_CREATED, responses=problems(400, 413, 415, 422, 503))
async def start_series(here: Here, response: Response, wanted: SeriesRequest) -> SeriesReply:
    """Start a series and define its columns, as in the header of a table."""
    number = await here.series.begin(wanted.series())
    response.headers["Location"] = f"/api/v1/series/{number}"
    return SeriesReply.of(await here.series.get(number))


@router.get("", responses=LIST)
async def list_series(here: Here, paging: Paged) -> list[SeriesReply]:
    """List series, oldest first."""
    return paging.shown(await here.series.page(paging.page), SeriesReply.of)


@router.get("/{id}", responses=READ)
async def get_series(here: Here, id: Id) -> SeriesReply:
    """Return a series, and the number of the next reading to deliver."""
    return SeriesReply.of(await here.series.get(id))


@router.post("/{id}/readings", status_code=status.HTTP_201_CREATED, responses=CHANGE)
async def add_readings(here: Here, id: Id, wanted: DeliveryRequest) -> DeliveredReply:
    """Deliver readings; the response is sent once they are on disk.

    `first` numbers them: if the response to a delivery is lost, send the delivery again unchanged; it is
    stored once. A delivery that leaves a gap, or differs from a stored reading of the same number, is refused
    (409).
    """
    delivery = Delivery(wanted.first, tuple(map(tuple, wanted.readings)))
    await here.series.deliver(id, delivery)
    return DeliveredReply(next_number=delivery.next_number)


@router.get("/{id}/readings", responses=LIST_OF_RECORD)
async def list_readings_of_series(here: Here, id: Id, paging: Paged) -> list[DeliveredReadingReply]:
    """List the readings of a series in order."""
    record = await here.series.get(id)
    readings = await here.series.readings(id, paging.page)
    last = readings[-1].number if readings else paging.page.after
    paging.say(record.readings, last if last < record.readings and readings else None)
    return [DeliveredReadingReply.of(one, values=list(one.values)) for one in readings]


@router.post(
    "/{id}/draft", status_code=status.HTTP_201_CREATED, responses=problems(404, 409, 413, 415, 422, 503)
)
async def make_draft_of_series(here: Here, response: Response, id: Id) -> DraftReply:
    """Create a draft from the readings of a series so far, as if their table had been dropped at `/bring`."""
    draft = await draft_of_series(here.series, here.draft_desk, id)
    response.headers["Location"] = f"/api/v1/drafts/{draft.id}"
    return DraftReply.of(draft)
