"""Signing in, standing before a shared tablet, and showing once more who it is."""

import asyncio
import dataclasses
import time

import pytest

from tests.helpers.web.clients import client_of, command, served
from tests.integration.web.people.conftest import ORIGIN, PASSWORD, PIN, browser_at
from truepose.app import create_app
from truepose.domain.people import Role
from truepose.people import secrets
from truepose.people.accounts import Preferences
from truepose.people.attempts import GUESSES
from truepose.people.errors import AccountRefusedError
from truepose.people.secrets import new_secret
from truepose.people.sign_ins import FRESH_S, IDLE_S
from truepose.settings import Settings
from truepose.storage.people import CredentialKind

PRESENT = "/api/v1/sign-ins/present"
FIRST = {"name": "Ada Byron", "password": PASSWORD, "pin": PIN}


async def first(client, **more):
    client.headers.update(ORIGIN)
    secret = client._transport.app.state.context.people.accounts.first_secret
    return await client.post("/api/v1/first-person", json=FIRST | {"secret": secret} | more)


@pytest.fixture
async def ada(client):
    """The browser of the first person, who is administrator."""
    entered = await first(client)
    assert entered.status_code == 201, entered.text
    return client


@pytest.fixture
async def elsewhere(app):
    """Another browser, which nobody has signed in."""
    async with browser_at(app) as opened:
        yield opened


async def invited(ada, browser, name, role, pin=PIN):
    entered = await ada.post("/api/v1/people", json={"name": name, "role": role})
    assert entered.status_code == 201, entered.text
    secret = entered.json()["link"].removeprefix("/welcome/")
    return await browser.post(
        "/api/v1/links/accepted", json={"secret": secret, "password": PASSWORD, "pin": pin}
    )


async def test_a_fresh_service_on_this_computer_asks_nobody(client):
    who = (await client.get(PRESENT)).json()

    assert (who["accounts"], who["name"]) == ("open", None)
    assert (await client.get("/api/v1/sessions")).status_code == 200


async def test_an_open_service_is_closed_by_its_link_alone(client):
    client.headers.update(ORIGIN)

    unknown = await client.post("/api/v1/first-person", json=FIRST | {"secret": new_secret()})
    entered = await client.post("/api/v1/people", json={"name": "Eve", "role": "administrator"})

    assert (unknown.status_code, entered.status_code) == (401, 409)
    assert (await client.get(PRESENT)).json()["accounts"] == "open"


async def test_the_first_person_closes_it_for_everybody_else(ada, elsewhere):
    assert (await ada.get(PRESENT)).json() | {"fresh": True} == {
        "accounts": "on", "name": "Ada Byron", "role": "administrator", "tablet": "", "fresh": True,
        "people": ["Ada Byron"],
    }  # fmt: skip
    assert (await ada.get("/api/v1/sessions")).status_code == 200
    assert (await elsewhere.get("/api/v1/sessions")).status_code == 401
    assert (await first(elsewhere, name="Mallory")).status_code == 401


async def test_the_cookie_is_for_the_browser_alone(ada, elsewhere):
    told = await elsewhere.post("/api/v1/sign-ins", json={"name": "ada  byron", "password": PASSWORD})

    cookie = told.headers["set-cookie"]
    assert told.status_code == 201
    assert {"HttpOnly", "SameSite=strict", "Path=/"} <= set(cookie.split("; "))
    assert "Secure" not in cookie  # there is no TLS here; behind it there is
    assert elsewhere.cookies["truepose_sign_in"] not in told.text


async def test_behind_tls_the_cookie_is_secure(settings, bench):
    shop = Settings(**{name: getattr(settings, name) for name in ("database_url", "cell_file")},
                    allowed_hosts=("https://cell3.shop",))  # fmt: skip
    async with served(shop, bench.registry()) as client:
        secret = client._transport.app.state.context.people.accounts.first_secret
        told = await client.post(
            "https://cell3.shop/api/v1/first-person",
            json=FIRST | {"secret": secret},
            headers={"Origin": "https://cell3.shop"},
        )

    assert told.status_code == 201
    assert told.headers["set-cookie"].startswith("__Host-truepose_sign_in=")
    assert "Secure" in told.headers["set-cookie"].split("; ")


async def test_reached_by_others_it_is_closed_from_the_first_start(settings, bench):
    shop = Settings(settings.database_url, host="0.0.0.0", cell_file=settings.cell_file)
    async with served(shop, bench.registry()) as client:
        client.headers.update(ORIGIN)
        assert (await client.get("/api/v1/sessions")).status_code == 401
        assert "No users yet" in (await client.get("/", follow_redirects=True)).text
        assert (await first(client, secret=new_secret())).status_code == 401
        assert (await first(client)).status_code == 201
        assert (await client.get("/api/v1/sessions")).status_code == 200
        assert (await first(client, name="Eve")).status_code == 401


async def test_without_accounts_nobody_is_asked_whoever_is_entered(settings, bench):
    async with served(
        Settings(settings.database_url, cell_file=settings.cell_file), bench.registry()
    ) as client:
        assert (await first(client)).status_code == 201
        client.cookies.clear()
        assert (await client.get("/api/v1/sessions")).status_code == 401

    off = Settings(settings.database_url, cell_file=settings.cell_file, accounts=False)
    async with served(off, bench.registry()) as client:
        assert (await client.get("/api/v1/sessions")).status_code == 200
        assert (await client.get(PRESENT)).json()["accounts"] == "off"


async def test_a_link_works_once(ada, elsewhere):
    entered = (await ada.post("/api/v1/people", json={"name": "Alan Turing", "role": "operator"})).json()
    wanted = {"secret": entered["link"].removeprefix("/welcome/"), "password": PASSWORD}

    first = await elsewhere.post("/api/v1/links/accepted", json=wanted)
    second = await elsewhere.post("/api/v1/links/accepted", json=wanted | {"password": "another password"})

    assert (first.status_code, second.status_code) == (201, 401)
    assert first.json()["role"] == "operator"


async def test_a_shared_tablet_changes_hands_by_a_pin(ada, elsewhere):
    await invited(ada, elsewhere, "Alan Turing", "operator", pin="1912")
    before = elsewhere.cookies["truepose_sign_in"]

    switched = await elsewhere.post(f"{PRESENT}/person", json={"name": "Ada Byron", "pin": PIN})

    assert (switched.status_code, switched.json()["name"]) == (200, "Ada Byron")
    assert elsewhere.cookies["truepose_sign_in"] != before
    back = await elsewhere.post(f"{PRESENT}/person", json={"name": "Alan Turing", "pin": "1912"})
    assert back.json()["role"] == "operator"
    elsewhere.cookies.set("truepose_sign_in", before)
    assert (await elsewhere.get("/api/v1/sessions")).status_code == 401


async def test_a_badge_says_who_and_the_pin_proves_it(ada):
    mine = {"present_password": PASSWORD, "badge": "0007421993"}
    assert (await ada.put(f"{PRESENT}/secrets", json=mine)).status_code == 200

    wrong = await ada.post(f"{PRESENT}/person", json={"badge": "0007421993", "pin": "9999"})
    foreign = await ada.post(f"{PRESENT}/person", json={"badge": "0007421994", "pin": PIN})
    right = await ada.post(f"{PRESENT}/person", json={"badge": "0007421993", "pin": PIN})

    assert (wrong.status_code, foreign.status_code, right.status_code) == (401, 401, 200)


async def test_badges_are_looked_up_only_as_often_as_it_may_be_guessed(ada, monkeypatch):
    looked_up = []
    monkeypatch.setattr(secrets.Badges, "hashed", lambda self, badge: looked_up.append(badge) or badge)

    guess = {"badge": "0007421994", "pin": "9999"}
    told = [(await ada.post(f"{PRESENT}/person", json=guess)).status_code for _ in range(GUESSES + 3)]

    assert told == [401] * GUESSES + [429] * 3
    assert len(looked_up) == GUESSES


async def test_the_first_badges_of_a_service_are_not_the_same(ada, accounts):
    grace = await accounts.register.enter("Grace Hopper", Role.OPERATOR, "a test")
    people = [*accounts.register.people[:1], grace]

    chosen = [accounts.choose(person, Preferences(badge="0007421993")) for person in people]
    ends = await asyncio.gather(*chosen, return_exceptions=True)

    assert [isinstance(end, AccountRefusedError) for end in ends].count(True) == 1
    badges = [r for r in accounts.register.credentials if r.kind is CredentialKind.BADGE]
    assert len(badges) == 1


async def test_a_pin_that_is_refused_costs_no_guess_of_a_link(ada, elsewhere):
    entered = (await ada.post("/api/v1/people", json={"name": "Alan Turing", "role": "operator"})).json()
    wanted = {"secret": entered["link"].removeprefix("/welcome/"), "password": PASSWORD}

    told = [
        await elsewhere.post("/api/v1/links/accepted", json=wanted | {"pin": pin})
        for pin in [*["1111"] * (GUESSES + 1), PIN]
    ]

    assert [one.status_code for one in told] == [409] * (GUESSES + 1) + [201]


async def test_a_pin_opens_no_tablet_that_nobody_signed_in(ada, elsewhere):
    refused = await elsewhere.post(f"{PRESENT}/person", json={"name": "Ada Byron", "pin": PIN})

    assert refused.status_code == 401


async def test_a_pin_that_was_guessed_at_counts_no_more(ada, later):
    for _ in range(10):
        assert (await ada.post(f"{PRESENT}/fresh", json={"pin": "9999"})).status_code == 401
        later(60)

    assert (await ada.post(f"{PRESENT}/fresh", json={"pin": PIN})).status_code == 401
    later(60)
    assert (await ada.post(f"{PRESENT}/fresh", json={"password": PASSWORD})).status_code == 200
    assert (await ada.post(f"{PRESENT}/fresh", json={"pin": PIN})).status_code == 200


async def test_ten_guesses_a_minute_and_no_more(ada, elsewhere, later):
    wrong = {"name": "Ada Byron", "password": "not this one"}
    tried = []
    for _ in range(60):
        tried.append((await elsewhere.post("/api/v1/sign-ins", json=wrong)).status_code)
        later(1)

    assert tried.count(401) <= 10
    assert tried[:GUESSES] == [401] * GUESSES
    assert set(tried) == {401, 429}
    await elsewhere.post("/api/v1/sign-ins", json=wrong)
    last = await elsewhere.post("/api/v1/sign-ins", json=wrong | {"password": PASSWORD})
    assert last.status_code == 429
    assert 1 <= int(last.headers["retry-after"]) <= 12
    later(60)
    assert (await elsewhere.post("/api/v1/sign-ins", json=wrong | {"password": PASSWORD})).status_code == 201


@pytest.mark.true_hashes
async def test_known_and_unknown_are_refused_alike(ada, elsewhere, later):
    times, told = {"Ada Byron": [], "Nobody Here": []}, set()
    for _ in range(7):
        for name, found in times.items():
            later(60)
            began = time.process_time()
            refused = await elsewhere.post(
                "/api/v1/sign-ins", json={"name": name, "password": "not this one"}
            )
            found.append(time.process_time() - began)
            told.add((refused.status_code, refused.json()["detail"]))

    known, unknown = (sorted(found)[3] for found in times.values())
    assert len(told) == 1
    assert abs(known - unknown) < 0.5 * max(known, unknown)  # without a hash it would be twenty times less


async def test_a_sign_in_ends_with_the_shift(ada, later):
    later(IDLE_S - 60)
    assert (await ada.get("/api/v1/sessions")).status_code == 200
    later(IDLE_S + 1)
    assert (await ada.get("/api/v1/sessions")).status_code == 401


async def test_what_was_shown_is_fresh_for_five_minutes(ada, later):
    assert (await ada.get(PRESENT)).json()["fresh"] is True
    later(FRESH_S + 1)
    assert (await ada.get(PRESENT)).json()["fresh"] is False
    assert (await ada.post(f"{PRESENT}/fresh", json={"pin": PIN})).json()["fresh"] is True


async def test_signed_out_is_signed_out(ada):
    cookie = ada.cookies["truepose_sign_in"]

    assert (await ada.delete(PRESENT)).status_code == 204
    ada.cookies.set("truepose_sign_in", cookie)

    assert (await ada.get("/api/v1/sessions")).status_code == 401


async def test_a_new_password_closes_every_other_browser(ada, elsewhere):
    await elsewhere.post("/api/v1/sign-ins", json={"name": "Ada Byron", "password": PASSWORD})

    changed = {"present_password": PASSWORD, "password": "weaves algebraic patterns"}
    assert (await ada.put(f"{PRESENT}/secrets", json=changed)).status_code == 200

    assert (await ada.get("/api/v1/sessions")).status_code == 200
    assert (await elsewhere.get("/api/v1/sessions")).status_code == 401


@pytest.mark.parametrize("change", ["remove", "viewer"])
async def test_a_right_that_is_taken_ends_at_once(ada, elsewhere, change):
    await invited(ada, elsewhere, "Alan Turing", "operator")
    assert (await elsewhere.get("/api/v1/sessions")).status_code == 200

    if change == "remove":
        assert (await ada.delete("/api/v1/people/2")).status_code == 204
    else:
        assert (await ada.put("/api/v1/people/2/role", json={"role": "viewer"})).status_code == 200

    started = await command(elsewhere, "/api/v1/sessions/1", "start", person=None)
    assert started.status_code == (401 if change == "remove" else 403)


async def test_the_last_administrator_stays(ada):
    assert (await ada.delete("/api/v1/people/1")).status_code == 409
    assert (await ada.put("/api/v1/people/1/role", json={"role": "viewer"})).status_code == 409


async def test_a_service_that_is_started_anew_knows_who_is_signed_in(settings, bench):
    async with served(settings, bench.registry()) as client:
        await first(client)
        cookie = client.cookies["truepose_sign_in"]

    again = create_app(settings, bench.registry())
    async with again.router.lifespan_context(again), client_of(again) as client:
        client.cookies.set("truepose_sign_in", cookie)
        who = (await client.get(PRESENT)).json()

    assert (who["name"], who["fresh"]) == ("Ada Byron", False)


@pytest.mark.parametrize(
    ("path", "body"),
    [
        ("/api/v1/people", {"name": "Eve", "role": "viewer", "active": True}),
        ("/api/v1/people", {"name": "Eve", "role": "viewer", "id": 1}),
        ("/api/v1/people", {"name": "Eve", "role": "device"}),
        ("/api/v1/people", {"name": "Eve", "role": "root"}),
        (
            "/api/v1/tokens",
            {"name": "x", "owner": "Ada Byron", "role": "viewer", "hours": 1, "secret": "y"},
        ),
        ("/api/v1/tokens", {"name": "x", "owner": "Ada Byron", "role": "viewer", "hours": 10**6}),
        ("/api/v1/sign-ins", {"name": "Ada Byron", "password": PASSWORD, "role": "administrator"}),
    ],
)
async def test_nobody_sends_what_is_not_theirs_to_say(ada, path, body):
    assert (await ada.post(path, json=body)).status_code in {409, 422}


async def test_a_token_is_never_more_than_its_owner(ada):
    await ada.post("/api/v1/people", json={"name": "Vera Rubin", "role": "viewer"})
    wanted = {"name": "script", "owner": "Vera Rubin", "role": "administrator", "hours": 1}

    assert (await ada.post("/api/v1/tokens", json=wanted)).status_code == 409
    made = (await ada.post("/api/v1/tokens", json=wanted | {"role": "viewer"})).json()
    assert made["token"]["owner"] == "Vera Rubin"
    assert made["secret"] not in (await ada.get("/api/v1/tokens")).text


@pytest.fixture
async def proxied(settings, bench):
    """A service of people behind a proxy at 192.168.1.2."""
    app = create_app(dataclasses.replace(settings, proxies=("192.168.1.2",)), bench.registry())
    async with app.router.lifespan_context(app):
        yield app


async def guessed(app, peer, forwarded):
    """Return how many of eight guesses at unlike names are looked at."""
    async with browser_at(app, peer, **{"X-Forwarded-For": forwarded}) as opened:
        wrong = [{"name": f"Person {k}", "password": "not this one"} for k in range(8)]
        replies = [await opened.post("/api/v1/sign-ins", json=one) for one in wrong]
    return [reply.status_code for reply in replies].count(401)


async def test_behind_a_proxy_each_guesses_for_themselves(proxied):
    async with client_of(proxied) as opened:
        await first(opened)

    assert await guessed(proxied, "192.168.1.2", "203.0.113.1") == GUESSES
    assert await guessed(proxied, "192.168.1.2", "203.0.113.1") == 0
    assert await guessed(proxied, "192.168.1.2", "203.0.113.2") == GUESSES  # the shop still signs in
    assert await guessed(proxied, "192.168.1.2", "198.51.100.1, 203.0.113.2") == 0  # another name of the same


async def test_past_the_proxy_nobody_guesses_under_other_addresses(proxied):
    async with client_of(proxied) as opened:
        await first(opened)

    looked_at = [await guessed(proxied, "203.0.113.7", f"198.51.100.{k}") for k in range(3)]

    assert looked_at == [GUESSES, 0, 0]
