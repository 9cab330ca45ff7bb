"""Following a session: where it stands, what its instrument sees, what to draw of it, what happened in it.

A slow reader gets the newest of both, not a queue of old ones.
"""

import asyncio
import contextlib
import json
from collections.abc import AsyncGenerator
from dataclasses import dataclass
from typing import Annotated, Final

from fastapi import Depends, Query
from fastapi.responses import StreamingResponse
from pydantic import AfterValidator

from truepose.analysis.campaigns.contacts import readings_of
from truepose.domain.people import NAME_PATTERN, tidy_name
from truepose.web.api.events import EventStream, Seconds, stream_content
from truepose.web.api.sessions.ballbar import entry_reply
from truepose.web.api.sessions.ballbar_replies import LedgerReply
from truepose.web.api.sessions.contact_schemas import ContactReadingReply
from truepose.web.api.sessions.guides import OutlookReply, SheetReply
from truepose.web.api.sessions.kind import KindOfSession
from truepose.web.api.sessions.kinds import AnyPlan, AnyScene, AnySituation, kind_of
from truepose.web.context import Here
from truepose.web.resources import ACT, LIST_OF_RECORD, READ, Counted, Id, Paged, resource, sending
from truepose.web.schemas import Reply

router = resource("/sessions/{id}", tags=["sessions"])
_SAMPLE: Final = {
    "time_s": 812.35,
    "length_mm": 300.4213,
    "deviation_mm": 0.4213,
    "state": "in_range",
    "stable_share": 0.6,
    "spread_mm": 0.0012,
    "robot_still": True,
    "sampled_at_ms": 1777885953125.0,
    "ballbar": "connected",
    "reason_needed": False,
    "can_store": True,
    "why_not": None,
    "let_go": True,
}
_LIVE: Final = sending(
    "Samples of the instrument (here a ballbar) and situations of the session as they occur.",
    stream_content(f"event: sample\ndata: {json.dumps(_SAMPLE)}\n\n"),
)
_HEARTBEAT_S: Final = 1.0  # a page tells a person within two seconds that the link is gone
TabletName = Annotated[
    str,
    Query(
        min_length=1,
        max_length=100,
        pattern=NAME_PATTERN,
        description="Name of the tablet; it watches the session while the stream is open.",
        examples=["tablet-1"],
    ),
    AfterValidator(tidy_name),
]


@dataclass(frozen=True, slots=True)
class Follower:
    """A tablet that follows a session, for as long as it wants."""

    here: Here
    id: Id  # of the session
    tablet: TabletName
    stop_after_s: Seconds = None


async def _kind(here: Here, id: Id) -> KindOfSession:
    return kind_of(await here.sessions.get(id))


Kind = Annotated[KindOfSession, Depends(_kind)]


Following = Annotated[Follower, Depends()]


class _Mailbox:
    """Holds what the reader has not had yet: the newest sample and the newest situation."""

    def __init__(self) -> None:
        self._sample: str | None = None
        self._situation: str | None = None
        self._filled = asyncio.Event()

    def put_sample(self, text: str) -> None:
        self._sample = text
        self._filled.set()

    def put_situation(self, text: str) -> None:
        self._situation = text
        self._filled.set()

    async def take(self) -> str:
        """Return what is there, the situation first; a comment where nothing came for a second."""
        # not wait_for: before Python 3.12 it drops a cancellation that comes together with the sample
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(_HEARTBEAT_S):
                await self._filled.wait()
        self._filled.clear()
        texts = [text for text in (self._situation, self._sample) if text is not None]
        self._situation = self._sample = None
        return "".join(texts) or ": still here\n\n"


async def _stream(following: Follower, kind: KindOfSession) -> AsyncGenerator[str]:
    here, mailbox = following.here, _Mailbox()
    watching = here.session_desk.watching.by(following.id, following.tablet)
    with watching, contextlib.suppress(TimeoutError):
        feeding = [
            asyncio.create_task(feed(following, kind, mailbox)) for feed in (_feed_situations, _feed_samples)
        ]
        try:
            async with asyncio.timeout(following.stop_after_s):
                yield "retry: 1000\n\n"  # EventSource comes back after a second when the service restarts
                while not here.stopping.is_set():
                    yield await mailbox.take()
        finally:
            for task in feeding:
                task.cancel()
            await asyncio.gather(*feeding, return_exceptions=True)


async def _feed_situations(following: Follower, kind: KindOfSession, mailbox: _Mailbox) -> None:
    told = None
    async for _ in following.here.session_desk.changes(following.id):
        text = (await kind.situation(following.here, following.id)).model_dump_json()
        if text != told:
            mailbox.put_situation(f"event: situation\ndata: {text}\n\n")
            told = text


async def _feed_samples(following: Follower, kind: KindOfSession, mailbox: _Mailbox) -> None:
    async for seen in following.here.session_desk.live(following.id):
        mailbox.put_sample(f"event: sample\ndata: {json.dumps(kind.sample(seen))}\n\n")


@router.get("/situation", response_model=AnySituation, responses=READ)
async def get_situation(here: Here, id: Id, kind: Kind) -> Reply:
    """Return the current situation and the available commands; follow `live` instead of polling."""
    return await kind.situation(here, id)


@router.get("/plan", response_model=AnyPlan, responses=READ)
async def get_plan(here: Here, id: Id, kind: Kind) -> Reply:
    """Return the steps or configurations of a session in order; available before the start as well."""
    return await kind.planned_steps(here, id)


@router.get("/scene", response_model=AnyScene, responses=READ)
async def get_scene(here: Here, id: Id, kind: Kind) -> Reply:
    """Return the scene to draw: the cell as its instrument sees it, or the present ballbar step."""
    return await kind.scene(here, id)


@router.get("/sheet", responses=ACT)
async def get_sheet(here: Here, id: Id) -> SheetReply:
    """Return the readings of a session without a ballbar: warm-up, fixed nests and configurations."""
    return SheetReply.of(await here.guided_sessions.sheet(id))


@router.get("/outlook", responses=ACT)
async def get_outlook(here: Here, id: Id) -> OutlookReply:
    """Return the accuracy predicted from the readings so far and from the complete plan.

    It is computed by a worker.
    """
    found = await here.guided_sessions.outlook(id)
    if found is None:
        return OutlookReply(state="too_early", now=None, at_end=None)
    return OutlookReply.of(found, state="known")


@router.get("/ledger", responses=LIST_OF_RECORD)
async def read_ledger(here: Here, id: Id, paging: Paged) -> LedgerReply:
    """Return the ledger, oldest entry first; `after` is the number of the last entry already read."""
    await here.sessions.require(id)
    return LedgerReply(
        entries=paging.shown(await here.session_desk.ledger.page(id, paging.page), entry_reply)
    )


@router.get("/contact-readings", responses=LIST_OF_RECORD)
async def list_contact_readings(here: Here, id: Id, paging: Counted) -> list[ContactReadingReply]:
    """List the gauge readings by configuration."""
    await here.contact_sessions.get(id)
    lines = await here.session_desk.ledger.whole(id)
    return paging.of(readings_of(line.entry for line in lines), ContactReadingReply.of)


@router.get("/live", response_class=StreamingResponse, responses=_LIVE | READ)
async def follow_session(following: Following) -> EventStream:
    """Follow a session: `sample` is the present reading of its instrument, `situation` the session state.

    The stream begins with the current situation; a comment every second shows that the connection is alive.
    """
    kind = kind_of(await following.here.sessions.get(following.id))
    await kind.situation(following.here, following.id)  # refused before an answer has begun
    return EventStream(_stream(following, kind))
