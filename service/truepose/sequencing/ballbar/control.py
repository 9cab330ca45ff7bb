"""What a CONTROL line of the ledger says: the state that was entered and why, or which tablet acts now."""

from typing import Final

from truepose.domain.session import SessionState

HAND_OVER: Final = "hand_over"
ZERO_LOST: Final = "zero_lost"  # the ballbar was without supply; what it shows is counted from elsewhere now
NOBODY_RUNS: Final = "The program failed and does not run this session now; nothing moves."
RESTARTED: Final = "The service was started anew."


def state_text(state: SessionState, reason: str) -> str:
    """Return the text that keeps a change of state."""
    return f"{state.value}: {reason}"


def state_in(text: str) -> SessionState | None:
    """Return the state that a text says was entered; None where it says something else."""
    word = text.partition(":")[0]
    return SessionState(word) if word in {state.value for state in SessionState} else None


def reason_in(text: str) -> str:
    """Return why the state was entered."""
    return text.partition(": ")[2]
