"""What somebody chose for the files to be imported, and what was understood of them, to be shown first."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import date
from typing import Any, Final, Literal, TypeAlias

from truepose.exchange.import_wizard.headings import ColumnMeaning
from truepose.identification.verdict.conventions import Change
from truepose.messages.message import Message, Text

ROLES: Final = ("calibration", "validation", "legs", "validation_legs", "nothing")
OWN_ROBOT: Final = "file"  # the robot that one of the files describes


@dataclass(frozen=True, slots=True)
class FileChoice:
    """What was said of one file."""

    role: str | None = None  # of ROLES; None: nothing was said
    columns: Mapping[int, ColumnMeaning] = field(default_factory=dict)  # by column, from 0
    edits: Mapping[int, str | None] = field(default_factory=dict)  # by line; None: it is left out


@dataclass(frozen=True, slots=True)
class Choices:
    """What was said of all of them."""

    files: Mapping[str, FileChoice] = field(default_factory=dict)
    robot: str | None = None  # a shipped one, or OWN_ROBOT; None: it is found
    changes: tuple[Change, ...] = ()
    u_mm: float | None = None
    measured_on: date | None = None
    robot_serial_number: str = ""  # empty: nothing was said; so below
    instrument_serial_number: str = ""
    undated: bool = False  # the day may stay unknown: whoever asks is not made a record of
    notes: tuple[str, ...] = ()

    def of(self, file: str) -> FileChoice:
        """Return what was said of a file."""
        return self.files.get(file, FileChoice())


def choices_of(document: Mapping[str, Any], notes: Sequence[str] = ()) -> Choices:
    """Return choices from what requests send and drafts keep; it was checked where it came in."""
    day = document.get("measured_on")
    return Choices(
        files={name: _file(said) for name, said in (document.get("files") or {}).items()},
        robot=document.get("robot"),
        changes=tuple(Change(**change) for change in document.get("changes") or ()),
        u_mm=document.get("u_mm"),
        measured_on=None if day is None else date.fromisoformat(day),
        robot_serial_number=document.get("robot_serial_number") or "",
        instrument_serial_number=document.get("instrument_serial_number") or "",
        notes=tuple(notes),
    )


def _file(said: Mapping[str, Any]) -> FileChoice:
    columns = {int(at): ColumnMeaning(**meaning) for at, meaning in (said.get("columns") or {}).items()}
    edits: dict[int, str | None] = {int(line): text for line, text in (said.get("lines") or {}).items()}
    # Behind the edits: a line that was corrected and is left out later is left out.
    left_out = dict.fromkeys(said.get("left_out") or (), None)
    return FileChoice(said.get("role"), columns, edits | left_out)


def merge_patch(before: Mapping[str, Any], said: Mapping[str, Any]) -> dict[str, Any]:
    """Return a document with what was said since, member by member; null takes one back (RFC 7396)."""
    found = dict(before)
    for key, value in said.items():
        if value is None:
            found.pop(key, None)
        elif isinstance(value, Mapping):
            found[key] = merge_patch(found.get(key) or {}, value)
        else:
            found[key] = value
    return found


Kind: TypeAlias = Literal["table", "robot", "description", "other"]
Asked: TypeAlias = Literal["tables", "joints", "readings", "robot", "change", "uncertainty", "day"]


@dataclass(frozen=True, slots=True)
class DetectedColumn:
    """A column and what it is taken for."""

    heading: str
    meaning: ColumnMeaning
    certainty: str  # "certain", "likely", "guess"; "said": somebody chose it
    reason: Message
    shown: tuple[str, ...]  # its first cells


@dataclass(frozen=True, slots=True)
class DetectedFile:
    """A file and what it is taken for."""

    name: str
    kind: Kind
    role: str = "nothing"
    reason: Text = ""  # for its role, or why it is not read
    rows: int = 0
    first_line: int = 0  # of the rows
    columns: tuple[DetectedColumn, ...] = ()


@dataclass(frozen=True, slots=True)
class ChangeOffered:
    """A change of convention that would make the robot fit."""

    sentence: Message
    kind: str
    first: int
    second: int
    amount: float


@dataclass(frozen=True, slots=True)
class RobotSeen:
    """The robot that the readings are held against."""

    key: str  # a shipped one, or "file"
    name: str
    reason: Text
    fits: bool
    typical_mm: float | None = None  # what the nominal robot misses the readings by; None: not looked at
    offered: tuple[ChangeOffered, ...] = ()


@dataclass(frozen=True, slots=True)
class DisplayedLine:
    """A line around a fault, its cells apart."""

    number: int
    cells: tuple[str, ...]
    text: str


@dataclass(frozen=True, slots=True)
class Fault:
    """The first place that cannot be used."""

    file: str
    sentence: str
    line: int | None = None
    column: int | None = None  # from 0
    around: tuple[DisplayedLine, ...] = ()


@dataclass(frozen=True, slots=True)
class Question:
    """Something that no file says and nobody can guess."""

    about: Asked
    sentence: Message


@dataclass(frozen=True, slots=True)
class Understood:
    """Everything that is shown of what somebody brought."""

    files: tuple[DetectedFile, ...]
    robot: RobotSeen | None = None
    questions: tuple[Question, ...] = ()
    fault: Fault | None = None
    notes: tuple[Message, ...] = ()  # what was done without being asked
    u_mm: float | None = None  # from revisits, where no column and nobody says it
    measured_on: str | None = None  # as the files themselves say
    robot_serial_number: str = ""  # as somebody said, or the files themselves; so below
    instrument_serial_number: str = ""
    readings: int = 0
    simulated: bool = False  # as the files say of themselves

    @property
    def ready(self) -> bool:
        """Whether a campaign can be made of it."""
        return not self.questions and self.fault is None and self.readings > 0
