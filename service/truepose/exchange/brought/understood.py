"""What was understood of the files that somebody brought, to be shown before anything is made of it."""

from dataclasses import dataclass
from typing import Literal, TypeAlias

from truepose.domain.sentences import Sentence, Text
from truepose.exchange.brought.guessing.quantities import Meaning

Kind: TypeAlias = Literal["table", "robot", "description", "other"]
Asked: TypeAlias = Literal["tables", "joints", "readings", "robot", "change", "uncertainty", "day"]


@dataclass(frozen=True, slots=True)
class ColumnSeen:
    """A column and what it is taken for."""

    heading: str
    meaning: Meaning
    certainty: str  # "certain", "likely", "guess"; "said": somebody chose it
    reason: Sentence
    shown: tuple[str, ...]  # its first cells


@dataclass(frozen=True, slots=True)
class FileSeen:
    """A file and what it is taken for."""

    name: str
    kind: Kind
    role: str = "nothing"
    reason: Text = ""  # for its role, or why it is not read
    rows: int = 0
    first_line: int = 0  # of the rows
    columns: tuple[ColumnSeen, ...] = ()


@dataclass(frozen=True, slots=True)
class ChangeOffered:
    """A change of convention that would make the robot fit."""

    sentence: Sentence
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
class LineShown:
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
    around: tuple[LineShown, ...] = ()


@dataclass(frozen=True, slots=True)
class Question:
    """Something that no file says and nobody can guess."""

    about: Asked
    sentence: Sentence


@dataclass(frozen=True, slots=True)
class Understood:
    """Everything that is shown of what somebody brought."""

    files: tuple[FileSeen, ...]
    robot: RobotSeen | None = None
    questions: tuple[Question, ...] = ()
    fault: Fault | None = None
    notes: tuple[Sentence, ...] = ()  # what was done without being asked
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
