"""Coming in, in a browser: by password, PIN, badge and link, wrongly, and after the sign-in has ended."""

import contextlib
from dataclasses import dataclass

import httpx
import pytest
from argon2 import PasswordHasher
from playwright.sync_api import expect

from tests.browser.windows import without_complaint
from tests.integration.web.bench import CELL, Bench
from tests.integration.web.listening import listening
from truepose.app import create_app
from truepose.people import secrets, sign_ins
from truepose.settings import Settings

PASSWORD, PIN, BADGE = "on the looms of Lyon", "4071", "04A1B2C3D4"
ADA, ALAN = "Ada Byron", "Alan Turing"
REFUSED = "Failed to load resource"  # Chromium's own word for an answer of 401


@pytest.fixture(scope="module")
def cheap_hashes():
    """Hashes that cost nothing: what they are worth is tried elsewhere."""
    hasher = PasswordHasher(time_cost=1, memory_cost=8, parallelism=1)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(secrets, "_HASHER", hasher)
        patch.setattr(secrets, "MEMORY_KIB", 8)
        patch.setattr(sign_ins, "NOBODYS", hasher.hash("of nobody"))
        yield


@dataclass
class House:
    """A service that knows two people; one of them has a badge."""

    url: str
    administrator: httpx.Client

    def ask(self, method, path, **body):
        answer = self.administrator.request(method, f"/api/v1{path}", json=body)
        assert answer.is_success, answer.text
        return answer.json() if answer.content else None

    def link_of(self, name):
        return self.url + self.ask("POST", "/people", name=name, role="operator")["link"]


@pytest.fixture(scope="module")
def house(tmp_path_factory, cheap_hashes):
    folder = tmp_path_factory.mktemp("house")
    (folder / "cell.toml").write_text(CELL)
    where = Settings(database_url=f"sqlite:///{folder}/t.sqlite3", cell_file=folder / "cell.toml")
    application = create_app(where, Bench().registry())
    with listening(application) as url, httpx.Client(base_url=url, headers={"Origin": url}) as client:
        client.get("/health").raise_for_status()  # it is there
        opens = application.state.context.people.accounts.first_secret
        house = House(url, client)
        house.ask("POST", "/first-person", secret=opens, name=ADA, password=PASSWORD, pin=PIN)
        house.ask("PUT", "/sign-ins/present/secrets", present_password=PASSWORD, badge=BADGE)
        yield house


@contextlib.contextmanager
def before(chromium, house):
    with chromium.one(house.url) as page, without_complaint(page, house.url, [REFUSED]):
        yield page


def come_in(page, house, to="/", name=ADA, password=PASSWORD):
    page.goto(house.url + to)
    page.locator("main [name=name]").fill(name)
    page.locator("main [name=password]").fill(password)
    page.get_by_role("button", name="Sign in").click()


def present(page):
    return page.locator("details.person summary")


def test_a_link_lets_somebody_choose_how_they_come_in_and_works_once(chromium, house):
    link = house.link_of(ALAN)
    with before(chromium, house) as page:
        page.goto(link)
        for field, secret in (("password", PASSWORD), ("repeated", PASSWORD), ("pin", "1906")):
            page.locator(f"main [name={field}]").fill(secret)
        page.get_by_role("button", name="Set password").click()
        expect(present(page)).to_have_text(ALAN)

        page.goto(link)
        expect(page.locator("h1")).to_have_text("This link is no longer valid")


def test_a_password_leads_to_the_page_that_was_wanted_and_a_wrong_one_nowhere(chromium, house):
    with before(chromium, house) as page:
        come_in(page, house, "/work?q=left+arm", password="a guess of ten letters")
        expect(page.locator("#sign-in output")).to_contain_text("Wrong name or password")
        expect(page.locator("main [name=name]")).to_have_value(ADA)

        page.locator("main [name=password]").fill(PASSWORD)
        page.get_by_role("button", name="Sign in").click()
        page.wait_for_url("**/work?q=left+arm")
        expect(present(page)).to_have_text(ADA)


def test_somebody_else_comes_to_the_tablet_by_pin_and_by_badge(chromium, house):
    with before(chromium, house) as page:
        come_in(page, house)
        house.ask("POST", "/people", name="Edith Clarke", role="viewer")  # has no PIN: is not asked for
        present(page).click()
        page.get_by_role("button", name="Switch user").click()
        names = page.locator("dialog .names button")
        expect(names.first).to_be_visible()
        assert "Edith Clarke" not in names.all_inner_texts()

        page.locator("dialog [name=badge]").fill(BADGE)
        page.keyboard.press("Enter")
        for key in ("9", "9", "9", "9", "ok"):
            page.locator(f"dialog [data-key='{key}']").click()
        expect(page.locator("dialog output")).to_contain_text("PIN")
        for key in (*PIN, "ok"):
            page.locator(f"dialog [data-key='{key}']").click()
        page.locator("dialog").wait_for(state="detached")
        expect(present(page)).to_have_text(ADA)


def test_what_stands_in_a_form_outlives_the_sign_in(chromium, house):
    with before(chromium, house) as page:
        come_in(page, house, "/people")
        name = page.locator("#enter [name=name]")
        name.fill("Rosalind Franklin")
        page.context.clear_cookies()  # as after a week, or where somebody revoked it

        page.locator("#enter button").click()
        page.locator("dialog [name=password]").fill(PASSWORD)
        page.locator("dialog [data-key=ok]").click()
        expect(page.locator("#enter output")).to_have_text(
            "Signed in again. Press the button again to continue."
        )
        expect(name).to_have_value("Rosalind Franklin")

        page.locator("#enter button").click()
        expect(page.locator("#listed")).to_contain_text("Rosalind Franklin")
        expect(name).to_have_value("")


def test_what_is_sent_before_the_scripts_are_there_is_sent_once_and_in_no_address(chromium, house):
    asked = []
    with before(chromium, house) as page:
        waiting = []
        page.route("**/static/people.js", lambda route: waiting.append(route))
        page.on("request", lambda request: asked.append((request.method, request.url)))
        with page.expect_request("**/static/people.js"):
            page.goto(f"{house.url}/sign-in", wait_until="commit")
        page.locator("main [name=name]").fill(ADA)
        page.locator("main [name=password]").fill(PASSWORD)
        page.get_by_role("button", name="Sign in").click()
        for route in waiting:
            route.continue_()
        page.unroute("**/static/people.js")  # the next page has it at once, whenever it asks
        expect(present(page)).to_have_text(ADA)

    assert [url for method, url in asked if method == "POST"] == [f"{house.url}/api/v1/sign-ins"]
    assert not any("Lyon" in url for _, url in asked)


def test_what_is_pressed_before_the_scripts_are_there_is_pressed_then(chromium, house):
    with before(chromium, house) as page:
        come_in(page, house)
        expect(present(page)).to_have_text(ADA)
        waiting = []
        page.route("**/static/shell.js", lambda route: waiting.append(route))
        page.goto(house.url, wait_until="commit")
        present(page).click()
        page.get_by_role("button", name="Switch user").click()
        for route in waiting:
            route.continue_()
        expect(page.locator("dialog [name=badge]")).to_be_visible()
