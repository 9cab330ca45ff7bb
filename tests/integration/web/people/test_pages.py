"""Pages of signing in, people and acts: what they show, and to whom."""

import pytest

from tests.helpers.web.clients import served
from tests.helpers.web.pages import Page, links
from truepose.domain.people import Role
from truepose.settings import Settings

in_one_loop = pytest.mark.asyncio(loop_scope="module")


async def test_an_open_service_says_so_and_leads_to_the_first_person(client, app):
    page = await client.get("/")
    way = f"/first-person/{app.state.context.people.accounts.first_secret}"

    assert way in links(page)
    assert "No users yet: add an administrator" in Page(page.text).text
    assert "First administrator" in Page((await client.get(way)).text).text


async def test_without_accounts_pages_say_so_and_lead_nowhere(settings, bench):
    off = Settings(settings.database_url, cell_file=settings.cell_file, accounts=False)
    async with served(off, bench.registry()) as client:
        page = await client.get("/")
        over = await client.get(
            f"/first-person/{client._transport.app.state.context.people.accounts.first_secret}"
        )

    assert "Accounts are off" in Page(page.text).text
    assert not any(href and href.startswith("/first-person") for href in links(page))
    assert over.status_code == 401


@pytest.mark.parametrize(
    ("path", "sees"),
    [
        ("/sign-in", "Password"),
        ("/account", "Current password"),
        ("/people", "Alan Turing"),
        ("/people?language=fr", "Personnes et programmes"),
        ("/audit", "Audit log"),
        ("/audit?q=nothing+like+it", "No entries yet."),
        ("/sessions", "Ada Byron"),
    ],
)
@in_one_loop
async def test_an_administrator_sees_every_page(house, path, sees):
    async with await house.browser(Role.ADMINISTRATOR) as browser:
        answer = await browser.get(path)

    assert answer.status_code == 200
    assert sees in Page(answer.text).text


@in_one_loop
async def test_the_way_to_a_page_is_shown_to_whom_it_is_open(house):
    ways, open_to = {}, {"/people", "/audit", "/account"}
    for role in (Role.ADMINISTRATOR, Role.METROLOGIST, Role.VIEWER):
        async with await house.browser(role) as browser:
            ways[role] = open_to & set(links(await browser.get("/sessions")))

    assert ways == {
        Role.ADMINISTRATOR: {"/people", "/audit", "/account"},
        Role.METROLOGIST: {"/audit", "/account"},
        Role.VIEWER: {"/account"},
    }


@in_one_loop
async def test_a_page_for_others_says_so_and_lets_them_come(house):
    async with await house.browser(Role.OPERATOR) as browser:
        answer = await browser.get("/people", follow_redirects=True)

    assert answer.status_code == 403
    assert "Alan Turing is signed in as operator" in Page(answer.text).text


@in_one_loop
async def test_a_link_shows_for_whom_it_is_and_nothing_once_it_was_used(house):
    accounts = house.here.accounts
    eve = await accounts.register.enter("Eve", Role.VIEWER, "a test")
    secret = await accounts.link(eve, "a test")
    async with house.client() as browser:
        good = await browser.get(f"/welcome/{secret}")
        bad = await browser.get(f"/welcome/{secret[::-1]}")
    await accounts.register.remove(eve, "a test")

    assert "Welcome, Eve" in Page(good.text).text
    assert (bad.status_code, "is no longer valid" in bad.text) == (401, True)
