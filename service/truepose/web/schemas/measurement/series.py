"""Series, and the readings that programs deliver to them."""

from typing import Annotated, Final

from pydantic import Field, field_validator

from truepose.domain.measurement.series import Series
from truepose.storage.measurement.series import SeriesRecord
from truepose.web.schemas.base import NUMBER_LIMIT, VISIBLE, RecordedAt, RecordId, Reply, Request, example

_MOST_COLUMNS: Final = 64
_MOST_READINGS: Final = 1000  # of one delivery: a second of the fastest instrument
Column = Annotated[str, Field(min_length=1, max_length=80, pattern=VISIBLE)]
Columns = Annotated[
    list[Column],
    Field(
        min_length=1,
        max_length=_MOST_COLUMNS,
        description="What each value of a reading is, with its unit, as the header of a table says it.",
        examples=[["q1 [deg]", "q2 [deg]", "x [mm]", "y [mm]", "z [mm]"]],
    ),
]
Values = Annotated[
    list[float | None],
    Field(
        min_length=1,
        max_length=_MOST_COLUMNS,
        description="A value for each column; null where it was not read.",
        examples=[[0.0, -30.0, 512.4, -33.1, 640.2]],
    ),
]
First = Annotated[
    int,
    Field(
        ge=1,
        le=NUMBER_LIMIT,
        description="Number of the first of these readings: 1 to begin with, then `next_number` of the "
        "last answer.",
        examples=[1],
    ),
]


class SeriesRequest(Request):
    """What a program is going to deliver."""

    model_config = example({"name": "left arm", "columns": ["q1 [deg]", "x [mm]", "y [mm]", "z [mm]"]})
    name: str = Field(min_length=1, max_length=200, pattern=VISIBLE, examples=["left arm"])
    columns: Columns

    @field_validator("columns")
    @classmethod
    def _each_once(cls, columns: list[str]) -> list[str]:
        if len(set(columns)) < len(columns):
            raise ValueError("each column needs a name of its own")
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
    """A series and how far it has come."""

    id: RecordId
    recorded_at: RecordedAt
    name: str
    columns: Columns
    readings: int = Field(description="How many it holds.")
    next_number: int = Field(description="Number of the reading that it goes on at.")


class DeliveredReply(Reply):
    """Readings that are on disk."""

    next_number: int = Field(description="Number of the reading that the series goes on at.", examples=[2])


class DeliveredReadingReply(Reply):
    """A reading of a series."""

    number: int = Field(examples=[1])
    recorded_at: RecordedAt
    values: Values


def series_reply(record: SeriesRecord) -> SeriesReply:
    """Return a series as it travels."""
    return SeriesReply(
        id=record.id,
        recorded_at=record.recorded_at,
        name=record.series.name,
        columns=list(record.series.columns),
        readings=record.readings,
        next_number=record.readings + 1,
    )
