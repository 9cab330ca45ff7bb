"""Jobs: what a worker process was asked and how far it is."""

from pydantic import Field

from truepose.storage.records import JobKind, JobRecord, JobState
from truepose.web.schemas.base import RecordedAt, RecordId, Reply

_RESULTS = {
    JobKind.IDENTIFICATION: "identifications",
    JobKind.VALIDATION: "validations",
    JobKind.DIAGNOSIS: "diagnoses",
    JobKind.PLAN: "sessions",
    JobKind.CORRECTION: "corrections",
}


class JobRequestReply(Reply):
    """What the job was asked; each kind has its own part of these."""

    campaign_id: int | None = None
    model_id: int | None = None
    effects: list[str] | None = Field(None, description="Null: the usual ones.")
    measured_on: str | None = Field(None, description="Day of the readings, where somebody said it.")
    limit_mm: float | None = None
    name: str | None = None
    role: str | None = None
    configurations: int | None = None
    seed: int | None = None
    proves_model_id: int | None = Field(None, description="Of the plan of a proof move.")
    method: str | None = Field(None, description="Of the plan of a test: `circles`, `iso9283`.")
    test: str | None = Field(None, description="Of the plan of ISO 9283: `poses`, `directions`, `drift`.")
    file: str | None = Field(None, description="Name of what is corrected.")
    beside: list[str] | None = Field(None, description="Names of the files beside it.")
    frame: str | None = None
    define: list[str] | None = None
    branch: str | None = None
    angles: str | None = None
    coupled: bool | None = Field(None, description="Whether joint 3 of FANUC counts from the horizontal.")
    joints: list[int] | None = Field(None, description="That are turned; none: the usual ones.")


class JobReply(Reply):
    """A job and where it stands."""

    id: RecordId
    recorded_at: RecordedAt
    kind: JobKind
    request: JobRequestReply
    state: JobState = Field(description="`interrupted`: the service ended before the job did.")
    state_since: RecordedAt
    message: str = Field(description="What it is doing, how it ended, or why it failed.")
    fraction: float = Field(ge=0, le=1, description="How far it is: 0 to 1.", examples=[0.4])
    result_id: int | None = Field(description="Number of what it made, once it succeeded.")
    result_url: str | None = Field(examples=["/api/v1/identifications/3"])


def job_reply(record: JobRecord) -> JobReply:
    """Return a job as it travels."""
    made = record.result_id
    return JobReply.of(record, result_url=None if made is None else f"/api/v1/{_RESULTS[record.kind]}/{made}")
