"""Health: outside the versioned API, for whatever watches the service, and for people."""

from http import HTTPStatus
from typing import Any

from fastapi import Response

from truepose.storage.connection.sqlite.library import FAULTY as SQLITE_FAULTY
from truepose.storage.connection.sqlite.library import VERSION as SQLITE_VERSION
from truepose.web.context import Context
from truepose.web.healthiness.checks import Check, checks, worst
from truepose.web.problems import problem_response, problems
from truepose.web.resources import outside_the_api
from truepose.web.schemas.health import CheckReply, Health, IntegrityReply
from truepose.web.visiting.visits import Visit, Visited
from truepose.words.catalogue import english
from truepose.words.error_codes import code_named

router = outside_the_api(tags=["health"])
_HTML = "text/html"
_SIGN_IN = "Something is amiss; sign in to see what."


@router.get(
    "/health",
    response_model=Health,
    response_model_by_alias=True,
    responses={**problems(503), 200: {"content": {_HTML: {}}}},
)
async def get_health(visit: Visited) -> Health | Response:
    """Say that the service works, on what, and what is amiss; a browser is shown a page.

    Strangers learn how it is, and not why. The status is 200 also where the disk refuses records: the
    readings that wait for it are in this process, and whoever watches must not end it. It is 503 where the
    database cannot be read, or has been silent for ten seconds.
    """
    state = await visit.here.lookout.state()
    found = checks(state)
    status = HTTPStatus.OK if state.records.readable else HTTPStatus.SERVICE_UNAVAILABLE
    if _wants_a_page(visit):
        shown = found if visit.may("get_cell") else []
        return visit.page("health.html", status, checks=shown, worst=worst(found))
    if status is not HTTPStatus.OK:
        return problem_response(visit.request, status, " ".join(_wrong(found)), code=code_named("NotReady"))
    told = _reply(visit.here, found)
    return told if visit.may("get_cell") else told.model_copy(update=_to_strangers(told))


def _to_strangers(told: Health) -> dict[str, Any]:
    return {"checks": [], "fault": None if told.fault is None else _SIGN_IN}


def _wrong(found: list[Check]) -> list[str]:
    return [english(check.sentence) for check in found if check.verdict == "bad"]


def _wants_a_page(visit: Visit) -> bool:
    return _HTML in visit.request.headers.get("accept", "")


def _reply(here: Context, found: list[Check]) -> Health:
    storage = here.database.condition
    fault = " ".join(told for told in (here.fault(), storage.fault) if told) or None
    return Health(
        status="ok" if fault is None else "degraded",
        fault=fault,
        version=here.version,
        simulated=here.simulated,
        people="announced" if here.cell.people else "anybody",
        schema=here.database.schema,
        writable=storage.trouble is None,
        integrity=IntegrityReply(state=storage.integrity, share=storage.verified_share),
        sqlite=SQLITE_VERSION,
        sqlite_mended=not SQLITE_FAULTY,
        verdict=worst(found),
        checks=[
            CheckReply(name=check.name, verdict=check.verdict, sentence=english(check.sentence))
            for check in found
        ],
    )
