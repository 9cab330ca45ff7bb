"""What live streams to tablets share: the newest sample, the situation whenever it changes, a sign of life.

A slow reader gets the newest of both, not a queue of old ones.
"""

import asyncio
import contextlib
import json
from collections.abc import AsyncIterator, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Annotated, Any, Final

from fastapi import Depends, Query
from fastapi.responses import StreamingResponse
from pydantic import AfterValidator

from truepose.domain.people.names import NAME_PATTERN, tidy_name
from truepose.web.context import Context, Here
from truepose.web.events import Seconds
from truepose.web.problems import problems
from truepose.web.requests.parameters import Id
from truepose.web.schemas.streams import EVENT_STREAM, stream_content

_HEARTBEAT_S: Final = 1.0  # a page tells a person within two seconds that the link is gone
TabletName = Annotated[
    str,
    Query(
        min_length=1,
        max_length=100,
        pattern=NAME_PATTERN,
        description="Who follows; as long as the stream is open this tablet watches.",
        examples=["tablet-1"],
    ),
    AfterValidator(tidy_name),
]


def live_responses(sample: Mapping[str, object], told: str, *refused: int) -> dict[int | str, dict[str, Any]]:
    """Return what documents a stream of such samples, and the problems that it may be refused with."""
    content = stream_content(f"event: sample\ndata: {json.dumps(sample)}\n\n")
    return {200: {"description": told, "content": content}, **problems(*refused)}


@dataclass(frozen=True, slots=True)
class Follower:
    """A tablet that follows a session, for as long as it wants."""

    here: Context
    session_id: int
    tablet: str
    stop_after_s: float | None = None

    def streamed(self, situations: AsyncIterator[str], samples: AsyncIterator[str]) -> StreamingResponse:
        """Return the answer that sends situations and samples, as JSON, while the tablet is counted."""
        headers = {"Cache-Control": "no-store", "X-Accel-Buffering": "no"}
        watching = self.here.session_desk.watching.by(self.session_id, self.tablet)
        stream = _stream(self.here, watching, situations, samples, self.stop_after_s)
        return StreamingResponse(stream, media_type=EVENT_STREAM, headers=headers)


async def _follower(here: Here, id: Id, tablet: TabletName, stop_after_s: Seconds = None) -> Follower:
    return Follower(here, id, tablet, stop_after_s)


Following = Annotated[Follower, Depends(_follower)]


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


async def _stream(
    here: Context,
    watching: AbstractContextManager[None],
    situations: AsyncIterator[str],
    samples: AsyncIterator[str],
    stop_after_s: float | None,
) -> AsyncIterator[str]:
    mailbox = _Mailbox()
    with watching, contextlib.suppress(TimeoutError):
        feeding = [
            asyncio.create_task(_feed_situations(situations, mailbox)),
            asyncio.create_task(_feed_samples(samples, mailbox)),
        ]
        try:
            async with asyncio.timeout(stop_after_s):
                yield "retry: 1000\n\n"  # EventSource comes back after a second when the service restarts
                while not here.stopping.is_set():
                    yield await mailbox.take()
        finally:
            for task in feeding:
                task.cancel()
            await asyncio.gather(*feeding, return_exceptions=True)


async def _feed_situations(situations: AsyncIterator[str], mailbox: _Mailbox) -> None:
    told = None
    async for text in situations:
        if text != told:
            mailbox.put_situation(f"event: situation\ndata: {text}\n\n")
            told = text


async def _feed_samples(samples: AsyncIterator[str], mailbox: _Mailbox) -> None:
    async for text in samples:
        mailbox.put_sample(f"event: sample\ndata: {text}\n\n")
