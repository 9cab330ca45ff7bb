"""Readings set aside by a person, as documents of results list them."""

from typing import Annotated, TypeAlias

from pydantic import Field

from truepose.exchange.results.document import Document, FieldSource


class ReadingNameDocument(Document):
    """A reading of a campaign."""

    config: int = Field(examples=[12])
    nest: int = Field(description="Tool nest, starting at 1.", examples=[2])
    base_point: int | None = Field(description="Base point of a length; null for other readings.")
    target: int | None = Field(description="Target of a contact; null for other readings.")


class ReadingsSetAsideDocument(Document):
    """Readings excluded from an analysis, with the reason and the person who excluded them."""

    person: str = Field(examples=["Ada Byron"])
    reason: str = Field(
        description="Reason for all of the readings; different reasons are joined with semicolons.",
        examples=["a cable lay in the beam"],
    )
    readings: list[ReadingNameDocument]
    reasons: Annotated[list[str], FieldSource("reason_of_each")] = Field(
        default=[],
        description="Reason for each of the readings, in their order.",
        examples=[["a cable lay in the beam"]],
    )
    rows: list[int] = Field(description="Rows of the table, starting at 0.", examples=[[22, 23]])


SetAside: TypeAlias = Annotated[
    ReadingsSetAsideDocument | None,
    Field(description="Readings set aside by a person; null if all readings were used."),
]
