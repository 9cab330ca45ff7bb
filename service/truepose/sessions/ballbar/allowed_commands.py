"""What a person may do at the tablet, and when it may be pressed."""

from typing import Final

from truepose.domain.ballbar import BallbarStep, StepKind
from truepose.domain.session import SessionState
from truepose.sessions.ballbar import step_ids
from truepose.sessions.ballbar.state import READINGS
from truepose.sessions.engine.commands import CommandName

_ALWAYS: Final = frozenset({CommandName.HAND_OVER, CommandName.ABORT})
_RUNNING: Final = frozenset({CommandName.PAUSE, CommandName.STOP, *_ALWAYS})
_BY_STATE: Final = {
    SessionState.PLANNED: frozenset({CommandName.START, CommandName.ABORT}),
    SessionState.RUNNING: _RUNNING,
    SessionState.PAUSING: frozenset({CommandName.STOP, *_ALWAYS}),
    SessionState.PAUSED: frozenset({CommandName.RESUME, *_ALWAYS}),
    SessionState.AWAITING_CONFIRMATION: frozenset({CommandName.CONFIRM, *_ALWAYS}),
    SessionState.ABORTING: frozenset({CommandName.HAND_OVER}),
}


def acts_allowed(
    state: SessionState, step: BallbarStep | None, *, confirmed: bool, suspected: bool, can_go_back: bool
) -> frozenset[CommandName]:
    """Return the acts that may be pressed now."""
    acts: frozenset[CommandName] = _BY_STATE.get(state, frozenset())
    if step is None:
        return acts
    if state is SessionState.PAUSED and step.kind is StepKind.PRECALIBRATE:
        return acts | {CommandName.SKIP}  # it has failed, or was not wanted now
    if state is not SessionState.RUNNING or confirmed or step.kind is StepKind.PRECALIBRATE:
        return acts
    acts |= _acts_of_the_step(step, suspected=suspected)
    return acts | {CommandName.BACK} if can_go_back and not suspected else acts


def _acts_of_the_step(step: BallbarStep, *, suspected: bool) -> frozenset[CommandName]:
    skip = {CommandName.SKIP} if may_be_skipped(step) else set()
    # A doubt is answered before anything else of the step is done, and before *Back*: what is in doubt is not
    # on record yet.
    if suspected:
        return frozenset({CommandName.ANSWER, CommandName.RETRY, *skip})
    do = CommandName.STORE if step.kind in READINGS else CommandName.CONFIRM
    return frozenset({do, CommandName.RETRY, *skip})


def may_be_skipped(step: BallbarStep) -> bool:
    """Whether the session can do without this step: what is of a pose, and a side of a triangle."""
    if step.kind is StepKind.DETACH:
        return False  # the arm could not move any more
    return step_ids.is_of_a_pose(step.id) or step.kind in {StepKind.MEASURE_SIDE, StepKind.PRECALIBRATE}
