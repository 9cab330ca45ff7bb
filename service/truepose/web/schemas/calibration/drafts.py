"""Drafts: files that somebody brings, what is said of them, and what is understood."""

from typing import Annotated, Any, Literal

from pydantic import Field, JsonValue

from truepose.exchange.brought.understood import Asked, Kind, Understood
from truepose.exchange.outgoing import Quantity
from truepose.storage.files.drafts import Draft
from truepose.web.schemas.base import VISIBLE, Day, RecordedAt, RecordId, Reply, Request, example
from truepose.words.catalogue import english

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
    quantity: str
    number: int
    unit: str
    point: int
    column: str = Field(description="Its name in the file format; empty: it is not read.")
    certainty: str = Field(description="`certain`, `likely`, `guess`; `said`: somebody chose it.")
    reason: str
    shown: list[str]


class SeenFileReply(Reply):
    """A file and what it is taken for."""

    name: str
    kind: Kind
    role: str
    reason: str
    rows: int
    first_line: int
    columns: list[ColumnReply]


class OfferedReply(Reply):
    """A change of convention that would make the robot fit; accepted by sending it back in `changes`."""

    kind: str
    first: int
    second: int
    amount: float
    sentence: str


class SeenRobotReply(Reply):
    """The robot that the readings are held against."""

    key: str
    name: str
    reason: str
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


class FaultReply(Reply):
    """The first place that cannot be used."""

    file: str
    line: int | None
    column: int | None = Field(description="From 0.")
    sentence: str
    around: list[LineReply]


class QuestionReply(Reply):
    """Something that no file says and nobody can guess."""

    about: Asked
    sentence: str


class UnderstoodReply(Reply):
    """What is understood of the files, before anything is made of them."""

    ready: bool
    readings: int
    files: list[SeenFileReply]
    robot: SeenRobotReply | None
    questions: list[QuestionReply]
    fault: FaultReply | None
    notes: list[str] = Field(description="What was done without being asked.")
    u_mm: Quantity = Field(description="From places measured again, where nobody says it; null: none.")
    measured_on: str | None = Field(description="As somebody said, or the files themselves.")
    robot_serial_number: str = Field(description="The same; empty: nobody said it.", examples=["120-500123"])
    instrument_serial_number: str = Field(description="The same; empty: nobody said it.", examples=["391234"])
    simulated: bool = Field(description="As the files say of themselves.")


def draft_reply(draft: Draft) -> DraftReply:
    """Return a draft as it travels."""
    return DraftReply.of(draft)


def understood_reply(found: Understood) -> UnderstoodReply:
    """Return what was understood as it travels."""
    return UnderstoodReply.of(
        found,
        files=[_file(file) for file in found.files],
        robot=None if found.robot is None else _robot(found.robot),
        questions=[{"about": one.about, "sentence": english(one.sentence)} for one in found.questions],
        notes=[english(note) for note in found.notes],
    )


def _file(file: Any) -> SeenFileReply:
    columns = [ColumnReply.of(one, one.meaning, reason=english(one.reason)) for one in file.columns]
    return SeenFileReply.of(file, reason=english(file.reason), columns=columns)


def _robot(robot: Any) -> SeenRobotReply:
    offered = [OfferedReply.of(one, sentence=english(one.sentence)) for one in robot.offered]
    return SeenRobotReply.of(robot, reason=english(robot.reason), offered=offered)
