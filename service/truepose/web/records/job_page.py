"""A job: how far it is, how it ended, and what it made."""

from fastapi import APIRouter
from fastapi.responses import HTMLResponse

from truepose.storage.records import JobKind, JobRecord
from truepose.storage.work.items import WorkKind
from truepose.web.records.links import address_of, state_words, title_of
from truepose.web.records.trail import missing, record_at
from truepose.web.visiting.visits import Visit, Visited
from truepose.words.error_codes import explained

router = APIRouter(prefix="/jobs", include_in_schema=False)
_MAKES = {
    JobKind.IDENTIFICATION: (WorkKind.IDENTIFICATION, "job.identification"),
    JobKind.VALIDATION: (WorkKind.VALIDATION, "job.validation"),
    JobKind.DIAGNOSIS: (WorkKind.DIAGNOSIS, "job.diagnosis"),
    JobKind.PLAN: (WorkKind.SESSION, "job.plan"),
    JobKind.BALLBAR_PLAN: (WorkKind.SESSION, "job.plan"),
    JobKind.CONTACT_PLAN: (WorkKind.SESSION, "job.plan"),
    JobKind.CORRECTION: (WorkKind.CORRECTION, "job.correction"),
}


@router.get("/{id}", response_class=HTMLResponse)
async def job_page(visit: Visited, id: str) -> HTMLResponse:
    """Show a job; the page follows it and goes to what it made."""
    record = await record_at(id, visit.here.jobs.get)
    return missing(visit) if record is None else _shown(visit, record)


def _shown(visit: Visit, record: JobRecord) -> HTMLResponse:
    made, title = _MAKES[record.kind]
    look, state = state_words(WorkKind.JOB, record.state)
    sources = [(WorkKind.CAMPAIGN, "campaign_id"), (WorkKind.MODEL, "model_id")]
    asked = [(kind, record.request.get(key)) for kind, key in sources]
    return visit.page(
        "results/job.html",
        record=record,
        title=title,
        look=look,
        state=state,
        made=None if record.result_id is None else address_of(made, record.result_id),
        told=None if record.code is None else explained(record.code, visit.words),
        sources=[(address_of(kind, n), title_of(kind, n, visit.words)) for kind, n in asked if n],
    )
