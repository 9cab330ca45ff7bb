"""What the storage hands out: records with their number, the time they were written and their state."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Literal

from truepose.domain.cell import Cell
from truepose.domain.correction import FileCorrection
from truepose.domain.diagnosis import Diagnosis
from truepose.domain.identification import Identification, Model
from truepose.domain.ledger import LedgerEntry
from truepose.domain.session import (
    FixedNestTaken,
    PlannedStop,
    PointTaken,
    SessionRole,
    SessionState,
)
from truepose.domain.validation import Validation
from truepose.messages.message import Text

ReadingKind = Literal["point", "fixed_nest"]


@dataclass(frozen=True, slots=True)
class SessionSetup:
    """What a session was measured with, kept with it: the cell file may say something else tomorrow."""

    cell: Cell
    attachment: int = 1  # how often the tool has been mounted

    @property
    def simulated(self) -> bool:
        """Whether no robot and no instrument took part."""
        return self.cell.simulated is not None


@dataclass(frozen=True, slots=True)
class SessionRecord:
    """A session and where it stands."""

    id: int
    recorded_at: str
    name: str
    role: SessionRole
    state: SessionState
    reason: Text  # of the present state
    person: str | None  # who brought it there
    state_since: str
    planned: int
    measured: int
    skipped: int
    simulated: bool
    test: str | None = None  # of a session with the ballbar: which; None: it identifies, or is no such


@dataclass(frozen=True, slots=True)
class AddedStops:
    """Stops that a person added to the plan of a session."""

    session_id: int
    person: str
    stops: tuple[PlannedStop, ...]
    diagnosis_id: int | None = None  # which is run again once they are measured


@dataclass(frozen=True, slots=True)
class AdditionRecord:
    """Stops that were added, and when."""

    recorded_at: str
    added: AddedStops


@dataclass(frozen=True, slots=True)
class StateChange:
    """One step in the life of a session."""

    recorded_at: str
    state: SessionState
    reason: Text
    person: str | None


@dataclass(frozen=True, slots=True)
class ReadingRecord:
    """A reading as it was stored; `superseded_by` is the later reading that counts in its place."""

    id: int
    session_id: int
    recorded_at: str
    supersedes: int | None
    superseded_by: int | None
    reading: PointTaken | FixedNestTaken

    @property
    def kind(self) -> ReadingKind:
        """Whether a tool nest or a fixed nest was read."""
        return "point" if isinstance(self.reading, PointTaken) else "fixed_nest"


@dataclass(frozen=True, slots=True)
class LedgerRecord:
    """A line of a session's ledger as it was stored."""

    id: int
    recorded_at: str
    entry: LedgerEntry


@dataclass(frozen=True, slots=True)
class CommandAnswer:
    """What was answered to an act, and the number of the entry that was kept; None where nothing was."""

    sentence: Text
    entry: int | None


@dataclass(frozen=True, slots=True)
class CampaignRecord:
    """A stored campaign without its archive; `session_ids` is empty for an uploaded one."""

    id: int
    recorded_at: str
    name: str
    robot: str
    session_ids: tuple[int, ...]
    simulated: bool
    summary: "CampaignSummary"


@dataclass(frozen=True, slots=True)
class CampaignSummary:
    """How much a campaign holds, and what was kept without being understood."""

    calibration_points: int
    validation_points: int
    calibration_legs: int
    validation_legs: int
    reference_readings: int
    ignored: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    calibration_contacts: int = 0
    validation_contacts: int = 0
    simulated: bool | None = None  # as its description says; None: it does not
    measured_on: str | None = None  # a day; None: nobody said
    measured_zone: str | None = None  # of that day: a name as Europe/Paris
    measured_by: str | None = None
    instrument: str | None = None
    certificate: str | None = None  # of the instrument
    robot_serial_number: str | None = None  # None: nobody said; so below
    instrument_serial_number: str | None = None


class JobKind(StrEnum):
    """Kind of a job, named after its result."""

    IDENTIFICATION = "identification"
    VALIDATION = "validation"
    DIAGNOSIS = "diagnosis"
    PLAN = "plan"
    BALLBAR_PLAN = "ballbar_plan"
    CONTACT_PLAN = "contact_plan"
    CORRECTION = "correction"


class JobState(StrEnum):
    """State of a job; the last four are final."""

    QUEUED = "queued"
    RUNNING = "running"
    SUCCEEDED = "succeeded"
    FAILED = "failed"
    CANCELLED = "cancelled"
    INTERRUPTED = "interrupted"

    @property
    def final(self) -> bool:
        """Whether nothing more happens to the job."""
        return self not in {JobState.QUEUED, JobState.RUNNING}


@dataclass(frozen=True, slots=True)
class JobTaken:
    """How long a job took that succeeded."""

    work_count: int  # readings, configurations, poses, or kilobytes of a file
    duration_s: float


@dataclass(frozen=True, slots=True)
class JobRecord:
    """A job and where it stands; `result_id` is the number of what it made."""

    id: int
    recorded_at: str
    kind: JobKind
    request: dict[str, Any]
    state: JobState
    message: Text
    state_since: str
    fraction: float
    result_id: int | None
    code: str | None  # of the error that it failed with; None: it did not


@dataclass(frozen=True, slots=True)
class IdentificationRecord:
    """A stored identification; its model is a record of its own."""

    id: int
    recorded_at: str
    job_id: int
    campaign_id: int
    model_id: int | None
    robot: str
    simulated: bool  # as its campaign
    identification: Identification


@dataclass(frozen=True, slots=True)
class DiagnosisRecord:
    """A stored diagnosis; its model is a record of its own."""

    id: int
    recorded_at: str
    measured_at: str | None  # when its readings were taken: a day, or UTC in ISO 8601; None: nobody said
    job_id: int
    campaign_id: int
    session_id: int | None  # whose readings it is of; None for an uploaded campaign
    model_id: int | None
    robot_serial_number: str  # empty where nobody said it
    simulated: bool  # as its campaign
    diagnosis: Diagnosis


@dataclass(frozen=True, slots=True)
class ModelRecord:
    """A stored model; exactly one of its three origins is given."""

    id: int
    recorded_at: str
    identification_id: int | None
    diagnosis_id: int | None
    robot: str
    simulated: bool  # as the campaign that it was made from; of one that was handed down nobody says it
    model: Model
    handed_down_id: int | None = None
    accepted_by: str | None = None  # of one that was handed down


@dataclass(frozen=True, slots=True)
class ValidationRecord:
    """A stored validation."""

    id: int
    recorded_at: str
    job_id: int
    model_id: int
    campaign_id: int
    simulated: bool  # as its campaign
    validation: Validation


@dataclass(frozen=True, slots=True)
class CorrectionRecord:
    """A stored correction without its targets and its file."""

    id: int
    recorded_at: str
    job_id: int
    model_id: int
    robot: str
    simulated: bool  # as its model
    name: str  # of the file
    original_sha256: str
    corrected_sha256: str
    asked: dict[str, Any]
    correction: FileCorrection


@dataclass(frozen=True, slots=True)
class EventRecord:
    """Something that happened, in the order of the commits."""

    id: int
    recorded_at: str
    kind: str
    session_id: int | None
    job_id: int | None
    document: dict[str, Any]


@dataclass(frozen=True, slots=True)
class Page:
    """Which part of a list: records with a number above `after`, at most `limit`."""

    after: int = 0
    limit: int = 100


@dataclass(frozen=True, slots=True)
class RequestKey:
    """A client's Idempotency-Key with the fingerprint of its request."""

    key: str
    fingerprint: str
