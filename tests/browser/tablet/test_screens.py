"""Every screen, in both languages, upright and lying: what is there, how large, and where."""

import pytest
from playwright.sync_api import expect

from tests.browser.tablet.bench.fake_desk import ARM_BEFORE, FakeDesk, leg, move, sample, scene, step
from tests.browser.tablet.conftest import a_tablet, served
from tests.browser.windows import LANDSCAPE, PORTRAIT

SUSPICION = {"kind": "other_pair", "asked": ["B2", "T3"], "suspected": ["B1", "T2"]}
DOUBT = {**SUSPICION, "length_mm": 300.1004, "expected_mm": 300.42}
FOREIGN = {
    "device": "ballbar",
    "finding": "foreign",
    "serial_number": "QC20-12A345",
    "expected_serial_number": "QC20-98B761",
    "person": None,
}
STORED = {"step_id": leg(1, 1)["id"], "kind": "measured", "length_mm": 299.8612, "text": ""}
SCREENS = {
    "connect_leg": {"step": leg(), "swaps_can_be_seen": False, "last_outcome": STORED},
    "measure_side": {"step": step("measure_side", artefact="tool", points=["T1", "T2"])},
    "initialise": {"step": step("initialise", artefact="base")},
    "place_base": {"step": step("place_base")},
    "fit_ball": {"step": step("fit_ball")},
    "clamp_cup": {"step": step("clamp_cup", base_point=1)},
    "remove_ball": {"step": step("remove_ball")},
    "detach": {"step": step("detach")},
    "move": {"step": move(), "ballbar_attached": False},
    "moving": {"step": move(), "robot_moving": True},
    "doubt": {"suspicion": DOUBT},
    "precalibrate": {"step": step("precalibrate")},
    "planned": {"state": "planned"},
    "paused": {"state": "paused", "reason": "The pre-calibration failed: measure more poses."},
    "pausing": {"state": "pausing"},
    "interrupted": {"state": "awaiting_confirmation"},
    "foreign": {"state": "awaiting_confirmation", "ballbar_in_question": FOREIGN},
    "finished": {"state": "finished", "step": None},
    "aborted": {"state": "aborted", "step": None},
    "failed": {"state": "failed", "step": None, "reason": "The disk is full."},
}
STATES = {
    "in_range": sample(),
    "out_low": sample("out_low", None),
    "out_high": sample("out_high", None),
    "unstable": sample("unstable", 300.1),
    "no_signal": sample("no_signal", None),
}
UNSEEN = ["planned", "finished", "aborted", "failed"]  # screens without a picture
LAYOUTS = [(PORTRAIT, "en"), (PORTRAIT, "fr"), (LANDSCAPE, "en"), (LANDSCAPE, "de")]
BLOCKS = ".top, .notices, .ask, .picture, .panel, .last, .gauge, .caution, .actions, .dock"
# Blocks that lie on another one, and blocks whose content is larger than they are (a list may scroll).
COVERED = f"""() => {{
  const blocks = [...document.querySelectorAll("{BLOCKS}")].filter((node) => node.offsetHeight);
  const found = [];
  for (const [i, one] of blocks.entries()) {{
    const a = one.getBoundingClientRect();
    const cut = one.scrollHeight > one.clientHeight + 1 && !one.matches(".panel, .picture");
    if (a.bottom > innerHeight + 1 || a.right > innerWidth + 1) found.push(`${{one.className}} sticks out`);
    if (cut) found.push(`${{one.className}} is cut`);
    for (const other of blocks.slice(i + 1)) {{
      const b = other.getBoundingClientRect();
      const across = Math.min(a.right, b.right) - Math.max(a.left, b.left);
      const down = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
      if (across > 1 && down > 1) found.push(`${{one.className}} / ${{other.className}}`);
    }}
  }}
  return found;
}}"""
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
# Contrast of every text with what lies behind it, after WCAG 2.2, 1.4.3; disabled controls are exempt there.
FAINT_TEXTS = """() => {
  const channel = (value) => (value /= 255) <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
  const light = ([r, g, b]) => 0.2126 * channel(r) + 0.7152 * channel(g) + 0.0722 * channel(b);
  const numbers = (text) => text.match(/[\\d.]+/g).map(Number);
  const behind = (node) => {
    for (; node; node = node.parentElement) {
      const [r, g, b, a = 1] = numbers(getComputedStyle(node).backgroundColor);
      if (a > 0.5) return [r, g, b];
    }
    return [255, 255, 255];
  };
  const said = (node) => [...node.childNodes].some((child) => child.nodeType === 3 && child.data.trim());
  return [...document.querySelectorAll("body *")]
    .filter((node) => node.checkVisibility() && said(node))
    .filter((node) => !node.closest("svg, :disabled, .unseen, script"))
    .map((node) => {
      const ink = light(numbers(getComputedStyle(node).color));
      const [a, b] = [ink, light(behind(node))].sort((x, y) => y - x);
      return [node.textContent, (a + 0.05) / (b + 0.05)];
    })
    .filter(([, contrast]) => contrast < 4.5);
}"""


def boxes(page, selector):
    return page.locator(selector).evaluate_all(
        "nodes => nodes.map(n => (({x, y, width, height}) => [n.className, x, y, width, height])"
        "(n.getBoundingClientRect()))"
    )


def shown(page, desk, screen):
    """Bring the page to a screen and wait until it is there with its picture."""
    if page.locator("body").get_attribute("data-screen") == screen:
        shown(page, desk, next(other for other in SCREENS if other != screen))
    moving = screen in {"move", "moving"}
    desk.scene = scene(before=ARM_BEFORE if moving else None)
    dull = {"state": "running", "step": leg(), "suspicion": None, "robot_moving": False}
    dull["ballbar_in_question"] = None
    desk.show(**{**dull, **SCREENS[screen]})
    page.locator(f"body[data-screen={screen}]").wait_for()
    if screen not in UNSEEN:  # the geometry of a step is fetched after its words
        page.locator("#picture:not([hidden])").wait_for(state="attached")


def looked_at(page):
    """Measure the screen that is shown."""
    names = page.locator("#names")
    return {
        "dock": boxes(page, ".dock button"),
        "heights": page.locator("#actions button").evaluate_all("all => all.map(b => b.offsetHeight)"),
        "letters": names.evaluate("n => parseFloat(getComputedStyle(n).fontSize)"),
        "capitals": names.evaluate("n => getComputedStyle(n).textTransform"),
        "width": page.evaluate("document.documentElement.scrollWidth"),
        "viewport": page.viewport_size["width"],
        "covered": page.evaluate(COVERED),
        "faint": page.evaluate(FAINT_TEXTS),
    }


@pytest.fixture(scope="module", params=LAYOUTS, ids=lambda layout: f"{layout[0]['width']}-{layout[1]}")
def screens(request, chromium, door):
    """Every screen of a tablet, measured in one walk through all."""
    size, language = request.param
    desk, found = FakeDesk(), {}
    with served(desk, door) as url, a_tablet(chromium, url, size=size, language=language) as page:
        page.goto(f"{url}/operator/3")
        page.locator("#simulated").wait_for()
        for screen in SCREENS:
            shown(page, desk, screen)
            found[screen] = looked_at(page)
    return found


def test_the_controls_are_at_the_same_place_on_every_screen(screens):
    found = {screen: look["dock"] for screen, look in screens.items()}

    places = found["connect_leg"]
    assert [name.split()[1] for name, *_ in places] == ["back", "retry", "skip", "pause", "abort", "stop"]
    assert min(height for *_, height in places) >= 72
    moved = {screen for screen, at in found.items() if [box[1:] for box in at] != [box[1:] for box in places]}
    assert moved == set()


def test_main_buttons_are_large_and_names_are_readable(screens):
    for screen, look in screens.items():
        assert all(height >= 72 for height in look["heights"]), screen
        assert (look["letters"] >= 48, look["capitals"]) == (True, "uppercase"), screen


def test_nothing_is_cut_or_covered_and_every_text_stands_out(screens):
    for screen, look in screens.items():
        assert look["width"] == look["viewport"], screen
        assert look["covered"] == [], screen
        assert look["faint"] == [], screen


def test_nothing_that_is_told_covers_anything(desk, chromium, url):
    acting = {"tablet": "another", "person": "Wilhelmina Featherstonehaugh"}
    for size, language in LAYOUTS:
        with a_tablet(chromium, url, size=size, language=language, may_fail=True) as page:
            page.goto(f"{url}/operator/3")
            page.locator("#simulated").wait_for()
            for screen in SCREENS:
                desk.show(acting=acting, swaps_can_be_seen=False)
                shown(page, desk, screen)
                assert page.evaluate(COVERED) == [], (screen, size, language)
            page.context.set_offline(True)
            page.locator("#lost").wait_for()
            assert page.evaluate(COVERED) == [], (size, language)


@pytest.mark.parametrize("size", [PORTRAIT, LANDSCAPE], ids=["portrait", "landscape"])
def test_pose_leg_and_attempt_can_always_be_read(desk, chromium, url, size):
    with a_tablet(chromium, url, size=size, language="fr") as page:
        page.goto(f"{url}/operator/3")
        desk.show(step=leg(attempt=2, index=122, count=431), acting={"tablet": "another", "person": "Ada"})

        where = page.locator("#where")
        expect(where).to_have_text("Étape 122 sur 431, emplacement 1, pose 12, jambe 4 sur 6, essai 2")
        cut = "n => n.scrollWidth > n.clientWidth + 1 || n.getBoundingClientRect().right > innerWidth"
        assert where.evaluate(cut) is False


def test_where_the_base_goes_is_said_in_numbers(desk, tablet):
    shown(tablet, desk, "place_base")

    rows = tablet.locator("#panel tbody tr")
    # From the robot's base at the origin: x, y, height, and 409 mm = hypot(380, 150) from its axis.
    expect(rows.nth(0)).to_have_text("B1380\u221215060409")
    expect(rows).to_have_count(3)
    # B1 to B2 goes 260 mm along x and 150 mm along y: 30 degrees.
    expect(tablet.locator("#panel")).to_contain_text("B1→B2 points 30° anticlockwise from x")


def test_numbers_are_from_the_robot_wherever_it_stands(desk, tablet):
    desk.show(step=step("place_base"))
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


@pytest.fixture(params=LAYOUTS, ids=lambda layout: f"{layout[0]['width']}-{layout[1]}")
def any_tablet(request, chromium, url):
    size, language = request.param
    with a_tablet(chromium, url, size=size, language=language) as page:
        page.goto(f"{url}/operator/3")
        page.locator("#simulated").wait_for()
        yield page


def test_no_advice_pushes_anything_away(desk, any_tablet):
    for swaps_can_be_seen in (True, False):
        for state, said in STATES.items():
            desk.sample = said
            desk.show(swaps_can_be_seen=swaps_can_be_seen)
            any_tablet.locator(f"#gauge[data-state={state}]").wait_for()
            any_tablet.wait_for_timeout(60)

            assert any_tablet.evaluate(COVERED) == [], (state, swaps_can_be_seen)
            assert any_tablet.evaluate(FAINT_TEXTS) == [], state


@pytest.mark.parametrize("pair", [(1, 1), (1, 2), (2, 1), (2, 2), (2, 3), (3, 1), (3, 3)])
def test_the_picture_shows_the_pair_and_no_name_lies_on_another(desk, tablet, pair):
    base, tool = pair
    desk.show(step=leg(base, tool))

    expect(tablet.locator("#picture .tag.asked")).to_have_count(2)
    expect(tablet.locator(f"#picture .tag.asked[data-name=B{base}]")).to_be_visible()
    expect(tablet.locator(f"#picture .tag.asked[data-name=T{tool}]")).to_be_visible()
    expect(tablet.locator("#picture .ballbar.asked")).to_have_count(1)
    assert tablet.evaluate(OVERLAPPING_NAMES) == {"tags": 6, "pairs": 0, "outside": 0}


@pytest.mark.parametrize(
    "stand_mm", [(1500, 900, 1600), (-900, 100, 900), (480, -30, 2500), (480, 1800, 150)]
)
def test_names_keep_apart_from_wherever_the_person_looks(desk, tablet, stand_mm):
    desk.scene = {**scene(), "stand_mm": stand_mm}
    desk.show(step=leg(3, 1))

    expect(tablet.locator("#picture .tag.asked")).to_have_count(2)
    assert tablet.evaluate(OVERLAPPING_NAMES) == {"tags": 6, "pairs": 0, "outside": 0}


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


@pytest.mark.parametrize("simulated", [True, False])
@pytest.mark.parametrize("hands", [True, False])
def test_the_record_says_what_is_simulated_and_hands_are_wherever_the_cell_has_them(
    desk, chromium, url, simulated, hands
):
    desk.simulated = hands
    desk.show(simulated=simulated)

    with a_tablet(chromium, url, size={"width": 390, "height": 844}) as page:
        with page.expect_response("**/api/v1/simulated-hands"):
            page.goto(f"{url}/operator/3")
        expect(page.locator("#names")).to_have_text("B2T3")
        page.locator("#mute").click()  # which draws the page anew
        expect(page.locator("#simulated strong")).to_be_visible(visible=simulated)
        expect(page.get_by_role("button", name="Do as asked")).to_be_visible(visible=hands)
        # On a phone the hands are named where no other word is beside them.
        expect(page.locator("#hands-title")).to_be_visible(visible=hands and not simulated)


def test_a_real_cell_has_no_simulated_hands(desk, chromium, url):
    desk.simulated = False
    desk.show(simulated=False)

    with a_tablet(chromium, url) as page:
        page.goto(f"{url}/operator/3")
        expect(page.locator("#names")).to_have_text("B2T3")
        expect(page.locator("#simulated")).to_be_hidden()


def test_where_legs_are_too_much_alike_the_page_says_that_a_swap_cannot_be_seen(desk, tablet):
    desk.show(swaps_can_be_seen=False)
    expect(tablet.locator("#hint")).to_contain_text("too similar to detect a swap")
    expect(tablet.locator("#hint")).to_contain_text("pre-calibration checks all poses measured before it")

    desk.show(swaps_can_be_seen=True)
    expect(tablet.locator("#hint")).to_be_hidden()
