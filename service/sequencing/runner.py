"""Executes a tracker session: the only place that commands motion."""

from service.domain.session import Progress, SessionPlan, SessionState
from service.sequencing.cell import SessionCell
from service.sequencing.journal import SessionHistory, SessionJournal


class SessionRunner:
    """One session on one cell; `run` is its task, all other methods may be called from other tasks."""

    def __init__(
        self,
        plan: SessionPlan,
        cell: SessionCell,
        journal: SessionJournal,
        history: SessionHistory | None = None,
    ) -> None:
        self._plan = plan
        self._cell = cell
        self._journal = journal
        self._history = history or SessionHistory()

    @property
    def state(self) -> SessionState:
        """Where the session stands."""
        return self._history.state

    @property
    def question(self) -> str | None:
        """What a person is asked to confirm, or why the session pauses; None while it runs or has ended."""
        raise NotImplementedError

    @property
    def progress(self) -> Progress:
        """How far the session is."""
        raise NotImplementedError

    async def run(self) -> SessionState:
        """Run to the end and return the state it ended in; first a person has to `confirm`.

        Raises what the journal raises; every other fault becomes a state with a sentence.
        """
        raise NotImplementedError

    async def request_pause(self, person: str | None = None) -> str:
        """Ask for a pause; returns the sentence that says when it takes effect. Raises NotNowError."""
        raise NotImplementedError

    async def request_abort(self, person: str | None = None) -> str:
        """Ask for the end; returns the sentence that says when it takes effect. Raises NotNowError."""
        raise NotImplementedError

    async def resume(self, person: str) -> str:
        """Continue a paused session. Raises NotNowError, PersonMissingError."""
        raise NotImplementedError

    async def confirm(self, person: str) -> str:
        """Confirm what `question` asks. Raises NotNowError, PersonMissingError."""
        raise NotImplementedError
