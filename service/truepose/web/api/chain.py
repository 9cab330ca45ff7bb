"""The hash chain of records as a plant collects it: its head with the cell's clock, and its links in order.

Nothing here waits for anybody: what is not asked for stays where it is, and is there when it is.
"""

import asyncio
import json
from collections.abc import AsyncIterator, Sequence
from datetime import UTC, datetime
from typing import Annotated, Any, Final

from fastapi import Query
from fastapi.responses import Response, StreamingResponse
from pydantic import Field

from truepose.storage.plant.outbox import Outbox, OutboxLink, to_typed_json
from truepose.web.context import Here
from truepose.web.resources import problems, resource, sending
from truepose.web.schemas import NUMBER_LIMIT, Reply

LINES: Final = "application/x-ndjson"  # media type of links


class ChainHeadReply(Reply):
    """State of the hash chain of a cell, and the time of its clock."""

    cell: str = Field(description="Name of the cell in its cell file.", examples=["left arm"])
    version: str = Field(description="Version of the software.", examples=["0.1.0"])
    schema_revision: str = Field(
        alias="schema", description="Schema revision of the database.", examples=["0001"]
    )
    newest: int = Field(description="Number of the newest chain entry.", examples=[4711])
    links: int = Field(description="Number of chain entries covered by the head hash.", examples=[4711])
    head: str = Field(description="Head hash, as printed in reports.", examples=["4711-K3QF-7ZWD-M2PA-XY5R"])
    hash: str | None = Field(
        description="Hash of the last covered entry, in hexadecimal; null if there is none.",
        examples=["9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08"],
    )
    time: str = Field(
        description="Time by this computer's clock: UTC, ISO 8601.",
        examples=["2026-05-04T09:12:33.125000+00:00"],
    )


router = resource("/chain", tags=["plant"])
MOST_LINKS: Final = 5000
MOST_BYTES: Final = 8 * 2**20  # of a page, unless its first record alone has more
_EXAMPLE: Final = (
    '{"link":1,"stream":0,"record":"campaigns","record_id":1,"hash":"9f86...",'
    '"row":{"id":1,"name":"left arm"}}\n{"end":1,"newest":1}\n'
)
_SENT: Final = sending(
    "One chain entry per line, then a line that states the last entry sent.",
    {LINES: {"schema": {"type": "string"}, "example": _EXAMPLE}},
)
At = Annotated[
    int | None,
    Query(
        alias="links",
        ge=0,
        le=NUMBER_LIMIT,
        description="Number of chain entries for which to return the state; by default, all.",
    ),
]
After = Annotated[int, Query(ge=0, le=NUMBER_LIMIT, description="Only chain entries with a higher number.")]
Limit = Annotated[int, Query(ge=1, le=MOST_LINKS, description="Maximum number of chain entries.")]


def wall_time() -> datetime:
    """Return the time of day as this computer has it; it may be wrong, and may jump."""
    return datetime.now(UTC)


@router.get("/head", responses=problems(422, 503))
async def get_chain_head(here: Here, at: At = None) -> ChainHeadReply:
    """Return the length of the hash chain, its head as printed in reports, and the time of this computer."""
    stand = await Outbox(here.database).stand(at)
    return ChainHeadReply(
        cell=here.cell.name,
        version=here.version,
        schema=here.database.schema,
        newest=stand.newest,
        links=stand.head.links,
        head=stand.head.text,
        hash=None if stand.hash is None else stand.hash.hex(),
        time=wall_time().isoformat(timespec="microseconds"),
    )


@router.get("/links", response_class=Response, responses=_SENT | problems(422, 503))
async def list_links(here: Here, after: After = 0, limit: Limit = 500) -> StreamingResponse:
    """Send chain entries with their records in order, so that each hash can be recomputed.

    For a record that does not leave the cell, only the entry is sent. A page ends after `limit` entries or 8
    MB; a page without the last line `{"end": ..., "newest": ...}` was truncated in transit.
    """
    records = Outbox(here.database)
    # Once the head of an answer is sent no problem document can follow it.
    first = await records.after(after, limit)  # refused before an answer has begun, where it is
    return StreamingResponse(_lines(records, first, after, limit), media_type=LINES)


async def _lines(records: Outbox, some: Sequence[OutboxLink], after: int, limit: int) -> AsyncIterator[str]:
    left, room_bytes = limit, MOST_BYTES
    while some:
        text = await asyncio.to_thread(_text, some)  # a campaign has megabytes; a reading waits for none
        after, left, room_bytes = some[-1].id, left - len(some), room_bytes - len(text)
        yield text
        some = await records.after(after, left) if left and room_bytes > 0 else ()
    yield json.dumps({"end": after, "newest": await records.newest()}) + "\n"


def _text(some: Sequence[OutboxLink]) -> str:
    return "".join(_line(link) for link in some)


def _line(link: OutboxLink) -> str:
    said: dict[str, Any] = {
        "link": link.id,
        "stream": link.stream,
        "record": link.record,
        "record_id": link.record_id,
        "hash": link.hash.hex(),
    }
    if link.row is not None:
        said["row"] = to_typed_json(link.row)
    if link.told is not None:
        said["told"] = to_typed_json(link.told)
    return json.dumps(said, ensure_ascii=False, separators=(",", ":")) + "\n"
