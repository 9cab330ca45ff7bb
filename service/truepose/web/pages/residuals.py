"""The readings of a result as charts that answer: which are off, over what, and where."""

from dataclasses import asdict, dataclass
from typing import Annotated, Any, Final, TypeAlias

from fastapi import APIRouter, Query
from fastapi.responses import HTMLResponse

from truepose.domain.campaign import ReadingsSetAside
from truepose.sessions.engine.states import has_ended
from truepose.storage.records import CampaignRecord, DiagnosisRecord, IdentificationRecord, ValidationRecord
from truepose.storage.results.items import WorkKind
from truepose.web.api.repeat_session import template_of
from truepose.web.context import Context
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


IdentifiedFrom = Annotated[bool, Query(include_in_schema=False)]


@dataclass(frozen=True, slots=True)
class ReadingActions:
    """What can be done with readings that are selected among those of a result.

    Attributes
    ----------
    judging : bool
        Whether they judge the model: none of them is set aside.
    others : str
        Address of those of the other role; empty: there are none.
    ask : dict or None
        The request that a reason and readings to set aside are added to; None of what cannot be made again.
    session_id : int or None
        Where they can be measured again; None: nowhere.
    is_open : bool
        Whether that session takes configurations still; else it is planned again.
    """

    judging: bool
    others: str
    ask: dict[str, Any] | None
    session_id: int | None
    is_open: bool


@router.get("/identifications/{id}/readings", response_class=HTMLResponse)
async def identification_readings(
    visit: Visited, id: str, identified_from: IdentifiedFrom = False
) -> HTMLResponse:
    """Show the readings of an identification."""
    record = await record_at(id, visit.here.results.identification)
    return await _page(visit, WorkKind.IDENTIFICATION, record, identified_from=identified_from)


@router.get("/validations/{id}/readings", response_class=HTMLResponse)
async def validation_readings(visit: Visited, id: str) -> HTMLResponse:
    """Show the readings of a validation."""
    record = await record_at(id, visit.here.results.validation)
    return await _page(visit, WorkKind.VALIDATION, record, identified_from=False)


@router.get("/diagnoses/{id}/readings", response_class=HTMLResponse)
async def diagnosis_readings(
    visit: Visited, id: str, identified_from: IdentifiedFrom = False
) -> HTMLResponse:
    """Show the readings of a diagnosis."""
    record = await record_at(id, visit.here.diagnoses.get)
    return await _page(visit, WorkKind.DIAGNOSIS, record, identified_from=identified_from)


async def _page(visit: Visit, kind: WorkKind, record: _Judged, *, identified_from: bool) -> HTMLResponse:
    if record.model_id is None:
        raise MissingPageError
    say, aside = visit.words.say, _set_aside(record)
    return visit.page(
        "results/readings.html",
        record=record,
        result=address_of(kind, record.id),
        title=title_of(kind, record.id, visit.words),
        query="?identified_from=true" if identified_from else "",
        aside=aside,
        earlier=[] if aside is None else [asdict(one) for one in aside.readings],
        actions=await _actions(visit.here, kind, record, identified_from=identified_from),
        variables={key.removeprefix("readings."): say(key, number="<number>") for key in _VARIABLES},
        of_reading=say("readings.reading", **{name: f"<{name}>" for name in _OF_READING}),
        of_class=say("readings.class", **{name: f"<{name}>" for name in _OF_CLASS}),
    )


def _set_aside(record: _Judged) -> ReadingsSetAside | None:
    if isinstance(record, IdentificationRecord):
        return record.identification.set_aside
    return record.diagnosis.set_aside if isinstance(record, DiagnosisRecord) else None


async def _actions(
    here: Context, kind: WorkKind, record: _Judged, *, identified_from: bool
) -> ReadingActions:
    campaign = await here.campaigns.get(record.campaign_id)
    held = campaign.summary
    others = held.validation_points + held.validation_legs + held.validation_contacts > 0
    made_from = kind is not WorkKind.VALIDATION
    judging = not made_from or (others and not identified_from)
    session_id = await _session(here, campaign, judging=judging)
    return ReadingActions(
        judging=judging,
        others=f"?identified_from={str(judging).lower()}" if made_from and others else "",
        ask=await _ask(here, kind, record) if made_from and not judging else None,
        session_id=session_id,
        is_open=session_id is not None and await _is_open(here, session_id),
    )


async def _ask(here: Context, kind: WorkKind, record: _Judged) -> dict[str, Any]:
    """Return the request that made a result, without what it was to set aside."""
    asked = (await here.jobs.get(record.job_id)).request
    body = {name: asked[name] for name in ("effects", "measured_on") if asked.get(name)}
    path = f"/api/v1{address_of(kind, record.id).rpartition('/')[0]}"
    return {"path": path, "body": {"campaign_id": record.campaign_id, **body}}


async def _session(here: Context, campaign: CampaignRecord, *, judging: bool) -> int | None:
    """Return the session that measured readings of a campaign, where some of its stops may be repeated."""
    # The first session calibrates; a second one only judges its model.
    measured_in = campaign.session_ids[judging : judging + 1]
    for session_id in measured_in:
        if (await template_of(here, session_id)).can_be_repeated_in_part:
            return session_id
    return None


async def _is_open(here: Context, session_id: int) -> bool:
    """Whether configurations can be added to a session: of those without a tracker or camera to none."""
    session = await here.sessions.get(session_id)
    return session.role in here.tracker_sessions.roles and not has_ended(session.state)
