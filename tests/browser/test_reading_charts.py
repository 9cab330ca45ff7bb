"""Charts of readings as an engineer uses them: what is picked in one is picked in all."""

import csv
import io

import pytest
from playwright.sync_api import expect

from tests.browser.conftest import looking
from tests.browser.pages.shop import open_shop


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
