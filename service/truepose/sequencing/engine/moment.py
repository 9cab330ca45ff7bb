"""What a session says of itself at one moment."""

from dataclasses import dataclass

from truepose.domain.measurement.session import SessionState


@dataclass(frozen=True, slots=True)
class Moment:
    """State, reason and question, which belong together: whoever shows a session takes all from one."""

    state: SessionState
    reason: str  # why this state was entered
    question: str | None  # what a person is asked to look at, or why the session waits
    prompt_id: int | None  # of the line that asks it
    trouble: str | None  # what a person is told while lines are refused
