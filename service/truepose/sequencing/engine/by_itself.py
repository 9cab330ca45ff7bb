"""What every session says of itself that runs while nobody is in the cell."""

from dataclasses import dataclass

from truepose.domain.measurement.session import SessionState
from truepose.sequencing.engine.states import ASKS


@dataclass(frozen=True, slots=True)
class RunsByItself:
    """Where a session stands, as far as a person is concerned."""

    state: SessionState
    reason: str  # why this state was entered; of a person who is waited for: the question

    @property
    def busy(self) -> bool:
        """Whether the present step is done, as soon as nothing forbids it."""
        return self.state is SessionState.RUNNING

    @property
    def question(self) -> str | None:
        """What a person is asked to confirm, or why the session waits."""
        return self.reason if self.state in ASKS else None
