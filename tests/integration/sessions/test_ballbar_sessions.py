"""Who runs a ballbar session, and what becomes of the devices and of requests when something goes wrong."""

import asyncio
from dataclasses import replace

import pytest

from tests.helpers.ballbar.cells import domain_cell
from tests.helpers.ballbar.sessions import make_ballbar_plan, measured
from tests.helpers.domain.tracker_sessions import entered
from tests.helpers.machine import HANGS_S
from tests.integration.sessions.scenes import Surroundings
from tests.integration.web.bench import Bench
from truepose.domain.cell import BallbarKit
from truepose.domain.ledger import EntryKind, LedgerEntry
from truepose.domain.session import SessionState
from truepose.messages.catalogue import english
from truepose.sessions.ballbar.planning import BallbarPlanRequest
from truepose.sessions.ballbar.service import NOBODY_RUNS, BallbarSessions
from truepose.sessions.ballbar.situation import situation
from truepose.sessions.devices import DeviceRegistry
from truepose.sessions.engine.commands import CommandName, CommandOutcome, OperatorCommand
from truepose.sessions.errors import DeviceInUseError, NotNowError, PlanRefusedError
from truepose.sessions.service import SessionService
from truepose.storage.errors import KeyReusedError
from truepose.storage.records import RequestKey, SessionSetup


class FakeRunner:
    """Does what the test says, and runs until it is cancelled or told to fail."""

    def __init__(self, plan, kit, cell, ledger, foresight, entries=(), judges=None):
        self.robot = cell.robot_controller
        self.situation = situation(plan, kit, entries)
        self.prompt = self.trouble = self.cause_of_trouble = None
        self.version = 0
        self.entries, self.judges = entries, judges
        self.acts = 0
        self.gate = asyncio.Event()
        self.gate.set()
        self.refusal = None
        self.failure = asyncio.Event()
        self._ledger = ledger

    async def run(self):
        await self.failure.wait()
        raise RuntimeError("the program has a mistake")

    async def changed(self, after):
        await asyncio.Event().wait()

    @property
    def state(self):
        return self.situation.state

    async def ask(self, act):
        if self.refusal is not None:
            raise self.refusal
        await self.gate.wait()
        self.acts += 1
        number = await self._ledger.append(measured("tool/initialise", 150.0, key=act.key))
        return CommandOutcome(f"Done {self.acts} times.", number)


class Scene(Surroundings):
    """A desk on a real database, fake devices, and the runners that it made."""

    def __init__(self, database):
        super().__init__(database, "ballbar")
        self.refusal = None
        self.desk, self.ballbar = self.open()

    def open(self, rack=None, choose=None):
        """Return a desk, and the ballbar sessions behind it."""
        desk = SessionService(self.sessions, self.ledger, rack or self.rack)
        return desk, BallbarSessions(desk, lambda setup: None, choose, self.make_runner)

    def make_runner(self, *pieces, **entries):
        self.runners.append(FakeRunner(*pieces, **entries))
        self.runners[-1].refusal = self.refusal
        return self.runners[-1]

    async def planned(self):
        setup = SessionSetup(domain_cell(ballbar=BallbarKit()))
        return await self.ballbar.plan("six legs", setup, BallbarPlanRequest(given=make_ballbar_plan()))

    async def act(self, session_id, name=CommandName.START, key="k"):
        act = OperatorCommand(name, "Ada", "tablet-1", key)
        return await self.desk.act(session_id, act, RequestKey(key, f"fingerprint of {name}"))


@pytest.fixture
async def scene(database):
    opened = Scene(database)
    yield opened
    await opened.desk.close()


async def test_a_start_that_is_refused_leaves_the_devices_to_others(scene):
    first, second = await scene.planned(), await scene.planned()
    scene.refusal = NotNowError("not now")

    with pytest.raises(NotNowError):
        await scene.act(first)
    scene.refusal = None

    assert (await scene.act(second, key="k2")).entry is not None


async def test_a_key_of_a_refused_act_is_free(scene):
    session_id = await scene.planned()
    scene.refusal = NotNowError("not now")
    with pytest.raises(NotNowError):
        await scene.act(session_id)
    scene.refusal = None

    assert (await scene.act(session_id)).sentence == "Done 1 times."


async def test_a_request_that_is_repeated_while_the_first_is_under_way_waits_for_its_answer(scene):
    session_id = await scene.planned()
    first = asyncio.create_task(scene.act(session_id))
    while not scene.runners:
        await asyncio.sleep(0.001)
    scene.runners[0].gate.clear()
    again = asyncio.create_task(scene.act(session_id))
    await asyncio.sleep(0.05)
    scene.runners[0].gate.set()

    assert await first == await again
    assert scene.runners[0].acts == 1


async def test_an_act_whose_tablet_is_gone_is_done_all_the_same(scene):
    session_id = await scene.planned()
    await scene.act(session_id, key="k1")
    scene.runners[0].gate.clear()
    gone = asyncio.create_task(scene.act(session_id, CommandName.STORE, key="k2"))
    await asyncio.sleep(0.05)

    gone.cancel()
    scene.runners[0].gate.set()

    answer = await scene.act(session_id, CommandName.STORE, key="k2")
    assert answer.sentence == "Done 2 times."
    assert scene.runners[0].acts == 2


async def test_an_act_of_a_session_that_runs_does_not_wait_for_what_others_prepare(scene):
    """As long as configurations are judged that somebody adds to another session, say."""
    session_id = await scene.planned()
    await scene.act(session_id, key="k1")

    async with scene.desk.turn, asyncio.timeout(HANGS_S):
        stopped = await scene.act(session_id, CommandName.STOP, key="k2")

    assert stopped.sentence == "Done 2 times."


async def test_an_entry_without_its_answer_is_not_made_again(scene):
    """As a service leaves it that is killed between the two."""
    session_id = await scene.planned()
    number = await scene.ledger.append(session_id, measured("tool/initialise", 150.0, key="k9"))

    answer = await scene.act(session_id, CommandName.STORE, key="k9")

    assert answer.entry == number
    assert scene.runners == []
    assert await scene.act(session_id, CommandName.STORE, key="k9") == answer


async def test_a_runner_that_fails_gives_the_devices_back(scene):
    first, second = await scene.planned(), await scene.planned()
    await scene.act(first)

    scene.runners[0].failure.set()
    while scene.ballbar.running(first) is not None:
        await asyncio.sleep(0.001)

    assert (await scene.act(second, key="k2")).entry is not None


@pytest.mark.parametrize("state", [SessionState.RUNNING, SessionState.PAUSING, SessionState.ABORTING])
async def test_a_session_that_nobody_runs_never_says_that_it_runs(scene, state):
    session_id = await scene.planned()
    await scene.act(session_id)
    entry = LedgerEntry("", EntryKind.CONTROL, 2.0, "Ada", text="Ada asked.", entered=state)
    await scene.ledger.append(session_id, entry)

    scene.runners[0].failure.set()
    while scene.ballbar.running(session_id) is not None:
        await asyncio.sleep(0.001)

    found = (await scene.ballbar.view(session_id)).situation
    assert found.state is SessionState.AWAITING_CONFIRMATION
    assert found.reason == NOBODY_RUNS
    assert CommandName.CONFIRM in found.acts
    await scene.act(session_id, CommandName.CONFIRM, key="k2")  # somebody runs it again
    assert scene.ballbar.running(session_id) is scene.runners[1]


async def test_what_an_earlier_service_left_is_taken_up_with_its_ledger(scene):
    session_id = await scene.planned()
    await scene.act(session_id)
    await scene.ledger.append(session_id, entered(SessionState.RUNNING, "started"))
    await scene.desk.close()

    again, ballbar = scene.open()
    await again.recover()

    assert [entry.kind for entry in scene.runners[-1].entries] == [EntryKind.MEASURED, EntryKind.CONTROL]
    assert ballbar.running(session_id) is scene.runners[-1]
    await again.close()


async def test_a_session_whose_cell_lost_its_ballbar_does_not_keep_the_service_from_starting(scene):
    session_id = await scene.planned()
    await scene.ledger.append(session_id, entered(SessionState.RUNNING, "started"))
    bare = DeviceRegistry([], Bench().clock)

    desk, ballbar = scene.open(bare)
    await desk.recover()

    (note,) = await scene.sessions.notes(session_id)
    assert "was not continued" in english(note)
    assert (await ballbar.view(session_id)).id == session_id


async def test_while_one_session_holds_the_devices_no_other_starts(scene):
    first, second = await scene.planned(), await scene.planned()
    await scene.act(first)

    with pytest.raises(DeviceInUseError, match=f"Session {first}"):
        await scene.act(second, key="k2")


async def test_the_number_of_cups_is_that_of_the_kit(scene):
    setup = SessionSetup(domain_cell(ballbar=replace(BallbarKit(), base_points=4)))

    with pytest.raises(PlanRefusedError, match="4"):
        await scene.ballbar.plan("six legs", setup, BallbarPlanRequest(given=make_ballbar_plan()))


async def test_a_plan_that_was_stored_while_another_request_looked_for_it_is_not_made_again(
    scene, monkeypatch
):
    setup, key = SessionSetup(domain_cell(ballbar=BallbarKit())), RequestKey("k", "fingerprint")
    asked, stored, look = [], asyncio.Event(), scene.sessions.answered

    async def choose(setup, wish):
        asked.append(wish)
        return make_ballbar_plan()

    async def look_and_be_slow(key):
        found = await look(key)
        await stored.wait()
        return found

    _, ballbar = scene.open(choose=choose)
    monkeypatch.setattr(scene.sessions, "answered", look_and_be_slow)
    second = asyncio.create_task(ballbar.plan("six legs", setup, BallbarPlanRequest(), key))
    await asyncio.sleep(0.05)
    monkeypatch.setattr(scene.sessions, "answered", look)
    first = await ballbar.plan("six legs", setup, BallbarPlanRequest(), key)
    stored.set()

    assert await second == first
    assert len(asked) == 1


async def test_a_plan_that_is_asked_for_again_while_it_is_made_is_made_once(scene):
    setup, key = SessionSetup(domain_cell(ballbar=BallbarKit())), RequestKey("k", "fingerprint")
    asked, gate = [], asyncio.Event()

    async def choose(setup, wish):
        asked.append(wish)
        await gate.wait()
        return make_ballbar_plan()

    _, ballbar = scene.open(choose=choose)
    requests = [
        asyncio.create_task(ballbar.plan("six legs", setup, BallbarPlanRequest(), key)) for _ in range(2)
    ]
    while not asked:
        await asyncio.sleep(0.001)
    requests[0].cancel()  # its tablet gave up waiting
    gate.set()

    number = await requests[1]
    assert await ballbar.plan("six legs", setup, BallbarPlanRequest(), key) == number
    assert len(asked) == 1
    with pytest.raises(KeyReusedError):
        await ballbar.plan("other", setup, BallbarPlanRequest(), replace(key, fingerprint="other"))
