"""The states of a session and the one table of their transitions.

Two rules: nothing moves in any state but RUNNING, and RUNNING is entered by a person only, through
AWAITING_CONFIRMATION or PAUSED. Whatever the table lacks is refused.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from truepose.domain.measurement.session import SessionState as S
from truepose.sequencing.errors import NotNowError

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


# Where a person is asked; each line of the ledger that enters one of these is a prompt of its own.
ASKS: Final = frozenset({S.AWAITING_CONFIRMATION, S.PAUSED})


def has_ended(state: S) -> bool:
    """Whether nothing follows."""
    return not TRANSITIONS[state]


def require_transition(present: S, wanted: S) -> None:
    """Raise NotNowError where the table does not lead from `present` to `wanted`."""
    if wanted not in TRANSITIONS[present]:
        raise NotNowError(f"The session is {words(present)}; it cannot become {words(wanted)} from there.")


def after_restart(state: S) -> S:
    """Return the state of a session after its program ended without it; what could move awaits a person."""
    if state is S.ABORTING:
        return S.ABORTED
    if state is S.PLANNED or has_ended(state):
        return state
    return S.AWAITING_CONFIRMATION


def words(state: S) -> str:
    """Return the state as the operator reads it."""
    return state.value.replace("_", " ")
