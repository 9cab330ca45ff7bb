"""Sessions that run by themselves, as a tablet guides through them: seen, followed, acted upon."""

import json
from collections.abc import AsyncIterator
from typing import Final

from fastapi.responses import StreamingResponse

from truepose.sequencing.tracker.measuring.watching import Sighting
from truepose.web.context import Context, Here
from truepose.web.measurement.live_stream import Following, live_responses
from truepose.web.people.authority import require_authority
from truepose.web.problems import problems
from truepose.web.requests.parameters import Id, RequiredKey
from truepose.web.resources import resource
from truepose.web.schemas.measurement.guides import (
    GuideActReply,
    GuideActRequest,
    GuidedSceneReply,
    GuideReply,
    OutlookReply,
    SheetReply,
    guide_act,
    guide_reply,
    scene_reply,
    sheet_reply,
)

router = resource("/sessions/{id}", tags=["sessions"])
_READ: Final = problems(404, 409, 422, 503)
_ACT: Final = problems(400, 404, 409, 413, 415, 422, 503)
_SAMPLE: Final = {
    "sampled_at_ms": 1777885953125,
    "config": 7,
    "nest": 1,
    "fixed_nest": None,
    "expected_mm": [412.1, -80.4, 633.0],
    "tolerance_mm": 10.0,
    "delta_mm": [0.412, -1.032, 0.633],
    "distance_mm": 1.279,
    "state": "within",
    "is_seen": True,
    "is_moving": False,
}
_LIVE: Final = live_responses(_SAMPLE, "Looks and situations as they come.", 404, 409, 422, 503)


@router.get("/guide", responses=_READ)
async def get_guide(here: Here, id: Id) -> GuideReply:
    """Show where a session stands and what may be pressed; follow `live` instead of asking again."""
    return guide_reply(await here.guided_sessions.guide(id))


@router.get("/guide/sheet", responses=_READ)
async def get_sheet(here: Here, id: Id) -> SheetReply:
    """List what was read so far: warm-up, fixed nests, looks at them, configurations."""
    return sheet_reply(await here.guided_sessions.sheet(id))


@router.get("/guide/scene", responses=_READ)
async def get_guided_scene(here: Here, id: Id) -> GuidedSceneReply:
    """Show the cell as its instrument sees it: arm, nests, configurations in sight and hidden ones."""
    return scene_reply(await here.guided_sessions.scene(id))


@router.get("/guide/outlook", responses=_READ)
async def get_outlook(here: Here, id: Id) -> OutlookReply:
    """Say what accuracy the readings so far promise, and the rest of the plan; a worker computes it."""
    found = await here.guided_sessions.outlook(id)
    if found is None:
        return OutlookReply(state="too_early", now=None, at_end=None)
    return OutlookReply.of(found, state="known")


@router.post("/guide/acts", responses=_ACT)
async def press_button_of_session(
    here: Here, id: Id, wanted: GuideActRequest, key: RequiredKey
) -> GuideActReply:
    """Press a button. The answer comes when what it did is on disk; a repeated key gets the same answer."""
    await require_authority(here, id, wanted.act)
    answer = await here.guided_sessions.act(id, guide_act(wanted, key.key), key)
    session = guide_reply(await here.guided_sessions.guide(id))
    return GuideActReply(sentence=answer.sentence, entry=answer.entry, session=session)


@router.get("/guide/live", response_class=StreamingResponse, responses=_LIVE)
async def follow_guide(following: Following) -> StreamingResponse:
    """Follow a session: `sample` is where the reflector is, `situation` the session as it changes.

    The stream begins with the session as it is; a comment each second shows that the service lives.
    """
    here, id = following.here, following.session_id
    await here.guided_sessions.guide(id)
    return following.streamed(_situations(here, id), _samples(here, id))


async def _situations(here: Context, id: int) -> AsyncIterator[str]:
    async for view in here.guided_sessions.follow(id):
        yield guide_reply(view).model_dump_json()


async def _samples(here: Context, id: int) -> AsyncIterator[str]:
    async for sighting in here.guided_sessions.sightings(id):
        yield json.dumps(_document(sighting))


def _document(sighting: Sighting) -> dict[str, object]:
    aim = sighting.aim
    return {
        "sampled_at_ms": sighting.sampled_at_ms,
        "config": None if aim is None else aim.config,
        "nest": None if aim is None else aim.nest,
        "fixed_nest": None if aim is None else aim.fixed_nest,
        "expected_mm": None if aim is None else aim.expected_mm,
        "tolerance_mm": None if aim is None else aim.tolerance_mm,
        "delta_mm": sighting.delta_mm,
        "distance_mm": sighting.distance_mm,
        "state": sighting.state,
        "is_seen": sighting.is_seen,
        "is_moving": sighting.is_moving,
    }
