"""PINs of a restored database do not count, and that is said."""

import logging

from tests.helpers.web.clients import client_of
from tests.integration.web.people.conftest import ORIGIN, PASSWORD, PIN
from truepose.app import create_app
from truepose.domain.people import Role
from truepose.people.secrets import chosen_hash
from truepose.storage.backup.schedule import back_up_at, restore_at
from truepose.storage.engine.address import database_file
from truepose.storage.people import CredentialKind, NewCredential

PRESENT = "/api/v1/sign-ins/present"


async def signed_in(app):
    """Return Ada, and her browser."""
    accounts = app.state.context.people.accounts
    ada = accounts.register.named("Ada Byron")
    if ada is None:
        ada = await accounts.register.enter("Ada Byron", Role.ADMINISTRATOR, "a test")
        for kind, kept in (
            (CredentialKind.PIN, accounts.pins.kept(PIN)),
            (CredentialKind.PASSWORD, chosen_hash(PASSWORD)),
        ):
            await accounts.register.put(ada, [NewCredential(kind, ada.id, kept)], by="a test")
    browser = client_of(app)
    browser.headers.update(ORIGIN)
    browser.cookies.set("truepose_sign_in", (await accounts.sign_ins.opened(ada, "cell 3")).secret)
    return ada, browser


async def shown(browser, **proof):
    return await browser.post(f"{PRESENT}/fresh", json=proof)


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
    assert "PINs (1) are no longer valid because the database was restored" in caplog.text
    assert database_file(settings.database_url).with_name("truepose.sqlite3.pins").exists()
