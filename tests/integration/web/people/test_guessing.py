"""A stranger who guesses gets nowhere, and keeps nobody out, neither at the door nor at a tablet."""

import pytest

from tests.helpers.web.clients import served
from tests.integration.web.people.conftest import PASSWORD, PIN, browser_at
from truepose.app import create_app
from truepose.people.attempts import FROM_ALL_ADDRESSES, GUESSES, WRONG_PINS

PRESENT = "/api/v1/sign-ins/present"
ADA = {"name": "Ada Byron", "password": PASSWORD}
WRONG = {"name": "Ada Byron", "password": "not this one"}


@pytest.fixture
async def entered(app, accounts):
    """A service in which Ada is entered and nobody has signed in; gives its accounts."""
    async with browser_at(app, "192.168.1.10") as browser:
        first = {"secret": accounts.first_secret, "name": "Ada Byron", "password": PASSWORD, "pin": PIN}
        told = await browser.post("/api/v1/first-person", json=first)
        assert told.status_code == 201, told.text
    return accounts


async def asked(app, address, path, body, cookies=None):
    """Return the status of a request from an address."""
    async with browser_at(app, address) as browser:
        browser.cookies.update(cookies or {})
        return (await browser.post(path, json=body)).status_code


async def tried(app, address, body, times=1):
    return [await asked(app, address, "/api/v1/sign-ins", body) for _ in range(times)]


async def test_wrong_passwords_from_one_address_keep_nobody_out_elsewhere(app, entered):
    assert await tried(app, "203.0.113.7", WRONG, 8) == [401] * GUESSES + [429] * 3

    assert await tried(app, "192.168.1.10", ADA) == [201]
    assert await tried(app, "192.168.1.99", ADA) == [201]  # also where she never was


async def test_a_pin_before_a_motion_is_taken_whatever_strangers_guess(app, entered):
    tablet = await entered.sign_ins.opened(entered.register.require("Ada Byron"), "cell 3")
    for address in ("203.0.113.7", "127.0.0.1"):  # from the tablet's own address as well
        assert 429 in await tried(app, address, WRONG, 8)

    here = {"truepose_sign_in": tablet.secret}
    assert await asked(app, "127.0.0.1", f"{PRESENT}/fresh", {"pin": PIN}, here) == 200


async def test_guesses_from_everywhere_are_few_and_known_places_stay_open(app, entered, later):
    most = FROM_ALL_ADDRESSES.at_once
    codes = [(await tried(app, f"198.51.100.{k}", WRONG))[0] for k in range(most + 3)]
    later(FROM_ALL_ADDRESSES.refill_s)
    codes += [(await tried(app, f"198.51.101.{k}", WRONG))[0] for k in range(3)]

    assert codes == [401] * most + [429] * 3 + [401] + [429] * 2
    assert await tried(app, "203.0.113.9", ADA) == [429]  # nobody has seen her there
    assert await tried(app, "192.168.1.10", ADA) == [201]


async def test_one_network_of_ipv6_is_one_address(app, entered):
    codes = [(await tried(app, f"2001:db8:1:2::{k:x}", WRONG))[0] for k in range(1, 9)]

    assert codes == [401] * GUESSES + [429] * 3
    assert await tried(app, "2001:db8:1:3::1", ADA) == [201]


async def test_unknown_names_are_limited_like_known_ones(app, entered):
    nobody = {"name": "Nobody Here", "password": "not this one"}

    codes = [(await tried(app, f"198.51.100.{k}", nobody))[0] for k in range(FROM_ALL_ADDRESSES.at_once + 3)]

    assert codes == [401] * FROM_ALL_ADDRESSES.at_once + [429] * 3


async def test_known_places_outlast_the_service(settings, bench):
    app = create_app(settings, bench.registry())
    async with app.router.lifespan_context(app):
        accounts = app.state.context.people.accounts
        async with browser_at(app, "192.168.1.10") as browser:
            first = {"secret": accounts.first_secret, "name": "Ada Byron", "password": PASSWORD}
            await browser.post("/api/v1/first-person", json=first)
            assert (await browser.delete(PRESENT)).status_code == 204

    async with served(settings, bench.registry()) as client:
        again = client._transport.app
        for k in range(FROM_ALL_ADDRESSES.at_once):
            assert await tried(again, f"198.51.100.{k}", WRONG) == [401]

        assert await tried(again, "203.0.113.9", ADA) == [429]
        assert await tried(again, "192.168.1.10", ADA) == [201]


async def test_pins_guessed_at_one_tablet_leave_the_others_alone(app, entered, later):
    await entered.register.enter("Vera Rubin", entered.register.people[0].role, "a test")
    ada, vera = (entered.register.require(name) for name in ("Ada Byron", "Vera Rubin"))
    hers = await entered.sign_ins.opened(ada, "cell 3")
    guess = {"name": "Ada Byron", "pin": "9999"}
    for k in range(3):  # signing in again and again gives no further guesses
        foreign = {"truepose_sign_in": (await entered.sign_ins.opened(vera, f"tablet {k}")).secret}
        for _ in range(WRONG_PINS):
            later(60)
            assert await asked(app, "192.168.1.11", f"{PRESENT}/person", guess, foreign) == 401

    right = {"name": "Ada Byron", "pin": PIN}
    assert await asked(app, "192.168.1.11", f"{PRESENT}/person", right, foreign) == 401
    here = {"truepose_sign_in": hers.secret}
    assert await asked(app, "192.168.1.10", f"{PRESENT}/fresh", {"pin": PIN}, here) == 200
