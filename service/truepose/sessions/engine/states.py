"""The states of a session and the one table of their transitions.

Two rules: nothing moves in any state but RUNNING, and RUNNING is entered by a person only, through
AWAITING_CONFIRMATION or PAUSED. Whatever the table lacks is refused.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

from truepose.domain.session import SessionState
from truepose.domain.session import SessionState as S
from truepose.messages.message import Message, Text, message
from truepose.sessions.engine.prompts import Prompt
from truepose.sessions.errors import NotNowError

TRANSITIONS: Final[Mapping[S, frozenset[S]]] = MappingProxyType({
    S.PLANNED: frozenset({S.AWAITING_CONFIRMATION, S.ABORTED, S.FAILED}),
    S.AWAITING_CONFIRMATION: frozenset({S.RUNNING, S.ABORTED, S.FAILED}),
    # PAUSED without PAUSING: the session pauses itself, between two motions
    S.RUNNING: frozenset({S.PAUSING, S.PAUSED, S.AWAITING_CONFIRMATION, S.ABORTING, S.FINISHED, S.FAILED}),
    S.PAUSING: frozenset({S.PAUSED, S.AWAITING_CONFIRMATION, S.ABORTING, S.FAILED}),
    S.PAUSED: frozenset({S.RUNNING, S.ABORTED, S.FAILED}),
    S.ABORTING: frozenset({S.ABORTED, S.FAILED}),
    S.ABORTED: frozenset(),
    S.FINISHED: frozenset(),
    S.FAILED: frozenset(),
})


_WORDS: Final[Mapping[S, Message]] = MappingProxyType({
    S.PLANNED: message("session.state.planned"),
    S.AWAITING_CONFIRMATION: message("session.state.awaiting_confirmation"),
    S.RUNNING: message("session.state.running"),
    S.PAUSING: message("session.state.pausing"),
    S.PAUSED: message("session.state.paused"),
    S.ABORTING: message("session.state.aborting"),
    S.ABORTED: message("session.state.aborted"),
    S.FINISHED: message("session.state.finished"),
    S.FAILED: message("session.state.failed"),
})

# Where a person is asked; each line of the ledger that enters one of these is a prompt of its own.
ASKS: Final = frozenset({S.AWAITING_CONFIRMATION, S.PAUSED})


def has_ended(state: S) -> bool:
    """Whether nothing follows."""
    return not TRANSITIONS[state]


def require_transition(present: S, wanted: S) -> None:
    """Raise NotNowError where the table does not lead from `present` to `wanted`."""
    if wanted not in TRANSITIONS[present]:
        raise NotNowError(message("session.refused.transition", present=words(present), wanted=words(wanted)))


def after_restart(state: S) -> S:
    """Return the state of a session after its program ended without it; what could move awaits a person."""
    # The end was asked for, and the program is gone: nothing can move, so it has taken place.
    if state is S.ABORTING:
        return S.ABORTED
    if state is S.PLANNED or has_ended(state):
        return state
    return S.AWAITING_CONFIRMATION


def words(state: S) -> Message:
    """Return the state as the operator reads it."""
    return _WORDS[state]


@dataclass(frozen=True, slots=True)
class Moment:
    """State, reason and prompt, which belong together: whoever shows a session takes all from one."""

    state: SessionState
    reason: Text  # why this state was entered
    prompt: Prompt | None  # what a person is asked to look at
    trouble: Text | None  # what a person is told while lines are refused
    robot_moving: bool  # or about to
