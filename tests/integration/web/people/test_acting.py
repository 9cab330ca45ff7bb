"""Who acts: under their own name, having shown who they are, one at a time, and on record."""

import asyncio
import json
import logging

import pytest

from tests.helpers.domain.builders import make_points
from tests.helpers.machine import HANGS_S
from tests.helpers.web.clients import command, until
from tests.helpers.web.routes import asked
from tests.integration.web.bench import session_request, uploaded
from tests.integration.web.people.conftest import PASSWORD, PIN, browser_at, peopled
from truepose.domain.people import Role
from truepose.messages.catalogue import IN_ENGLISH
from truepose.messages.message import leading_key
from truepose.people.accounts import Preferences
from truepose.people.leases import LEASE_S
from truepose.people.register import Caller
from truepose.storage import database
from truepose.storage.errors import StorageUnavailableError
from truepose.web.api import watch_links
from truepose.web.api.events import EventStream
from truepose.web.middleware.authorization import AuthorizationMiddleware
from truepose.web.middleware.routing import operations_of
from truepose.web.pages.session_history import acts_of_session

SESSIONS = "/api/v1/sessions"
FRESH = "urn:truepose:problem:fresh-sign-in"


@pytest.fixture
async def house(app):
    return await peopled(app)


@pytest.fixture
async def alan(house):
    async with await house.browser(Role.OPERATOR) as browser:
        yield browser


@pytest.fixture
async def ada(house):
    async with await house.browser(Role.ADMINISTRATOR) as browser:
        yield browser


@pytest.fixture
async def started(alan):
    """A session that waits for somebody to look at the cell."""
    for device in ("tracker", "robot"):
        await alan.post(f"/api/v1/devices/{device}/connect")
    path = (await alan.post(SESSIONS, json=session_request())).headers["Location"]
    assert (await command(alan, path, "start", person=None)).status_code == 200
    return path, (await until(alan, path, lambda session: session["prompt"]))["prompt"]["id"]


async def acts_of(house):
    await house.here.log.written()
    return [record.act for record in await house.here.acts.newest(None, 100)]


async def test_a_session_has_the_person_who_is_signed_in(alan, started):
    path, prompt = started

    other = await command(alan, path, "confirm", person="Grace Hopper", prompt_id=prompt)
    own = await command(alan, path, "confirm", person=" alan  turing", prompt_id=prompt)
    session = await until(alan, path, lambda session: session["state"] == "finished")

    assert (other.status_code, own.status_code) == (403, 200)
    assert "Alan Turing is signed in here" in other.json()["detail"]
    assert {state["person"] for state in session["states"]} == {None, "Alan Turing"}


async def test_a_name_need_not_be_said_twice(alan, started, bench):
    path, prompt = started

    confirmed = await command(alan, path, "confirm", prompt_id=prompt, person=None)

    assert confirmed.status_code == 200, confirmed.text


async def test_nothing_moves_before_it_was_shown_once_more_who_it_is(house, started, bench):
    path, prompt = started
    await house.here.accounts.choose(house.people[Role.OPERATOR], Preferences(pin=PIN))
    async with await house.browser(Role.OPERATOR, fresh=False) as stale:
        refused = await command(stale, path, "confirm", prompt_id=prompt, person=None)
        assert (refused.status_code, refused.json()["type"]) == (403, FRESH)
        assert bench.robot.moves == 0

        assert (
            await command(stale, path, "pause", person=None)
        ).status_code != 403  # halting waits for nothing
        assert (await stale.post("/api/v1/sign-ins/present/fresh", json={"pin": PIN})).status_code == 200


@pytest.mark.parametrize("role", [Role.VIEWER, Role.DEVICE])
async def test_who_may_not_act_may_stop(house, started, role):
    path, prompt = started
    async with house.of(role) as client:
        confirmed = await command(client, path, "confirm", prompt_id=prompt, person=None)
        stopped = await command(client, path, "abort", person=None)

    assert (confirmed.status_code, stopped.status_code) == (403, 200)


async def test_a_program_of_an_operator_is_hindered_by_nobody(house, alan, started):
    path, prompt = started
    async with house.of(Role.OPERATOR) as script:
        confirmed = await command(script, path, "confirm", person="Alan Turing", prompt_id=prompt)

    assert confirmed.status_code == 200, confirmed.text


async def test_one_acts_and_another_takes_over_by_saying_so(ada, alan, started):
    path, prompt = started  # Alan started it, and has the authority

    refused = await command(ada, path, "confirm", prompt_id=prompt, person=None)
    assert (refused.status_code, refused.json()["type"]) == (409, "urn:truepose:problem:authority")
    assert "Alan Turing has control of session 1" in refused.json()["detail"]
    assert (await ada.put(f"{path}/authority", json={})).status_code == 409
    assert (await ada.put(f"{path}/authority", json={"take_over": True})).json()["mine"] is True

    assert (await alan.get(f"{path}/authority")).json()["person"] == "Ada Byron"
    assert (await command(alan, path, "confirm", prompt_id=prompt, person=None)).status_code == 409
    assert (await command(ada, path, "confirm", prompt_id=prompt, person=None)).status_code == 200


async def test_from_whom_the_authority_was_taken_stands_on_reports(house, ada, started):
    path, _ = started
    number = int(path.rsplit("/", 1)[1])

    for _ in range(2):  # to go on having it is no event
        await ada.put(f"{path}/authority", json={"take_over": True})
    events = await acts_of_session(house.app.state.context, number, IN_ENGLISH)

    taken = [one for one in events if leading_key(one.what) == "event.taken_over"]
    assert [(one.person, IN_ENGLISH.spoken(one.what)) for one in taken] == [
        ("Ada Byron", "Took control of the session from Alan Turing.")
    ]


async def test_the_authority_ends_where_nobody_renews_it(house, ada, alan, started, monkeypatch):
    path, prompt = started
    leases = house.here.leases
    began = leases._elapsed_s
    assert (await alan.put(f"{path}/authority", json={})).json()["mine"] is True  # after a reload too

    monkeypatch.setattr(leases, "_elapsed_s", lambda: began() + LEASE_S + 1)

    assert (await alan.get(f"{path}/authority")).json()["person"] is None
    assert (await command(ada, path, "confirm", prompt_id=prompt, person=None)).status_code == 200


async def test_to_go_on_having_the_authority_is_no_act(house, ada, alan, started):
    path, _ = started

    for _ in range(3):  # as an open page does every few seconds
        await alan.put(f"{path}/authority", json={})
    await ada.put(f"{path}/authority", json={})  # refused

    claimed = [(act.person, act.status) for act in await acts_of(house) if act.operation == "claim_authority"]
    assert claimed == [("Ada Byron", 409)]


async def test_who_only_looks_at_a_stranger_s_tablet_takes_nothing_over(house, started):
    path, _ = started
    async with await house.browser(Role.ADMINISTRATOR, fresh=False) as stale:
        refused = await stale.put(f"{path}/authority", json={"take_over": True})

    assert (refused.status_code, refused.json()["type"]) == (403, FRESH)


async def test_every_act_is_on_record_with_its_person(house, alan, started):
    path, _ = started
    await command(alan, path, "abort", person="Alan Turing")
    async with house.client() as nobody:
        await command(nobody, path, "start", person=None)

    found = await acts_of(house)

    told = {(act.person, act.operation, act.resource, act.status) for act in found}
    assert ("Alan Turing", "start_session", f"{path}/commands", 200) in told
    assert ("Alan Turing", "abort_session", f"{path}/commands", 200) in told
    assert (None, "command_session", f"{path}/commands", 401) in told
    assert {act.tablet for act in found if act.person} == {"cell 3"}


async def test_signing_in_and_lock_outs_are_on_record_and_a_flood_is_not(house):
    await house.here.accounts.choose(house.people[Role.OPERATOR], Preferences(password=PASSWORD))
    async with house.client() as browser:
        good = {"name": "Alan Turing", "password": PASSWORD}
        assert (await browser.post("/api/v1/sign-ins", json=good)).status_code == 201
        browser.cookies.clear()
        for _ in range(40):
            await browser.post("/api/v1/sign-ins", json=good | {"password": "not this one"})

    found = await acts_of(house)

    statuses = [act.status for act in found if act.operation == "sign_in"]
    assert statuses.count(201) == 1
    assert 401 in statuses
    assert len(statuses) < 12
    assert {act.person for act in found if act.operation == "sign_in"} == {"Alan Turing"}


async def test_acts_are_searched_and_sent_as_lines(house, started):
    async with house.of(Role.METROLOGIST) as script:
        found = (await script.get("/api/v1/audit?search=start_session")).json()
        lines = (await script.get("/api/v1/audit/lines")).text.splitlines()

    assert (found["total"], found["acts"][0]["person"]) == (1, "Alan Turing")
    assert [json.loads(line)["id"] for line in lines] == list(range(1, len(lines) + 1))


async def test_a_full_disk_is_told_to_who_reads_acts_and_holds_up_no_command(
    house, alan, app, started, monkeypatch
):
    monkeypatch.setattr(database, "_TRIAL_S", HANGS_S)
    app.state.context.database._try_again_after(StorageUnavailableError("The disk is full."))
    path, _ = started
    async with house.of(Role.METROLOGIST) as script:
        await script.delete("/api/v1/tokens/999")  # an act that waits for the disk
        readers = [script.get(page) for page in ("/audit", "/api/v1/audit") for _ in range(10)]
        halted, *told = await asyncio.gather(command(alan, path, "pause", person=None), *readers)

    assert halted.status_code == 409, halted.text  # it waits for a person, and nothing moves
    assert {reply.status_code for reply in told} == {503}
    assert "not on disk yet (The disk is full)" in told[-1].json()["detail"]


async def test_no_secret_is_in_a_log_an_act_or_an_answer(house, app, caplog, started):
    caplog.set_level(logging.DEBUG)
    secrets = {"canary password 7f3a", "990417", "CANARYBADGE77"}
    _, link = await house.here.accounts.enter("Eve", Role.VIEWER, "a test")
    answers = []
    async with browser_at(app) as browser:
        body = {"secret": link, "password": "canary password 7f3a", "pin": "990417", "badge": "CANARYBADGE77"}
        answers += [await browser.post("/api/v1/links/accepted", json=body | {"badge": " "})]
        answers += [await browser.post("/api/v1/links/accepted", json=body)]
        secrets |= {link, browser.cookies["truepose_sign_in"]}
        answers += [
            await browser.post("/api/v1/sign-ins", json={"name": "canary password 7f3a", "password": link})
        ]
        answers += [
            await browser.post("/api/v1/sign-ins", json={"name": 7, "password": "canary password 7f3a"})
        ]
        answers += [await browser.get("/account"), await browser.get("/")]
        answers += [await browser.post("/api/v1/sign-ins/present/fresh", json={"pin": "990417"})]
    async with house.of(Role.ADMINISTRATOR) as script:
        made = await script.post(
            "/api/v1/tokens", json={"name": "x", "owner": "Ada Byron", "role": "viewer", "hours": 1}
        )
        secrets |= {made.json()["secret"], house.tokens[Role.ADMINISTRATOR]}
        answers += [await script.get("/api/v1/tokens"), await script.get("/api/v1/people")]
        answers += [await script.get("/api/v1/audit/lines"), await script.get("/people")]

    told = caplog.text + "".join(answer.text for answer in answers) + repr(await acts_of(house))
    stored = app.state.context.database.file.read_bytes()
    log = app.state.context.database.file.with_name(
        f"{app.state.context.database.file.name}-wal"
    ).read_bytes()

    assert {secret for secret in secrets if secret in told} == set()
    assert {secret for secret in secrets if secret.encode() in stored + log} == set()


async def test_a_watch_link_shows_one_session_and_nothing_else(house, alan, app, started):
    path, _ = started
    made = (await alan.post(f"{path}/watch-links", json={"hours": 2})).json()
    secret = made["url"].removeprefix("http://localhost/watch/")
    async with house.client() as screen:
        shown = await screen.get(f"/watch/{secret}")
        assert shown.status_code == 200
        assert "View only" in shown.text
        assert made["qr_svg"].startswith("data:image/svg+xml")
        for method, other in (
            ("GET", path),
            ("POST", f"{path}/pause"),
            ("GET", "/"),
            ("GET", f"{path}/live"),
        ):
            answer = await screen.request(method, other, headers={"Authorization": f"Bearer {secret}"})
            assert answer.status_code in {303, 401}, other
        assert (await screen.post(f"/watch/{secret}")).status_code == 401

        assert (await alan.delete(f"/api/v1/watch-links/{made['link']['id']}")).status_code == 204
        assert (await screen.get(f"/watch/{secret}")).status_code == 401
        assert (await screen.get(f"/watch/{secret}/live")).status_code == 401


async def test_a_key_of_somebody_else_answers_with_nothing_of_theirs(house, alan, ada):
    sent = {"json": session_request(), "headers": {"Idempotency-Key": "1"}}

    first, hers, again = [await browser.post(SESSIONS, **sent) for browser in (alan, ada, alan)]

    assert [first.status_code, hers.status_code, again.status_code] == [201, 409, 201]
    assert again.json()["id"] == first.json()["id"]


async def streamed(app, meanwhile, *headers):
    """Return what is sent of a stream, during which something happens."""

    async def streaming(scope, receive, send):
        await send({"type": "http.response.start", "status": 200, "headers": []})
        await send({"type": "http.response.body", "body": b"before", "more_body": True})
        await meanwhile()
        await send({"type": "http.response.body", "body": b"after", "more_body": True})

    gate = AuthorizationMiddleware(streaming, operations_of(app.routes))

    async def served(scope, receive, send):
        await gate({**scope, "app": app}, receive, send)

    answer = await asked(served, "GET", "/api/v1/events", [("host", "localhost"), *headers])
    return answer.status, answer.body


async def test_a_stream_ends_with_the_right_to_it(house):
    async def removed():
        await house.here.accounts.register.remove(house.people[Role.OPERATOR], "a test")

    token = ("authorization", f"Bearer {house.tokens[Role.OPERATOR]}")

    assert await streamed(house.app, removed, token) == (200, b"before")


async def test_a_stream_of_an_open_service_ends_when_the_first_person_closes_it(app):
    accounts = app.state.context.people.accounts

    async def entered():
        chosen = Preferences(password=PASSWORD)
        await accounts.enter_first(accounts.first_secret, "Ada Byron", chosen, "127.0.0.1")

    assert await streamed(app, entered) == (200, b"before")


async def two_events(closed):
    try:
        yield "first"
        yield "second"
    finally:
        closed.append(True)


async def test_a_link_that_is_taken_back_closes_what_it_showed(house):
    record, secret = await house.here.accounts.make_watch_link(1, 1.0, Caller())
    closed = []
    events = two_events(closed)
    shown = watch_links._while_it_lasts(house.app.state.context, secret, events)

    first = await anext(shown)
    await house.here.accounts.register.revoke(record.id, by="a test")
    rest = [event async for event in shown]

    assert (first, rest, closed) == ("first", [], [True])


async def test_a_reader_that_is_gone_closes_what_it_followed():
    closed = []
    stream = EventStream(two_events(closed))

    async def gone(message):
        if message["type"] == "http.response.body":
            raise OSError("nobody reads")

    with pytest.raises(OSError, match="nobody reads"):
        await stream.stream_response(gone)

    assert closed == [True]


async def test_a_plant_hands_down_for_somebody_whom_the_cell_does_not_know(house):
    plan = {"kind": "plan", "name": "monthly", "person": "Emmy Noether", "document": {"name": "monthly"}}

    async with house.of(Role.PLANT) as plant, house.of(Role.OPERATOR) as operator:
        handed = await plant.post("/api/v1/hand-downs", json=plan, headers={"Idempotency-Key": "monthly-1"})
        used = await operator.post(f"{handed.headers['Location']}/uses", json={"person": "Emmy Noether"})

    assert (handed.status_code, handed.json()["person"]) == (201, "Emmy Noether")
    assert used.status_code == 403  # whoever uses it is there, and signed in


async def test_readings_are_set_aside_by_whoever_is_signed_in(alan):
    number = await uploaded(alan, calibration=make_points(10))
    aside = {"reason": "it slipped", "readings": [{"config": 3, "nest": 1}]}

    own, other = [
        await alan.post("/api/v1/identifications", json={"campaign_id": number, "set_aside": aside | who})
        for who in ({}, {"person": "Grace Hopper"})
    ]

    assert (own.status_code, other.status_code) == (202, 403)
    assert own.json()["request"]["set_aside"]["person"] == "Alan Turing"
    assert "Alan Turing is signed in here" in other.json()["detail"]
