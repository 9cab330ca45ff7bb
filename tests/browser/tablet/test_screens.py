"""Every screen, in three languages, at every size: what is there, how large, and where."""

import itertools

import pytest
from playwright.sync_api import expect

from tests.browser.tablet.bench.fake_desk import FakeDesk, leg, scene, step
from tests.browser.tablet.bench.screens import (
    COVERED,
    FAINT_TEXTS,
    SCREENS,
    SIZES,
    STATES,
    drawn,
    looked_at,
    resized,
    shown,
)
from tests.browser.tablet.conftest import a_tablet, served
from truepose.messages.catalogue import english
from truepose.sessions.engine.interlocks import motion_notice
from truepose_drivers.api import MotionGuard

UPRIGHT, LYING = (800, 1280), (1280, 800)  # of tablets, on which a whole screen is seen
ASKING = ("planned", "move", "interrupted", "foreign")  # screens whose button lets the arm move
WARNED = [(360, 640), (390, 844), (844, 390), (1024, 768), UPRIGHT, (1440, 900)]
LONGEST = english(motion_notice(MotionGuard(stops_unheard_s=0.8)))
ANOTHER = {"tablet": "another", "person": "Wilhelmina Featherstonehaugh"}
LAYOUTS = {"en": [UPRIGHT, LYING], "fr": [UPRIGHT], "de": [LYING]}
OVERLAPPING_NAMES = """() => {
  const place = (node) => node.getBoundingClientRect();
  const tags = [...document.querySelectorAll("#picture .tag rect")].map(place);
  const frame = place(document.querySelector("#picture"));
  const outside = tags.filter((a) => a.left < frame.left || a.right > frame.right
    || a.top < frame.top || a.bottom > frame.bottom);
  let pairs = 0;
  tags.forEach((a, i) => tags.slice(i + 1).forEach((b) => {
    if (Math.min(a.right, b.right) - Math.max(a.left, b.left) > 0
        && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 0) pairs += 1;
  }));
  return { tags: tags.length, pairs, outside: outside.length };
}"""


class Walk:
    """What a walk through every screen in one language found."""

    def __init__(self, language):
        self.language = language
        self.looks = {}  # by screen and size
        self.covered = []  # where something is told beside the screen itself
        self.faint = []

    def through(self, page, desk):
        desk.show(motion_notice=LONGEST)
        for screen in SCREENS:
            desk.show(acting=None, swaps_can_be_seen=True)
            shown(page, desk, screen)
            self._look(page, screen)
            desk.show(acting=ANOTHER, swaps_can_be_seen=False)
            expect(page.locator("#who")).to_contain_text(ANOTHER["person"])
            self._look_again(page, (screen, "another acts"))
        desk.show(acting=None)
        self._advised(page, desk)
        page.context.set_offline(True)
        page.locator("#lost").wait_for()
        self._look_again(page, "lost")

    def _look(self, page, screen):
        warned = WARNED if self.language == "fr" and screen in ASKING else []
        every = SIZES if self.language == "en" else []
        for size in dict.fromkeys([*LAYOUTS[self.language], *every, *warned]):
            self.looks[screen, size] = looked_at(page, size)

    def _advised(self, page, desk):
        shown(page, desk, "connect_leg")
        for swaps_can_be_seen in (True, False):
            desk.show(swaps_can_be_seen=swaps_can_be_seen)
            expect(page.locator("#hint")).to_be_visible(visible=not swaps_can_be_seen)
            for state, said in STATES.items():
                desk.sample = said
                page.locator(f"#gauge[data-state={state}]").wait_for()
                drawn(page)
                self._look_again(page, (state, swaps_can_be_seen))

    def _look_again(self, page, where):
        for size in LAYOUTS[self.language]:
            resized(page, size)
            self.covered += [(where, size, found) for found in page.evaluate(COVERED)]
            self.faint += [(where, size, text) for text in page.evaluate(FAINT_TEXTS)]

    def wrong(self, judged, sizes=None):
        """Return what is judged to be wrong, by screen and size."""
        found = {at: judged(look) for at, look in self.looks.items() if at[1] in (sizes or [at[1]])}
        return {at: wrong for at, wrong in found.items() if wrong}


@pytest.fixture(scope="module", params=LAYOUTS)
def walk(request, chromium, door):
    """One walk through all screens, of which each is measured at every size while it is there."""
    desk, walk = FakeDesk(), Walk(request.param)
    with served(desk, door) as url, a_tablet(chromium, url, language=walk.language, may_fail=True) as page:
        page.goto(f"{url}/operator/3")
        page.locator("#simulated").wait_for()
        walk.through(page, desk)
    return walk


def test_the_controls_are_at_the_same_place_on_every_screen(walk):
    for size in LAYOUTS[walk.language]:
        places = walk.looks["connect_leg", size]["dock"]
        assert [name.split()[1] for name, *_ in places] == ["back", "retry", "skip", "pause", "abort", "stop"]
        assert min(height for *_, height in places) >= 72
        at = [box[1:] for box in places]
        assert walk.wrong(lambda look, at=at: [box[1:] for box in look["dock"]] != at, [size]) == {}


def test_main_buttons_are_large_and_names_are_readable(walk):
    sizes = LAYOUTS[walk.language]
    assert walk.wrong(lambda look: [height for height in look["heights"] if height < 72], sizes) == {}
    assert walk.wrong(lambda look: look["letters"] < 48 or look["capitals"] != "uppercase", sizes) == {}


def test_nothing_is_cut_or_covered_and_every_text_stands_out(walk):
    sizes = LAYOUTS[walk.language]
    assert walk.wrong(lambda look: look["covered"] or look["faint"] or look["beyond"], sizes) == {}


def test_nothing_that_is_told_covers_or_pushes_away_anything(walk):
    assert walk.covered == []
    assert walk.faint == []


def test_stop_what_confirms_and_what_it_cannot_do_are_in_reach_with_notices_open(walk):
    assert walk.wrong(lambda look: look["out_of_reach"]) == {}


def test_that_a_motion_cannot_be_stopped_from_here_is_large_enough_to_read(walk):
    for size in LAYOUTS[walk.language]:
        assert min(walk.looks[screen, size]["warning"] for screen in ASKING) >= 22
    assert walk.wrong(lambda look: look["warning"] is not None and look["warning"] < 15) == {}


def test_pose_leg_and_attempt_can_always_be_read(desk, chromium, url):
    with a_tablet(chromium, url, language="fr") as page:
        page.goto(f"{url}/operator/3")
        desk.show(step=leg(attempt=2, index=122, count=431), acting={"tablet": "another", "person": "Ada"})

        where = page.locator("#where")
        expect(where).to_have_text("Étape 122 sur 431, emplacement 1, pose 12, jambe 4 sur 6, essai 2")
        cut = "n => n.scrollWidth > n.clientWidth + 1 || n.getBoundingClientRect().right > innerWidth"
        for size in (UPRIGHT, LYING):
            resized(page, size)
            assert where.evaluate(cut) is False, size


def test_where_the_base_goes_is_said_in_numbers(desk, tablet):
    shown(tablet, desk, "place_base")

    rows = tablet.locator("#panel tbody tr")
    # From the robot's base at the origin: x, y, height, and 409 mm = hypot(380, 150) from its axis.
    expect(rows.nth(0)).to_have_text("B1380\u221215060409")
    expect(rows).to_have_count(3)
    # B1 to B2 goes 260 mm along x and 150 mm along y: 30 degrees.
    expect(tablet.locator("#panel")).to_contain_text("B1→B2 points 30° anticlockwise from x")

    # They are from the robot wherever it stands.
    told = scene()
    desk.scene = {**told, "arm_mm": [(100.0, 50.0, 20.0)], "points": told["points"][:3]}
    tablet.reload()

    expect(tablet.locator("#panel tbody tr").nth(0)).to_have_text("B1280\u221220040344")


def test_an_arm_whose_angles_nobody_knows_is_not_drawn(desk, tablet):
    told = scene()
    desk.scene = {**told, "arm_mm": told["arm_mm"][:1], "points": told["points"][:3]}
    desk.show(step=step("place_base"))

    expect(tablet.locator("#picture .tag.moment")).to_have_text("robot")
    expect(tablet.locator("#picture .arm path")).to_have_count(0)
    assert tablet.evaluate(OVERLAPPING_NAMES) == {"tags": 4, "pairs": 0, "outside": 0}


def test_a_robot_of_which_only_the_base_is_known_is_a_picture_too(desk, tablet):
    desk.scene = {**scene(), "arm_mm": [(100.0, 50.0, 20.0)], "points": []}
    desk.show(step=step("initialise", artefact="tool"))

    expect(tablet.locator("#picture .tag")).to_have_text(["robot"])


def test_a_tool_whose_arm_is_unknown_is_seen_from_near(desk, tablet):
    told = scene()
    desk.scene = {
        **told,
        "arm_mm": told["arm_mm"][:1],
        "points": told["points"][3:],
        "look_at_mm": (535, 15, 335),
    }
    desk.show(step=step("measure_side", artefact="tool", points=["T1", "T2"]))

    expect(tablet.locator("#names")).to_have_text("T1T2")  # drawn with it: no picture of the step before
    expect(tablet.locator("#picture")).to_be_visible()
    expect(tablet.locator("#picture .tag")).to_have_count(3)
    # Three nests over the width of the picture; with the base, 560 mm away, they would be close together.
    tablet.wait_for_function(
        """() => {
          const balls = [...document.querySelectorAll("#picture .ball")];
          const at = balls.map((ball) => ball.getBoundingClientRect().x);
          return Math.max(...at) - Math.min(...at) > 0.2 * innerWidth;
        }"""
    )


def test_why_nothing_goes_on_is_shown_as_the_service_says_it(desk, tablet):
    desk.show(state="awaiting_confirmation", reason="Axis 3 is not where it was left.")

    expect(tablet.locator("#panel .reason")).to_have_text("Axis 3 is not where it was left.")


def test_the_service_is_asked_in_the_language_that_is_chosen(desk, chromium, url):
    def asked(page, act, path):
        with page.expect_request(lambda request: request.url.partition("?")[0].endswith(path)) as sent:
            act()
        return sent.value.headers["accept-language"]

    with a_tablet(chromium, url, language="fr") as page:
        assert asked(page, lambda: page.goto(f"{url}/operator/3"), "/live") == "fr"
        page.locator("#simulated").wait_for()
        language = page.get_by_label("Langue")

        assert asked(page, lambda: language.select_option("de"), "/live") == "de"
        expect(page.locator("html")).to_have_attribute("lang", "de")


def test_a_pause_needs_no_reason_below_its_title(desk, tablet):
    desk.show(state="paused", reason="A pause was requested.", reason_key="session.pause_asked")

    expect(tablet.locator("#names")).to_have_text("PAUSED")
    expect(tablet.locator("#panel")).to_be_hidden()


def test_the_picture_shows_the_pair_and_no_name_lies_on_another(desk, tablet):
    for base, tool in [(1, 1), (1, 2), (2, 1), (2, 2), (2, 3), (3, 1), (3, 3)]:
        desk.show(step=leg(base, tool))

        expect(tablet.locator(f"#picture .tag.asked[data-name=B{base}]")).to_be_visible()
        expect(tablet.locator(f"#picture .tag.asked[data-name=T{tool}]")).to_be_visible()
        expect(tablet.locator("#picture .tag.asked")).to_have_count(2)
        expect(tablet.locator("#picture .ballbar.asked")).to_have_count(1)
        assert tablet.evaluate(OVERLAPPING_NAMES) == {"tags": 6, "pairs": 0, "outside": 0}, (base, tool)


def test_names_keep_apart_from_wherever_the_person_looks(desk, tablet):
    views = tablet.locator("#picture .ground")
    for tool, stand_mm in enumerate([
        (1500, 900, 1600),
        (-900, 100, 900),
        (480, -30, 2500),
        (480, 1800, 150),
    ]):
        before = views.get_attribute("d")
        desk.scene = {**scene(), "stand_mm": stand_mm}
        desk.show(step=leg(3, 1, pose=20 + tool))

        expect(views).not_to_have_attribute("d", before)
        expect(tablet.locator("#picture .tag.asked")).to_have_count(2)
        assert tablet.evaluate(OVERLAPPING_NAMES) == {"tags": 6, "pairs": 0, "outside": 0}, stand_mm


def test_what_is_left_of_the_person_is_left_in_the_picture(desk, tablet):
    # The person stands at +x and looks back along x: +y is on the right hand.
    points = [("B1", (0, -100, 0), "cup"), ("T1", (0, 100, 50), "nest"), ("T2", (0, 0, 200), "nest")]
    told = [{"name": name, "position_mm": at, "kind": kind} for name, at, kind in points]
    desk.scene = {**scene(), "points": told, "stand_mm": (2000, 0, 300), "look_at_mm": (0, 0, 50)}
    desk.show(step=leg(1, 1))
    # The scene before has a T2 as well: the new one is drawn once its three points are all that there is.
    expect(tablet.locator("#picture .ball")).to_have_count(3)

    places = tablet.locator("#picture .ball").evaluate_all(
        "all => all.map(ball => [ball.getAttribute('cx'), ball.getAttribute('cy')].map(Number))"
    )
    t2, t1, b1 = places  # what is asked for lies on top, so it is drawn last

    assert b1[0] < t2[0] < t1[0]
    assert t2[1] < b1[1]


def test_the_screen_that_moves_the_robot_looks_like_no_other(desk, tablet):
    shown(tablet, desk, "move")

    expect(tablet.locator("#names")).to_have_text("ROBOT MOVES")
    expect(tablet.locator("#picture .arm")).to_have_count(2)  # where it is, and where it goes
    assert tablet.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(20, 24, 28)"


def test_the_page_speaks_the_language_that_was_chosen(desk, tablet):
    tablet.get_by_label("Language").select_option("fr")

    expect(tablet.locator("#word")).to_have_text("Dans la plage")
    expect(tablet.locator("#length")).to_have_text("300,421 mm")
    expect(tablet.locator("html")).to_have_attribute("lang", "fr")
    tablet.reload()
    expect(tablet.locator("#kicker")).to_have_text("Poser le ballbar")


def test_the_record_says_what_is_simulated_and_hands_are_wherever_the_cell_has_them(desk, chromium, url):
    with a_tablet(chromium, url, size={"width": 390, "height": 844}) as page:
        for simulated, hands in itertools.product((True, False), repeat=2):
            desk.simulated = hands
            desk.show(simulated=simulated)
            with page.expect_response("**/api/v1/simulated-hands"):
                page.goto(f"{url}/operator/3")
            expect(page.locator("#names")).to_have_text("B2T3")
            page.locator("#mute").click()  # which draws the page anew
            expect(page.locator("#simulated strong")).to_be_visible(visible=simulated)
            expect(page.get_by_role("button", name="Do as asked")).to_be_visible(visible=hands)
            # On a phone the hands are named where no other word is beside them.
            expect(page.locator("#hands-title")).to_be_visible(visible=hands and not simulated)
            expect(page.locator("#simulated")).to_be_visible(visible=hands or simulated)


def test_where_legs_are_too_much_alike_the_page_says_that_a_swap_cannot_be_seen(desk, tablet):
    desk.show(swaps_can_be_seen=False)
    expect(tablet.locator("#hint")).to_contain_text("too similar to detect a swap")
    expect(tablet.locator("#hint")).to_contain_text("pre-calibration checks all poses measured before it")

    desk.show(swaps_can_be_seen=True)
    expect(tablet.locator("#hint")).to_be_hidden()
