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
    """Result of one health check."""

    name: str = Field(
        description="Name of the check, such as database, disk or chain.",
        examples=["disk"],
    )
    verdict: Verdict = Field(description="`warn`: needs attention soon. `bad`: needs attention now.")
    sentence: str = Field(
        description="Explanation for the operator of the service.",
        examples=["24.1 GB are free on the disk of the database."],
    )


class IntegrityReply(Reply):
    """Integrity of all records, checked after each start and at intervals."""

    state: Integrity
    share: float = Field(description="Completed share of the present or last check.", examples=[1.0])


class Health(Reply):
    """Health and versions of the service."""

    status: Literal["ok", "degraded"] = Field(description="`degraded`: see `fault`.")
    fault: str | None = Field(description="Description of the fault; null if there is none.")
    version: str = Field(description="Version of the software.", examples=["0.1.0"])
    simulated: bool = Field(description="True if no real robot or instrument takes part.")
    people: Literal["announced", "anybody"] = Field(
        description="People permitted to move the arm: those in the cell file, or anyone who gives a name."
    )
    writable: bool = Field(description="False if records cannot be stored; sessions wait until they can.")
    integrity: IntegrityReply
    sqlite: str = Field(description="Version of the SQLite library.", examples=["3.53.4"])
    sqlite_mended: bool = Field(
        description="False if the library has the WAL-reset bug, which has no effect here because there "
        "is only one writer."
    )
    verdict: Verdict = Field(description="Worst verdict of all checks.")
    checks: list[CheckReply] = Field(description="Results of the health checks.")
    schema_revision: str = Field(
        alias="schema", description="Schema revision of the database.", examples=["0006"]
    )


router = outside_the_api(tags=["health"])
_HTML = "text/html"
_SIGN_IN = "There is a problem; sign in for details."


@router.get(
    "/health",
    response_model=Health,
    response_model_by_alias=True,
    responses={**problems(503), 200: {"content": {_HTML: {}}}},
)
async def get_health(visit: Visited) -> Health | Response:
    """Return the health of the service, its versions and its faults; browsers get a page.

    Without signing in, only the state is shown, not the reason. The status is 200 even if the disk refuses
    records: the readings that wait for it are held by this process, so monitoring must not restart it. It is
    503 if the database cannot be read or has not responded for ten seconds.
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
    """Return the metrics of the service in the Prometheus text format."""
    program = {"version": here.version, "schema": here.database.schema}
    text = request.app.state.metrics.text(await here.lookout.state(), program)
    return Response(text, media_type=MEDIA_TYPE)
