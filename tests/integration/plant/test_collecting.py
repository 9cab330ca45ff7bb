"""A plant collects from its cells once and in order, whatever ends, repeats, jumps or is changed."""

import json
import sqlite3
from datetime import UTC, datetime, timedelta

import httpx
import pytest

from tests.integration.plant.conftest import restored_from_an_older_copy
from truepose.plant import collector as visiting
from truepose.storage.errors import ConflictError, TamperedRecordError
from truepose.storage.integrity.hash_chain import GENESIS, linked_hash
from truepose.storage.integrity.verification import verify
from truepose.storage.plant import cells, journal
from truepose.storage.plant.deployments import HandDownRepository, HandedDownRepository
from truepose.storage.plant.records import (
    CollectedLink,
    HandDown,
    HandDownKind,
    HandDownState,
    Outcome,
    Visit,
)
from truepose.storage.records import Page
from truepose.web.api import chain


class Killed(Exception):  # noqa: N818  # the process is gone; nothing here catches it
    """What happens at this point happens no more."""


class Between(httpx.AsyncBaseTransport):
    """Stands between plant and cell and changes the pages that come."""

    def __init__(self, cell, change):
        self._transport, self._change = cell.transport, change
        self.asked = []

    async def handle_async_request(self, request):
        self.asked.append(str(request.url))
        answer = await self._transport.handle_async_request(request)
        body = await answer.aread()
        if request.url.path.endswith("/chain/links"):
            body = self._change(body)
        return httpx.Response(answer.status_code, content=body)


class Cut(httpx.AsyncBaseTransport):
    """Stands for a network without a cell."""

    async def handle_async_request(self, request):
        raise httpx.ConnectError("no route to host", request=request)


def lines_changed(change):
    """Return what changes the links of a page, its last line left alone."""

    def changed(body):
        *links, end = [json.loads(line) for line in body.splitlines()]
        return "\n".join(json.dumps(line) for line in [*change(links), end]).encode()

    return changed


@pytest.fixture(autouse=True)
def small_pages(monkeypatch):
    monkeypatch.setattr(visiting, "_LINKS", 4)


def numbers(kept):
    return [link for _, link, *_ in kept]


async def test_everything_is_collected_once_and_in_order(plant, cell):
    await cell.measure()

    found = await plant.visit(cell)

    newest = await cell.newest()
    assert (found.outcome, found.collected, found.sentence) == (Outcome.WHOLE, newest, "")
    assert numbers(await plant.kept()) == [*range(1, newest + 1)]
    assert found.head == (await cell.database.head()).text


async def test_a_further_visit_brings_what_came_since_and_nothing_twice(plant, cell):
    await cell.measure()
    await plant.visit(cell)
    before = await cell.newest()
    await cell.measure(name="second")

    found = await plant.visit(cell)
    again = await plant.visit(cell)

    assert found.collected == await cell.newest() - before
    assert (again.outcome, again.collected) == (Outcome.WHOLE, 0)
    assert numbers(await plant.kept()) == [*range(1, await cell.newest() + 1)]


@pytest.mark.parametrize("nth", [1, 2, 3])
@pytest.mark.parametrize(
    ("room", "point"),
    [
        (visiting, "verify_page"),  # received
        (journal, "position"),  # verified; the transaction has begun
        (journal, "project"),  # rows are in the transaction
        (journal, "newest_branch"),  # before anything
    ],
)
async def test_a_plant_that_is_killed_anywhere_goes_on_where_it_was(
    open_plant, cell, monkeypatch, room, point, nth
):
    await cell.measure()
    left, true = [nth], getattr(room, point)

    def dies(*given):
        left[0] -= 1
        if left[0] == 0:
            raise Killed
        return true(*given)

    with open_plant() as plant:
        await plant.journal.enter("left arm")
        with monkeypatch.context() as patched, pytest.raises(Killed):
            patched.setattr(room, point, dies)
            for _ in range(4):  # what is asked for once a visit dies in a later one
                await plant.visit(cell)
    with open_plant() as plant:
        await plant.visit(cell)

        assert numbers(await plant.kept()) == [*range(1, await cell.newest() + 1)]


async def test_a_plant_killed_after_its_commit_has_the_page_and_asks_for_the_next(
    open_plant, cell, monkeypatch
):
    await cell.measure()
    true = journal.JournalRepository.keep

    async def dies(self, *given):
        await true(self, *given)
        raise Killed

    with open_plant() as plant, monkeypatch.context() as patched, pytest.raises(Killed):
        patched.setattr(journal.JournalRepository, "keep", dies)
        await plant.visit(cell)
    with open_plant() as plant:
        assert await plant.position() == 4
        await plant.visit(cell)
        assert numbers(await plant.kept()) == [*range(1, await cell.newest() + 1)]


@pytest.mark.parametrize(
    "change",
    [
        lambda links: [*links, *links],
        lambda links: links[::-1],
        lambda links: links[1:],
        lambda links: [links[0], *links],
        lambda links: [links[1], links[0], *links[2:]],
        lambda links: [link | {"link": str(link["link"])} for link in links],
        lambda links: [link | {"hash": "00"} for link in links],
        lambda links: [[]],
    ],
)
async def test_a_page_that_repeats_or_reorders_is_refused_and_comes_right_later(plant, cell, change):
    await cell.measure()

    refused = await plant.visit(cell, transport=Between(cell, lines_changed(change)))
    assert refused.outcome in {Outcome.REFUSED, Outcome.UNREACHABLE}
    assert await plant.kept() == []

    await plant.visit(cell)
    assert numbers(await plant.kept()) == [*range(1, await cell.newest() + 1)]


async def test_the_same_page_kept_twice_is_refused(plant, cell):
    await cell.measure()
    await plant.visit(cell)
    seen = []

    def noted(links):
        seen.extend(links)
        return links

    known = await plant.journal.collected(await plant.journal.reached("left arm"))
    await cell.measure(name="second")
    await plant.visit(cell, transport=Between(cell, lines_changed(noted)))
    links, _ = visiting.verify_page(seen[:4], known.position, known.heads)

    with pytest.raises(ConflictError):
        await plant.journal.keep(known.branch, links, None)


@pytest.mark.parametrize("cut", [2, 50, 1000])
async def test_a_page_that_was_cut_off_is_none(plant, cell, cut):
    await cell.measure()

    found = await plant.visit(cell, transport=Between(cell, lambda body: body[:-cut]))

    assert found.outcome is Outcome.UNREACHABLE
    assert await plant.kept() == []


async def test_a_record_that_was_changed_is_refused_and_named(plant, cell):
    number = await cell.measure()

    def change(links):
        return [_with_another_name(link) if link["record"] == "sessions" else link for link in links]

    found = await plant.visit(cell, transport=Between(cell, lines_changed(change)))

    assert found.outcome is Outcome.REFUSED
    assert found.sentence.startswith(f"Record {number} of the sessions (link ")
    assert await plant.position() < found.newest


def _with_another_name(link):
    return link | {"row": link["row"] | {"name": "another"}}


@pytest.mark.parametrize("moved", [{"record_id": 2}, {"stream": 2}])
def test_a_session_told_without_its_secret_is_still_that_of_its_link(moved):
    told = {"id": 1, "recorded_at": "2026", "name": "first", "role": "calibration", "setup": "{}"}
    line = {"link": 1, "stream": 1, "record": "sessions", "record_id": 1, "hash": "00" * 32, "told": told}

    (link,), _ = visiting.verify_page([line], 0, {})

    assert not link.verified
    with pytest.raises(TamperedRecordError, match=r"of the sessions .* is not as"):
        visiting.verify_page([line | moved], 0, {})


@pytest.mark.parametrize("record", ["readings", "sessions"])
async def test_a_record_that_is_kept_back_is_refused_and_named(plant, cell, record):
    await cell.measure()

    def keep_back(links):
        return [
            {name: value for name, value in link.items() if name != "row" or link["record"] != record}
            for link in links
        ]

    found = await plant.visit(cell, transport=Between(cell, lines_changed(keep_back)))

    assert found.outcome is Outcome.REFUSED
    assert f"of the {record} " in found.sentence


async def test_a_record_changed_in_the_cells_database_is_refused_and_named(plant, open_cell, tmp_path):
    async with open_cell() as cell:
        await cell.measure()
    with sqlite3.connect(tmp_path / "cell" / "truepose.sqlite3") as raw:
        raw.execute("DROP TRIGGER readings_no_update")
        raw.execute("UPDATE readings SET time_s = time_s + 1 WHERE id = 2")
    raw.close()
    async with open_cell() as cell:
        found = await plant.visit(cell)

    assert found.sentence.startswith("Record 2 of the readings (link ")
    assert "truepose verify" in found.sentence


async def test_a_cell_away_for_a_week_loses_nothing_and_measures_alone(plant, cell, monkeypatch):
    await cell.measure()
    await plant.visit(cell)
    for day in range(1, 8):
        away = datetime(2026, 5, 4, tzinfo=UTC) + timedelta(days=day)
        monkeypatch.setattr(chain, "wall_time", lambda now=away: now)
        await cell.measure(name=f"day {day}")
        found = await plant.visit(cell, transport=Cut(), wall_time=lambda now=away: now)
        assert (found.outcome, found.newest) == (Outcome.UNREACHABLE, None)

    back = await plant.visit(cell)

    assert back.outcome is Outcome.WHOLE
    assert numbers(await plant.kept()) == [*range(1, await cell.newest() + 1)]
    outcomes = [record.visit.outcome for record in await plant.visits.of("left arm", 10)]
    assert outcomes == [Outcome.WHOLE, Outcome.UNREACHABLE, Outcome.WHOLE]  # one silence, said once


async def test_a_visit_that_finds_the_same_is_remembered_and_not_kept(plant, cell, monkeypatch):
    await cell.measure()
    await plant.visit(cell)
    for day in range(1, 8):
        monkeypatch.setattr(cells, "_now", lambda now=f"2026-05-1{day}": now)
        await plant.visit(cell)

    (kept,) = await plant.visits.of("left arm", 10)

    assert kept.found_at == "2026-05-17"
    assert kept == (await plant.visits.newest())["left arm"]


async def test_a_plant_started_beside_a_cell_that_is_away_looks_through_no_chain(
    open_plant, cell, monkeypatch
):
    def looked_through(*given):
        raise Killed

    await cell.measure()
    with open_plant() as plant:
        before = await plant.visit(cell)
    monkeypatch.setattr(journal, "heads", looked_through)
    with open_plant() as plant:
        found = await plant.visit(cell, transport=Cut())

        assert found.outcome is Outcome.UNREACHABLE
        newest, first = await plant.visits.of("left arm", 10)
        assert newest.visit.head == first.visit.head == before.head


@pytest.mark.parametrize("years", [-10, 10])
@pytest.mark.parametrize("side", ["cell", "plant"])
async def test_clocks_that_jump_are_measured_and_put_nothing_out_of_order(
    plant, cell, monkeypatch, noon, side, years
):
    jumped = noon + timedelta(days=3652.5 * years / 10)
    of_cell, of_plant = (jumped, noon) if side == "cell" else (noon, jumped)
    monkeypatch.setattr(chain, "wall_time", lambda: noon)
    await cell.measure()
    await plant.visit(cell, wall_time=lambda: noon)
    monkeypatch.setattr(chain, "wall_time", lambda: of_cell)
    await cell.measure(name="second")

    found = await plant.visit(cell, wall_time=lambda: of_plant)

    assert found.outcome is Outcome.WHOLE
    off_s = (of_cell - of_plant).total_seconds()
    assert abs(found.clock.offset_s - off_s) <= found.clock.bound_s
    assert numbers(await plant.kept()) == [*range(1, await cell.newest() + 1)]
    newest, first = [record.visit.clock for record in await plant.visits.of("left arm", 10)]
    assert abs(newest.offset_s - off_s) < 60 < abs(newest.offset_s - first.offset_s)


async def test_two_plants_collect_the_same_cell_and_neither_sees_the_other(open_plant, cell):
    await cell.measure()
    with open_plant("one") as one, open_plant("other") as other:
        await one.visit(cell)
        await cell.measure(name="second")
        await other.visit(cell)
        await one.visit(cell)

        assert await one.kept() == await other.kept()


async def test_a_cell_of_an_older_version_is_told_to_be_renewed(plant, cell):
    class Older(httpx.AsyncBaseTransport):
        async def handle_async_request(self, request):
            return httpx.Response(404, json={"detail": "Not Found"})

    found = await plant.visit(cell, transport=Older())

    assert found.outcome is Outcome.UNREACHABLE
    assert "404" in found.sentence


async def test_a_newer_cell_with_a_table_that_nobody_knows_is_collected_and_verified(plant, cell):
    row = {"id": 1, "recorded_at": "2030-01-01T00:00:00+00:00", "colour": "red"}
    found = linked_hash(GENESIS, "later", tuple(row), tuple(row.values()))
    line = {"link": 1, "stream": 0, "record": "later", "record_id": 1, "hash": found.hex(), "row": row}

    links, _ = visiting.verify_page([line], 0, {})

    assert (links[0].record, links[0].verified) == ("later", True)


async def test_a_cell_restored_from_an_older_copy_is_not_mixed_in(open_cell, plant, tmp_path):
    async with restored_from_an_older_copy(open_cell, plant, tmp_path) as (cell, common, collected):
        found = await plant.visit(cell)
        silent = await plant.visit(cell)

        assert (found.outcome, found.fork) == (Outcome.ANOTHER_CHAIN, common)
        assert f"only the first {common} are still there unchanged" in found.sentence
        assert silent.outcome is Outcome.ANOTHER_CHAIN
        assert len(await plant.kept()) == collected

        await plant.journal.accept_other_chain("left arm", "Ada Byron", "the disk was exchanged")
        accepted = await plant.visit(cell)

        newest = await cell.newest()
        assert (accepted.outcome, accepted.collected) == (Outcome.WHOLE, newest - common)
        own = [link for branch, link, *_ in await plant.kept() if branch == 2]
        assert own == [*range(common + 1, newest + 1)]
        assert accepted.head == (await cell.database.head()).text
        sessions = await plant.looks.days_of_robot("120-1")
        assert sum(day.readings for day in sessions) == 3 + 3 + 6


async def test_another_chain_is_accepted_once_for_each_visit_that_saw_it(plant):
    async def collected():
        return await plant.journal.collected(await plant.journal.reached("left arm"))

    async def collect(*hashes):
        known = await collected()
        links = [
            CollectedLink(number, 0, "notes", number, hashed)
            for number, hashed in enumerate(hashes, known.position + 1)
        ]
        await plant.journal.keep(known.branch, links, None)

    async def see_another():
        head = (await collected()).head.text
        await plant.visits.keep("left arm", Visit(Outcome.ANOTHER_CHAIN, "x", newest=2, head=head, fork=0))

    await plant.journal.enter("left arm")
    await collect(b"a" * 32, b"b" * 32)
    await see_another()
    await plant.journal.accept_other_chain("left arm", "Ada", "the disk was exchanged")
    for hashed in (b"c" * 32, b"d" * 32):  # the visit that goes on has kept none, some, as many links
        with pytest.raises(ConflictError, match="accepted already"):
            await plant.journal.accept_other_chain("left arm", "Ada", "once more")
        await collect(hashed)
    with pytest.raises(ConflictError, match="accepted already"):
        await plant.journal.accept_other_chain("left arm", "Ada", "once more")
    await see_another()
    await plant.journal.accept_other_chain("left arm", "Ada", "and once more")

    assert (await plant.journal.reached("left arm")).branch.id == 3


async def test_a_cell_with_the_chain_that_was_collected_has_no_other_to_accept(plant, cell):
    await cell.measure()
    await plant.visit(cell)

    with pytest.raises(ConflictError, match="left arm still has the chain that was collected"):
        await plant.journal.accept_other_chain("left arm", "Ada Byron", "to be sure")


async def test_what_was_collected_can_be_looked_up_by_robot_and_instrument(plant, cell):
    await cell.measure(3, serial="120-1", instrument="T-7")
    await cell.measure(2, name="second", serial="120-2", instrument="T-7")
    await plant.visit(cell)

    today = datetime.now(UTC).date()
    robots = await plant.looks.robots(Page(), today)
    instruments = await plant.looks.instruments(Page(), today)
    days = await plant.looks.days_of_instrument("T-7")

    last = today.isoformat()
    assert [(robot.serial_number, robot.cell, robot.last_measured_on) for robot in robots] == [
        ("120-1", "left arm", last),
        ("120-2", "left arm", last),
    ]
    assert [(one.serial_number, one.last_measured_on) for one in instruments] == [("T-7", last)]
    assert {(day.robot_serial_number, day.readings) for day in days} == {("120-1", 3), ("120-2", 2)}


async def test_the_plants_own_chain_holds_what_was_collected(open_plant, cell, tmp_path):
    await cell.measure()
    with open_plant() as plant:
        await plant.visit(cell)

    verdict = verify(tmp_path / "plant.sqlite3")

    assert verdict.findings == ()
    assert verdict.records > await cell.newest()


@pytest.fixture
async def plan(plant):
    await plant.journal.enter("left arm")
    wanted = HandDown("left arm", HandDownKind.PLAN, "monthly", "Ada Byron", {"name": "monthly"})
    return await plant.hand_downs.add(wanted)


async def test_a_plan_is_handed_down_at_the_next_visit_and_its_use_comes_back(plant, cell, plan):
    assert (await plant.hand_downs.get(plan)).state is HandDownState.WAITING

    await plant.visit(cell)
    delivered = await plant.hand_downs.get(plan)
    await HandedDownRepository(cell.database).note_use(delivered.number_in_cell, "Alan", "session 3")
    await plant.visit(cell)

    assert delivered.state is HandDownState.DELIVERED
    assert "hand_down_uses" in [record for _, _, record, _ in await plant.kept()]


async def test_a_plan_whose_acknowledgement_was_lost_is_handed_down_once(plant, cell, plan, monkeypatch):
    async def dies(self, *given):
        raise Killed

    with monkeypatch.context() as patched, pytest.raises(Killed):
        patched.setattr(HandDownRepository, "note", dies)
        await plant.visit(cell)
    await plant.visit(cell)

    assert len(await HandedDownRepository(cell.database).page(Page())) == 1
    assert (await plant.hand_downs.get(plan)).state is HandDownState.DELIVERED


async def test_a_plan_for_a_cell_that_is_away_waits(plant, cell, plan):
    def cut(body):
        return b""

    await cell.measure()
    await plant.visit(cell, transport=Between(cell, cut))

    assert (await plant.hand_downs.get(plan)).state is HandDownState.WAITING
