"""Readings that a person set aside, as every document of a result that was made without them lists them."""

from typing import Annotated, TypeAlias

from pydantic import Field

from truepose.exchange.results.document import Document


class ReadingNameDocument(Document):
    """What tells a reading from the others of its campaign."""

    config: int = Field(examples=[12])
    nest: int = Field(description="Of the tool, from 1.", examples=[2])
    base_point: int | None = Field(description="Of a length: its other end; null of what is none.")
    target: int | None = Field(description="Of a contact; null of what is none.")


class ReadingsSetAsideDocument(Document):
    """Readings without which a result was made, why, and who wanted that."""

    person: str = Field(examples=["Ada Byron"])
    reason: str = Field(examples=["a cable lay in the beam"])
    readings: list[ReadingNameDocument]
    rows: list[int] = Field(description="Of their table, from 0.", examples=[[22, 23]])


SetAside: TypeAlias = Annotated[
    ReadingsSetAsideDocument | None,
    Field(description="Readings that a person set aside; null: all of the campaign took part."),
]
