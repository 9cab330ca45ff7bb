"""What a session writes down, line by line: appended, never changed. A session is what its ledger says.

The present step, what may be pressed and where the arm stands are pure functions of plan and lines; a line is
on disk before anything follows from it (docs/decisions/0016, 0033).
"""

from dataclasses import dataclass
from enum import StrEnum
from typing import Final

from truepose.domain.ballbar import ArrivalTaken, LengthTaken, PreCalibration, Suspicion
from truepose.domain.contacts import ContactTaken
from truepose.domain.session import (
    FixedNestTaken,
    IdentityTaken,
    PointTaken,
    Progress,
    Registration,
    SessionState,
)
from truepose.messages.message import Text, message

# Steps of lines that a session without the ballbar notes of the one in its cell.
# A session with a tracker, a camera or gauges moves the same arm: a bar that was left between two balls would
# be torn down by it (docs/decisions/0018).
BALLBAR_OFF: Final = "ballbar-off"  # it was seen to come off, or a person said how they know
BALLBAR_ON: Final = "ballbar-on"  # it read a length within its range


class EntryKind(StrEnum):
    """Kind of a ledger entry."""

    SHOWN = "shown"  # a prompt was shown
    CONFIRMED = "confirmed"  # a person did what was asked, or confirmed that the cell is clear
    MEASURED = "measured"  # a length, or the reading of a stop, was stored
    MOVED = "moved"  # the robot arrived
    SKIPPED = "skipped"  # with a reason; of a step in a pose: the whole rest of the pose
    # Nothing is deleted: who asks why a length is missing should find the reason.
    REOPENED = "reopened"  # what was kept of this step counts no more
    COMPUTED = "computed"  # the pre-calibration, or the registration, ended
    SUSPECTED = "suspected"  # a reading contradicts the pair that was asked for; it was not stored
    ANSWERED = "answered"  # what a person said to a suspicion
    BEGUN = "begun"  # the service began a step
    READ = "read"  # an instrument gave a reading on the way to the end of a step
    ENDED = "ended"  # the service did what the step asks for
    NOTED = "noted"  # a sentence for the report and the operator
    CONTROL = "control"  # a state was entered; which tablet acts; which device answered


class Control(StrEnum):
    """What a line of the ledger says of the session as a whole, besides the state that it enters."""

    HAND_OVER = "hand_over"  # another tablet acts from now on
    # Some gauges would have kept their zero through it; which do is not known, so that it is read again.
    ZERO_LOST = "zero_lost"  # the ballbar was without supply; what it shows is counted from elsewhere now
    RESTARTED = "restarted"  # the service was started anew; what happened before is of an earlier run


@dataclass(frozen=True, slots=True)
class LedgerEntry:
    """One line of what happened.

    A line has a step, a kind and a time; beside these it has what its kind brings: a reading, a state, a
    device.
    """

    step_id: str
    kind: EntryKind
    time_s: float  # cell clock; the storage adds the time of day
    person: str | None = None
    tablet: str | None = None
    key: str | None = None  # idempotency key of the request
    text: Text = ""  # reason, answer, or what was asked of the session
    length: LengthTaken | None = None
    arrival: ArrivalTaken | None = None
    precalibration: PreCalibration | None = None
    suspicion: Suspicion | None = None
    identity: IdentityTaken | None = None
    entered: SessionState | None = None  # the state that the session enters with this line, `text` says why
    control: Control | None = None
    point: PointTaken | None = None
    fixed_nest: FixedNestTaken | None = None
    registration: Registration | None = None
    contact: ContactTaken | None = None
    progress: Progress | None = None
    # To others the arm does not go by that answer: they were added since, and nobody was asked about them.
    stops: tuple[int, ...] = ()  # configurations to which the arm goes once the question is answered

    @property
    def told(self) -> Text:
        """What the line says in words: of a state that is entered, its name and why."""
        if self.entered is not None:
            return message("session.entered", state=self.entered.value, text=self.text)
        return self.text or ("" if self.control is None else self.control.value)
