"""What the program cannot do once the arm moves, on every screen whose button lets it move."""

import pytest
from playwright.sync_api import expect

from tests.browser.tablet.bench.fake_desk import leg, move
from tests.browser.tablet.conftest import a_tablet
from tests.browser.tablet.test_screens import shown
from tests.browser.tablet.test_stop_is_there import NOTICES, OUT_OF_REACH
from truepose.messages.catalogue import catalogue, english
from truepose.sessions.engine.interlocks import motion_notice
from truepose_drivers.api import MotionGuard

ASKING = ("planned", "move", "interrupted", "foreign")
SIZES = [(360, 640), (390, 844), (844, 390), (1024, 768), (800, 1280), (1440, 900)]
LONGEST = english(motion_notice(MotionGuard(stops_unheard_s=0.8)))
LETTERS_PX = "n => parseFloat(getComputedStyle(n).fontSize)"
GUARDS = (MotionGuard(stops_unheard_s=0.8), MotionGuard(longest_piece_s=1.0), MotionGuard())


@pytest.fixture
def french(chromium, url):
    with a_tablet(chromium, url, language="fr") as page:
        page.goto(f"{url}/operator/3")
        page.locator("#simulated").wait_for()
        yield page


def test_it_is_in_view_beside_stop_and_what_confirms_at_every_size_with_notices_open(desk, french):
    wrong = {}
    desk.show(motion_notice=LONGEST)
    for screen in ASKING:
        shown(french, desk, screen)
        for width, height in SIZES:
            french.set_viewport_size({"width": width, "height": height})
            french.evaluate(NOTICES)
            found = french.evaluate(OUT_OF_REACH, "#caution, #actions button, .dock button")
            letters = french.locator("#caution strong").evaluate(LETTERS_PX)
            least = 22 if min(width, height) >= 700 else 15
            wrong |= {(screen, width): found or letters} if found or letters < least else {}

    assert wrong == {}


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
