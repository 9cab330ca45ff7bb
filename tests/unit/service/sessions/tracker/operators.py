"""Operators for the tests: each answers the questions of a session in its own way."""

import asyncio
from collections.abc import Callable

from tests.helpers.domain import asking
from tests.helpers.domain.asking import question
from tests.helpers.machine import HANGS_S
from tests.unit.service.sessions.tracker.fakes import FakeCell
from truepose.domain.ledger import LedgerEntry
from truepose.domain.session import SessionPlan, SessionState
from truepose.messages.catalogue import english
from truepose.sessions.tracker.runner import TrackerRunner

_TURNS_WITHOUT_CHANGE = 2000  # of the event loop; a session that waits longer waits for nobody


class PatientOperator:
    """Confirms and resumes whatever is asked, at most `patience` times; then ends the session.

    Looks for a question every `look_s`; at 0 in every turn of the event loop, which keeps a processor busy.
    """

    def __init__(self, patience: int = 3, *, look_s: float = 0.0) -> None:
        self._patience = patience
        self._look_s = look_s
        self.questions: list[str] = []
        self.before_answer: Callable[[str], None] | None = None

    async def attend(self, runner: TrackerRunner, running: asyncio.Task[SessionState]) -> SessionState:
        while not running.done():
            await asyncio.sleep(self._look_s)
            if runner.prompt is None or runner.state not in (
                SessionState.PAUSED,
                SessionState.AWAITING_CONFIRMATION,
            ):
                continue
            await self._answer(runner)
        return running.result()

    async def attend_from_the_start(self, runner: TrackerRunner) -> SessionState:
        """Run a session and answer what it asks."""
        async with asyncio.timeout(HANGS_S):
            return await self.attend(runner, asyncio.create_task(runner.run()))

    async def _answer(self, runner: TrackerRunner) -> None:
        asked = english(question(runner))
        self.questions.append(asked)
        if self.before_answer is not None:
            self.before_answer(asked)
        if len(self.questions) > self._patience:
            await asking.end(runner, "Eva")
        elif runner.state is SessionState.PAUSED:
            await asking.resume(runner, "Eva")
        else:
            await asking.confirm(runner, "Eva")


async def run_session(
    cell: FakeCell,
    plan: SessionPlan,
    operator: PatientOperator | None = None,
    entries: tuple[LedgerEntry, ...] = (),
) -> SessionState:
    runner = TrackerRunner(plan, cell.cell, cell.journal, entries)
    return await (operator or PatientOperator()).attend_from_the_start(runner)


async def begun(cell: FakeCell, plan: SessionPlan) -> tuple[TrackerRunner, asyncio.Task[SessionState]]:
    """Begin a session, and return it with its task once it asks its first question."""
    runner = TrackerRunner(plan, cell.cell, cell.journal)
    running = asyncio.create_task(runner.run())
    await until(lambda: runner.prompt is not None)
    return runner, running


async def until(condition: Callable[[], bool], turns: int = _TURNS_WITHOUT_CHANGE) -> None:
    """Let other tasks run until `condition` holds; fails where it never does."""
    for _ in range(turns):
        if condition():
            return
        await asyncio.sleep(0)
    raise AssertionError("the session never came to that")
