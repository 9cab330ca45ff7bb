"""The live stream of a ballbar session: the newest length at 20 Hz, and the session whenever it changes.

Nothing here asks the database while a session is under way: a sample goes from the driver to the page.
"""

import json
from collections.abc import AsyncIterator
from typing import Final

from fastapi.responses import StreamingResponse

from truepose.sequencing.ballbar.measuring.live import LiveSample
from truepose.web.context import Context
from truepose.web.measurement.ballbar.replies import ballbar_session_reply
from truepose.web.measurement.live_stream import Following, live_responses
from truepose.web.resources import resource

router = resource("/ballbar-sessions", tags=["ballbar sessions"])
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
_LIVE: Final = live_responses(_SAMPLE, "Samples and situations as they come.", 404, 422, 503)


@router.get("/{id}/live", response_class=StreamingResponse, responses=_LIVE)
async def follow_ballbar_session(following: Following) -> StreamingResponse:
    """Follow a session: `sample` is the newest value of the ballbar, `situation` the session as it changes.

    The stream begins with the session as it is; a comment each second shows that the service lives.
    """
    here, id = following.here, following.session_id
    await here.ballbar_sessions.view(id)
    return following.streamed(_situations(here, id), _samples(here, id))


async def _situations(here: Context, id: int) -> AsyncIterator[str]:
    async for view in here.ballbar_sessions.follow_views(id):
        yield ballbar_session_reply(view).model_dump_json()


async def _samples(here: Context, id: int) -> AsyncIterator[str]:
    while True:
        news = here.session_desk.watching.news
        runner = here.ballbar_sessions.running(id)
        if runner is not None:
            async for sample in runner.live():
                yield json.dumps(_document(sample))
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
