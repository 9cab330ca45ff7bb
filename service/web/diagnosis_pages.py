"""Diagnoses for people: a list, and each as its report, at the size of a tablet."""

import asyncio
import dataclasses
from http import HTTPStatus
from typing import Final

from fastapi import APIRouter
from fastapi.responses import HTMLResponse

from service.reports import (
    DiagnosisInput,
    ReportConditions,
    VerdictWords,
    diagnosis_content,
    page_styles,
    verdict_shape,
    verdict_words,
)
from service.storage.errors import NotFoundError
from service.storage.records import DiagnosisRecord
from service.web.context import Context, Here
from service.web.rendering import page

router = APIRouter(include_in_schema=False)
_SHOWN: Final = 50


@router.get("/diagnoses", response_class=HTMLResponse)
async def diagnoses_page(here: Here) -> HTMLResponse:
    """List the latest diagnoses with their first lines."""
    records = await here.diagnoses.newest(_SHOWN)
    rows = [(record, _verdict(record)) for record in records]
    return page(
        "diagnoses.html", here=here, rows=rows, shape=verdict_shape, shown=_SHOWN, styles=page_styles()
    )


@router.get("/diagnoses/{id}", response_class=HTMLResponse)
async def diagnosis_page(here: Here, id: str) -> HTMLResponse:
    """Show a diagnosis as its report."""
    record = await _record(here, id)
    if record is None:
        return page("no_diagnosis.html", HTTPStatus.NOT_FOUND, here=here, styles=page_styles())
    report = await _report(here, record)
    # Drawing takes a second or two; a session under way must not wait for it.
    content = await asyncio.to_thread(diagnosis_content, report)
    return page(
        "diagnosis.html", here=here, record=record, report=report, content=content, styles=page_styles()
    )


def _verdict(record: DiagnosisRecord) -> VerdictWords:
    return verdict_words(record.diagnosis.verdict, answered=record.model_id is not None)


async def _record(here: Context, id: str) -> DiagnosisRecord | None:
    """Return the diagnosis of that number; None where an address names none."""
    if not (id.isascii() and id.isdecimal()) or len(id) > len(str(2**31)):
        return None
    try:
        return await here.diagnoses.get(int(id))
    except NotFoundError:
        return None


async def _report(here: Context, record: DiagnosisRecord) -> DiagnosisInput:
    campaign = await here.campaigns.get(record.campaign_id)
    diagnosis = record.diagnosis
    if record.model_id is not None:
        model = (await here.results.model(record.model_id)).model
        diagnosis = dataclasses.replace(diagnosis, model=model)
    conditions = ReportConditions(
        robot_serial_number=record.robot_serial_number,
        written_at=record.recorded_at,
        notes=campaign.summary.notes,
    )
    return DiagnosisInput(diagnosis, f"{campaign.name}, measured {record.measured_at}", conditions)
