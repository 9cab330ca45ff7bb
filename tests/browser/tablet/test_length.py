"""The live length: colour, word, shape, sound and advice of each state."""

import time

from playwright.sync_api import expect

from tests.browser.tablet.bench.fake_desk import leg, sample, step

STATES = {
    "in_range": ("In range", sample()),
    "out_low": ("Too short", sample("out_low", None)),
    "out_high": ("Too long", sample("out_high", None)),
    "unstable": ("Unstable", sample("unstable", 300.1)),
    "no_signal": ("No signal", sample("no_signal", None)),
}
# Counts the tones that the page starts; a test cannot hear.
LISTEN = """() => {
  window.tones = [];
  const start = OscillatorNode.prototype.start;
  OscillatorNode.prototype.start = function (...when) {
    window.tones.push(this.frequency.value);
    return start.apply(this, when);
  };
}"""

# Keeps what the last outcome looked like; a busy test may look away while it is large.
WATCH_LAST = """() => {
  window.lasts = [];
  const last = document.querySelector("#last");
  const noted = () => window.lasts.push([last.classList.contains("fresh"), last.textContent]);
  new MutationObserver(noted).observe(last, { attributes: true, childList: true, subtree: true });
  window.spoken = [];
  const spoken = document.querySelector("#spoken");
  new MutationObserver(() => window.spoken.push(spoken.textContent)).observe(spoken, { childList: true });
}"""


def until(tablet, condition):
    """Wait for a condition; Playwright's own way evaluates text in the page, which its policy forbids."""
    end = time.monotonic() + 60.0
    while not tablet.evaluate(condition):
        assert time.monotonic() < end, condition
        tablet.wait_for_timeout(20)


def in_state(tablet, desk, state):
    desk.sample = STATES[state][1]
    tablet.locator(f"#gauge[data-state={state}]").wait_for()


def test_each_state_has_a_colour_a_word_and_a_shape_of_its_own(desk, tablet):
    colours, shapes = set(), set()
    for state, (word, _) in STATES.items():
        in_state(tablet, desk, state)
        expect(tablet.locator("#word")).to_have_text(word)
        colours.add(tablet.locator("#word").evaluate("node => getComputedStyle(node).color"))
        shapes.add(tablet.locator("#shape path").get_attribute("d"))

    assert len(colours) == len(shapes) == len(STATES)


def test_a_needle_on_the_scale_follows_the_length_and_is_gone_without_one(desk, tablet):
    needle, aim = tablet.locator("#scale .needle"), tablet.locator("#scale .aim")
    places = []
    desk.show(step=leg(expected_mm=300.6, nominal_mm=300.0))
    expect(aim).to_be_visible()
    for length_mm in (299.5, 300.5):
        desk.sample = sample("unstable", length_mm)
        expect(tablet.locator("#length")).to_contain_text(str(length_mm))
        places.append(needle.bounding_box()["x"])
    first, second = places
    assert first < second < aim.bounding_box()["x"]

    in_state(tablet, desk, "no_signal")
    expect(needle).to_be_hidden()
    desk.show(step=leg(expected_mm=305.0, nominal_mm=300.0))
    expect(aim).to_be_hidden()  # beyond the scale


def test_nothing_is_offered_to_be_stored_where_there_is_no_length(desk, tablet):
    store = tablet.locator("#actions button")
    in_state(tablet, desk, "in_range")
    expect(store).to_have_text("Store now")
    expect(store).to_be_enabled()
    inviting = store.evaluate("node => [node.offsetHeight, getComputedStyle(node).backgroundColor]")

    for state in ("out_low", "out_high", "no_signal", "unstable"):
        in_state(tablet, desk, state)
        expect(store).to_be_disabled()
        expect(store).not_to_have_text("Store now")
        idle = store.evaluate("node => [node.offsetHeight, getComputedStyle(node).backgroundColor]")
        assert idle[0] < inviting[0], state
        assert idle[1] != inviting[1], state

    in_state(tablet, desk, "in_range")
    expect(store).to_be_enabled()


def test_the_length_is_shown_to_the_micrometre_with_what_it_is_off(desk, tablet):
    desk.sample = sample("in_range", 299.6504)

    expect(tablet.locator("#length")).to_have_text("299.650 mm")
    expect(tablet.locator("#deviation")).to_have_text("\u22120.770 from 300.420")

    # In inches for whoever chose them, and no coarser.
    desk.sample = sample("in_range", 299.65)
    tablet.get_by_role("button", name="Unit of length").click()
    expect(tablet.locator("#length")).to_have_text("11.79724 in")
    tablet.get_by_role("button", name="Unit of length").click()
    expect(tablet.locator("#length")).to_have_text("299.650 mm")


def test_out_of_range_is_explained_and_skipping_is_offered_with_its_reason(desk, tablet):
    for state, said, reason in (
        ("out_low", "balls are too close", "Out of range: too short"),
        ("out_high", "too far apart", "Out of range: too long"),
    ):
        in_state(tablet, desk, state)

        expect(tablet.locator("#advice")).to_contain_text(said)
        expect(tablet.locator("#advice")).to_contain_text("skip")
        expect(tablet.locator("#advice")).to_contain_text("150 + 50 mm")
        tablet.get_by_role("button", name="Skip", exact=True).click()
        expect(tablet.get_by_role("radio", name=reason)).to_be_checked()
        tablet.get_by_role("button", name="Cancel").click()


def test_a_triangle_out_of_range_is_no_pose_to_be_skipped(desk, tablet):
    desk.show(step=step("measure_side", artefact="tool", points=["T1", "T2"], bars_mm=[50]))
    in_state(tablet, desk, "out_high")

    expect(tablet.locator("#advice")).to_contain_text("50 mm")
    expect(tablet.locator("#advice")).not_to_contain_text("skip")

    # The robot places a base, and may do that badly.
    desk.show(step=step("measure_side", artefact="base", points=["B1", "B2"]))
    expect(tablet.locator("#advice")).to_contain_text("skip this side as out of range")


def test_standing_still_is_seen_to_grow(desk, tablet):
    desk.sample = sample(stable=0.8)
    until(tablet, "document.querySelector('#gauge').style.getPropertyValue('--stable') === '0.8'")

    expect(tablet.locator("#advice")).to_have_text("Hands off: the length is stored automatically")
    desk.sample = sample(still=False)
    expect(tablet.locator("#advice")).to_have_text("The arm is not at rest yet")


def test_a_bar_that_was_not_moved_is_told_of(desk, tablet):
    desk.sample = sample(stable=1.0)

    expect(tablet.locator("#advice")).to_have_text("Hands off: the length is stored automatically")
    expect(tablet.locator("#advice")).to_contain_text("seems to be where it was", timeout=4000)
    desk.show(step=leg(3, 1))
    expect(tablet.locator("#advice")).to_have_text("Hands off: the length is stored automatically")


def test_what_was_read_is_not_waited_for_again_until_the_bar_was_off(desk, tablet):
    expect(tablet.locator("#advice")).to_have_text("Hands off: the length is stored automatically")

    desk.show(last_outcome={"step_id": "x", "kind": "measured", "length_mm": 300.4213, "text": ""})
    expect(tablet.locator("#advice")).to_contain_text("has already been read")
    in_state(tablet, desk, "no_signal")
    in_state(tablet, desk, "in_range")
    expect(tablet.locator("#advice")).to_have_text("Hands off: the length is stored automatically")


def test_after_a_doubt_the_bar_must_be_put_on_anew_or_read_again(desk, tablet):
    told = {"kind": "unlikely", "asked": ["B2", "T3"], "suspected": None, "expected_mm": 300.9}
    for renewed in ("off", "moved", "retry"):
        desk.sample = sample()
        desk.show(suspicion={**told, "length_mm": 300.4213})
        tablet.locator("body[data-screen=doubt]").wait_for()
        expect(tablet.locator("#length")).to_have_text("300.421 mm")
        desk.show(suspicion=None)  # "I have reconnected it", and nobody did
        expect(tablet.locator("#advice")).to_contain_text("has already been read")

        if renewed == "off":
            in_state(tablet, desk, "no_signal")
        elif renewed == "retry":
            tablet.get_by_role("button", name="Retry").click()
        desk.sample = sample(length_mm=300.8 if renewed == "moved" else 300.4215)

        expect(tablet.locator("#advice")).to_have_text("Hands off: the length is stored automatically")


def test_what_was_stored_is_shown_large_then_kept_in_sight(desk, tablet):
    expect(tablet.locator("#last")).to_have_text("Nothing stored yet")
    tablet.evaluate(WATCH_LAST)
    tablet.evaluate("navigator.vibrate = (shakes_ms) => (window.shaken = shakes_ms)")
    tablet.locator("#kicker").click()  # a browser lets a page sound and shake once it was touched

    kept = {"step_id": leg(1, 1)["id"], "kind": "measured", "length_mm": 299.86123, "text": ""}
    desk.show(last_outcome=kept)

    until(tablet, 'window.spoken.includes("Stored")')
    expect(tablet.locator("#last:not(.fresh)")).to_contain_text("Last stored: B1\u2013T1")
    large = [text for fresh, text in tablet.evaluate("window.lasts") if fresh]
    assert any("STORED: B1\u2013T1  299.861 mm" in text for text in large)
    assert tablet.evaluate("window.shaken") == [80]


def test_states_sound_until_they_are_muted(desk, tablet):
    tablet.evaluate(LISTEN)
    tablet.locator("#kicker").click()  # a browser lets a page sound once it was touched
    in_state(tablet, desk, "out_low")
    until(tablet, "window.tones.length >= 2")
    low = tablet.evaluate("window.tones.splice(0)")
    in_state(tablet, desk, "out_high")
    until(tablet, "window.tones.length >= 3")
    high = tablet.evaluate("window.tones.splice(0)")
    tablet.get_by_role("button", name="Sound off").click()
    in_state(tablet, desk, "in_range")
    tablet.wait_for_timeout(800)  # a state that lasts sounds after 350 ms

    assert set(low).isdisjoint(high)
    assert tablet.evaluate("window.tones") == []
    tablet.reload()
    expect(tablet.get_by_role("button", name="Sound on")).to_be_visible()


def test_a_state_is_spoken_once_it_has_lasted(desk, tablet):
    in_state(tablet, desk, "unstable")
    expect(tablet.locator("#spoken")).to_have_text("Unstable")
    expect(tablet.locator("#spoken")).to_have_attribute("aria-live", "polite")

    # Shorter than the 700 ms after which it is spoken: nobody listens to a flicker.
    in_state(tablet, desk, "no_signal")
    in_state(tablet, desk, "unstable")
    time.sleep(0.3)
    expect(tablet.locator("#spoken")).to_have_text("Unstable")


def test_a_state_that_was_spoken_is_not_said_again_after_stored(desk, tablet):
    in_state(tablet, desk, "unstable")
    expect(tablet.locator("#spoken")).to_have_text("Unstable")

    desk.show(last_outcome={"step_id": leg(1, 1)["id"], "kind": "measured", "length_mm": 299.86, "text": ""})

    expect(tablet.locator("#spoken")).to_have_text("Stored")
    tablet.wait_for_timeout(1500)
    expect(tablet.locator("#spoken")).to_have_text("Stored")
