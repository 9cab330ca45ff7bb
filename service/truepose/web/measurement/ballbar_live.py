"""The live stream of a ballbar session: the newest length at 20 Hz, and the session whenever it changes.

Nothing here asks the database while a session is under way: a sample goes from the driver to the page.
A slow reader gets the newest sample, not a queue of old ones.
"""

import asyncio
import contextlib
import json
from collections.abc import AsyncIterator
from typing import Annotated, Final

from fastapi import APIRouter, Query
from fastapi.responses import StreamingResponse
from pydantic import AfterValidator

from truepose.domain.people import NAME_PATTERN, tidy_name
from truepose.sequencing.ballbar.measuring.live import LiveSample
from truepose.web.context import Context, Here
from truepose.web.events import Seconds
from truepose.web.measurement.ballbar_replies import ballbar_session_reply
from truepose.web.parameters import Id
from truepose.web.problems import problems

router = APIRouter(prefix="/ballbar-sessions", tags=["ballbar sessions"])
_HEARTBEAT_S: Final = 1.0  # a page tells a person within two seconds that the link is gone
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
_EXAMPLE: Final = f"event: sample\ndata: {json.dumps(_SAMPLE)}\n\n"
_STREAM: Final = {"text/event-stream": {"schema": {"type": "string"}, "example": _EXAMPLE}}
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


@router.get(
    "/{id}/live",
    response_class=StreamingResponse,
    responses={
        200: {"description": "Samples and situations as they come.", "content": _STREAM},
        **problems(404, 422, 503),
    },
)
async def follow_ballbar_session(
    here: Here, id: Id, tablet: TabletName, stop_after_s: Seconds = None
) -> StreamingResponse:
    """Follow a session: `sample` is the newest value of the ballbar, `situation` the session as it changes.

    The stream begins with the session as it is; a comment each second shows that the service lives.
    """
    await here.ballbar_sessions.view(id)
    headers = {"Cache-Control": "no-store", "X-Accel-Buffering": "no"}
    return StreamingResponse(
        _stream(here, id, tablet, stop_after_s), media_type="text/event-stream", headers=headers
    )


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


async def _stream(here: Context, id: int, tablet: str, stop_after_s: float | None) -> AsyncIterator[str]:
    mailbox = _Mailbox()
    with here.session_desk.watching.by(id, tablet), contextlib.suppress(TimeoutError):
        feeding = [
            asyncio.create_task(_feed_situations(here, id, mailbox)),
            asyncio.create_task(_feed_samples(here, id, mailbox)),
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


async def _feed_situations(here: Context, id: int, mailbox: _Mailbox) -> None:
    told = None
    async for view in here.ballbar_sessions.follow_views(id):
        text = ballbar_session_reply(view).model_dump_json()
        if text != told:
            mailbox.put_situation(f"event: situation\ndata: {text}\n\n")
            told = text


async def _feed_samples(here: Context, id: int, mailbox: _Mailbox) -> None:
    while True:
        news = here.session_desk.watching.news
        runner = here.ballbar_sessions.running(id)
        if runner is not None:
            async for sample in runner.live():
                mailbox.put_sample(f"event: sample\ndata: {json.dumps(_document(sample))}\n\n")
        await news.wait()  # also behind a run that is over, until there is another one


def _document(sample: LiveSample) -> dict[str, object]:
    return {
        "time_s": sample.time_s,
        "length_mm": sample.length_mm,
        "deviation_mm": sample.deviation_mm,
        "state": sample.state,
        "stable_share": sample.stable_share,
        "spread_mm": sample.spread_mm,
        "robot_still": sample.robot_still,
        "sampled_at_ms": sample.sampled_at_ms,
        "ballbar": sample.ballbar,
        "reason_needed": sample.reason_needed,
        "can_store": sample.can_store,
        "why_not": sample.why_not,
        "let_go": sample.let_go,
    }
