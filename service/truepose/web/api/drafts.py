"""Drafts: files that somebody imports and says more of, until a campaign is made of them."""

from typing import Annotated, Any, Final, Literal

from fastapi import Query, Response, status
from fastapi import Request as HttpRequest
from pydantic import Field, JsonValue

from truepose.exchange.import_wizard.dialogue import Asked, Kind
from truepose.exchange.results.document import FieldSource, Quantity, Spoken
from truepose.web.context import Here
from truepose.web.resources import CHANGE, LIST, READ, Counted, Id, problems, receiving, resource
from truepose.web.schemas import (
    NUMBER_LIMIT,
    VISIBLE,
    Day,
    RecordedAt,
    RecordId,
    Reply,
    Request,
    example,
)

_MOST_JOINTS = 9
_MOST_POINTS = 99
_MOST_COLUMNS = 500
_MOST_LINES = 200
_LONGEST_LINE = 2**16
_LAST_LINE = 10_000_000
_QUARTER_TURNS = 7.0  # a turn and a bit, in rad
Role = Literal["calibration", "validation", "legs", "validation_legs", "nothing"]
ChangeKind = Literal[
    "radians", "metres", "inches", "radians_and_metres", "left_handed", "nests", "other_way", "coupled",
    "columns", "zero",
]  # fmt: skip
NumberOf = Annotated[str, Field(pattern="^[0-9]{1,8}$")]
Words = Annotated[str, Field(min_length=1, max_length=200, pattern=VISIBLE)]
FileName = Annotated[str, Field(max_length=400)]
LineNumber = Annotated[int, Field(ge=1, le=_LAST_LINE)]


Joint = Annotated[int, Field(ge=1, le=_MOST_JOINTS, description="Number of the joint.")]
LengthUnit = Literal["mm", "m", "cm", "um", "in"]


class AnglesRequest(Request):
    """A column of joint angles."""

    quantity: Literal["joint"]
    number: Joint
    unit: Literal["deg", "rad", "mrad"] = "deg"


class CoordinatesRequest(Request):
    """A column of coordinates of measured points."""

    quantity: Literal["position"]
    number: int = Field(ge=1, le=3, description="Number of the axis: 1 for x, 2 for y, 3 for z.")
    unit: LengthUnit = "mm"
    point: int = Field(
        0,
        ge=0,
        le=_MOST_POINTS,
        description="Number of the point in its row; 0 if the row has only one point.",
    )


class LengthsRequest(Request):
    """A column of lengths, or of uncertainties of points."""

    quantity: Literal["length", "uncertainty", "uncertainty_along", "uncertainty_across"]
    unit: LengthUnit = "mm"


class TorquesRequest(Request):
    """A column of joint torques."""

    quantity: Literal["torque"]
    number: Joint
    unit: Literal["Nm", "Nmm", "kNm"] = "Nm"


class DirectionsRequest(Request):
    """A column of approach directions of a joint."""

    quantity: Literal["direction"]
    number: Joint


class TimesRequest(Request):
    """A column of times."""

    quantity: Literal["time"]
    unit: Literal["s", "ms", "us", "min", "h"] = "s"


class TemperaturesRequest(Request):
    """A column of temperatures."""

    quantity: Literal["temperature"]
    unit: Literal["C", "K", "F"] = "C"


class LabelsRequest(Request):
    """A column of numbers without a unit, of labels, or of unused values."""

    quantity: Literal[
        "nest", "config", "attachment", "group", "repeat_of", "placement", "init", "base_point", "tool_point",
        "qw", "qx", "qy", "qz", "rotation_uncertainty", "nothing",
    ]  # fmt: skip


MeaningRequest = Annotated[
    AnglesRequest
    | CoordinatesRequest
    | LengthsRequest
    | TorquesRequest
    | DirectionsRequest
    | TimesRequest
    | TemperaturesRequest
    | LabelsRequest,
    Field(discriminator="quantity"),
]


# Keys are numbers, and no others: pydantic enforces it and does not say it.
_NO_OTHERS: dict[str, JsonValue] = {"additionalProperties": False}
Columns = Annotated[
    dict[NumberOf, MeaningRequest | None], Field(max_length=_MOST_COLUMNS, json_schema_extra=_NO_OTHERS)
]
Line = Annotated[str, Field(max_length=_LONGEST_LINE, pattern=r"^[^\r\n]*$")]
Lines = Annotated[dict[NumberOf, Line | None], Field(max_length=_MOST_LINES, json_schema_extra=_NO_OTHERS)]


class FileRequest(Request):
    """Settings for a file; omitted keys keep their value, null resets it."""

    role: Role | None = Field(None, examples=["calibration"])
    columns: Columns | None = Field(
        None, description="Meaning of each column, by column number starting at 0."
    )
    lines: Lines | None = Field(None, description="Lines corrected by hand, by line number starting at 1.")
    left_out: list[LineNumber] | None = Field(None, max_length=_MOST_LINES)


class ChangeRequest(Request):
    """A suggested change of convention that is accepted."""

    kind: ChangeKind
    first: int = Field(0, ge=0, le=_MOST_POINTS)
    second: int = Field(0, ge=0, le=_MOST_POINTS)
    amount: float = Field(0.0, ge=-_QUARTER_TURNS, le=_QUARTER_TURNS)


class DraftRequest(Request):
    """Settings for imported files; omitted keys keep their value, null resets it."""

    model_config = example({"measured_on": "2026-03-03", "robot": "abb-irb-120", "u_mm": 0.02})

    files: dict[Annotated[str, Field(max_length=400)], FileRequest | None] | None = Field(
        None, max_length=200
    )
    robot: Words | None = Field(
        None, description="Name of a known robot, or `file` for the robot described in a file."
    )
    changes: list[ChangeRequest] | None = Field(None, max_length=8)
    u_mm: float | None = Field(
        None, ge=1e-6, le=100, description="Standard uncertainty of all readings, per axis."
    )
    measured_on: Day | None = Field(None, description="Date of the readings, in local time.")
    robot_serial_number: Words | None = Field(None, examples=["120-500123"])
    instrument_serial_number: Words | None = Field(None, examples=["391234"])
    measured_zone: Words | None = Field(None, examples=["Europe/Paris"])
    measured_by: Words | None = None
    instrument: Words | None = None
    certificate: Words | None = Field(None, description="Certificate of the instrument.")


class NewDraftRequest(Request):
    """Initial content of a draft."""

    example: bool = Field(
        False, description="True: start with an example, simulated readings of a robot with one error source."
    )


class MakeRequest(Request):
    """Name of the campaign to create."""

    model_config = example({"name": "left arm"})

    name: Words | None = Field(
        None, description="Name of the campaign; by default, the common part of the file names."
    )


class DraftFileReply(Reply):
    """A file of a draft."""

    number: int
    name: str
    size_bytes: int


class DraftReply(Reply):
    """Imported files and their settings."""

    id: RecordId
    created_at: RecordedAt
    changed_at: RecordedAt
    expires_at: RecordedAt
    revision: int = Field(ge=0, description="Revision of files and settings.")
    files: list[DraftFileReply]
    choices: dict[str, Any] = Field(description="Settings, as accepted by `PATCH`.")
    campaign_id: int | None = Field(
        description="Number of the campaign created from the draft; null if there is none yet."
    )
    job_ids: list[int] = Field(description="Jobs of the identification and the diagnosis, in this order.")


class ColumnReply(Reply):
    """A column and its detected meaning."""

    heading: str
    quantity: Annotated[str, FieldSource("meaning.quantity")]
    number: Annotated[int, FieldSource("meaning.number")]
    unit: Annotated[str, FieldSource("meaning.unit")]
    point: Annotated[int, FieldSource("meaning.point")]
    column: Annotated[str, FieldSource("meaning.column")] = Field(
        description="Name in the file format; empty if the column is not used."
    )
    certainty: str = Field(
        description="`certain`, `likely` or `guess` if detected; `said` if chosen by a person."
    )
    reason: Spoken
    shown: list[str]


class SeenFileReply(Reply):
    """A file and its detected content."""

    name: str
    kind: Kind
    role: str
    reason: Spoken
    rows: int
    first_line: int
    columns: list[ColumnReply]


class OfferedReply(Reply):
    """A suggested change of convention that would make the robot fit; to accept it, send it in `changes`."""

    kind: str
    first: int
    second: int
    amount: float
    sentence: Spoken


class SeenRobotReply(Reply):
    """The robot to which the readings are compared."""

    key: str
    name: str
    reason: Spoken
    fits: bool
    typical_mm: Quantity = Field(
        description="Typical error of the nominal robot at the readings; null if not computed."
    )
    offered: list[OfferedReply]


class LineReply(Reply):
    """A line near a fault."""

    number: int
    cells: list[str]
    text: str


class DraftFaultReply(Reply):
    """The first location in the files that cannot be used."""

    file: str
    line: int | None
    column: int | None = Field(description="Column number, starting at 0.")
    sentence: Spoken
    around: list[LineReply]


class QuestionReply(Reply):
    """A question that the files do not answer."""

    about: Asked
    sentence: Spoken


class UnderstoodReply(Reply):
    """Interpretation of the files, before a campaign is created."""

    ready: bool
    readings: int
    files: list[SeenFileReply]
    robot: SeenRobotReply | None
    questions: list[QuestionReply]
    fault: DraftFaultReply | None
    notes: list[Spoken] = Field(description="Assumptions made without asking.")
    u_mm: Quantity = Field(
        description="Standard uncertainty per axis, estimated from repeated positions if not stated; null "
        "if no position was repeated."
    )
    measured_on: str | None = Field(description="Date of the readings, from the settings or the files.")
    robot_serial_number: str = Field(
        description="Serial number of the robot, from the settings or the files; empty if not stated.",
        examples=["120-500123"],
    )
    instrument_serial_number: str = Field(
        description="Serial number of the instrument, from the settings or the files; empty if not stated.",
        examples=["391234"],
    )
    simulated: bool = Field(description="True if the files state that they are simulated.")


router = resource("/drafts", tags=["drafts"])
_RECEIVING_S: Final = 300.0  # 64 MB at 2 Mbit/s
_BODY: Final = {
    "requestBody": {
        "description": "Content of the file; without a body, the file is empty.",
        "required": False,
        "content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}},
    }
}
NameOfFile = Annotated[
    str,
    Query(
        min_length=1,
        max_length=400,
        pattern=VISIBLE,
        description="Name of the file, including its folders.",
        examples=["left arm/points.csv"],
    ),
]
FileNumber = Annotated[int, Query(ge=1, le=NUMBER_LIMIT, description="Number of the file.", examples=[1])]


@router.post("", status_code=status.HTTP_201_CREATED, responses=problems(400, 409, 413, 415, 422, 503))
async def start_draft(here: Here, response: Response, wanted: NewDraftRequest) -> DraftReply:
    """Start an empty draft or one with the example; files are added next.

    A draft expires 14 days after its last change.
    """
    draft = await (here.draft_desk.create_example() if wanted.example else here.draft_desk.create())
    response.headers["Location"] = f"/api/v1/drafts/{draft.id}"
    return DraftReply.of(draft)


@router.get("", responses=LIST)
async def list_drafts(here: Here, paging: Counted) -> list[DraftReply]:
    """List drafts, latest first; there are 20 at most."""
    return paging.of(await here.draft_desk.all(), DraftReply.of)


@router.get("/{id}", responses=READ)
async def get_draft(here: Here, id: Id) -> DraftReply:
    """Return the files of a draft and their settings."""
    return DraftReply.of(await here.draft_desk.get(id))


@router.delete("/{id}", status_code=status.HTTP_204_NO_CONTENT, responses=READ)
async def remove_draft(here: Here, id: Id) -> None:
    """Delete a draft; the campaign created from it is kept."""
    await here.draft_desk.remove(id)


@router.post(
    "/{id}/files",
    status_code=status.HTTP_201_CREATED,
    responses=problems(404, 408, 409, 413, 415, 422, 503),
    openapi_extra=_BODY,
)
async def add_draft_file(here: Here, request: HttpRequest, id: Id, name: NameOfFile) -> DraftReply:
    """Add a file as it is: a table, a file of a folder, a zip, or a robot description.

    A file of the same name is replaced. If the connection ends before the response, nothing is stored.
    """
    async with receiving(_RECEIVING_S, "file", "nothing was stored"):
        return DraftReply.of(await here.draft_desk.receive(id, name, request.stream()))


@router.delete("/{id}/files", responses=READ)
async def remove_draft_file(here: Here, id: Id, number: FileNumber) -> DraftReply:
    """Remove a file from a draft."""
    return DraftReply.of(await here.draft_desk.remove_file(id, number))


@router.patch("/{id}", responses=problems(400, 404, 413, 415, 422, 503))
async def correct_draft(here: Here, id: Id, said: DraftRequest) -> DraftReply:
    """Set the meaning of columns and files, the robot and the date, or correct single lines."""
    return DraftReply.of(await here.draft_desk.say(id, said.model_dump(mode="json", exclude_unset=True)))


@router.get("/{id}/understood", responses=READ)
async def get_understood(here: Here, id: Id) -> UnderstoodReply:
    """Return the interpretation of each file and column, the robot, open questions and the first fault."""
    draft = await here.draft_desk.get(id)
    return UnderstoodReply.of(await here.draft_desk.understood(draft))


@router.post("/{id}/campaign", status_code=status.HTTP_201_CREATED, responses=CHANGE)
async def make_campaign_of_draft(here: Here, response: Response, id: Id, wanted: MakeRequest) -> DraftReply:
    """Create a campaign from a draft and queue its identification and diagnosis.

    A repeated request returns the same campaign. Refused (409) while a question is open or something cannot
    be read.
    """
    draft = await here.draft_desk.make(id, wanted.name)
    response.headers["Location"] = f"/api/v1/campaigns/{draft.campaign_id}"
    return DraftReply.of(draft)
