"""Charts of readings as an engineer uses them: what is picked in one is picked in all."""

import csv
import io

import pytest
from playwright.sync_api import expect

from tests.browser.conftest import looking
from tests.browser.pages.shop import open_shop
from tests.browser.windows import without_complaint
from tests.helpers.diagnosis.answers import make_diagnosis
from tests.helpers.identification.synthetic import nominal_campaign
from truepose.identification import identify


@pytest.fixture(scope="module")
def shop(tmp_path_factory):
    with open_shop(tmp_path_factory.mktemp("shop")) as url:
        yield url


@pytest.fixture
def charts(chromium, shop):
    with looking(chromium, shop) as page:
        page.goto(f"{shop}/identifications/1/readings")
        page.locator("reading-charts[data-ready]").wait_for()
        yield page


def picked(page):
    return page.locator("tr.picked")


def evaluated(page, expression):
    return page.evaluate(f"(element => {expression})(document.querySelector('reading-charts'))")


def place_of(page, chart, index):
    """Where a chart draws a reading, in the window."""
    plot = page.locator(f"[data-part={chart}] .u-over").bounding_box()
    at = evaluated(
        page,
        f"""(({{x, y}}) => [x(element.charts.{chart}.x[{index}]), y(element.charts.{chart}.y[{index}])])
        (element.charts.{chart}.placing(false))""",
    )
    return plot["x"] + at[0], plot["y"] + at[1]


def test_the_worst_reading_stands_first_and_a_click_on_it_picks_it_everywhere(charts):
    worst = charts.locator("tr[data-index]").first
    index = int(worst.get_attribute("data-index"))
    sizes = evaluated(charts, "Array.from(element.after)")

    assert index == max(range(len(sizes)), key=sizes.__getitem__)
    charts.mouse.click(*place_of(charts, "over", index))
    expect(picked(charts)).to_have_count(1)
    assert int(picked(charts).get_attribute("data-index")) == index
    assert [
        evaluated(charts, f"[...element.charts.{name}.picked]") for name in ("over", "map", "spread")
    ] == [[index]] * 3
    charts.get_by_role("button", name="Clear selection").click()
    expect(picked(charts)).to_have_count(0)


def test_hovering_tells_configuration_value_and_what_was_to_be_expected(charts):
    charts.locator("[data-part=map]").scroll_into_view_if_needed()
    charts.mouse.move(*place_of(charts, "map", 5))

    line = charts.locator("[data-part=line]")
    expect(line).to_contain_text("expected about")
    config = evaluated(
        charts, "element.found.config[element.hovered]"
    )  # of two that cover each other the nearer
    expect(line).to_contain_text(f"Configuration {config}, nest")


def test_keys_go_from_reading_to_reading_and_pick(charts):
    charts.locator("[data-part=over]").focus()
    charts.keyboard.press("ArrowRight")
    first = evaluated(charts, "element.hovered")
    charts.keyboard.press("Enter")

    order = evaluated(charts, "Array.from(element.charts.over.x)")
    assert order[first] == min(order)
    assert evaluated(charts, "[...element.picked]") == [first]


def test_dragging_zooms_and_the_zoom_is_undone(charts):
    plot = charts.locator("[data-part=over] .u-over").bounding_box()
    whole = evaluated(charts, "element.charts.over.bounds('x')")
    charts.mouse.move(plot["x"] + plot["width"] * 0.25, plot["y"] + 10)
    charts.mouse.down()
    charts.mouse.move(plot["x"] + plot["width"] * 0.75, plot["y"] + plot["height"] - 10)
    charts.mouse.up()

    low, high = evaluated(charts, "element.charts.over.bounds('x')")
    assert (high - low) / (whole[1] - whole[0]) == pytest.approx(0.5, abs=0.02)
    charts.get_by_role("button", name="Reset zoom").click()
    assert evaluated(charts, "element.charts.over.bounds('x')") == whole


def test_a_class_of_the_histogram_picks_its_readings_and_no_others(charts):
    class_ = evaluated(
        charts, "element.charts.spread.counts.after.indexOf(Math.max(...element.charts.spread.counts.after))"
    )
    bounds = evaluated(
        charts,
        f"[element.charts.spread.low + {class_} * element.charts.spread.width, element.charts.spread.width]",
    )
    x = evaluated(charts, f"element.charts.spread.placing(false).x({bounds[0] + bounds[1] / 2})")
    plot = charts.locator("[data-part=spread] .u-over").bounding_box()
    charts.mouse.click(plot["x"] + x, plot["y"] + 20)

    of_class = evaluated(charts, "[...element.picked].map((i) => element.after[i])")
    assert len(of_class) == evaluated(charts, f"element.charts.spread.counts.after[{class_}]")
    assert all(bounds[0] <= size <= sum(bounds) * (1 + 1e-9) for size in of_class)


def test_what_is_seen_is_kept_as_picture_and_table(charts):
    index = int(charts.locator("tr[data-index]").first.get_attribute("data-index"))
    charts.locator("tr[data-index]").first.click()
    kept = {}
    for name, button in {"csv": "CSV", "svg": "SVG", "png": "PNG"}.items():
        with charts.expect_download() as download:
            charts.get_by_role("button", name=button).first.click()
        kept[name] = download.value.path().read_bytes()

    (row,) = csv.DictReader(io.StringIO(kept["csv"].decode()))
    assert int(row["config"]) == evaluated(charts, f"element.found.config[{index}]")
    assert float(row["after_x_mm"]) == evaluated(charts, f"element.found.after_mm[{index}][0]")
    assert kept["svg"].count(b"<circle") == evaluated(charts, "element.after.length")
    assert kept["png"].startswith(b"\x89PNG")


DEPENDENCE = """async () => {
  const { dependence } = await import("/static/dependence.js");
  const angles = Float64Array.from({ length: 400 }, (_, i) => ((i * 137) % 400) - 200);
  const wave = angles.map((angle) => Math.sin(angle / 20));
  const noise = angles.map((_, i) => Math.sin(i * i * 12.9898) * 43758.5453 % 1);
  const twice = Float64Array.from(angles, (_, i) => i % 2);
  const [constant, unknown] = [3, NaN].map((value) => angles.map(() => value));
  const pairs = [[angles, wave], [angles, noise], [twice, twice], [constant, wave], [unknown, wave]];
  return pairs.map((pair) => dependence(...pair));
}"""


def test_dependence_is_whole_of_a_wave_and_nothing_of_noise_or_of_what_does_not_vary(charts):
    wave, noise, states, constant, unknown = charts.evaluate(DEPENDENCE)

    assert wave > 0.6
    assert noise < 0.03
    assert states == pytest.approx(1.0)
    assert (constant, unknown) == (0, 0)


def test_a_tap_on_what_the_error_depends_on_draws_it(charts):
    cause = charts.locator("[data-part=causes] button").nth(1)
    name = cause.locator("span").inner_text()
    cause.click()

    assert charts.locator("[data-part=variable]").evaluate("select => select.selectedOptions[0].text") == name
    assert evaluated(charts, "element.charts.over.labels[0]").startswith(name)


def ready(page):
    page.locator("reading-charts[data-ready]").wait_for()
    return page


def test_readings_are_set_aside_by_keys_and_the_new_result_says_so(chromium, shop):
    with looking(chromium, shop) as page:
        page.goto(f"{shop}/identifications/1/readings")
        expect(page.get_by_text("These readings judge the model and cannot be set aside.")).to_be_visible()
        expect(page.get_by_role("button", name="Set aside")).to_have_count(0)
        page.get_by_role("link", name="Show the readings that the model was identified from").click()
        button = ready(page).get_by_role("button", name="Set aside")
        expect(button).to_be_disabled()
        page.locator("[data-part=over]").focus()
        page.keyboard.press("ArrowRight")
        page.keyboard.press("Enter")
        named = "configuration {}, nest {}".format(*picked(page).locator("td").all_inner_texts()[:2])
        button.press("Enter")

        dialogue = page.get_by_role("dialog", name="Set readings aside")
        expect(dialogue.get_by_role("listitem")).to_have_text(named)
        page.keyboard.press("Escape")
        expect(dialogue).to_be_hidden()
        expect(button).to_be_focused()
        button.press("Enter")
        page.keyboard.type("Ada Byron")
        page.keyboard.press("Tab")
        page.keyboard.type("a cable lay in the beam")
        page.keyboard.press("Tab")
        page.keyboard.press("Enter")
        page.wait_for_url("**/identifications/2")

        said = "1 reading set aside by Ada Byron: a cable lay in the beam."
        expect(page.get_by_text(said).first).to_be_visible()
        page.goto(f"{shop}/identifications/2/readings?identified_from=true")
        ready(page).locator("tr[data-index]").first.click()
        button.click()
        expect(dialogue.get_by_role("listitem")).to_have_count(2)
        expect(dialogue.get_by_label("Reason")).to_have_value("a cable lay in the beam")


def test_what_cannot_be_set_aside_is_said_in_the_dialogue(chromium, shop):
    refusal = "Failed to load resource: the server responded with a status of 422"
    with chromium.one(shop) as page, without_complaint(page, shop, allowed=(refusal,)):
        page.goto(f"{shop}/identifications/1/readings?identified_from=true")
        evaluated(ready(page), "element.pick([...element.after.keys()])")
        page.get_by_role("button", name="Set aside").click()
        dialogue = page.get_by_role("dialog")
        dialogue.get_by_label("Your name").fill("Ada Byron")
        dialogue.get_by_label("Reason").fill("none of them looks right")
        dialogue.get_by_role("button", name="Analyse without them").click()

        expect(dialogue.get_by_text("readings are more than 20% and cannot be set aside")).to_be_visible()
        assert page.evaluate("document.querySelector('dialog[open]').scrollHeight <= innerHeight")


def test_a_session_that_has_ended_is_planned_again_with_the_selected_configurations(charts, shop):
    charts.goto(f"{shop}/identifications/1/readings?identified_from=true")
    ready(charts).locator("tr[data-index]").first.click()
    config = picked(charts).locator("td").first.inner_text()

    charts.get_by_role("button", name="Measure again").click()
    charts.wait_for_url(f"**/sessions/1/again?configurations={config}")

    expect(charts.get_by_text(f"Only these configurations: {config}.")).to_be_visible()


def test_a_session_that_is_open_takes_the_selected_configurations_and_asks(service, tablet):
    model = identify(nominal_campaign(30), ("base",)).model
    session = service.paused_session("left arm")
    result = service.diagnosed(session, make_diagnosis(model=model)).partition("?")[0]
    tablet.goto(f"{result}/readings")
    ready(tablet).locator("tr[data-index]").first.click()
    planned = service.get(session)["planned"]

    tablet.get_by_role("button", name="Measure again").click()
    dialogue = tablet.get_by_role("dialog", name="Measure readings again")
    dialogue.get_by_label("Your name").fill("Ada Byron")
    dialogue.get_by_role("button", name="Add to the session").click()
    tablet.wait_for_url("**/sessions/1")

    told = service.get(session)
    assert (told["planned"], told["state"]) == (planned + 1, "paused")
