"""What the program cannot do once the arm moves, on every screen whose button lets it move."""

import pytest
from playwright.sync_api import expect

from tests.browser.tablet.bench.fake_desk import leg, move
from tests.browser.tablet.conftest import a_tablet
from tests.browser.tablet.test_screens import shown
from tests.browser.tablet.test_stop_is_there import NOTICES, OUT_OF_REACH
from truepose.sequencing.engine.notices import motion_notice
from truepose_drivers.api import MotionGuard

ASKING = ("planned", "move", "interrupted", "foreign")
SIZES = [(360, 640), (390, 844), (844, 390), (1024, 768), (800, 1280), (1440, 900)]
LONGEST = motion_notice(MotionGuard(stops_unheard_s=0.8))
LETTERS_PX = "n => parseFloat(getComputedStyle(n).fontSize)"
SAID = [
    (
        MotionGuard(stops_unheard_s=0.8),
        "If program or connection fails, the controller stops the arm by itself within 0.8 s.",
        "Si programme ou liaison tombe en panne, le contrôleur arrête lui-même le bras en 0,8 s au plus.",
    ),
    (
        MotionGuard(longest_piece_s=1.0),
        "If program or connection fails, the arm goes on for up to 1 s.",
        "Si programme ou liaison tombe en panne, le bras continue 1 s au plus.",
    ),
    (
        MotionGuard(),
        "If program or connection fails, the arm goes on to its target.",
        "Si programme ou liaison tombe en panne, le bras continue jusqu\u2019à sa cible.",
    ),
]


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


def test_it_is_said_in_few_words_of_each_language(desk, french):
    told = french.locator("#caution")
    for guard, _, said in SAID:
        desk.show(step=move(), ballbar_attached=False, motion_notice=motion_notice(guard))
        expect(told).to_contain_text(f"Seul l\u2019arrêt d\u2019urgence arrête le bras aussitôt. {said}")

    french.get_by_label("Langue").select_option("en")

    for guard, said, _ in SAID:
        desk.show(motion_notice=motion_notice(guard))
        expect(told).to_have_text(f"Only the emergency stop stops the arm at once. {said}")


def test_a_sentence_that_the_page_does_not_know_stays_as_it_is(desk, french):
    desk.show(step=move(), ballbar_attached=False, motion_notice=f"{LONGEST} The brakes are slow.")

    expect(french.locator("#caution p")).to_have_text(f"{LONGEST} The brakes are slow.")
    expect(french.locator("#caution p")).to_have_attribute("lang", "en")


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
