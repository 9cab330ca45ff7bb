"""What leaves a cell: its whole chain, each hash computed anew, and nothing that has to stay."""

import dataclasses
import json
from datetime import UTC, datetime

import pytest

from tests.helpers.domain.tracker_sessions import make_plan, make_point, make_setup, point_taken
from truepose.domain.cell import DeviceEntry
from truepose.domain.people import Role
from truepose.storage.integrity.hash_chain import GENESIS, linked_hash
from truepose.storage.ledger.entries import LedgerRepository
from truepose.storage.ledger.sessions import SessionRepository
from truepose.storage.people import (
    ActRepository,
    CredentialKind,
    CredentialRepository,
    NewCredential,
    PersonsAct,
)
from truepose.storage.plant.outbox import AT_HOME, LEAVING, from_typed_json
from truepose.storage.records import RequestKey
from truepose.storage.tables import metadata
from truepose.web.api import chain

CANARY = "canary-7f3a"


async def chain_of(client, after=0, **asked):
    """Return the links of one page, and what its last line says."""
    answer = await client.get("/api/v1/chain/links", params={"after": after, **asked})
    assert answer.status_code == 200, answer.text
    *links, end = [json.loads(line) for line in answer.text.splitlines()]
    return links, end


def refuted(links, heads=None):
    """Return the links whose hash is not that of their record; follows those that have none."""
    heads = {} if heads is None else heads
    wrong = []
    for link in links:
        before, heads[link["stream"]] = heads.get(link["stream"], GENESIS), bytes.fromhex(link["hash"])
        if "row" in link:
            row = from_typed_json(link["row"])
            if linked_hash(before, link["record"], tuple(row), tuple(row.values())).hex() != link["hash"]:
                wrong.append(link["link"])
    return wrong


def altered(link):
    return link | {"row": link["row"] | {"recorded_at": "1970"}} if "row" in link else link


@pytest.fixture
def database(app):
    return app.state.context.database


@pytest.fixture
async def measured(database):
    """A session with readings between people, their secrets and their acts."""
    sessions, people = SessionRepository(database), CredentialRepository(database)
    number = await sessions.add("first", make_setup(), make_plan(), RequestKey(f"{CANARY}-key", "f" * 64))
    secrets = [
        NewCredential(kind, None, f"{CANARY}-{kind}", None, {"name": CANARY}) for kind in CredentialKind
    ]
    await people.enter(f"Ada {CANARY}", Role.ADMINISTRATOR, "a test", secrets)
    await people.revoke((1,), CANARY)
    await ActRepository(database).add([PersonsAct("now", "sign_in", f"/{CANARY}", 201, CANARY)])
    ledger = LedgerRepository(database)
    for nest in (1, 2, 3):
        await ledger.append(number, point_taken(make_point(1, nest=nest)))
    return number


def test_every_table_was_decided_upon():
    assert set(metadata.tables) == LEAVING | AT_HOME
    assert not LEAVING & AT_HOME


async def test_the_whole_chain_can_be_computed_anew(client, measured):
    links, end = await chain_of(client)

    assert [link["link"] for link in links] == [*range(1, end["newest"] + 1)]
    assert refuted(links) == []
    assert {"sessions", "readings"} <= {link["record"] for link in links if "row" in link}


async def test_no_secret_leaves_and_around_it_everything_can_be_verified(client, measured):
    text = (await client.get("/api/v1/chain/links")).text
    links, _ = await chain_of(client)

    assert CANARY not in text
    bare = {link["record"] for link in links if "row" not in link}
    assert bare == {"people", "person_states", "credentials", "revocations", "acts", "request_keys"}
    verified = [link for link in links if "row" in link]
    assert refuted(map(altered, links)) == [link["link"] for link in verified]


async def test_a_password_of_a_controller_stays_at_home_with_the_hash_of_its_session(client, database):
    setup = make_setup()
    robot = DeviceEntry("robot", "abb_rws", {"host": "r1", "password": CANARY})
    cell = dataclasses.replace(setup.cell, devices=(robot,))
    await SessionRepository(database).add("secret", dataclasses.replace(setup, cell=cell), make_plan())

    links, _ = await chain_of(client)

    (session,) = [link for link in links if link["record"] == "sessions"]
    assert "row" not in session
    assert CANARY not in json.dumps(links)
    assert json.loads(session["told"]["setup"])["cell"]["devices"][0]["options"]["host"] == "r1"
    assert refuted(links) == []


@pytest.mark.parametrize("limit", [1, 2, 5])
async def test_pages_follow_each_other_and_give_the_same_chain(client, measured, limit):
    whole, end = await chain_of(client)
    read, after = [], 0
    while after < end["newest"]:
        links, last = await chain_of(client, after, limit=limit)
        assert len(links) <= limit
        assert last["end"] == links[-1]["link"]
        read, after = [*read, *links], last["end"]

    assert read == whole


async def test_a_page_of_large_records_ends_when_it_has_enough_bytes(client, measured, monkeypatch):
    monkeypatch.setattr(chain, "MOST_BYTES", 1)
    monkeypatch.setattr("truepose.storage.plant.outbox._AT_A_TIME", 2)

    links, end = await chain_of(client)

    assert len(links) == 2
    assert end["end"] == 2 < end["newest"]


async def test_behind_the_newest_link_there_is_nothing(client, measured):
    _, end = await chain_of(client)

    assert await chain_of(client, end["newest"]) == ([], end)
    assert await chain_of(client, 2**31 - 1) == ([], {"end": 2**31 - 1, "newest": end["newest"]})


async def test_the_head_is_that_of_reports_and_goes_back_to_any_link(client, database, measured):
    whole = (await client.get("/api/v1/chain/head")).json()
    links, _ = await chain_of(client)

    at_three = (await client.get("/api/v1/chain/head", params={"links": 3})).json()

    assert whole["head"] == (await database.head()).text
    assert (whole["newest"], whole["hash"]) == (len(links), links[-1]["hash"])
    assert (at_three["links"], at_three["hash"]) == (3, links[2]["hash"])
    assert at_three["head"] != whole["head"]


async def test_the_head_tells_the_time_that_the_cell_has(client, monkeypatch):
    monkeypatch.setattr(chain, "wall_time", lambda: datetime(1970, 1, 1, tzinfo=UTC))

    head = (await client.get("/api/v1/chain/head")).json()

    assert head["time"] == "1970-01-01T00:00:00.000000+00:00"
    assert head["cell"] == "bench"
