"""What the program cannot do once the arm moves, on every screen whose button lets it move."""

import pytest
from playwright.sync_api import expect

from tests.browser.tablet.bench.fake_desk import leg, move
from tests.browser.tablet.bench.screens import shown
from tests.browser.tablet.conftest import a_tablet
from truepose.messages.catalogue import catalogue
from truepose.sessions.engine.interlocks import motion_notice
from truepose_drivers.api import MotionGuard

GUARDS = (MotionGuard(stops_unheard_s=0.8), MotionGuard(longest_piece_s=1.0), MotionGuard())


@pytest.fixture
def french(chromium, url):
    with a_tablet(chromium, url, language="fr") as page:
        page.goto(f"{url}/operator/3")
        page.locator("#simulated").wait_for()
        yield page


def test_it_is_said_as_the_service_says_it(desk, french):
    told = french.locator("#caution")
    for guard in GUARDS:
        notice = catalogue("fr").spoken(motion_notice(guard))
        desk.show(step=move(), ballbar_attached=False, motion_notice=notice)
        expect(told).to_contain_text(notice)


def test_it_is_said_where_a_motion_follows_and_nowhere_else(desk, tablet):
    told = tablet.locator("#caution")
    for screen in ("connect_leg", "detach", "moving", "doubt", "finished"):
        shown(tablet, desk, screen)
        assert not told.is_visible(), screen

    desk.show(state="paused", step=move())
    expect(told).to_be_visible()
    desk.show(state="paused", step=leg())
    expect(told).to_be_hidden()
    desk.show(state="running", step=move(), motion_notice=None)
    tablet.locator("body[data-screen=move]").wait_for()
    expect(told).to_be_hidden()
