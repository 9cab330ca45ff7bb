"""Jobs: what a worker process was asked and how far it is; watch and cancel."""

from typing import Final

from fastapi import Response
from pydantic import Field

from truepose.analysis.job_queue.queue import JobForecast
from truepose.exchange.results.set_aside import SetAside
from truepose.messages.message import message, together
from truepose.storage.records import JobKind, JobRecord, JobState
from truepose.web.context import Context, Here
from truepose.web.middleware.language import Said, in_words
from truepose.web.pages.records import MAKES, address_of
from truepose.web.resources import ACT, LIST, READ, RESPOND_ASYNC, Id, Paged, resource
from truepose.web.schemas import RecordedAt, RecordId, Reply, example

_WAITS: Final = message("job.kept_in_memory")


class JobRequestReply(Reply):
    """Parameters of the job; each kind of job uses some of them."""

    campaign_id: int | None = None
    model_id: int | None = None
    effects: list[str] | None = Field(None, description="Names of effects; null for the default effects.")
    measured_on: str | None = Field(None, description="Date of the readings, if stated.")
    set_aside: SetAside = None
    limit_mm: float | None = None
    name: str | None = None
    role: str | None = None
    configurations: int | None = None
    poses: int | None = Field(None, description="Number of poses, for the plan of a ballbar session.")
    placements: int | None = Field(
        None, description="Number of base fixture placements, for the plan of a ballbar session."
    )
    seed: int | None = None
    work_count: int | None = Field(
        None,
        description="Amount of work: readings, configurations, poses, or kB of a file. The duration is "
        "estimated from it and from earlier jobs.",
    )
    proves_model_id: int | None = Field(None, description="Model whose improvement the session measures.")
    repeats_session_id: int | None = Field(None, description="Session whose plan is repeated.")
    method: str | None = Field(None, description="Test to plan: `circles`, `iso9283` or `sphere`.")
    test: str | None = Field(None, description="ISO 9283 test to plan: `poses`, `directions` or `drift`.")
    file: str | None = Field(None, description="Name of the file to correct.")
    beside: list[str] | None = Field(None, description="Names of the accompanying files.")
    frame: str | None = None
    define: list[str] | None = None
    branch: str | None = None
    angles: str | None = None
    coupled: bool | None = Field(None, description="True if FANUC joint 3 is measured from the horizontal.")
    as_written: bool | None = Field(None, description="True if the targets are used as written.")
    joints: list[int] | None = Field(
        None, description="Joints to turn; empty for those of the standard test."
    )


class JobReply(Reply):
    """A job and its state."""

    model_config = example({
        "id": 7,
        "recorded_at": "2026-05-04T09:12:33.125+00:00",
        "kind": "identification",
        "request": {"campaign_id": 3, "effects": ["base", "geometry"], "work_count": 150},
        "state": "succeeded",
        "state_since": "2026-05-04T09:12:36.410+00:00",
        "message": "Converged.",
        "fraction": 1.0,
        "result_id": 4,
        "result_url": "/api/v1/identifications/4",
    })

    id: RecordId
    recorded_at: RecordedAt
    kind: JobKind
    request: JobRequestReply
    state: JobState = Field(
        description="State of the job; `interrupted`: the service stopped before the job ended."
    )
    state_since: RecordedAt
    message: Said = Field(description="Present activity, result, or reason for the failure.")
    fraction: float = Field(
        ge=0,
        le=1,
        description="Progress from 0 to 1, from the worker's reports and the estimated duration.",
        examples=[0.4],
    )
    remaining_s: float | None = Field(
        None,
        description="Estimated remaining time, from earlier jobs; null if the job is not running.",
        examples=[12.5],
    )
    ahead_count: int | None = Field(
        None,
        description="Number of jobs ahead of this one in the queue; null once this job has ended.",
        examples=[0],
    )
    result_id: int | None = Field(
        description="Number of the record created by the job; null until it has succeeded."
    )
    result_url: str | None = Field(examples=["/api/v1/identifications/3"])
    code: str | None = Field(
        None,
        description="Error code of the failure, to quote in support requests; null if the job did not fail.",
        examples=["TP-4002"],
    )
    code_url: str | None = Field(
        None, description="Page that explains the error code.", examples=["/errors/TP-4002"]
    )


def job_reply(record: JobRecord, foreseen: JobForecast | None = None) -> JobReply:
    """Return a job as it travels, with what is foreseen of one under way."""
    made, _ = MAKES[record.kind]
    reply = JobReply.of(
        record,
        result_url=None if record.result_id is None else f"/api/v1{address_of(made, record.result_id)}",
        code_url=None if record.code is None else f"/errors/{record.code}",
    )
    if foreseen is None or record.state.final:
        return reply
    reply.ahead_count = foreseen.ahead_count
    if foreseen.refused is not None:
        reply.message = in_words(together(_WAITS, foreseen.refused))
    if foreseen.outlook is not None:
        reply.fraction, reply.remaining_s = foreseen.outlook.fraction, foreseen.outlook.remaining_s
    return reply


router = resource("/jobs", tags=["jobs"])


@router.get("", responses=LIST)
async def list_jobs(here: Here, paging: Paged) -> list[JobReply]:
    """List jobs, oldest first."""
    return paging.shown(await here.jobs.page(paging.page), lambda record: _shown(here, record))


@router.get("/{id}", responses=READ)
async def get_job(here: Here, id: Id) -> JobReply:
    """Return a job, its progress and its result."""
    return _shown(here, await here.jobs.get(id))


@router.post("/{id}/cancel", responses=ACT)
async def cancel_job(here: Here, id: Id) -> JobReply:
    """Cancel a job and its worker process at once; nothing is stored. Refused if the job has ended."""
    await here.job_desk.cancel(id)
    return _shown(here, await here.jobs.get(id))


async def queued_job(here: Context, number: int, response: Response, *, preferred: bool = False) -> JobReply:
    """Return a job that was queued just now, and say where it is watched.

    `preferred`: the client would rather be told of it than wait (RFC 7240).
    """
    if preferred:
        response.headers["Preference-Applied"] = RESPOND_ASYNC
    response.headers["Location"] = f"/api/v1/jobs/{number}"
    return _shown(here, await here.jobs.get(number))


def _shown(here: Context, record: JobRecord) -> JobReply:
    return job_reply(record, here.job_desk.foreseen(record.id))
