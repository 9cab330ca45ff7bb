"""Lines between whole orders: in place of the waves beside them, and only where these are clearly worse."""

import numpy as np
import pytest

from tests.helpers.diagnosis.selections import make_selected, make_start, select_from, those_of
from truepose.diagnosis.screening.refinement import with_known_orders, with_lines_between
from truepose.domain.diagnosis import Detail

N = 120
SIZE_RAD = 4e-4


def waves(joint, *orders):
    return {"joint_harmonics": {f"wave_{joint}_{order:g}_sin": SIZE_RAD for order in orders}}


def selection(joint, *orders):
    """What the selection makes of waves that were planted, and of lines between their orders."""
    start = make_start(waves(joint, *orders), n=N)
    propose = those_of(start, "joint_harmonics")
    selected = select_from(start, propose)
    return start, selected, with_lines_between(start.fit, selected, propose, start.scene)


def orders_of(selected):
    return sorted(pick.variant for pick in selected.picks)


@pytest.mark.parametrize(("joint", "order"), [(4, 7.4), (6, 5.5), (2, 8.45)])
def test_a_line_takes_the_place_of_the_waves_beside_it(joint, order):
    start, before, after = selection(joint, order)

    assert all(one == round(one) for one in orders_of(before))
    (found,) = orders_of(after)
    assert found == pytest.approx(order, abs=0.1)
    (told,) = with_known_orders(after, after.picks, (Detail("order", found, "1", 0.0),), start.scene)
    assert 0.0 < told.standard_uncertainty < 0.05
    assert found == pytest.approx(order, abs=3.5 * told.standard_uncertainty)


@pytest.mark.parametrize("orders", [(7,), (7, 8), (3, 9)])
def test_whole_orders_stay(orders):
    _, before, after = selection(4, *orders)

    assert orders_of(before) == orders_of(after) == list(orders)
    assert after is before


def test_less_than_one_period_is_no_line():
    """Joint 2 turns by a quarter: a wave of 2.6 per turn is a bow there, whatever its order."""
    _, before, after = selection(2, 2.6)

    assert after is before


def test_nothing_found_is_nothing_refined():
    start, before, after = selection(4)

    assert before.picks == after.picks == ()
    assert with_known_orders(after, (), (), start.scene) == ()


def test_a_line_alone_is_not_refined_again():
    start, _, after = selection(4, 7.4)

    again = with_lines_between(start.fit, after, lambda fit: (), start.scene)

    assert again is after


def test_whole_orders_are_exact_and_other_details_stay():
    start = make_start(waves(4, 7))
    selected = make_selected(start, [("joint_harmonics", "joint 4", "wave_4_7_sin")])
    details = (Detail("order", 7.0, "1", 0.0), Detail("phase", 10.0, "deg", 2.0))

    assert with_known_orders(selected, selected.picks, details, start.scene) == details


def test_the_phase_is_as_uncertain_as_the_order_over_the_mean_angle():
    start, _, after = selection(2, 8.45)
    (line,) = after.picks
    details = (Detail("order", line.variant, "1", 0.0), Detail("phase", 10.0, "deg", 2.0))

    order, phase = with_known_orders(after, after.picks, details, start.scene)

    mean_deg = np.rad2deg(start.scene.turn_rad[:, 1].mean())
    assert phase.standard_uncertainty == pytest.approx(np.hypot(2.0, mean_deg * order.standard_uncertainty))
