"""What the states of a session are called."""

from collections.abc import Mapping
from typing import Final

from truepose.domain.measurement.session import SessionState
from truepose.words.catalogue import Catalogue

STATES: Final[Mapping[SessionState, str]] = {  # keys of the catalogue
    SessionState.PLANNED: "session.planned",
    SessionState.RUNNING: "session.running",
    SessionState.PAUSING: "session.pausing",
    SessionState.PAUSED: "session.paused",
    SessionState.AWAITING_CONFIRMATION: "session.awaiting_confirmation",
    SessionState.ABORTING: "session.aborting",
    SessionState.ABORTED: "session.aborted",
    SessionState.FINISHED: "session.finished",
    SessionState.FAILED: "session.failed",
}


def state_words(words: Catalogue) -> dict[str, str]:
    """Return each state, as documents name it, with what people read."""
    return {state.value: words.say(key) for state, key in STATES.items()}
