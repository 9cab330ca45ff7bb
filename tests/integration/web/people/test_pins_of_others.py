"""PINs of older versions count and are kept anew; those of a restored database do not, and that is said."""

import asyncio
import logging

from tests.helpers.web.clients import client_of
from tests.integration.web.people.conftest import ORIGIN, PASSWORD, PIN
from truepose.app import create_app
from truepose.domain.people.accounts import Role
from truepose.operation.people.hashes import chosen_hash
from truepose.storage.backup.addressed import back_up_at, restore_at
from truepose.storage.connection.address import database_file
from truepose.storage.integrity.taken_out import TAKEN_OUT
from truepose.storage.integrity.verification import verify_at
from truepose.storage.people.credentials import CredentialKind, NewCredential

PRESENT = "/api/v1/sign-ins/present"


async def signed_in(app):
    """Return Ada, and her browser."""
    accounts = app.state.context.people.accounts
    ada = accounts.register.named("Ada Byron")
    if ada is None:
        ada = await accounts.register.enter("Ada Byron", Role.ADMINISTRATOR, "a test")
        old = NewCredential(CredentialKind.PIN, ada.id, await asyncio.to_thread(chosen_hash, PIN))
        await accounts.register.put(old, "a test")
        old = NewCredential(CredentialKind.PASSWORD, ada.id, await asyncio.to_thread(chosen_hash, PASSWORD))
        await accounts.register.put(old, "a test")
    browser = client_of(app)
    browser.headers.update(ORIGIN)
    browser.cookies.set("truepose_sign_in", (await accounts.sign_ins.opened(ada, "cell 3")).secret)
    return ada, browser


async def shown(browser, **proof):
    return await browser.post(f"{PRESENT}/fresh", json=proof)


async def test_a_pin_of_an_older_version_is_kept_anew_when_it_is_used(app):
    ada, browser = await signed_in(app)
    register = app.state.context.people.accounts.register
    (before,) = register.of(ada.id, CredentialKind.PIN)

    wrong = await shown(browser, pin="9999")
    unchanged = register.of(ada.id, CredentialKind.PIN) == (before,)
    right = await shown(browser, pin=PIN)
    (after,) = register.of(ada.id, CredentialKind.PIN)
    again = await shown(browser, pin=PIN)

    assert (wrong.status_code, unchanged, right.status_code, again.status_code) == (401, True, 200, 200)
    assert before.hash.startswith("$argon2id")
    assert after.hash[8:].startswith("$argon2id")
    held = app.state.context.database
    kept = await held.read(
        lambda c: c.exec_driver_sql("SELECT hash FROM credentials WHERE kind = 'pin'").all()
    )
    assert [row[0] for row in kept] == [TAKEN_OUT, after.hash]
    assert verify_at(held.held.url).findings == ()


async def test_after_a_restore_passwords_count_and_pins_are_chosen_anew(settings, bench, tmp_path, caplog):
    copy = tmp_path / "copy.sqlite3"
    app = create_app(settings, bench.registry())
    async with app.router.lifespan_context(app):
        await shown((await signed_in(app))[1], pin=PIN)
    back_up_at(settings.database_url, copy)
    restore_at(copy, settings.database_url, replace=True)

    with caplog.at_level(logging.WARNING):
        app = create_app(settings, bench.registry())
        async with app.router.lifespan_context(app):
            _, browser = await signed_in(app)
            people = (await browser.get("/api/v1/people")).json()["people"]
            offered = (await browser.get(PRESENT)).json()["people"]
            by_pin = await shown(browser, pin=PIN)
            by_password = await shown(browser, password=PASSWORD)
            mine = {"present_password": PASSWORD, "pin": "190612"}
            chosen = await browser.put(f"{PRESENT}/secrets", json=mine)
            anew = await shown(browser, pin="190612")

    assert (by_pin.status_code, by_password.status_code) == (401, 200)
    assert "choose a PIN at /account" in by_pin.json()["detail"]
    assert (chosen.status_code, anew.status_code) == (200, 200)
    assert ([one["has_pin"] for one in people], offered) == ([False], [])
    assert "1 PINs do not count here" in caplog.text
    assert database_file(settings.database_url).with_name("truepose.sqlite3.pins").exists()
