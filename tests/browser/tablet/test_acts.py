"""What taps do: each is one act of the public API, with who, where and which step."""

from playwright.sync_api import expect

from tests.browser.tablet.bench.fake_desk import leg, move, sample, step
from tests.browser.tablet.bench.operator_hands import acted, hold_long_enough
from tests.browser.tablet.conftest import a_tablet

SUSPICION = {"asked": ["B2", "T3"], "suspected": ["B1", "T2"], "length_mm": 300.1, "expected_mm": 300.42}
CONTROLS = {"Back": "back", "Retry": "retry", "Pause": "pause", "STOP": "stop"}
# The kind of doubt, what is said of it, an answer, and the button that gives it.
DOUBTS = [
    ("same_pair", "already measured", "reconnected", "I have reconnected the ballbar"),
    (
        "other_pair",
        "The length matches B1\u2013T2, not B2\u2013T3.",
        "right_pair",
        "The ballbar is on B2\u2013T3",
    ),
    (
        "exchanged",
        "B2\u2013T3 and B1\u2013T2 seem to be swapped.",
        "reconnected",
        "Swapped: read both again",
    ),
    ("unlikely", "Expected for B2\u2013T3: 300.420 mm", "right_pair", "The ballbar is on B2\u2013T3"),
    (
        "calibrator",
        "This is the length of the calibrator",
        "reconnected",
        "I have reconnected the ballbar",
    ),
    (
        "like_calibrator",
        "does not show which of the two was measured",
        "right_pair",
        "The ballbar is on B2\u2013T3",
    ),
    (
        "same_connection",
        "not taken off after B1\u2013T2 was read",
        "reconnected",
        "I have reconnected the ballbar",
    ),
    ("not_calibrator", "differs from the previous one", "right_pair", "The ballbar is on B2\u2013T3"),
    (
        "same_bars",
        "the zero of the other extension bars",
        "reconnected",
        "I have reconnected the ballbar",
    ),
]


def test_store_is_always_at_hand_and_says_who_and_what(desk, tablet):
    tablet.get_by_role("button", name="Store now").click()

    (act,) = acted(tablet, desk)
    assert (act["act"], act["step_id"], act["person"]) == ("store", leg()["id"], "Ada Byron")
    assert act["tablet"] == tablet.evaluate("localStorage.getItem('truepose.tablet')")


def test_a_control_is_one_tap(desk, tablet):
    for done, (name, act) in enumerate(CONTROLS.items(), 1):
        tablet.get_by_role("button", name=name, exact=True).click()

        assert acted(tablet, desk, done)[-1]["act"] == act


def test_a_paused_session_resumes_where_it_was_paused(desk, tablet):
    desk.show(state="paused")

    tablet.locator("#dock").get_by_role("button", name="Resume", exact=True).click()

    assert [done["act"] for done in acted(tablet, desk)] == ["resume"]


def test_a_skip_needs_a_reason(desk, tablet):
    tablet.get_by_role("button", name="Skip", exact=True).click()
    do = tablet.get_by_role("button", name="Skip for this reason")
    do.click()
    tablet.get_by_text("Another reason").click()
    do.click()
    assert desk.acts == []

    tablet.get_by_label("Write the reason").fill("the hose is in the way")
    do.click()

    (act,) = acted(tablet, desk)
    assert (act["act"], act["reason"]) == ("skip", "the hose is in the way")


def test_where_nothing_shows_that_the_ballbar_is_off_one_says_how_one_knows(desk, tablet):
    desk.sample = {**sample("no_signal", None), "reason_needed": True}
    desk.show(step=step("detach"), commands=["confirm", "retry", "back", "pause", "abort", "stop"])

    tablet.locator("#actions [data-act=confirm]").click()
    do = tablet.get_by_role("button", name="The ballbar is off and out of the arm\u2019s way")
    do.click()
    assert desk.acts == []
    tablet.get_by_label("What you see").fill("its battery is out")
    do.click()

    (act,) = acted(tablet, desk)
    assert (act["act"], act["step_id"], act["reason"]) == (
        "confirm",
        "placement-1/detach",
        "its battery is out",
    )


def test_a_reason_to_choose_goes_into_the_records_in_one_language(desk, chromium, url):
    with a_tablet(chromium, url, language="fr") as tablet:
        tablet.goto(f"{url}/operator/3")
        tablet.get_by_role("button", name="Passer", exact=True).click()
        tablet.get_by_text("La longueur ne se stabilise pas").click()
        tablet.get_by_role("button", name="Passer pour cette raison").click()

        (act,) = acted(tablet, desk)
    assert act["reason"] == "The length does not settle"


def test_ending_the_session_is_asked_twice_and_stop_stays_in_reach_of_the_question(desk, tablet):
    tablet.get_by_role("button", name="Abort").click()
    tablet.get_by_role("button", name="Cancel").click()
    tablet.get_by_role("button", name="Abort").click()
    assert desk.acts == []

    tablet.get_by_role("button", name="STOP").click()
    assert [act["act"] for act in acted(tablet, desk)] == ["stop"]
    tablet.get_by_role("button", name="Abort the session").click()

    assert [act["act"] for act in acted(tablet, desk, 2)] == ["stop", "abort"]


def test_the_robot_moves_only_after_a_button_was_held(desk, tablet):
    desk.show(step=move(), ballbar_attached=False)
    box = tablet.get_by_role("button", name="Hold").bounding_box()
    tablet.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)

    tablet.mouse.down()
    tablet.wait_for_timeout(500)
    tablet.mouse.up()
    tablet.wait_for_timeout(1200)
    assert desk.acts == []
    hold_long_enough(tablet)

    (act,) = acted(tablet, desk)
    assert (act["act"], act["step_id"]) == ("confirm", move()["id"])
    assert act["seen_time_s"] == 512.5  # the service refuses one that comes too late


def test_a_key_that_is_held_confirms_a_motion_and_a_key_that_is_pressed_does_not(desk, tablet):
    for pose, key in enumerate(["Enter", " "], 1):
        desk.show(step=move(pose), ballbar_attached=False)
        expect(tablet.locator("#where")).to_contain_text(f"pose {pose}")
        tablet.get_by_role("button", name="Hold").focus()

        tablet.keyboard.press(key)
        tablet.wait_for_timeout(200)
        assert len(desk.acts) == pose - 1
        tablet.keyboard.down(key)
        tablet.locator(".holding").wait_for(state="detached")
        tablet.keyboard.up(key)

        assert acted(tablet, desk, pose)[-1]["act"] == "confirm"


def test_a_motion_cannot_be_confirmed_where_the_service_does_not_offer_it(desk, tablet):
    desk.show(step=move(), ballbar_attached=True, commands=["pause", "stop", "abort"])

    expect(tablet.locator("#actions button")).to_be_disabled()
    expect(tablet.locator("#panel")).to_contain_text("still attached")


# A finger that is there before the eye: it taps what stands on the next screen as soon as that is drawn.
TAPS_AT_ONCE = """() => new MutationObserver((_, watch) => {
    if (document.body.dataset.screen !== "fit_ball") return;
    watch.disconnect();
    [...document.querySelectorAll("button")].find((button) => button.textContent.includes("Done")).click();
    document.body.dataset.tapped = "yes";
}).observe(document.body, { attributes: true, attributeFilter: ["data-screen"] })"""


def test_a_second_tap_does_not_answer_the_next_screen(desk, tablet):
    desk.show(step=step("place_base"))
    tablet.get_by_role("button", name="Done").click()
    acted(tablet, desk)

    tablet.evaluate(TAPS_AT_ONCE)
    desk.show(step=step("fit_ball"))
    tablet.locator("body[data-tapped]").wait_for()
    tablet.wait_for_timeout(800)
    assert len(desk.acts) == 1
    tablet.get_by_role("button", name="Done").click()

    assert [act["step_id"] for act in acted(tablet, desk, 2)][1] == "placement-1/fit_ball"


def test_a_key_that_stays_down_is_one_tap(desk, tablet):
    expect(tablet.get_by_role("button", name="Retry")).to_be_enabled()
    tablet.get_by_role("button", name="Retry").focus()

    for _ in range(5):
        tablet.keyboard.down("Enter")  # after the first one the browser says `repeat`
        tablet.wait_for_timeout(60)
    tablet.keyboard.up("Enter")

    assert [act["act"] for act in acted(tablet, desk)] == ["retry"]


def test_a_finger_may_rest_on_the_button_while_the_page_is_told_more(desk, tablet):
    desk.show(step=move(), ballbar_attached=False)
    tablet.get_by_role("button", name="Hold").hover()

    tablet.mouse.down()
    for _ in range(8):
        desk.show(watching=2)
        tablet.wait_for_timeout(200)
    tablet.locator(".holding").wait_for(state="detached")
    tablet.mouse.up()

    assert [act["act"] for act in acted(tablet, desk)] == ["confirm"]


def test_a_hold_that_began_on_one_screen_confirms_nothing_on_the_next(desk, tablet):
    desk.show(step=move(12), ballbar_attached=False)
    tablet.get_by_role("button", name="Hold").hover()

    tablet.mouse.down()
    tablet.wait_for_timeout(500)
    desk.show(step=move(13))
    tablet.wait_for_timeout(1200)
    tablet.mouse.up()

    assert desk.acts == []


def test_a_wrong_connection_is_asked_about(desk, tablet):
    for done, (kind, said, answer, button) in enumerate(DOUBTS, 1):
        suspected = None if kind == "unlikely" else SUSPICION["suspected"]
        # Each is of a step of its own, as the buttons are.
        desk.show(step=leg(pose=done), suspicion={**SUSPICION, "kind": kind, "suspected": suspected})
        expect(tablet.locator("#panel")).to_contain_text(said)
        expect(tablet.locator("#panel")).to_contain_text("Not stored yet")

        tablet.get_by_role("button", name=button).click()

        act = acted(tablet, desk, done)[-1]
        assert (act["act"], act["answer"]) == ("answer", answer), kind


def test_the_large_coloured_answer_to_a_doubt_is_the_one_that_stores_nothing(desk, tablet):
    desk.show(suspicion={**SUSPICION, "kind": "other_pair"})

    coloured = tablet.locator("#actions .main:not(.plain)")
    expect(coloured).to_have_text("I have reconnected the ballbar")
    expect(tablet.locator("#actions .main").nth(1)).to_have_class("main plain")
    coloured.click()
    assert acted(tablet, desk)[0]["answer"] == "reconnected"

    # One that has led nowhere is not the large one.
    desk.show(step=leg(3, 1), suspicion={**SUSPICION, "kind": "calibrator"}, main_answer="right_pair")
    expect(coloured).not_to_contain_text("reconnected")
    coloured.click()
    assert acted(tablet, desk, 2)[1]["answer"] == "right_pair"


def test_a_doubt_about_the_calibrator_is_about_no_pair(desk, tablet):
    told = {
        "kind": "unlikely",
        "asked": ["B0", "T0"],
        "suspected": None,
        "length_mm": 300.0,
        "expected_mm": None,
    }
    desk.show(step=step("initialise", artefact="base"), suspicion=told)

    expect(tablet.locator("#names")).to_have_text("CALIBRATOR")
    expect(tablet.locator("body")).not_to_contain_text("B0")


def test_the_name_is_asked_for_once(desk, chromium, url):
    with a_tablet(chromium, url, person=None) as tablet:
        tablet.goto(f"{url}/operator/3")
        tablet.get_by_label("Name", exact=True).fill("Grace Hopper")
        tablet.get_by_role("button", name="Save name").click()
        tablet.get_by_role("button", name="Store now").click()
        assert acted(tablet, desk)[0]["person"] == "Grace Hopper"

        tablet.reload()

        expect(tablet.locator("#person")).to_have_text("Grace Hopper")
        expect(tablet.locator("#dialogue")).to_be_hidden()


def test_every_control_can_be_reached_and_seen_with_the_keyboard(desk, tablet):
    expect(tablet.get_by_role("button", name="Store now")).to_be_enabled()
    reached = []
    for _ in range(30):
        tablet.keyboard.press("Tab")
        reached.append(
            tablet.evaluate("""() => {
                const { dataset, id } = document.activeElement;
                const { outlineStyle, outlineWidth } = getComputedStyle(document.activeElement);
                return [dataset.act ?? id, outlineStyle === "solid" && parseFloat(outlineWidth) >= 3];
            }""")
        )

    seen = {name for name, outlined in reached if outlined}
    assert {"store", "back", "retry", "skip", "pause", "abort", "stop", "mute", "language"} <= seen


def hands(tablet, desk, n):
    """Wait until the simulated hands have done `n` things and return them."""
    for _ in range(500):
        if len(desk.hands) >= n:
            break
        tablet.wait_for_timeout(20)
    return desk.hands


def test_a_refusal_of_the_simulated_hands_is_a_sentence(desk, chromium, url):
    desk.hands_refuse = "the ballbar does not fit between B2 and T1: they are 305.1 mm apart"
    with a_tablet(chromium, url, may_fail=True) as tablet:
        tablet.goto(f"{url}/operator/3")

        tablet.get_by_role("button", name="Do as asked").click()

        said = "The ballbar does not fit between B2 and T1: they are 305.1 mm apart."
        expect(tablet.locator("#said")).to_have_text(said)


def test_the_simulated_hands_do_what_the_step_asks(desk, tablet):
    asked = tablet.get_by_role("button", name="Do as asked")
    asked.click()
    hands(tablet, desk, 2)
    desk.show(step=step("initialise", artefact="base"))
    tablet.locator("body[data-screen=initialise]").wait_for()
    asked.click()
    hands(tablet, desk, 4)
    tablet.get_by_role("button", name="Other pair").click()
    tablet.get_by_role("button", name="B1\u2013T2").click()
    hands(tablet, desk, 6)
    tablet.get_by_role("button", name="Pull cable").click()

    # The bar comes off before it is put elsewhere, as with real hands.
    assert hands(tablet, desk, 7) == [
        {"action": "detach"},
        {"action": "connect", "base": 2, "tool": 3},
        {"action": "detach"},
        {"action": "calibrator", "bars": "base"},
        {"action": "detach"},
        {"action": "connect", "base": 1, "tool": 2},
        {"action": "pull_cable"},
    ]
