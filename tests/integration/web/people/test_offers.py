"""What pages offer to whom: nobody is offered what they would be refused, and everybody may stop a robot."""

import pytest
import pytest_asyncio

from tests.helpers.web.pages import Page
from tests.integration.web.bench import session_request
from truepose.domain.people import Role
from truepose.reports.tables import Table
from truepose.web.pages import plan
from truepose.web.pages.rendering import render

in_one_loop = pytest.mark.asyncio(loop_scope="module")
HALTS = {"data-act=pause", "data-act=abort"}
MOVES = {"data-act=start", "data-act=confirm", "data-act=resume"}
NAMED = {"data-asks", "data-act", "data-bring", "data-throw-away"}
FORMS = {"close", "correct"}


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def planned(house):
    """The address of a session that waits for its start."""
    async with house.of(Role.OPERATOR) as operator:
        made = await operator.post("/api/v1/sessions", json=session_request())
    return made.headers["Location"].removeprefix("/api/v1")


async def offered(house, role, address):
    """Return what can be pressed on a page that does more than show something."""
    async with await house.browser(role) as browser:
        answer = await browser.get(address)
    assert answer.status_code == 200
    found = set()
    for _, attributes in Page(answer.text).elements:
        found |= {"data-act=" + attributes["data-act"]} if "data-act" in attributes else set()
        found |= NAMED & attributes.keys() - {"data-act"} | FORMS & {attributes.get("id")}
    return found


@in_one_loop
@pytest.mark.parametrize(
    ("address", "least", "what"),
    [
        ("/", Role.OPERATOR, {"data-bring", "data-asks"}),
        ("/bring", Role.OPERATOR, {"data-bring"}),
        ("/sessions/new", Role.OPERATOR, {"data-asks"}),
        ("{planned}", Role.OPERATOR, MOVES),
        ("{planned}/closing", Role.METROLOGIST, {"close"}),
    ],
)
async def test_a_page_offers_what_whoever_looks_may_do(house, planned, address, least, what):
    page = address.format(planned=planned)
    below = {Role.OPERATOR: Role.VIEWER, Role.METROLOGIST: Role.OPERATOR}[least]

    assert what <= await offered(house, least, page)
    assert (await offered(house, below, page)) - HALTS == set()


def without_a_figure(_, limit_mm, words, *, plans):
    shown = {
        "outcome": "",
        "limit": limit_mm,
        "sentences": [],
        "figure": "",
        "curve": Table([], []),
        "numbers": [],
    }
    return render("sessions/plan_told.html", n=30, plans=plans, words=words, say=words.say, **shown)


@in_one_loop
async def test_a_plan_that_was_drawn_for_one_is_offered_to_those_alone_who_may(house, monkeypatch):
    async def promised(*_):
        return None

    monkeypatch.setattr(house.app.state.context.promise_desk, "promise", promised)
    monkeypatch.setattr(plan, "_rendered", without_a_figure)

    roles = (Role.OPERATOR, Role.VIEWER, Role.OPERATOR)
    assert [await offered(house, role, "/plan?n=30&whole=true") for role in roles] == [
        {"data-asks"},
        set(),
        {"data-asks"},
    ]


@in_one_loop
async def test_a_viewer_may_stop_a_robot_from_the_page_of_its_session(house, planned):
    assert await offered(house, Role.VIEWER, planned) == HALTS


@in_one_loop
@pytest.mark.parametrize(("role", "hidden"), [(Role.VIEWER, True), (Role.OPERATOR, False)])
async def test_the_tablet_says_who_is_signed_in_and_plans_for_operators(house, role, hidden):
    async with await house.browser(role) as browser:
        page = Page((await browser.get("/operator")).text)

    planning = next(attributes for _, attributes in page.elements if attributes.get("class") == "new")
    assert ("hidden" in planning) is hidden
    assert house.people[role].name in page.text
