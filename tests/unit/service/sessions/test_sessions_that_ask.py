"""Sessions that are started wait for their question, and what is kept of sessions does not grow for ever."""

import asyncio
from types import SimpleNamespace

import pytest

from tests.helpers.machine import HANGS_S
from truepose.domain.errors import RecordRefusedError
from truepose.domain.session import SessionState
from truepose.sessions.ballbar import service as ballbar
from truepose.sessions.engine.states import Moment
from truepose.sessions.followers import TabletCounter
from truepose.sessions.kind_service import UnattendedSessionService


class Runner:
    """Asks once it is told to, and counts who looks."""

    def __init__(self):
        self.looks = self.version = 0
        self.cause_of_trouble = None
        self.state, self.prompt = SessionState.PLANNED, None
        self._changed = asyncio.Event()

    @property
    def moment(self):
        self.looks += 1
        return Moment(self.state, "", self.prompt, None, robot_moving=False)

    async def changed(self, after):
        while self.version <= after:
            await self._changed.wait()
        return self.version

    def tell(self, **news):
        for name, value in news.items():
            setattr(self, name, value)
        self.version += 1
        self._changed.set()
        self._changed = asyncio.Event()


class Kind(UnattendedSessionService):
    """One session, under way until it is released."""

    def __init__(self, runner):
        self.now = runner
        self.watching = TabletCounter()
        super().__init__(SimpleNamespace(serve=lambda kind: None, watching=self.watching))

    def running(self, session_id):
        return self.now

    async def runner(self, record, setup, ledger):
        raise NotImplementedError

    async def stored_plan(self, session_id):
        raise NotImplementedError


async def starting(kind):
    task = asyncio.create_task(kind.begun(1, kind.now))
    await asyncio.sleep(0.2)
    assert not task.done()
    return task


async def test_whoever_starts_a_session_waits_for_its_question_and_looks_at_news_only():
    kind = Kind(runner := Runner())
    task = await starting(kind)
    assert runner.looks == 1

    runner.tell(prompt="Is the cell clear?")  # and the state once the journal has it
    await asyncio.sleep(0)
    runner.tell(state=SessionState.AWAITING_CONFIRMATION)
    await asyncio.wait_for(task, HANGS_S)

    assert runner.looks <= 3


async def test_a_question_that_cannot_be_put_on_record_is_no_start():
    kind = Kind(runner := Runner())
    task = await starting(kind)

    runner.tell(cause_of_trouble=RecordRefusedError("disk full"))

    with pytest.raises(RecordRefusedError, match="was not started"):
        await asyncio.wait_for(task, HANGS_S)


async def test_nobody_waits_for_a_session_that_is_over():
    kind = Kind(Runner())
    task = await starting(kind)

    kind.now = None
    kind.watching.tell()
    await asyncio.wait_for(task, HANGS_S)

    assert task.done()


async def test_of_ballbar_sessions_the_last_ones_and_the_one_under_way_are_remembered(monkeypatch):
    async def found(number):
        cell = SimpleNamespace(ballbar="a kit")
        return SimpleNamespace(name=f"session {number}", role="ballbar", cell=cell)

    monkeypatch.setattr(ballbar, "Sight", lambda setup, plan, kit: None)
    sessions = SimpleNamespace(get=found, setup=found, ballbar_plan=found)
    desk = SimpleNamespace(
        serve=lambda kind: None,
        sessions=sessions,
        ledger=None,
        rack=None,
        note=None,
        under_way=lambda number: number == 1 or None,
    )
    kind = ballbar.BallbarSessions(desk, None, None)

    for number in range(1, 41):
        assert (await kind._what_is_fixed(number)).name == f"session {number}"

    assert [*kind._fixed] == [1, *range(33, 41)]
