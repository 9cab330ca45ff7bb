"""What a person may do at the tablet, and when it may be pressed."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Final

from truepose.domain.ballbar import BallbarStep, StepKind
from truepose.domain.session import SessionState
from truepose.sequencing.ballbar.plan import step_ids
from truepose.sequencing.ballbar.record import READINGS


class ActName(StrEnum):
    """One button."""

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


class Answer(StrEnum):
    """What a person says to a suspicion."""

    RIGHT_PAIR = "right_pair"  # the reading is stored, with the doubt kept beside it
    RECONNECTED = "reconnected"  # it is read again
    EXCHANGED = "exchanged"  # both legs are read again


@dataclass(frozen=True, slots=True)
class Act:
    """One button pressed by somebody on some tablet."""

    name: ActName
    person: str
    tablet: str
    key: str  # idempotency key: the same key again does nothing again
    step_id: str | None = None  # the step that the person saw
    reason: str = ""  # of a skip, or why the session pauses, stops or ends
    answer: str = ""  # to a suspicion
    seen_time_s: float | None = None  # cell clock of the newest sample that the person saw
    accepted_serial: str = ""  # of a confirmation: the ballbar in question that the person accepts


@dataclass(frozen=True, slots=True)
class ActOutcome:
    """What came of an act."""

    sentence: str
    entry: int  # its number in the ledger


LETS_MOVE: Final = frozenset({ActName.START, ActName.CONFIRM, ActName.RESUME})  # the arm may move after it
HALTS: Final = frozenset({ActName.PAUSE, ActName.STOP, ActName.ABORT})  # for everybody
_ALWAYS: Final = frozenset({ActName.HAND_OVER, ActName.ABORT})
_RUNNING: Final = frozenset({ActName.PAUSE, ActName.STOP, *_ALWAYS})
_BY_STATE: Final = {
    SessionState.PLANNED: frozenset({ActName.START, ActName.ABORT}),
    SessionState.RUNNING: _RUNNING,
    SessionState.PAUSING: frozenset({ActName.STOP, *_ALWAYS}),
    SessionState.PAUSED: frozenset({ActName.RESUME, *_ALWAYS}),
    SessionState.AWAITING_CONFIRMATION: frozenset({ActName.CONFIRM, *_ALWAYS}),
    SessionState.ABORTING: frozenset({ActName.HAND_OVER}),
}


def acts_allowed(
    state: SessionState, step: BallbarStep | None, *, confirmed: bool, suspected: bool, can_go_back: bool
) -> frozenset[ActName]:
    """Return the acts that may be pressed now."""
    acts: frozenset[ActName] = _BY_STATE.get(state, frozenset())
    if step is None:
        return acts
    if state is SessionState.PAUSED and step.kind is StepKind.PRECALIBRATE:
        return acts | {ActName.SKIP}  # it has failed, or was not wanted now
    if state is not SessionState.RUNNING or confirmed or step.kind is StepKind.PRECALIBRATE:
        return acts
    acts |= _acts_of_the_step(step, suspected=suspected)
    return acts | {ActName.BACK} if can_go_back and not suspected else acts


def _acts_of_the_step(step: BallbarStep, *, suspected: bool) -> frozenset[ActName]:
    skip = {ActName.SKIP} if may_be_skipped(step) else set()
    if suspected:
        return frozenset({ActName.ANSWER, ActName.RETRY, *skip})
    do = ActName.STORE if step.kind in READINGS else ActName.CONFIRM
    return frozenset({do, ActName.RETRY, *skip})


def may_be_skipped(step: BallbarStep) -> bool:
    """Whether the session can do without this step: what is of a pose, and a side of a triangle."""
    if step.kind is StepKind.DETACH:
        return False  # the arm could not move any more
    return step_ids.is_of_a_pose(step.id) or step.kind in {StepKind.MEASURE_SIDE, StepKind.PRECALIBRATE}
