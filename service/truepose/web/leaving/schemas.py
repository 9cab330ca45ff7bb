"""What a plant is told of a cell."""

from pydantic import Field

from truepose.web.schemas.base import Reply


class ChainHeadReply(Reply):
    """How far the chain of a cell goes, and what time it is there."""

    cell: str = Field(description="Name in the cell file.", examples=["left arm"])
    version: str = Field(description="Of the program.", examples=["0.1.0"])
    schema_revision: str = Field(alias="schema", description="Of the database.", examples=["0013"])
    newest: int = Field(description="Number of the newest link.", examples=[4711])
    links: int = Field(description="How many links the head stands for.", examples=[4711])
    head: str = Field(description="As reports print it.", examples=["4711-K3QF-7ZWD-M2PA-XY5R"])
    hash: str | None = Field(
        description="Of the last of these links, in hexadecimal; null: there is none.",
        examples=["9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08"],
    )
    time: str = Field(
        description="Time of day as this computer has it: UTC, ISO 8601.",
        examples=["2026-05-04T09:12:33.125000+00:00"],
    )
