"""The readings of a result as charts that answer: which are off, over what, and where."""

from typing import Final, TypeAlias

from fastapi import APIRouter
from fastapi.responses import HTMLResponse

from truepose.storage.records import DiagnosisRecord, IdentificationRecord, ValidationRecord
from truepose.storage.results.items import WorkKind
from truepose.web.pages.records import address_of, record_at, title_of
from truepose.web.pages.rendering import MissingPageError, Visit, Visited

_Judged: TypeAlias = IdentificationRecord | ValidationRecord | DiagnosisRecord
router = APIRouter(include_in_schema=False)
_VARIABLES: Final = (
    "readings.joint", "readings.torque", "readings.reach", "readings.x", "readings.y", "readings.z",
    "readings.number", "readings.time", "readings.temperature", "readings.attachment",
)  # fmt: skip
# What scripts fill into a sentence about a reading, and into one about a class of a histogram.
_OF_READING: Final = ("config", "nest", "after", "before", "expected", "variable", "value")
_OF_CLASS: Final = ("from", "to", "before", "after")


@router.get("/identifications/{id}/readings", response_class=HTMLResponse)
async def identification_readings(visit: Visited, id: str) -> HTMLResponse:
    """Show the readings of an identification."""
    record = await record_at(id, visit.here.results.identification)
    return _page(visit, WorkKind.IDENTIFICATION, record)


@router.get("/validations/{id}/readings", response_class=HTMLResponse)
async def validation_readings(visit: Visited, id: str) -> HTMLResponse:
    """Show the readings of a validation."""
    return _page(visit, WorkKind.VALIDATION, await record_at(id, visit.here.results.validation))


@router.get("/diagnoses/{id}/readings", response_class=HTMLResponse)
async def diagnosis_readings(visit: Visited, id: str) -> HTMLResponse:
    """Show the readings of a diagnosis."""
    return _page(visit, WorkKind.DIAGNOSIS, await record_at(id, visit.here.diagnoses.get))


def _page(visit: Visit, kind: WorkKind, record: _Judged) -> HTMLResponse:
    if record.model_id is None:
        raise MissingPageError
    say = visit.words.say
    return visit.page(
        "results/readings.html",
        record=record,
        result=address_of(kind, record.id),
        title=title_of(kind, record.id, visit.words),
        variables={key.removeprefix("readings."): say(key, number="<number>") for key in _VARIABLES},
        of_reading=say("readings.reading", **{name: f"<{name}>" for name in _OF_READING}),
        of_class=say("readings.class", **{name: f"<{name}>" for name in _OF_CLASS}),
    )
