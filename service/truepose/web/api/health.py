"""Health and figures, outside the versioned API: for whatever watches the service, and for people."""

from http import HTTPStatus
from typing import Literal

from fastapi import Request, Response
from fastapi.responses import PlainTextResponse
from pydantic import Field

from truepose.messages.catalogue import english
from truepose.messages.error_codes import code_named
from truepose.storage.engine.backend import Integrity
from truepose.storage.engine.sqlite_connections import FAULTY as SQLITE_FAULTY
from truepose.storage.engine.sqlite_connections import VERSION as SQLITE_VERSION
from truepose.web.api.health_checks import Check, Verdict, checks, worst
from truepose.web.context import Context, Here
from truepose.web.middleware.metrics import MEDIA_TYPE
from truepose.web.pages.rendering import Visited
from truepose.web.problems import problem_response, wants_a_page
from truepose.web.resources import outside_the_api, problems
from truepose.web.schemas import Reply


class CheckReply(Reply):
    """One thing that was looked at."""

    name: str = Field(
        description="What it was: the database, the disk, the chain of records, and so on.",
        examples=["disk"],
    )
    verdict: Verdict = Field(description="`warn`: look at it soon. `bad`: look at it now.")
    sentence: str = Field(
        description="For whoever runs the service.", examples=["24.1 GB are free where the database lies."]
    )


class IntegrityReply(Reply):
    """Whether all records are as they were written; looked through after each start and now and then."""

    state: Integrity
    share: float = Field(description="Done, of the look under way or the last one.", examples=[1.0])


class Health(Reply):
    """Whether the service works, and on what."""

    status: Literal["ok", "degraded"] = Field(description="`degraded`: `fault` says what is amiss.")
    fault: str | None = Field(description="One sentence; null where all is well.")
    version: str = Field(description="Of the program.", examples=["0.1.0"])
    simulated: bool = Field(description="True: no robot and no instrument take part.")
    people: Literal["announced", "anybody"] = Field(
        description="Who may have the arm move: people of the cell file, or whoever gives a name."
    )
    writable: bool = Field(description="False: the disk refuses records; sessions wait for it.")
    integrity: IntegrityReply
    sqlite: str = Field(description="Version of the database library.", examples=["3.53.4"])
    sqlite_mended: bool = Field(
        description="False: the library has the fault of the WAL reset; one writer keeps it from striking."
    )
    verdict: Verdict = Field(description="The worst of all checks.")
    checks: list[CheckReply] = Field(description="What was looked at.")
    schema_revision: str = Field(alias="schema", description="Of the database.", examples=["0006"])


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
    if wants_a_page(visit.request):
        shown = found if visit.may("get_cell") else []
        return visit.page("health.html", status, checks=shown, worst=worst(found))
    if status is not HTTPStatus.OK:
        return problem_response(visit.request, status, " ".join(_wrong(found)), code=code_named("NotReady"))
    told = _reply(visit.here, found)
    return told if visit.may("get_cell") else _for_strangers(told)


def _for_strangers(told: Health) -> Health:
    return told.model_copy(update={"checks": [], "fault": None if told.fault is None else _SIGN_IN})


def _wrong(found: list[Check]) -> list[str]:
    return [english(check.sentence) for check in found if check.verdict == "bad"]


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


@router.get("/metrics", response_class=PlainTextResponse)
async def get_metrics(request: Request, here: Here) -> Response:
    """Give every figure of the service in the text format of Prometheus."""
    program = {"version": here.version, "schema": here.database.schema}
    text = request.app.state.metrics.text(await here.lookout.state(), program)
    return Response(text, media_type=MEDIA_TYPE)
