"""Another ballbar answers: the tablet says which, and accepts it by a held button that names it."""

from playwright.sync_api import expect

from tests.browser.tablet.bench.fake_desk import move
from tests.browser.tablet.bench.operator_hands import acted, hold_long_enough

FOREIGN = {
    "device": "ballbar",
    "finding": "foreign",
    "serial_number": "B-9",
    "expected_serial_number": "B-7",
    "person": None,
}


def ask(desk, **changed):
    desk.show(
        state="awaiting_confirmation",
        commands=["confirm", "abort"],
        ballbar_in_question={**FOREIGN, **changed},
    )


def test_the_question_names_both_and_a_held_button_accepts_the_one_that_it_names(desk, tablet):
    ask(desk)
    expect(tablet.locator("body")).to_have_attribute("data-screen", "foreign")
    asked = tablet.locator("#instruction").inner_text()
    button = tablet.get_by_role("button", name="Hold: continue with B-9")
    button.click()  # a tap accepts nothing
    tablet.wait_for_timeout(300)
    assert desk.acts == []
    button.hover()

    hold_long_enough(tablet)

    assert "B-7" in asked
    assert [(act["act"], act["accept_serial_number"]) for act in acted(tablet, desk)] == [("confirm", "B-9")]


def test_a_hold_for_one_ballbar_does_not_accept_a_third(desk, tablet):
    ask(desk)
    tablet.get_by_role("button", name="Hold: continue with B-9").hover()

    tablet.mouse.down()
    tablet.wait_for_timeout(500)
    ask(desk, serial_number="B-11")
    tablet.wait_for_timeout(1200)
    tablet.mouse.up()

    assert desk.acts == []


def test_a_confirmation_names_the_question_that_was_read(desk, tablet):
    desk.show(state="awaiting_confirmation", commands=["confirm"], prompt={"id": 57})
    tablet.get_by_role("button", name="I have checked").click()
    acted(tablet, desk)
    desk.show(step=move(), state="running", commands=["confirm"], prompt=None, ballbar_attached=False)
    tablet.get_by_role("button", name="Hold").hover()

    hold_long_enough(tablet)

    acts = acted(tablet, desk, 2)
    assert [act.get("prompt_id") for act in acts] == [57, None]
    assert "accept_serial_number" not in acts[1]  # a motion is confirmed without a number
