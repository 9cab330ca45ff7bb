"""Records are appended or superseded, never changed."""

import asyncio
import functools
import threading
from dataclasses import replace

import pytest
from sqlalchemy import select, text

from tests.helpers.ballbar.sessions import make_ballbar_plan
from tests.helpers.domain.tracker_sessions import (
    entered,
    fixed_nest_taken,
    make_fixed_nest,
    make_plan,
    make_point,
    make_setup,
    point_taken,
)
from truepose.domain.ledger import EntryKind, LedgerEntry
from truepose.domain.session import PlannedStop, Progress, SessionState, StopSkipped
from truepose.storage import tables
from truepose.storage.errors import ConflictError, KeyReusedError, NotFoundError
from truepose.storage.ledger.added_stops import AddedStopsRepository
from truepose.storage.ledger.entries import LedgerRepository
from truepose.storage.ledger.sessions import SessionRepository
from truepose.storage.ledger.tracker_readings import ReadingRepository
from truepose.storage.record_insertion import EventRepository
from truepose.storage.records import AddedStops, JobKind, JobState, Page, RequestKey
from truepose.storage.results.jobs import JobRepository
from truepose.storage.results.models import ResultRepository


@pytest.fixture
def sessions(database):
    return SessionRepository(database)


@pytest.fixture
def readings(database):
    return ReadingRepository(database)


@pytest.fixture
async def keep(sessions, database):
    """Return what keeps lines of a session that was planned."""
    number = await sessions.add("first", make_setup(), make_plan())
    return functools.partial(LedgerRepository(database).append, number)


async def test_a_session_comes_back_as_it_was_planned(sessions):
    number = await sessions.add("first", make_setup(), make_plan(3))

    record = await sessions.get(number)

    assert (record.name, record.role, record.state) == ("first", "calibration", SessionState.PLANNED)
    assert (record.planned, record.measured, record.skipped) == (3, 0, 0)
    assert await sessions.plan(number) == make_plan(3)
    assert await sessions.setup(number) == make_setup()


async def test_the_ledger_tells_what_happened_in_order(keep, sessions, database):
    await keep(entered(SessionState.RUNNING, "started", "Ada"))
    await keep(point_taken(make_point()))
    await keep(LedgerEntry("stop-2", EntryKind.SKIPPED, 30.0, text="no reflector"))
    progress = Progress(1, 1, 2, 30.0, None, "ending")
    await keep(LedgerEntry("fixed-nests", EntryKind.BEGUN, 30.0, progress=progress))
    await keep(entered(SessionState.FINISHED, "all stops visited"))

    told = await EventRepository(database).after(Page())
    record = await sessions.get(1)

    assert [event.kind for event in told] == [
        "session.state",
        "session.state",
        "session.reading",
        "session.stop_skipped",
        "session.progress",
        "session.state",
    ]
    assert told[2].document["reading_id"] == 1
    assert await sessions.skipped(1) == [StopSkipped(2, 30.0, "no reflector")]
    assert (record.state, record.measured, record.skipped) == (SessionState.FINISHED, 1, 1)
    assert [change.person for change in await sessions.states(1)] == [None, "Ada", None]
    assert (await sessions.progress(1)).skipped == 1


async def test_a_stop_read_again_supersedes_and_keeps_the_first_reading(keep, readings):
    await keep(point_taken(make_point(x_mm=1.0)))
    await keep(point_taken(make_point(x_mm=2.0)))

    kept = await readings.get(1)
    counting = await readings.points(1)

    assert kept.superseded_by == 2
    assert kept.reading == make_point(x_mm=1.0)
    assert counting == [make_point(x_mm=2.0)]


async def test_every_look_at_a_fixed_nest_counts(keep, readings):
    await keep(fixed_nest_taken(make_fixed_nest(5.0)))
    await keep(fixed_nest_taken(make_fixed_nest(6.0)))

    assert [r.time_s for r in await readings.fixed_nests(1)] == [5.0, 6.0]
    assert await readings.points(1) == []


@pytest.mark.parametrize(
    "change",
    ["UPDATE readings SET time_s = 0", "DELETE FROM readings", "UPDATE session_states SET state = 'x'"],
)
async def test_the_database_itself_refuses_to_change_a_record(keep, database, change):
    await keep(point_taken(make_point()))

    with pytest.raises(ConflictError, match="never changed"):
        await database.write(lambda c: c.execute(text(change)))


async def test_a_request_sent_twice_with_one_key_makes_one_session(sessions):
    key = RequestKey("a-1", "fingerprint")

    first = await sessions.add("first", make_setup(), make_plan(), key)
    again = await sessions.add("first", make_setup(), make_plan(), key)

    assert again == first
    assert len(await sessions.page(Page())) == 1


async def test_a_key_with_another_request_is_refused(sessions):
    await sessions.add("first", make_setup(), make_plan(), RequestKey("a-1", "one"))

    with pytest.raises(KeyReusedError, match="'a-1'"):
        await sessions.add("other", make_setup(), make_plan(), RequestKey("a-1", "two"))


async def test_a_job_that_has_ended_stays_as_it_ended(database):
    jobs = JobRepository(database)
    number = await jobs.add(JobKind.IDENTIFICATION, {"campaign_id": 1})
    await jobs.change_state(number, JobState.CANCELLED, "by request")

    with pytest.raises(ConflictError, match=r"Job 1 has already been cancelled\."):
        await jobs.change_state(number, JobState.RUNNING, "late")

    assert (await jobs.get(number)).state is JobState.CANCELLED


async def test_a_running_job_says_how_far_it_is(database):
    jobs = JobRepository(database)
    number = await jobs.add(JobKind.PLAN, {})
    await jobs.change_state(number, JobState.RUNNING, "started")
    await jobs.tell_progress(number, 0.4, "exchanging configurations")

    record = await jobs.get(number)

    assert (record.fraction, record.message) == (0.4, "exchanging configurations")


async def test_a_session_knows_what_its_plan_was_asked_for(sessions, database):
    jobs, results = JobRepository(database), ResultRepository(database)
    given = await sessions.add("given", make_setup(), make_plan())
    asked = {"method": "iso9283", "role": "validation"}
    job = await jobs.add(JobKind.PLAN, asked)
    identified = await jobs.add(JobKind.IDENTIFICATION, {"campaign_id": 1})
    chosen = await results.keep_plan(job, "chosen", make_setup(), make_plan())
    await jobs.change_state(identified, JobState.CANCELLED, "not wanted")

    assert await jobs.plans_of([given, chosen]) == {chosen: asked}
    assert await jobs.plans_of([]) == {}


async def test_only_a_test_with_the_ballbar_is_named_so(sessions):
    identifies = await sessions.add("first", make_setup(), make_ballbar_plan())
    sphere = await sessions.add("second", make_setup(), replace(make_ballbar_plan(), test="sphere"))
    tracker = await sessions.add("third", make_setup(), make_plan())

    tests = [(await sessions.get(number)).test for number in (identifies, sphere, tracker)]

    assert tests == [None, "sphere", None]


async def test_the_head_of_a_chain_moves_with_its_own_session_alone(sessions, keep):
    other = await sessions.add("other", make_setup(), make_plan())
    first, second = [await sessions.chain_head(number) for number in (1, other)]

    await keep(entered(SessionState.RUNNING, "started", "Ada"))

    assert len(first) == 64
    assert await sessions.chain_head(1) != first
    assert await sessions.chain_head(other) == second
    assert await sessions.chain_head(99) == ""


async def test_what_is_not_there_is_named(sessions, readings):
    with pytest.raises(NotFoundError, match=r"There is no session 7\."):
        await sessions.get(7)
    with pytest.raises(NotFoundError, match=r"There is no reading 8\."):
        await readings.get(8)


async def test_a_job_whose_end_is_being_written_is_not_interrupted(database):
    jobs, may_write = JobRepository(database), threading.Event()
    ending, open_still = [await jobs.add(JobKind.IDENTIFICATION, {}) for _ in range(2)]
    busy = asyncio.create_task(database.write(lambda _: may_write.wait(10)))
    ends = asyncio.create_task(jobs.change_state(ending, JobState.SUCCEEDED, ""))
    await asyncio.sleep(0)

    interrupts = asyncio.create_task(jobs.interrupt("The service was stopped."))
    await asyncio.wait({interrupts}, timeout=0.05)  # time for a look that is not part of the writing
    may_write.set()
    await asyncio.gather(busy, ends, interrupts)

    states = [(await jobs.get(number)).state for number in (ending, open_still)]
    assert states == [JobState.SUCCEEDED, JobState.INTERRUPTED]


async def test_pages_follow_each_other(sessions):
    for name in "abc":
        await sessions.add(name, make_setup(), make_plan())

    first = await sessions.page(Page(limit=2))
    rest = await sessions.page(Page(after=first[-1].id))

    assert [record.name for record in (*first, *rest)] == ["a", "b", "c"]


async def test_what_a_person_adds_follows_the_plan_which_stays_as_it_was(sessions, database):
    number = await sessions.add("first", make_setup(), make_plan(2))
    additions = AddedStopsRepository(database)
    more = tuple(PlannedStop(config, (0.1 * config, 0.2), 1) for config in (3, 4))
    again = (PlannedStop(5, (0.1, 0.0), 1, repeat_of=1),)

    await additions.add(AddedStops(number, "Ada", more))
    await additions.add(AddedStops(number, "Eva", again))

    told = [e for e in await EventRepository(database).after(Page()) if e.kind == "session.stops_added"]
    assert (await sessions.plan(number)).stops == make_plan(2).stops + more + again
    assert (await sessions.get(number)).planned == 5
    assert [event.document["person"] for event in told] == ["Ada", "Eva"]
    stored = await database.read(lambda c: c.scalar(select(tables.sessions.c.plan)))
    assert len(stored["stops"]) == 2


async def test_an_addition_sent_twice_is_kept_once(sessions, database):
    number, key = await sessions.add("first", make_setup(), make_plan(2)), RequestKey("tap", "fingerprint")
    additions = AddedStopsRepository(database)
    added = AddedStops(number, "Ada", (PlannedStop(3, (0.3, 0.2), 1),))

    assert await additions.answered(key) is None
    await additions.add(added, key)
    await additions.add(added, key)

    assert await additions.answered(key) == added
    assert (await sessions.get(number)).planned == 3
    with pytest.raises(KeyReusedError):
        await additions.answered(RequestKey("tap", "another"))
