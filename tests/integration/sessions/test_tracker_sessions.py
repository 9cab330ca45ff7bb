"""Who runs a tracker session, and what becomes of the devices and of what follows its end."""

import asyncio
import logging

import pytest

from tests.helpers.ballbar.cells import domain_cell
from tests.helpers.domain.tracker_sessions import entered
from tests.helpers.machine import HANGS_S
from tests.integration.sessions.scenes import Surroundings
from truepose.domain.errors import RecordRefusedError
from truepose.domain.session import PlannedStop, SessionPlan, SessionState
from truepose.messages.catalogue import english
from truepose.sessions.engine.commands import CommandName, CommandOutcome, OperatorCommand
from truepose.sessions.engine.prompts import Prompt
from truepose.sessions.engine.states import Moment
from truepose.sessions.errors import NotNowError
from truepose.sessions.service import SessionService
from truepose.sessions.tracker.service import TrackerSessions
from truepose.storage.errors import ServerAwayError
from truepose.storage.ledger.added_stops import AddedStopsRepository
from truepose.storage.records import RequestKey, SessionSetup

_PLAN = SessionPlan("calibration", tuple(PlannedStop(k, (0.1 * k, *(0.2,) * 5), 1) for k in (1, 2)))


class FakeRunner:
    """Asks its question at once, or says why it is refused, and runs until it is told how it ends."""

    robot = None

    def __init__(self, trouble=None):
        self.trouble = trouble
        self.cause_of_trouble = None if trouble is None else ServerAwayError(trouble)
        self.prompt = None if trouble else Prompt(1, "Is the cell clear?", CommandName.CONFIRM)
        self.state = SessionState.PLANNED if trouble else SessionState.AWAITING_CONFIRMATION
        self.version = 0
        self.outcome = None if trouble else CommandOutcome(self.prompt.message, None)
        self._ended = asyncio.Event()
        self.leaves, self.may_leave = asyncio.Event(), asyncio.Event()
        self.may_leave.set()

    @property
    def moment(self):
        return Moment(self.state, "", self.prompt, self.trouble, robot_moving=False)

    async def ask(self, act):
        return self.outcome

    async def run(self):
        try:
            await self._ended.wait()
        finally:
            self.leaves.set()
            await self.may_leave.wait()
        return self.state

    def ends(self, state):
        self.state = state
        self._ended.set()


class Scene(Surroundings):
    """A desk on a real database, fake devices, and the runners that it was given."""

    def __init__(self, database):
        super().__init__(database, "tracker")
        self.trouble = None
        self.followed = []
        self.failure = None
        self.desk = SessionService(self.sessions, self.ledger, self.rack)
        additions = AddedStopsRepository(database)
        self.tracker = TrackerSessions(self.desk, additions, self.follow, self.make_runner)

    def make_runner(self, plan, cell, ledger, entries):
        self.runners.append(FakeRunner(self.trouble))
        return self.runners[-1]

    async def follow(self, session_id):
        self.followed.append(session_id)
        if self.failure is not None:
            raise self.failure

    async def planned(self):
        return await self.sessions.add("left arm", SessionSetup(domain_cell()), _PLAN)

    async def start(self, session_id):
        """Have Ada start a session; returns what it asks."""
        await self.desk.act(session_id, OperatorCommand(CommandName.START, "Ada"))
        return self.runners[-1].moment.prompt.message

    async def idle(self):
        async with asyncio.timeout(HANGS_S):
            while self.desk.now is not None:
                await asyncio.sleep(0.001)

    @property
    def held_by(self):
        return self.rack.status("robot").session_id


@pytest.fixture
async def scene(database):
    opened = Scene(database)
    yield opened
    await opened.desk.close()


async def test_a_session_whose_question_cannot_be_kept_is_not_started(scene):
    session_id, scene.trouble = await scene.planned(), "The server is away."

    with pytest.raises(
        ServerAwayError, match=rf"Session {session_id} was not started\. The server is away\."
    ):
        await scene.start(session_id)

    assert (scene.desk.now, scene.held_by) == (None, None)
    scene.trouble = None
    assert await scene.start(session_id) == "Is the cell clear?"
    assert scene.held_by == session_id


@pytest.mark.parametrize(("end", "followed"), [(SessionState.FINISHED, True), (SessionState.ABORTED, False)])
async def test_only_what_finished_is_followed_and_the_devices_are_free_by_then(scene, end, followed):
    session_id = await scene.planned()
    await scene.start(session_id)

    scene.runners[0].ends(end)
    await scene.idle()

    assert scene.followed == ([session_id] if followed else [])
    assert scene.held_by is None


async def test_what_fails_after_the_end_is_in_the_log_and_stops_nobody(scene, caplog):
    first, second = await scene.planned(), await scene.planned()
    scene.failure = KeyError("langid")
    await scene.start(first)

    scene.runners[0].ends(SessionState.FINISHED)
    await scene.idle()

    assert "the follow-up of session 1 failed" in caplog.text
    assert await scene.start(second) == "Is the cell clear?"


async def test_what_was_under_way_awaits_a_person_and_what_was_planned_stays_so(scene):
    running, planned = await scene.planned(), await scene.planned()
    await scene.ledger.append(running, entered(SessionState.AWAITING_CONFIRMATION, "asked"))
    await scene.ledger.append(running, entered(SessionState.RUNNING, "confirmed", "Ada", time_s=7.0))

    await scene.desk.recover()

    found = await scene.sessions.get(running)
    assert (found.state, scene.runners) == (SessionState.AWAITING_CONFIRMATION, [])
    assert "restarted" in english(found.reason)
    assert (await scene.sessions.get(planned)).state is SessionState.PLANNED
    assert (await scene.ledger.whole(running))[-1].entry.time_s == 7.0


async def test_a_halt_that_holds_is_answered_although_its_answer_cannot_be_kept(scene, monkeypatch):
    session_id, pause = await scene.planned(), OperatorCommand(CommandName.PAUSE, "Ada")
    await scene.start(session_id)
    holds = CommandOutcome("The session pauses, and that is on record later.", None)

    async def refuse(session_id, key, answer):
        raise RecordRefusedError("The disk is full.")

    monkeypatch.setattr(scene.ledger, "keep_answer", refuse)
    scene.runners[-1].outcome = holds

    for _ in range(2):  # a client that gets no answer asks again
        answer = await scene.desk.act(session_id, pause, RequestKey("tap-1", "pause"))
        assert answer.sentence == holds.sentence
    scene.runners[-1].outcome = CommandOutcome("Done.", 7)
    with pytest.raises(RecordRefusedError):
        await scene.desk.act(session_id, pause, RequestKey("tap-2", "pause"))


async def test_a_service_that_cannot_write_ends_all_the_same(scene, caplog, monkeypatch):
    session_id = await scene.planned()
    await scene.ledger.append(session_id, entered(SessionState.RUNNING, "confirmed", "Ada"))

    async def refuse(session_id, entry):
        raise RecordRefusedError("The disk is full.")

    monkeypatch.setattr(scene.ledger, "append", refuse)
    with caplog.at_level(logging.WARNING):
        await scene.desk.close()

    assert "left as they are: The disk is full." in caplog.text


async def test_whoever_is_cancelled_while_a_session_stops_is_cancelled_and_the_session_stops_in_peace(scene):
    await scene.start(await scene.planned())
    runner = scene.runners[-1]
    runner.may_leave.clear()
    closing = asyncio.create_task(scene.desk.close())
    await runner.leaves.wait()

    closing.cancel()
    await asyncio.wait({closing})
    assert closing.cancelled()
    assert scene.held_by is not None  # it still lets go of its devices
    runner.may_leave.set()
    await scene.idle()

    assert scene.held_by is None


async def test_only_a_planned_session_starts(scene):
    session_id = await scene.planned()
    await scene.ledger.append(session_id, entered(SessionState.ABORTED, "ended"))

    with pytest.raises(NotNowError, match=r"Session 1 is aborted; only a planned session can be started\."):
        await scene.start(session_id)
    assert scene.runners == []
