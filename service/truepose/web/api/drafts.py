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
    """A column of angles of a joint."""

    quantity: Literal["joint"]
    number: Joint
    unit: Literal["deg", "rad", "mrad"] = "deg"


class CoordinatesRequest(Request):
    """A column of a coordinate of measured points."""

    quantity: Literal["position"]
    number: int = Field(ge=1, le=3, description="Of the axis: x, y, z.")
    unit: LengthUnit = "mm"
    point: int = Field(0, ge=0, le=_MOST_POINTS, description="Which point of its row; 0: there is one.")


class LengthsRequest(Request):
    """A column of lengths, or of how uncertain points are."""

    quantity: Literal["length", "uncertainty", "uncertainty_along", "uncertainty_across"]
    unit: LengthUnit = "mm"


class TorquesRequest(Request):
    """A column of torques of a joint."""

    quantity: Literal["torque"]
    number: Joint
    unit: Literal["Nm", "Nmm", "kNm"] = "Nm"


class DirectionsRequest(Request):
    """A column that says from which side a joint came."""

    quantity: Literal["direction"]
    number: Joint


class TimesRequest(Request):
    """A column of moments."""

    quantity: Literal["time"]
    unit: Literal["s", "ms", "us", "min", "h"] = "s"


class TemperaturesRequest(Request):
    """A column of temperatures."""

    quantity: Literal["temperature"]
    unit: Literal["C", "K", "F"] = "C"


class LabelsRequest(Request):
    """A column of numbers without a unit, of labels, or of nothing that is used."""

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
    """What is said of a file; what is not named stays as it was, null takes it back."""

    role: Role | None = Field(None, examples=["calibration"])
    columns: Columns | None = Field(None, description="By the number of the column, from 0.")
    lines: Lines | None = Field(None, description="Corrected by hand, by their number from 1.")
    left_out: list[LineNumber] | None = Field(None, max_length=_MOST_LINES)


class ChangeRequest(Request):
    """A change of convention that was offered, and is accepted."""

    kind: ChangeKind
    first: int = Field(0, ge=0, le=_MOST_POINTS)
    second: int = Field(0, ge=0, le=_MOST_POINTS)
    amount: float = Field(0.0, ge=-_QUARTER_TURNS, le=_QUARTER_TURNS)


class DraftRequest(Request):
    """What is said of files that were brought; what is not named stays as it was, null takes it back."""

    model_config = example({"measured_on": "2026-03-03", "robot": "abb-irb-120", "u_mm": 0.02})

    files: dict[Annotated[str, Field(max_length=400)], FileRequest | None] | None = Field(
        None, max_length=200
    )
    robot: Words | None = Field(None, description="A known one, or `file`: the one that a file describes.")
    changes: list[ChangeRequest] | None = Field(None, max_length=8)
    u_mm: float | None = Field(
        None, ge=1e-6, le=100, description="Standard uncertainty per axis of all readings."
    )
    measured_on: Day | None = Field(None, description="Day of the readings, where they were taken.")
    robot_serial_number: Words | None = Field(None, examples=["120-500123"])
    instrument_serial_number: Words | None = Field(None, examples=["391234"])
    measured_zone: Words | None = Field(None, examples=["Europe/Paris"])
    measured_by: Words | None = None
    instrument: Words | None = None
    certificate: Words | None = Field(None, description="Of the instrument.")


class NewDraftRequest(Request):
    """How a draft begins."""

    example: bool = Field(False, description="With an example: readings of a simulated robot with one cause.")


class MakeRequest(Request):
    """What the campaign is called."""

    model_config = example({"name": "left arm"})

    name: Words | None = Field(None, description="Else what the files share.")


class DraftFileReply(Reply):
    """A file of a draft."""

    number: int
    name: str
    size_bytes: int


class DraftReply(Reply):
    """Files that were brought, and what was said of them."""

    id: RecordId
    created_at: RecordedAt
    changed_at: RecordedAt
    expires_at: RecordedAt
    revision: int = Field(ge=0, description="Of files and choices.")
    files: list[DraftFileReply]
    choices: dict[str, Any] = Field(description="As `PATCH` takes them.")
    campaign_id: int | None = Field(description="Number of the campaign that was made of it; null: none yet.")
    job_ids: list[int] = Field(description="Its identification, then its diagnosis.")


class ColumnReply(Reply):
    """A column and what it is taken for."""

    heading: str
    quantity: Annotated[str, FieldSource("meaning.quantity")]
    number: Annotated[int, FieldSource("meaning.number")]
    unit: Annotated[str, FieldSource("meaning.unit")]
    point: Annotated[int, FieldSource("meaning.point")]
    column: Annotated[str, FieldSource("meaning.column")] = Field(
        description="Its name in the file format; empty: it is not read."
    )
    certainty: str = Field(description="`certain`, `likely`, `guess`; `said`: somebody chose it.")
    reason: Spoken
    shown: list[str]


class SeenFileReply(Reply):
    """A file and what it is taken for."""

    name: str
    kind: Kind
    role: str
    reason: Spoken
    rows: int
    first_line: int
    columns: list[ColumnReply]


class OfferedReply(Reply):
    """A change of convention that would make the robot fit; accepted by sending it back in `changes`."""

    kind: str
    first: int
    second: int
    amount: float
    sentence: Spoken


class SeenRobotReply(Reply):
    """The robot that the readings are held against."""

    key: str
    name: str
    reason: Spoken
    fits: bool
    typical_mm: Quantity = Field(
        description="What the nominal robot misses the readings by; null: not looked at."
    )
    offered: list[OfferedReply]


class LineReply(Reply):
    """A line around a fault."""

    number: int
    cells: list[str]
    text: str


class DraftFaultReply(Reply):
    """The first place that cannot be used."""

    file: str
    line: int | None
    column: int | None = Field(description="From 0.")
    sentence: Spoken
    around: list[LineReply]


class QuestionReply(Reply):
    """Something that no file says and nobody can guess."""

    about: Asked
    sentence: Spoken


class UnderstoodReply(Reply):
    """What is understood of the files, before anything is made of them."""

    ready: bool
    readings: int
    files: list[SeenFileReply]
    robot: SeenRobotReply | None
    questions: list[QuestionReply]
    fault: DraftFaultReply | None
    notes: list[Spoken] = Field(description="What was done without being asked.")
    u_mm: Quantity = Field(description="From places measured again, where nobody says it; null: none.")
    measured_on: str | None = Field(description="As somebody said, or the files themselves.")
    robot_serial_number: str = Field(description="The same; empty: nobody said it.", examples=["120-500123"])
    instrument_serial_number: str = Field(description="The same; empty: nobody said it.", examples=["391234"])
    simulated: bool = Field(description="As the files say of themselves.")


router = resource("/drafts", tags=["drafts"])
_RECEIVING_S: Final = 300.0  # 64 MB at 2 Mbit/s
_BODY: Final = {
    "requestBody": {
        "description": "The bytes of the file; without any it is an empty one, as folders have them.",
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
        description="Its name, with the folders that it came in.",
        examples=["left arm/points.csv"],
    ),
]
FileNumber = Annotated[int, Query(ge=1, le=NUMBER_LIMIT, description="Number of the file.", examples=[1])]


@router.post("", status_code=status.HTTP_201_CREATED, responses=problems(400, 409, 413, 415, 422, 503))
async def start_draft(here: Here, response: Response, wanted: NewDraftRequest) -> DraftReply:
    """Begin with nothing, or with the example; files come next. It ends 14 days after its last change."""
    draft = await (here.draft_desk.create_example() if wanted.example else here.draft_desk.create())
    response.headers["Location"] = f"/api/v1/drafts/{draft.id}"
    return DraftReply.of(draft)


@router.get("", responses=LIST)
async def list_drafts(here: Here, paging: Counted) -> list[DraftReply]:
    """List drafts, the latest first; there are twenty at most."""
    return paging.of(await here.draft_desk.all(), DraftReply.of)


@router.get("/{id}", responses=READ)
async def get_draft(here: Here, id: Id) -> DraftReply:
    """Show the files of a draft, and what was said of them."""
    return DraftReply.of(await here.draft_desk.get(id))


@router.delete("/{id}", status_code=status.HTTP_204_NO_CONTENT, responses=READ)
async def remove_draft(here: Here, id: Id) -> None:
    """Throw a draft away; what was made of it stays."""
    await here.draft_desk.remove(id)


@router.post(
    "/{id}/files",
    status_code=status.HTTP_201_CREATED,
    responses=problems(404, 408, 409, 413, 415, 422, 503),
    openapi_extra=_BODY,
)
async def add_draft_file(here: Here, request: HttpRequest, id: Id, name: NameOfFile) -> DraftReply:
    """Add a file as it is: a table of any program, a folder's file, a zip, a robot's description.

    One of the same name is replaced. Where the connection ends before the answer, nothing is kept of it.
    """
    async with receiving(_RECEIVING_S, "file", "nothing of it was kept"):
        return DraftReply.of(await here.draft_desk.receive(id, name, request.stream()))


@router.delete("/{id}/files", responses=READ)
async def remove_draft_file(here: Here, id: Id, number: FileNumber) -> DraftReply:
    """Take a file out of a draft."""
    return DraftReply.of(await here.draft_desk.remove_file(id, number))


@router.patch("/{id}", responses=problems(400, 404, 413, 415, 422, 503))
async def correct_draft(here: Here, id: Id, said: DraftRequest) -> DraftReply:
    """Say what columns and files are, which robot it is, when it was measured; correct single lines."""
    return DraftReply.of(await here.draft_desk.say(id, said.model_dump(mode="json", exclude_unset=True)))


@router.get("/{id}/understood", responses=READ)
async def get_understood(here: Here, id: Id) -> UnderstoodReply:
    """Show what each file and column is taken for, which robot fits, what is asked, and the first fault."""
    draft = await here.draft_desk.get(id)
    return UnderstoodReply.of(await here.draft_desk.understood(draft))


@router.post("/{id}/campaign", status_code=status.HTTP_201_CREATED, responses=CHANGE)
async def make_campaign_of_draft(here: Here, response: Response, id: Id, wanted: MakeRequest) -> DraftReply:
    """Make a campaign of a draft, and queue its identification and diagnosis; again, answer the same.

    Refused (409) while something is asked or cannot be read.
    """
    draft = await here.draft_desk.make(id, wanted.name)
    response.headers["Location"] = f"/api/v1/campaigns/{draft.campaign_id}"
    return DraftReply.of(draft)
