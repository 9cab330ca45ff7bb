"""The first page of circle and sphere tests: passed or not by a limit, and neither where none was set."""

from dataclasses import replace

import pytest

from tests.helpers.ballbar.spheres import longer, sphere_campaign
from tests.helpers.domain.circles import read_on, there_and_back, turned
from tests.helpers.domain.robots import IRB_120
from tests.helpers.web.pages import Page
from truepose.messages.catalogue import IN_ENGLISH
from truepose.messages.message import message
from truepose.reports.circles import circles_front
from truepose.reports.limits import NO_LIMIT, Limit, figure_bars
from truepose.reports.spheres import sphere_front
from truepose.validation.circle_test import CircleTest, MissingCircle, circle_test
from truepose.validation.sphere_test import sphere_test
from truepose.validation.uncertainty import Figure

FAR = Limit(10.0)


@pytest.fixture(scope="module")
def circles():
    """A joint that turns by a thousandth too far."""
    asked = turned(2, there_and_back(-40, 40, 4))
    return circle_test(read_on(IRB_120, asked, true_rad=1.001 * asked, scatter_mm=0.005))


@pytest.fixture(scope="module")
def sphere():
    return sphere_test(sphere_campaign(longer(), per_nest=12))


def of_circles(test, limit):
    return circles_front(test, "IRB 120", limit, IN_ENGLISH)


def test_without_a_limit_neither_passes_and_both_say_how_to_set_one(circles, sphere):
    for front in (
        of_circles(circles, NO_LIMIT),
        sphere_front(sphere, "IRB 120", "nominal", NO_LIMIT, IN_ENGLISH),
    ):
        assert (front.word, front.look) == ("NO LIMIT SET", "not_answered")
        assert "Set a limit on the result page" in front.rule
        assert front.figure.value.endswith(" mm")


def test_the_largest_error_of_a_joint_is_held_against_the_limit(circles):
    size = circles.circles[0].tangential_range_mm
    guard = 1.65 * size.standard_uncertainty
    words = [
        of_circles(circles, Limit(limit)).word
        for limit in (size.value + 1.01 * guard, size.value, size.value - 1.01 * guard)
    ]

    assert words == ["PASSED", "CANNOT BE DECIDED", "FAILED"]
    assert of_circles(circles, Limit(size.value + 1e-6, "simple")).word == "PASSED"


def test_a_joint_that_was_not_judged_cannot_pass(circles):
    test = replace(circles, withheld=(MissingCircle(5, 1, message("circles.none")),))

    front = of_circles(test, FAR)

    assert front.word == "CANNOT BE DECIDED"
    assert "Joint 5, nest 1: The readings are at one point" in front.sentence
    assert of_circles(test, Limit(0.001)).word == "FAILED"


def test_of_nothing_there_is_neither_figure_nor_picture():
    front = of_circles(CircleTest((), ()), FAR)

    assert (front.word, front.look) == ("NOTHING TO ASSESS", "not_answered")
    assert (front.figure, front.picture, front.caption) == (None, None, "")


def test_lengths_about_the_taught_ball_are_held_against_the_limit(sphere):
    taught = sphere.spheres[0].of("nominal", taught=True).whole.max_mm
    passed = sphere_front(sphere, "IRB 120", "nominal", FAR, IN_ENGLISH)
    failed = sphere_front(sphere, "IRB 120", "nominal", Limit(taught.value / 2.0), IN_ENGLISH)

    assert (passed.word, failed.word) == ("PASSED", "FAILED")
    assert passed.figure.value.startswith(f"{taught.value:.2f}"[:4])
    assert "guard band to ISO 14253-1" in passed.rule


@pytest.mark.parametrize(
    ("skipped", "said"), [(1, "One configuration was skipped"), (3, "3 configurations were skipped")]
)
def test_stops_that_were_skipped_leave_it_open(sphere, skipped, said):
    front = sphere_front(replace(sphere, skipped=skipped), "IRB 120", "nominal", FAR, IN_ENGLISH)

    assert front.word == "CANNOT BE DECIDED"
    assert said in front.sentence


def test_bars_are_ranked_on_one_scale_with_their_intervals():
    page = Page(str(figure_bars([("a", Figure(0.1, 0.01)), ("b", Figure(-0.2, 0.02))], 0.4, IN_ENGLISH)))
    widths = [float(one["width"]) for tag, one in page.elements if tag == "rect"]

    assert widths[0] == pytest.approx(2.0 * widths[1], abs=0.1)
    assert page.text.index("b") < page.text.index("a")
    assert "limit 0.4 mm" in page.text
