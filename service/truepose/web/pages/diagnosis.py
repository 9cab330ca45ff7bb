"""Diagnoses: a list, the page of each, and its report.

The reports are imported where a page is made: their drawing library takes most of a second, and the service
must not wait for it when it starts.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

from fastapi import APIRouter
from fastapi.responses import HTMLResponse

from truepose.domain.campaign import ReadingsSetAside
from truepose.messages.catalogue import IN_ENGLISH, Catalogue
from truepose.messages.message import together
from truepose.sessions.engine.states import has_ended
from truepose.storage.records import DiagnosisRecord, SessionRecord
from truepose.storage.results.items import WorkKind
from truepose.validation.outcome import outcome_of
from truepose.web.context import Context
from truepose.web.pages.conditions import conditions_of_result
from truepose.web.pages.records import record_at, trail_of
from truepose.web.pages.rendering import Visited, Whole, moment
from truepose.web.pages.report_kinds import LISTED, Drawable, ReportKind, ReportRow, report_page
from truepose.web.pages.session_results import Choice

if TYPE_CHECKING:
    from truepose.reports.cause_words import VerdictWords
    from truepose.reports.traceability import ReportConditions


router = APIRouter(include_in_schema=False)
_SHOWN: Final = 50


@dataclass(frozen=True, slots=True)
class Actions:
    """What a person can ask for below a diagnosis of a session."""

    session: SessionRecord
    ended: bool
    configurations_deg: tuple[tuple[float, ...], ...]  # of all proposals
    again: dict[str, object]  # body of the request that repeats this diagnosis on the readings by now
    set_aside: ReadingsSetAside | None  # which that diagnosis leaves out as well

    @property
    def whole(self) -> dict[str, object]:
        """Body of the request that leaves nothing out."""
        return {**self.again, "keep_set_aside": False}

    @property
    def measures(self) -> bool:
        """Whether what the diagnosis proposes can be measured in its session."""
        return bool(self.configurations_deg) and not self.ended


@router.get("/diagnoses", response_class=HTMLResponse)
async def diagnoses_page(visit: Visited) -> HTMLResponse:
    """List the latest diagnoses with their first lines."""
    from truepose.reports.pages import verdict_shape

    records = await visit.here.diagnoses.newest(_SHOWN)
    rows = [
        (record, _verdict(record, visit.words), measured_words(record.measured_at, visit.words))
        for record in records
    ]
    return visit.page("results/diagnoses.html", rows=rows, shape=verdict_shape, shown=_SHOWN)


@router.get("/diagnoses/{id}", response_class=HTMLResponse)
async def diagnosis_page(visit: Visited, id: str, whole: Whole = False) -> HTMLResponse:
    """Show a diagnosis as its report."""
    here = visit.here
    record = await record_at(id, here.diagnoses.get)
    return visit.page(
        "results/diagnosis.html",
        record=record,
        outcome=outcome_of(record.diagnosis),
        actions=await _actions(here, record),
        content=await report_page(visit, DIAGNOSIS, record.id, whole=whole, cover=False),
        trail=await trail_of(visit, WorkKind.DIAGNOSIS, record.id),
    )


def _verdict(record: DiagnosisRecord, words: Catalogue) -> "VerdictWords":
    from truepose.reports.cause_words import verdict_words

    return verdict_words(record.diagnosis.verdict, answered=record.model_id is not None, words=words)


def measured_words(said: str | None, words: Catalogue = IN_ENGLISH) -> str:
    """Return when readings were taken, for people; None: nobody said."""
    return words.say("measured.unknown") if said is None else words.say("measured.on", day=moment(said))


async def _actions(here: Context, record: DiagnosisRecord) -> Actions | None:
    """Return what can be asked of the session that the readings come from; None for an uploaded campaign."""
    if record.session_id is None:
        return None
    session = await here.sessions.get(record.session_id)
    asked, campaign = (
        (await here.jobs.get(record.job_id)).request,
        await here.campaigns.get(record.campaign_id),
    )
    validation = campaign.session_ids[1] if len(campaign.session_ids) > 1 else None
    proposed = record.diagnosis.next_measurements
    return Actions(
        session=session,
        ended=has_ended(session.state),
        configurations_deg=tuple(joints for entry in proposed for joints in entry.configurations_deg),
        again={"effects": asked.get("effects"), "validation_session_id": validation},
        set_aside=await here.set_aside.of_session(session.id),
    )


async def _rows(here: Context, month: str) -> list[ReportRow]:
    return [_row(one) for one in await here.diagnoses.newest_of(LISTED, month)]


def _row(record: DiagnosisRecord) -> ReportRow:
    found = record.diagnosis
    sentence = together(outcome_of(found), found.message)
    return DIAGNOSIS.row(record, found.robot, sentence, record.robot_serial_number)


async def _drawable(here: Context, number: int, choice: Choice, words: Catalogue) -> Drawable:
    from truepose.reports.diagnosis.report import DiagnosisReport

    record = await here.diagnoses.get(number)
    diagnosis = record.diagnosis
    if record.model_id is not None:
        diagnosis = replace(diagnosis, model=(await here.results.model(record.model_id)).model)
    campaign = await here.campaigns.get(record.campaign_id)
    named = words.between.join((campaign.name, measured_words(record.measured_at, words)))
    return Drawable(
        record.id,
        lambda spoken: _conditions(here, record, spoken),
        lambda whole: DiagnosisReport(diagnosis, named, conditions=whole, language=words.tag),
    )


async def _conditions(here: Context, record: DiagnosisRecord, words: Catalogue) -> "ReportConditions":
    stated = await conditions_of_result(here, record.campaign_id, record.recorded_at, words)
    serial = stated.robot_serial_number or record.robot_serial_number
    return replace(
        stated,
        simulated=record.simulated,
        robot_serial_number=serial,
        measured_at=record.measured_at or "",
    )


DIAGNOSIS = ReportKind("diagnosis", "reports.diagnosis", _rows, _drawable)
