"""Jobs: watch and cancel."""

from typing import Any

from fastapi import Response, status

from truepose.storage.records import JobRecord
from truepose.web.context import Context, Here
from truepose.web.problems import problems
from truepose.web.requests.paging import Paged, listing
from truepose.web.requests.parameters import RESPOND_ASYNC, Id
from truepose.web.resources import resource
from truepose.web.schemas.base import Reply
from truepose.web.schemas.jobs import JobReply, job_reply

router = resource("/jobs", tags=["jobs"])


@router.get("", responses=listing(422, 503))
async def list_jobs(here: Here, paging: Paged) -> list[JobReply]:
    """List jobs, oldest first."""
    return paging.shown(await here.jobs.page(paging.page), lambda record: _shown(here, record))


@router.get("/{id}", responses=problems(404, 422, 503))
async def get_job(here: Here, id: Id) -> JobReply:
    """Show a job, how far it is, and what it made."""
    return _shown(here, await here.jobs.get(id))


@router.post("/{id}/cancel", responses=problems(404, 409, 422, 503))
async def cancel_job(here: Here, id: Id) -> JobReply:
    """End a job and its worker process at once; nothing of it is stored. Refused where it has ended."""
    await here.job_desk.cancel(id)
    return _shown(here, await here.jobs.get(id))


def planned_or_queued(session: type[Reply], job: str) -> dict[int | str, dict[str, Any]]:
    """Return what a route lists under `responses` that plans a session, at once or by a job."""
    return {
        201: {"model": session, "description": "The session is planned; nothing has moved."},
        202: {"model": JobReply, "description": job},
    }


async def queued(here: Context, number: int, response: Response) -> JobReply:
    """Return a job that was queued just now, and say where it is watched."""
    response.headers["Location"] = f"/api/v1/jobs/{number}"
    return _shown(here, await here.jobs.get(number))


async def queued_as_preferred(here: Context, number: int, response: Response) -> JobReply:
    """Return a job that a client would rather be told of than wait (RFC 7240)."""
    response.status_code = status.HTTP_202_ACCEPTED
    response.headers["Preference-Applied"] = RESPOND_ASYNC
    return await queued(here, number, response)


def _shown(here: Context, record: JobRecord) -> JobReply:
    return job_reply(record, here.job_desk.foreseen(record.id))
