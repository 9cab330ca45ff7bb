"""A robot for people, over the months: the page of a service visit."""

import asyncio
from collections.abc import Sequence
from dataclasses import dataclass
from http import HTTPStatus
from typing import TYPE_CHECKING, Annotated, Any, Final

import numpy as np
from fastapi import APIRouter, Query
from fastapi.responses import HTMLResponse
from markupsafe import Markup

from truepose.analysis.comparison import compare_over_time, dated_diagnoses
from truepose.analysis.job_queue.tasks import judging_or_own, stored_campaign
from truepose.diagnosis.alarms import alarms
from truepose.diagnosis.history import CauseOverTime
from truepose.domain.errors import TrueposeError, text_of
from truepose.domain.identification import Model
from truepose.storage.records import DiagnosisRecord
from truepose.web.context import Context
from truepose.web.pages.rendering import Visit, Visited, Whole, render, render_part
from truepose.web.schemas import NUMBER_LIMIT

if TYPE_CHECKING:
    from truepose.reports.history import Measurement
    from truepose.validation.model_comparison import ModelComparison

router = APIRouter(prefix="/robots", include_in_schema=False)
_MOST: Final = 60  # measurements on one page, the latest
Serial = Annotated[str | None, Query(max_length=200)]
Chosen = Annotated[int | None, Query(ge=1, le=NUMBER_LIMIT)]


@dataclass(frozen=True, slots=True)
class Pair:
    """Two measurements that the reader compares."""

    earlier: DiagnosisRecord
    later: DiagnosisRecord


@router.get("/{name:path}", response_class=HTMLResponse)
async def robot_page(
    visit: Visited,
    name: str,
    serial_number: Serial = None,
    earlier: Chosen = None,
    later: Chosen = None,
    whole: Whole = False,
) -> HTMLResponse:
    """Show what changed on a robot: causes, errors, temperatures, and two results side by side."""
    records = await visit.here.diagnoses.of_robot(name, serial_number)
    serials = sorted({record.robot_serial_number for record in records} - {""})
    shown: dict[str, Any] = {
        "robot": name,
        "serial": serial_number or "".join(serials[:1]),
        "serials": serials,
    }
    if not records:
        return visit.page("robots/no_robot.html", HTTPStatus.NOT_FOUND, **shown)
    if len(serials) > 1:
        return visit.page("robots/which_robot.html", **shown)
    counting, causes = compare_over_time(name, records[-_MOST:])
    pair = _pair(counting, earlier, later)
    of = f"robot {name} {_moments(counting)} {pair and _moments((pair.earlier, pair.later))}"
    told = await render_part(visit, of, lambda: _told(visit, counting, causes, pair), whole=whole)
    choices = [record for record in counting if record.model_id is not None]
    return visit.page("robots/robot.html", **shown, told=told, choices=choices, pair=pair)


def _pair(records: Sequence[DiagnosisRecord], earlier: int | None, later: int | None) -> Pair | None:
    """Return the chosen measurements, else the first and the last that have a model; None of fewer."""
    known = {record.id: record for record in records if record.model_id is not None}
    if len(known) < 2:
        return None
    ends = list(known.values())
    return Pair(known.get(earlier or 0, ends[0]), known.get(later or 0, ends[-1]))


def _moments(records: Sequence[DiagnosisRecord]) -> list[tuple[int, str]]:
    return [(record.id, record.recorded_at) for record in records]


async def _told(
    visit: Visit, records: Sequence[DiagnosisRecord], causes: tuple[CauseOverTime, ...], pair: Pair | None
) -> str:
    content, why = await _content(visit, records, causes, pair)
    return render("robots/robot_told.html", content=content, why=why, words=visit.words, say=visit.words.say)


async def _content(
    visit: Visit, records: Sequence[DiagnosisRecord], causes: tuple[CauseOverTime, ...], pair: Pair | None
) -> tuple[Markup, str]:
    """Return the content, and why two results cannot be compared where they cannot."""
    from truepose.reports.history import HistoryReport

    measurements = tuple([await _measurement(visit.here, record) for record in records])
    two, why = None, ""
    try:
        two = None if pair is None else await _two(visit.here, pair)
    except TrueposeError as error:
        why = visit.words.spoken(text_of(error))
    found = alarms(causes, dated_diagnoses(records))
    report = HistoryReport(
        records[0].diagnosis.robot, measurements, causes, found, two, language=visit.words.tag
    )
    return await asyncio.to_thread(report.content), why


async def _measurement(here: Context, record: DiagnosisRecord) -> "Measurement":
    from truepose.reports.history import Measurement

    content = await here.campaigns.content(record.campaign_id)
    found = record.diagnosis
    celsius = await asyncio.to_thread(_temperatures, content)
    return Measurement(record.id, record.measured_at, found.before, found.after, celsius)


def _temperatures(content: bytes) -> tuple[float, float] | None:
    readings = stored_campaign(content).readings
    taken = None if readings is None else readings.stops.temperature_c
    known = [] if taken is None else taken[np.isfinite(taken)].tolist()
    return (min(known), max(known)) if known else None


async def _two(here: Context, pair: Pair) -> "ModelComparison":
    earlier, later = [
        (await here.results.model(record.model_id or 0)).model for record in (pair.earlier, pair.later)
    ]
    content = await here.campaigns.content(pair.later.campaign_id)
    return await asyncio.to_thread(_compared, earlier, later, content)


def _compared(earlier: Model, later: Model, content: bytes) -> "ModelComparison":
    from truepose.validation.model_comparison import compare_models

    return compare_models(earlier, later, judging_or_own(stored_campaign(content)))
