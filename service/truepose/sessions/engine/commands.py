"""What a person asks of a session."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Final

from truepose.domain.session import SessionState
from truepose.messages.message import Text


class CommandName(StrEnum):
    """Name of an operator command."""

    START = "start"
    CONFIRM = "confirm"  # what is asked is done; of a motion: the cell is clear
    STORE = "store"  # the length that is shown, by hand
    ANSWER = "answer"  # to a suspicion
    RETRY = "retry"  # the same step again
    SKIP = "skip"  # with a reason; in a pose: the rest of it
    BACK = "back"
    PAUSE = "pause"
    RESUME = "resume"
    STOP = "stop"  # nothing more is sent to the robot before a person confirms anew
    ABORT = "abort"
    HAND_OVER = "hand_over"  # this tablet acts from now on


@dataclass(frozen=True, slots=True)
class OperatorCommand:
    """One button pressed by somebody on some tablet."""

    name: CommandName
    person: str
    tablet: str = ""
    key: str | None = None  # idempotency key: the same key again does nothing again
    step_id: str | None = None  # the step that the person saw
    reason: str = ""  # of a skip, of a halt, or how one knows that the ballbar is off
    answer: str = ""  # to a suspicion
    seen_time_s: float | None = None  # cell clock of the newest sample that the person saw
    accepted_serial: str = ""  # of a confirmation: the instrument in question that the person accepts
    prompt_id: int | None = None  # what the person saw asked; None: whatever is asked now
    under_way_s: float = 0.0  # since it was pressed, when it arrived here
    ballbar_off: Text = ""  # why the ballbar counts as off that an earlier session left attached


@dataclass(frozen=True, slots=True)
class CommandOutcome:
    """What came of an act."""

    sentence: Text
    entry: int | None  # its number in the ledger; None: it holds, and is on record later


# Halts and revisions are not among them: whoever asks for one need not have looked at the cell.
LETS_MOVE: Final = frozenset({
    CommandName.START,
    CommandName.CONFIRM,
    CommandName.RESUME,
})  # the arm may move after it
ANSWERS: Final = frozenset({
    CommandName.CONFIRM,
    CommandName.RESUME,
})  # to the question that is open, where one is
HALTS: Final = {  # for everybody, and the state that each of them leads to
    CommandName.PAUSE: SessionState.PAUSED,
    CommandName.STOP: SessionState.AWAITING_CONFIRMATION,
    CommandName.ABORT: SessionState.ABORTED,
}
