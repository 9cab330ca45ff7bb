"""Campaigns, each the folder of one measured robot as a zip: upload, make from sessions, download."""

import asyncio
import json
from dataclasses import dataclass
from pathlib import PurePath
from typing import Annotated, Any, Final, TypeAlias, TypeVar

from fastapi import Query, Response, status
from fastapi import Request as HttpRequest
from fastapi.exceptions import RequestValidationError
from pydantic import Field, TypeAdapter, ValidationError
from starlette.datastructures import FormData, UploadFile

from truepose.analysis.campaigns.records import NOTHING, UploadDetails
from truepose.storage.records import CampaignRecord
from truepose.web.context import Context, Here
from truepose.web.middleware.limits import sent_type
from truepose.web.resources import (
    CHANGE,
    LIST,
    READ,
    Id,
    IdempotencyKey,
    OptionalKey,
    Paged,
    problems,
    receiving,
    request_key,
    resource,
    sending,
    while_present,
)
from truepose.web.schemas import (
    VISIBLE,
    Day,
    Number,
    RecordedAt,
    RecordId,
    Reply,
    Request,
    Simulated,
    example,
)


class CampaignRequest(Request):
    """Campaign to create from a calibration session."""

    model_config = example({"name": "left arm", "validation_session_id": 2})

    name: str = Field(min_length=1, max_length=200, pattern=VISIBLE, examples=["left arm"])
    validation_session_id: Number | None = Field(
        None, description="Validation session; its readings are never used for identification.", examples=[2]
    )


class SessionsRequest(Request):
    """Sessions from which to create a campaign."""

    model_config = example({"name": "left arm", "session_ids": [3, 2]})

    name: str = Field("campaign", min_length=1, max_length=200, pattern=VISIBLE, examples=["left arm"])
    session_ids: list[Number] = Field(
        min_length=1,
        max_length=2,
        description="Calibration session, then the validation session if there is one.",
    )


class CampaignReply(Reply):
    """A stored campaign."""

    id: RecordId
    recorded_at: RecordedAt
    name: str = Field(examples=["left arm"])
    robot: str = Field(
        description="Name of the robot in the campaign; the campaign contains its nominal model."
    )
    session_ids: list[int] = Field(description="Sessions of the campaign; empty for an upload.")
    simulated: Simulated
    measured_on: str | None = Field(
        description="Date of the readings, from the upload or its description; null if not stated.",
        examples=["2026-03-03"],
    )
    robot_serial_number: str | None = Field(
        description="Serial number of the robot, from the upload or its description; null if not stated. "
        "For a campaign from sessions, see the sessions.",
        examples=["120-500123"],
    )
    instrument_serial_number: str | None = Field(
        description="Serial number of the instrument used for all readings, from the same source as the "
        "serial number of the robot.",
        examples=["391234"],
    )
    calibration_points: int = Field(examples=[55])
    validation_points: int = Field(examples=[1000])
    calibration_legs: int
    validation_legs: int
    calibration_contacts: int = Field(description="Number of readings of closed loops.")
    validation_contacts: int
    reference_readings: int = Field(description="Number of reference measurements of the fixed nests.")
    ignored: list[str] = Field(
        description="Columns and keys that were stored but not recognised, one sentence each."
    )
    notes: list[str]
    archive_url: str = Field(examples=["/api/v1/campaigns/3/archive"])


def campaign_reply(record: CampaignRecord) -> CampaignReply:
    """Return a campaign as it travels."""
    archive_url = f"/api/v1/campaigns/{record.id}/archive"
    return CampaignReply.of(record, record.summary, archive_url=archive_url, simulated=record.simulated)


T = TypeVar("T")
router = resource(tags=["campaigns"])
_DAY_READER: Final[TypeAdapter[Day]] = TypeAdapter(Day)
_RECEIVING_S = 60.0  # 16 MB at 2 Mbit/s
_BINARY = {"type": "string", "format": "binary", "description": "Zip of the campaign folder."}
_DAY = {"type": "string", "format": "date", "description": "Date of the readings."}
_SERIAL = {"type": "string", "maxLength": 200, "description": "Serial number."}
_SERIALS: Final = ("robot_serial_number", "instrument_serial_number")
_SAID = {"file": _BINARY, "measured_on": _DAY, **dict.fromkeys(_SERIALS, _SERIAL)}
_FORM = {"type": "object", "required": ["file"], "properties": _SAID}
_BODY: dict[str, Any] = {
    "requestBody": {
        "required": True,
        "content": {
            "application/zip": {"schema": _BINARY},
            "multipart/form-data": {"schema": _FORM},
            "application/json": {"schema": SessionsRequest.model_json_schema()},
        },
    }
}
_ZIP = {"application/zip": {"schema": {"type": "string", "format": "binary"}}}
CampaignName = Annotated[
    str | None,
    Query(
        min_length=1,
        max_length=200,
        pattern=VISIBLE,
        description="Name of the campaign; by default, the file name.",
        examples=["left"],
    ),
]
MeasuredOn = Annotated[
    Day | None,
    Query(
        description="Date of the readings; by default, as stated in the form or in the campaign description.",
        examples=["2026-03-03"],
    ),
]

SerialNumber: TypeAlias = Annotated[str, Field(min_length=1, max_length=200, pattern=VISIBLE)]
_SERIAL_READER: Final[TypeAdapter[str]] = TypeAdapter(SerialNumber)
RobotSerial = Annotated[
    SerialNumber | None,
    Query(
        description="Serial number of the robot; by default, as stated in the form or description.",
        examples=["120-500123"],
    ),
]
InstrumentSerial = Annotated[
    SerialNumber | None,
    Query(
        description="Serial number of the instrument used for all readings; by default, as stated in the "
        "form or description.",
        examples=["391234"],
    ),
]


@dataclass(frozen=True, slots=True)
class _Upload:
    """What somebody sent; the file of a form has a name."""

    archive: bytes
    file_name: str
    stated: UploadDetails = NOTHING


@router.post(
    "/campaigns",
    status_code=status.HTTP_201_CREATED,
    responses=problems(400, 404, 408, 409, 413, 415, 422, 503),
    openapi_extra=_BODY,
)
async def upload_campaign(
    here: Here,
    request: HttpRequest,
    response: Response,
    name: CampaignName = None,
    measured_on: MeasuredOn = None,
    robot_serial_number: RobotSerial = None,
    instrument_serial_number: InstrumentSerial = None,
    key: IdempotencyKey = None,
) -> CampaignReply:
    """Store a campaign: a zipped folder, as body or as a file of a form, or sessions to create it from.

    An uploaded folder contains its own robot model. One upload is read at a time and a few wait; if too many
    are waiting (503) or the connection ends before the response, nothing is stored. Of two sessions, the
    first is used for identification and the second for validation.
    """
    if sent_type(request) == "application/json":
        number = await _of_sessions(here, request, key)
        response.headers["Location"] = f"/api/v1/campaigns/{number}"
        return campaign_reply(await here.campaigns.get(number))
    stated = UploadDetails(measured_on, robot_serial_number, instrument_serial_number)
    async with here.campaign_desk.uploads.turn():
        number = await _stored(here, request, name, stated, key)
    response.headers["Location"] = f"/api/v1/campaigns/{number}"
    return campaign_reply(await here.campaigns.get(number))


@router.post("/sessions/{id}/campaign", status_code=status.HTTP_201_CREATED, responses=CHANGE)
async def make_campaign(
    here: Here, id: Id, wanted: CampaignRequest, response: Response, key: OptionalKey
) -> CampaignReply:
    """Create a campaign from a calibration session and, if given, its validation session."""
    number = await here.campaign_desk.from_sessions(wanted.name, id, wanted.validation_session_id, key)
    response.headers["Location"] = f"/api/v1/campaigns/{number}"
    return campaign_reply(await here.campaigns.get(number))


@router.get("/campaigns", responses=LIST)
async def list_campaigns(here: Here, paging: Paged) -> list[CampaignReply]:
    """List campaigns, oldest first."""
    return paging.shown(await here.campaigns.page(paging.page), campaign_reply)


@router.get("/campaigns/{id}", responses=READ)
async def get_campaign(here: Here, id: Id) -> CampaignReply:
    """Return a stored campaign."""
    return campaign_reply(await here.campaigns.get(id))


@router.get(
    "/campaigns/{id}/archive",
    response_class=Response,
    responses=sending("Zip of the campaign folder.", _ZIP) | READ,
)
async def download_campaign(here: Here, id: Id) -> Response:
    """Download the zipped campaign folder; an upload is returned byte for byte."""
    archive = await here.campaign_desk.archive(id)
    saved_as = {"Content-Disposition": f'attachment; filename="campaign-{id}.zip"'}
    return Response(archive, media_type="application/zip", headers=saved_as)


async def _stored(
    here: Context, request: HttpRequest, name: str | None, stated: UploadDetails, key: str | None
) -> int:
    """Receive an archive and store it, unless the client goes away meanwhile."""
    async with receiving(_RECEIVING_S, "archive", "nothing was stored"):
        sent = await _received(request)
    stored_as = name or PurePath(sent.file_name).stem or "campaign"
    told = stated.before(sent.stated)
    said = sent.archive + "".join(told.said.values()).encode()
    by_key = None if key is None else await asyncio.to_thread(request_key, request, key, said)
    # Whoever goes away ends the reading: the next upload waits for this one (decision 0023).
    return await while_present(request, here.campaign_desk.upload(sent.archive, stored_as, told, by_key))


async def _of_sessions(here: Context, request: HttpRequest, key: str | None) -> int:
    """Make a campaign of the sessions that the body names; raises RequestValidationError."""
    body = await request.body()
    try:
        wanted = SessionsRequest.model_validate(json.loads(body))
    except ValidationError as error:
        faults = [fault | {"loc": ("body", *fault["loc"])} for fault in error.errors()]
        raise RequestValidationError(faults) from error
    except (ValueError, RecursionError) as error:  # of text that is no JSON, no text, or without a bottom
        raise RequestValidationError([_no_json(error)]) from error
    by_key = None if key is None else request_key(request, key, body)
    first, *others = wanted.session_ids
    return await here.campaign_desk.from_sessions(wanted.name, first, others[0] if others else None, by_key)


def _no_json(error: ValueError | RecursionError) -> dict[str, Any]:
    """Return the fault as the framework states it for a body of its own."""
    where = error.pos if isinstance(error, json.JSONDecodeError) else 0
    return {"type": "json_invalid", "loc": ("body", where), "msg": "", "ctx": {"error": str(error)}}


async def _received(request: HttpRequest) -> _Upload:
    """Return what was sent; raises RequestValidationError where there is no archive."""
    if sent_type(request) != "multipart/form-data":
        upload = _Upload(await request.body(), "")
    else:
        upload = await _in_form(request)
    if not upload.archive:
        fault = {
            "loc": ("body", "file"),
            "msg": "the zip of a campaign folder is required",
            "type": "missing",
        }
        raise RequestValidationError([fault])
    return upload


async def _in_form(request: HttpRequest) -> _Upload:
    async with request.form() as form:
        sent = form.get("file")
        if not isinstance(sent, UploadFile):
            return _Upload(b"", "")
        day = _in_field(form, "measured_on", _DAY_READER)
        serials = (_in_field(form, name, _SERIAL_READER) for name in _SERIALS)
        return _Upload(await sent.read(), sent.filename or "", UploadDetails(day, *serials))


def _in_field(form: FormData, name: str, reader: TypeAdapter[T]) -> T | None:
    """Return what a form states; a field left empty states nothing. Raises RequestValidationError."""
    said = form.get(name)
    if said is None or said == "":
        return None
    try:
        return reader.validate_python(said)
    except ValidationError as error:
        faults = [{**fault, "loc": ("body", name)} for fault in error.errors()]
        raise RequestValidationError(faults) from error
