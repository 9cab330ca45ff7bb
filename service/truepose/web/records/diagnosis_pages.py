"""Diagnoses for people: a list, and each as its report, at the size of a tablet.

The reports are imported where a page is made: their drawing library takes most of a second, and the service
must not wait for it when it starts.
"""

import asyncio
import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from fastapi import APIRouter
from fastapi.responses import HTMLResponse

from truepose.sequencing.engine.states import has_ended
from truepose.storage.records import CampaignRecord, DiagnosisRecord, SessionRecord
from truepose.storage.work.items import WorkKind
from truepose.web.context import Context
from truepose.web.records.trail import missing, record_at, trail_of
from truepose.web.visiting.drawn import Whole, drawn_part
from truepose.web.visiting.moments import moment
from truepose.web.visiting.visits import Visited
from truepose.words.catalogue import IN_ENGLISH, Catalogue

if TYPE_CHECKING:
    from truepose.reports import DiagnosisInput, VerdictWords

router = APIRouter(include_in_schema=False)
_SHOWN: Final = 50


@dataclass(frozen=True, slots=True)
class Actions:
    """What a person can ask for below a diagnosis of a session."""

    session: SessionRecord
    ended: bool
    configurations_deg: tuple[tuple[float, ...], ...]  # of all proposals
    again: dict[str, object]  # body of the request that repeats this diagnosis on all readings by now


@router.get("/diagnoses", response_class=HTMLResponse)
async def diagnoses_page(visit: Visited) -> HTMLResponse:
    """List the latest diagnoses with their first lines."""
    from truepose.reports import verdict_shape

    records = await visit.here.diagnoses.newest(_SHOWN)
    rows = [
        (record, _verdict(record, visit.words), measured_words(record.measured_at, visit.words))
        for record in records
    ]
    return visit.page("results/diagnoses.html", rows=rows, shape=verdict_shape, shown=_SHOWN)


@router.get("/diagnoses/{id}", response_class=HTMLResponse)
async def diagnosis_page(visit: Visited, id: str, whole: Whole = False) -> HTMLResponse:
    """Show a diagnosis as its report."""
    from truepose.reports import diagnosis_content

    here = visit.here
    record = await record_at(id, here.diagnoses.get)
    if record is None:
        return missing(visit)
    campaign = await here.campaigns.get(record.campaign_id)
    report = await _report(here, record, campaign, visit.words)
    actions = await _actions(here, record, campaign)
    trail = await trail_of(visit, WorkKind.DIAGNOSIS, record.id)
    of = f"diagnosis {record.id} {record.recorded_at} {report.campaign} {report.conditions}"
    # Drawing takes a second or two; a session under way must not wait for it.
    content = await drawn_part(visit, of, lambda: asyncio.to_thread(diagnosis_content, report), whole=whole)
    return visit.page(
        "results/diagnosis.html",
        record=record,
        actions=actions,
        content=content,
        trail=trail,
    )


def _verdict(record: DiagnosisRecord, words: Catalogue) -> "VerdictWords":
    from truepose.reports import verdict_words

    return verdict_words(record.diagnosis.verdict, answered=record.model_id is not None, words=words)


def measured_words(said: str | None, words: Catalogue = IN_ENGLISH) -> str:
    """Return when readings were taken, for people; None: nobody said."""
    return words.say("measured.unknown") if said is None else words.say("measured.on", day=moment(said))


async def _actions(here: Context, record: DiagnosisRecord, campaign: CampaignRecord) -> Actions | None:
    """Return what can be asked of the session that the readings come from; None for an uploaded campaign."""
    if record.session_id is None:
        return None
    session = await here.sessions.get(record.session_id)
    asked = (await here.jobs.get(record.job_id)).request
    validation = campaign.session_ids[1] if len(campaign.session_ids) > 1 else None
    proposed = record.diagnosis.next_measurements
    return Actions(
        session=session,
        ended=has_ended(session.state),
        configurations_deg=tuple(joints for entry in proposed for joints in entry.configurations_deg),
        again={"effects": asked.get("effects"), "validation_session_id": validation},
    )


async def _report(
    here: Context, record: DiagnosisRecord, campaign: CampaignRecord, words: Catalogue
) -> "DiagnosisInput":
    from truepose.reports import DiagnosisInput, ReportConditions

    diagnosis = record.diagnosis
    if record.model_id is not None:
        model = (await here.results.model(record.model_id)).model
        diagnosis = dataclasses.replace(diagnosis, model=model)
    conditions = ReportConditions(
        simulated=record.simulated,
        robot_serial_number=record.robot_serial_number,
        written_at=moment(record.recorded_at),
        notes=campaign.summary.notes,
    )
    named = words.between.join((campaign.name, measured_words(record.measured_at, words)))
    return DiagnosisInput(diagnosis, named, conditions, words.tag)
