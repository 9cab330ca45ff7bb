"""Server-sent events: everything that happens, numbered, resumable by Last-Event-ID."""

import asyncio
import contextlib
import json
from collections.abc import AsyncGenerator
from dataclasses import dataclass
from typing import Annotated, Any, Final

from fastapi import Header, Query
from fastapi.responses import StreamingResponse
from starlette.types import Send

from truepose.storage.documents import text_from
from truepose.storage.records import EventRecord, Page
from truepose.web.context import Context, Here
from truepose.web.middleware.language import in_words
from truepose.web.resources import READ, resource, sending
from truepose.web.schemas import NUMBER_LIMIT

EVENT_STREAM: Final = "text/event-stream"
_EVENT: Final = {
    "type": "object",
    "description": "An event of the stream.",
    "required": ["data"],
    "properties": {
        "id": {"description": "Number of the event; absent if the event has none."},
        "event": {"type": "string", "description": "Kind of event."},
        "data": {"type": "string", "description": "Content of the event, as JSON."},
    },
}


class EventStream(StreamingResponse):
    """Server-sent events from a generator, which is closed with the connection and not some time after."""

    media_type = EVENT_STREAM

    def __init__(self, events: AsyncGenerator[str]) -> None:
        super().__init__(events, headers={"Cache-Control": "no-store", "X-Accel-Buffering": "no"})
        self.events = events

    async def stream_response(self, send: Send) -> None:
        """Send what happens until it ends or nobody follows."""
        async with contextlib.aclosing(self.events):
            await super().stream_response(send)


def stream_content(example: str) -> dict[str, Any]:
    """Return what documents the answer of a stream."""
    return {EVENT_STREAM: {"schema": _EVENT, "example": example}}


router = resource("/events", tags=["events"])
_BATCH: Final = 200
_HEARTBEAT_S: Final = 15.0  # proxies drop a connection on which nothing was said for half a minute or so
_EXAMPLE: Final = (
    "id: 42\nevent: session.progress\n"
    'data: {"session_id": 3, "job_id": null, "recorded_at": "2026-05-04T09:12:33.125+00:00", '
    '"done": 12, "skipped": 0, "planned": 55, "elapsed_s": 345.2, "remaining_s": 1190.0, '
    '"doing": "measuring configuration 13"}\n\n'
)
OfRecord = Annotated[int | None, Query(ge=1, le=NUMBER_LIMIT)]
EventNumber = Annotated[
    int | None,
    Header(
        alias="Last-Event-ID",
        ge=0,
        le=NUMBER_LIMIT,
        description="Number of the last event received; 0 to start with the first event.",
    ),
]
Seconds = Annotated[
    float | None,
    Query(gt=0, le=86_400, description="Time after which the stream ends; by default, it stays open."),
]


@dataclass(frozen=True, slots=True)
class _Interest:
    session_id: int | None
    job_id: int | None


@router.get(
    "",
    response_class=StreamingResponse,
    responses=sending("Events as they occur.", stream_content(_EXAMPLE)) | READ,
)
async def follow_events(
    here: Here,
    session_id: OfRecord = None,
    job_id: OfRecord = None,
    last_event_id: EventNumber = None,
    stop_after_s: Seconds = None,
) -> EventStream:
    """Follow events such as `session.state`, `session.reading`, `session.stops_added` and `job.state`.

    For one session or job the stream starts with its first event, otherwise with the next event, unless
    `Last-Event-ID` gives the event after which to resume. It stays open; a comment every 15 s shows that the
    connection is alive.
    """
    if session_id is not None:
        await here.sessions.get(session_id)
    if job_id is not None:
        await here.jobs.get(job_id)
    interest = _Interest(session_id, job_id)
    start = await _start(here, interest, last_event_id)
    return EventStream(_stream(here, interest, start, stop_after_s))


async def _start(here: Context, interest: _Interest, last_event_id: int | None) -> int:
    if last_event_id is not None:
        return last_event_id
    return await here.events.newest() if interest == _Interest(None, None) else 0


async def _stream(
    here: Context, interest: _Interest, after: int, stop_after_s: float | None
) -> AsyncGenerator[str]:
    with contextlib.suppress(TimeoutError):
        async with asyncio.timeout(stop_after_s):
            yield "retry: 1000\n\n"  # EventSource comes back after a second when the service restarts
            while not here.stopping.is_set():
                # Taken before the events are read: what is committed while they are read wakes the stream at
                # once.
                commit = here.database.next_commit
                found = await here.events.after(
                    Page(after, _BATCH), session_id=interest.session_id, job_id=interest.job_id
                )
                for event in found:
                    after = event.id
                    yield _text(event)
                if len(found) < _BATCH and not await _happens(commit):
                    yield ": still here\n\n"


async def _happens(commit: asyncio.Event) -> bool:
    try:
        # not wait_for: before Python 3.12 it drops a cancellation that comes together with the commit
        async with asyncio.timeout(_HEARTBEAT_S):
            await commit.wait()
    except TimeoutError:
        return False
    return True


def _text(event: EventRecord) -> str:
    origin = {
        "session_id": event.session_id,
        "job_id": event.job_id,
        "recorded_at": event.recorded_at,
    }
    told = {**origin, **_in_words(event.document)}
    # No line break can be in JSON, so one `data` line holds it.
    return f"id: {event.id}\nevent: {event.kind}\ndata: {json.dumps(told)}\n\n"


def _in_words(document: Any) -> Any:
    """Return a document with its messages in the words of whoever follows."""
    if not isinstance(document, dict):
        return document
    if document.keys() == {"key", "values"}:
        return in_words(text_from(document))
    return {name: _in_words(value) for name, value in document.items()}
