"""A cell that says nonsense, or cannot be asked, costs no other cell anything and is named."""

import asyncio
import json
import socket
from datetime import UTC, datetime

import httpx
import pytest
from sqlalchemy import select

from tests.helpers.machine import HANGS_S
from truepose.exchange.cells.plant import PlantCell
from truepose.plant import cell_client, collector
from truepose.plant.cell_client import CellClient
from truepose.plant.collector import Collector, Pace, PlantRepositories, collecting
from truepose.plant.errors import CellAnswerError, CellSilentError
from truepose.storage.errors import NotInPlantError
from truepose.storage.integrity.hash_chain import GENESIS, linked_hash
from truepose.storage.integrity.head_hash import head_of
from truepose.storage.plant.overview import PlantResults
from truepose.storage.plant.records import (
    CollectedLink,
    HandDown,
    HandDownKind,
    HandDownRecord,
    HandDownState,
    Outcome,
    Visit,
)
from truepose.storage.plant.tables import plant_told

GOOD = {
    "version": "1",
    "schema": "0001",
    "newest": 0,
    "head": head_of(0, {}).text,
    "time": datetime(2026, 5, 4, tzinfo=UTC).isoformat(),
}


def answering(status, body):
    return httpx.MockTransport(lambda request: httpx.Response(status, content=body))


def asked(status=200, body=b"", cell=None):
    return CellClient(cell or PlantCell("left arm", "http://localhost"), transport=answering(status, body))


async def until(holds):
    async with asyncio.timeout(HANGS_S):
        while not (found := await holds()):
            await asyncio.sleep(0.005)
    return found


@pytest.fixture
def follow(plant):
    """Return what visits two cells until the context ends."""
    cells = [PlantCell(name, "http://localhost") for name in ("left arm", "right arm")]
    shelves = PlantRepositories(plant.journal, plant.hand_downs)
    return Collector(cells, shelves, plant.visits, Pace(0.005, 0.005))


async def test_a_visit_that_fails_is_told_and_every_other_cell_is_visited(plant, follow, monkeypatch, caplog):
    async def visited(name, *_):
        if name == "left arm":
            raise ValueError("of a kind that nobody foresaw")
        return Visit(Outcome.WHOLE, collected=1)

    monkeypatch.setattr(collector, "visit", visited)
    await plant.journal.enter("left arm", "right arm")

    async def several():
        right = await plant.visits.of("right arm", 10)
        return len(right) > 2 and (await plant.visits.newest())["left arm"]

    async with collecting(follow):
        left = await until(several)
        assert not follow.has_ended

    assert follow.has_ended
    assert left.visit.outcome is Outcome.REFUSED
    assert left.visit.sentence == (
        "The visit to left arm failed in the plant service (ValueError); see its log."
    )
    assert "of a kind that nobody foresaw" in caplog.text


@pytest.mark.parametrize(
    "wrong",
    [
        b'{"newest": ' + b"[" * 100_000,
        json.dumps(GOOD | {"time": "2026-05-04T12:00:00"}).encode(),
        json.dumps(GOOD | {"time": 7}).encode(),
        json.dumps(GOOD | {"newest": 2**63}).encode(),
        json.dumps(GOOD | {"newest": -1}).encode(),
        json.dumps(GOOD | {"newest": float("inf")}).encode(),
        json.dumps(GOOD | {"version": "1\0"}).encode(),
        json.dumps(GOOD | {"version": "1" * 501}).encode(),
        json.dumps(GOOD | {"head": "\ud800"}).encode(),
        b"[]",
    ],
)
async def test_a_head_that_cannot_be_read_is_said(wrong):
    with pytest.raises(
        CellAnswerError, match="left arm does not respond like a truepose cell: the head of its chain"
    ):
        await asked(body=wrong).head()


async def test_why_nobody_answers_is_said_as_the_system_says_it():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))  # and listens to nobody
        cell = CellClient(PlantCell("left arm", f"http://127.0.0.1:{taken.getsockname()[1]}"))

        with pytest.raises(CellSilentError, match=r"\(Connection refused\)"):
            await cell.head()


async def test_a_certificate_that_cannot_be_read_is_said_with_its_file(tmp_path):
    cell = CellClient(PlantCell("left arm", "https://localhost", certificate=tmp_path / "left.pem"))

    with pytest.raises(CellAnswerError, match=r"certificate file .*left\.pem cannot be used \(No such file"):
        await cell.head()


async def byte_by_byte():
    while True:
        yield b" "
        await asyncio.sleep(0)


async def test_an_answer_that_comes_byte_by_byte_is_not_waited_for(monkeypatch):
    monkeypatch.setattr(cell_client, "_ANSWER_S", 0.05)
    cell = CellClient(
        PlantCell("left arm", "http://localhost"),
        transport=httpx.MockTransport(lambda request: httpx.Response(200, content=byte_by_byte())),
    )
    monkeypatch.setattr(cell_client, "_SLOWEST", float("inf"))

    with pytest.raises(CellSilentError, match=r"http://localhost \(its response arrives at"):
        await cell.head()


async def test_what_a_cell_says_to_people_is_cut_where_nobody_would_read_on():
    with pytest.raises(CellAnswerError) as raised:
        await asked(503, json.dumps({"detail": "No\0\ud800" * 1000}).encode()).head()

    assert str(raised.value).endswith("it returned status 503: " + "No  " * 125 + ".")


def hand_down(document):
    told = HandDown("left arm", HandDownKind.PLAN, "monthly", "Ada Byron", document)
    return HandDownRecord(1, "now", told, HandDownState.WAITING, "", None, "now")


@pytest.mark.parametrize("body", [b"", b"[]", b"{}", b'{"id": "1"}', b'{"id": %d}' % 2**63])
async def test_a_hand_down_taken_in_words_that_nobody_understands_is_not_taken(body):
    with pytest.raises(CellAnswerError, match="its reply to a deployment cannot be read"):
        await asked(201, body).hand_down(hand_down({}), "key")


async def test_a_hand_down_that_was_kept_and_cannot_be_sent_is_refused_and_not_tried_for_ever():
    handed = await asked(201, b'{"id": 1}').hand_down(hand_down({"a": float("nan")}), "key")

    assert (handed.number, handed.sentence) == (
        None,
        "It contains a number that is not finite, which JSON cannot represent",
    )


@pytest.mark.parametrize(
    ("written", "said"),
    [
        ("tp-secret".encode("utf-16"), "cannot be read"),
        ("tp-secrét".encode(), "contains no token"),
        (b"tp-secret\nanother", "contains no token"),
        (b"", "contains no token"),
        (None, "cannot be read"),
    ],
)
async def test_a_token_that_cannot_be_used_is_said_with_its_file(tmp_path, written, said):
    file = tmp_path / "left.token"
    if written is not None:
        file.write_bytes(written)
    cell = PlantCell("left arm", "http://localhost", file)

    with pytest.raises(CellAnswerError) as raised:
        await asked(cell=cell, body=json.dumps(GOOD).encode()).head()

    assert f"left arm is not contacted: its token file {file} {said}" in str(raised.value)


async def test_a_token_as_an_editor_of_windows_saves_it_is_used(tmp_path):
    file = tmp_path / "left.token"
    file.write_bytes(b"\xef\xbb\xbftp-secret\r\n")
    sent = []

    def answer(request):
        sent.append(request.headers["authorization"])
        return httpx.Response(200, json=GOOD)

    cell = CellClient(PlantCell("left arm", "http://localhost", file), transport=httpx.MockTransport(answer))
    await cell.head()
    await cell.close()

    assert sent == ["Bearer tp-secret"]


@pytest.mark.parametrize("figure", ["inf", float("inf"), float("nan"), None, True, [1.0]])
async def test_a_figure_that_is_not_finite_tells_nothing_and_its_record_is_kept(plant, figure):
    held_out = {"identified": {"mean_mm": figure}, "nominal": {"mean_mm": 0.25}}
    document = json.dumps({"status": "converged", "validation": held_out})
    row = {"id": 1, "recorded_at": "2026-11-01T00:00:00+00:00", "campaign_id": 1, "document": document}
    await plant.journal.enter("left arm")
    branch = (await plant.journal.reached("left arm")).branch

    await plant.journal.keep(branch, [CollectedLink(1, 0, "identifications", 1, bytes(32), "{}", row)], None)

    told = await plant.database.read(lambda c: c.execute(select(plant_told)).one())
    assert (told.verdict, told.figure_mm, told.document) == (
        "converged",
        None,
        {"before_mm": 0.25, "quantity": None},
    )


def campaigns(number):
    """Return the links of some records that all have the number 1, each verified by its hash."""
    before, lines = GENESIS, []
    for link in range(1, number + 1):
        row = {"id": 1, "recorded_at": "2026", "name": f"c {link}", "robot": "r", "summary": "{}"}
        row["session_ids"] = "[]"
        before = linked_hash(before, "campaigns", tuple(row), tuple(row.values()))
        line = {"link": link, "stream": 0, "record": "campaigns", "record_id": 1, "hash": before.hex()}
        lines.append(json.dumps(line | {"row": row}))
    return "\n".join([*lines, json.dumps({"end": number, "newest": number})])


def cell_with(links, hand_downs=lambda request: None, page=None):
    """Return a cell with so many links, what it answers to a hand-down, and what it sends of its links."""

    def answer(request):
        if request.method == "POST":
            return hand_downs(request)
        if request.url.path.endswith("/head"):
            asked_for = int(request.url.params.get("links", links))
            return httpx.Response(200, json=GOOD | {"newest": links, "head": head_of(asked_for, {}).text})
        return httpx.Response(200, text=page or campaigns(links))

    return httpx.MockTransport(answer)


async def test_records_that_cannot_be_kept_are_refused_with_a_visit_and_a_line_in_the_log(plant, caplog):
    found = await plant.visit(None, transport=cell_with(2))

    assert found.outcome is Outcome.REFUSED
    assert found.sentence.startswith("left arm sends records that cannot be stored here: The records do not")
    assert (await plant.visits.newest())["left arm"].visit.sentence == found.sentence
    assert await plant.kept() == []
    assert "a page of left arm was refused" in caplog.text


@pytest.mark.parametrize("wrong", [{"record": "campaigns\0"}, {"told": {"id": 1, "name": "\ud800"}}])
async def test_text_that_no_database_keeps_is_refused_by_the_link(plant, wrong):
    line = {"link": 1, "stream": 0, "record": "campaigns", "record_id": 1, "hash": "00" * 32, **wrong}
    page = f'{json.dumps(line)}\n{{"end": 1, "newest": 1}}'

    found = await plant.visit(None, transport=cell_with(1, page=page))

    assert (found.outcome, found.collected) == (Outcome.REFUSED, 0)
    assert found.sentence.startswith("The cell sent {'link': 1,")


async def test_how_far_a_cell_was_collected_that_nobody_entered_is_not_known(plant):
    with pytest.raises(NotInPlantError, match="There is no cell 'nobody' in this plant"):
        await plant.journal.reached("nobody")


async def waiting(plant, *names):
    """Have plans of these names wait for a cell, and return their numbers."""
    await plant.journal.enter("left arm")
    plans = [HandDown("left arm", HandDownKind.PLAN, name, "Ada", {}) for name in names]
    return [await plant.hand_downs.add(plan) for plan in plans]


def problem(status, kind="", **more):
    return httpx.Response(status, json={"type": f"urn:truepose:problem:{kind}", "detail": "No.", **more})


@pytest.mark.parametrize(
    "answer",
    [
        httpx.Response(400, text="<html>Bad Request</html>"),
        httpx.Response(404, text="<html>Not Found</html>"),
        httpx.Response(413, text="<html>too large for this proxy</html>"),
        httpx.Response(422, json={"type": "about:blank", "detail": "of another program"}),
        httpx.Response(422, json=[]),
        problem(403),
        problem(404),  # a cell of an earlier version takes nothing yet
        problem(415),
        problem(503),
    ],
)
async def test_what_passes_keeps_a_hand_down_waiting_and_collecting_goes_on(plant, answer):
    def first_not(request):
        is_first = json.loads(request.content)["name"] == "first"
        return answer if is_first else httpx.Response(201, json={"id": 7})

    first, behind = await waiting(plant, "first", "second")

    found = await plant.visit(None, transport=cell_with(1, first_not))

    assert (found.outcome, found.collected) == (Outcome.WHOLE, 1)
    assert found.sentence.startswith(
        f"All records are collected, but deployment {first} is waiting: left arm does not"
    )
    states = [(await plant.hand_downs.get(number)).state for number in (first, behind)]
    assert states == [HandDownState.WAITING, HandDownState.DELIVERED]


@pytest.mark.parametrize("status", [400, 409, 413, 422])
async def test_what_a_cell_itself_cannot_take_is_refused_with_its_sentence(plant, status):
    (number,) = await waiting(plant, "monthly")

    found = await plant.visit(None, transport=cell_with(0, lambda request: problem(status)))

    refused = await plant.hand_downs.get(number)
    assert (refused.state, refused.sentence) == (HandDownState.REFUSED, "No")
    assert (found.outcome, found.sentence) == (Outcome.WHOLE, "")


async def test_a_day_that_is_none_is_a_day_that_nobody_said(plant):
    said = {"measured_on": "<soon>", "robot_serial_number": "120-1", "instrument_serial_number": "T-7"}
    row = {"id": 1, "recorded_at": "yesterday", "name": "May", "robot": "IRB 120", "session_ids": "[]"}
    link = CollectedLink(1, 0, "campaigns", 1, bytes(32), "{}", {**row, "summary": json.dumps(said)})
    await plant.journal.enter("left arm")
    await plant.journal.keep((await plant.journal.reached("left arm")).branch, [link], None)

    (shown,) = await plant.looks.life_of_robot("120-1")

    assert (shown.name, shown.measured_on) == ("May", "")
    assert await PlantResults(plant.database).of_robot("120-1") == []


async def test_a_cell_that_falls_silent_is_not_asked_for_each_hand_down_that_waits(plant):
    asked_for = []

    def silent(request):
        asked_for.append(request)
        raise httpx.ConnectError("no route to host", request=request)

    await waiting(plant, "first", "second")

    found = await plant.visit(None, transport=cell_with(1, silent))

    assert (found.outcome, found.collected, len(asked_for)) == (Outcome.WHOLE, 1, 1)
