"""Of plans that the service chooses nothing touches on any way; what is clear already stays as it is."""

from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from truepose.domain.robot import JointRange, Nest
from truepose.exchange.cells.file import simulated_cell
from truepose.planning.errors import NoWayError
from truepose.planning.observability import observability_o1
from truepose.planning.tracker import plans
from truepose.planning.tracker.path_repair import pool_of, repair_order
from truepose.planning.tracker.plans import plan_calibration, plan_validation, scaled_jacobians
from truepose.planning.workspace.bodies import bodies_in, rooms
from truepose.planning.workspace.candidates import Candidates, draw_candidates
from truepose.planning.workspace.path_clearance import touching, ways_between
from truepose.planning.workspace.space import space_of_cell

FEW = 200  # candidates: enough for the tests, a tenth of the time


def space_of(scenario):
    cell = simulated_cell(scenario, 0)
    return space_of_cell(cell, cell.robot.calibration_ranges, float(np.radians(-5.0)))


SPACES = {arm: space_of(f"{arm}-tilted") for arm in ("irb120", "lrmate")}
LRMATE = SPACES["lrmate"]


def plan_of(arm, role, n, seed):
    if role == "validation":
        return plan_validation(SPACES[arm], n, seed)
    return plan_calibration(SPACES[arm], n, seed, n_candidates=FEW)


@cache
def chosen(*wanted):
    return plan_of(*wanted)


@cache
def unmended(*wanted):
    """The plan as it is ordered and not mended."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(plans, "mended_or_toured", lambda pool, order, *_, **__: np.array(order))
        return plan_of(*wanted)


def least_room_mm(arm, plan):
    """The least room on all ways of a plan, looked at two hundred times each."""
    ways = ways_between(plan.stops, plan.approach_offset_rad)
    share = np.linspace(0.0, 1.0, 200)[:, None, None]
    along = ways.start_rad + share * (ways.end_rad - ways.start_rad)
    return rooms(bodies_in(SPACES[arm]), along.reshape(-1, along.shape[-1])).least_mm().min()


def first_visits(plan):
    return [stop for stop in plan.stops if stop.repeat_of is None]


# among first visits, in revisits and from stops that touch themselves
@pytest.mark.parametrize(
    "wanted",
    [
        ("irb120", "calibration", 20, 8),
        ("lrmate", "calibration", 20, 2),
        ("lrmate", "calibration", 40, 5),
        ("lrmate", "calibration", 20, 6),
        ("lrmate", "validation", 50, 1),
    ],
)
def test_on_no_way_of_a_chosen_plan_anything_touches(wanted):
    before, plan = unmended(*wanted), chosen(*wanted)

    assert least_room_mm(wanted[0], before) < 0.0  # else there was nothing to mend
    # between two of its looks, a degree or two apart, the arm sinks by less than a millimetre
    assert least_room_mm(wanted[0], plan) > -1.0
    assert len(plan.stops) == len(before.stops)
    assert sorted(s.nest for s in first_visits(plan)) == sorted(s.nest for s in first_visits(before))
    by_number = {stop.config: stop for stop in plan.stops}
    for again in plan.stops[len(first_visits(plan)) :]:
        visited = by_number[again.repeat_of]
        assert (again.joints_rad, again.nest) == (visited.joints_rad, visited.nest)


@pytest.mark.parametrize(("arm", "role"), [("irb120", "calibration"), ("lrmate", "validation")])
def test_a_plan_that_is_clear_stays_as_it_is(arm, role):
    before = unmended(arm, role, 20, 4)
    assert least_room_mm(arm, before) > 0.0

    assert chosen(arm, role, 20, 4) == before


def test_what_takes_the_place_of_a_stop_costs_no_observability():
    wanted = ("lrmate", "calibration", 40, 5)
    before, after = unmended(*wanted), chosen(*wanted)
    assert {s.joints_rad for s in before.stops} != {s.joints_rad for s in after.stops}

    # measured: 0.1 % less with 200 candidates to choose from, less than that with 5,000
    assert o1(after) > 0.99 * o1(before)


def o1(plan):
    stops = first_visits(plan)
    joints, nests = (np.array([getattr(s, what) for s in stops]) for what in ("joints_rad", "nest"))
    jacobians = scaled_jacobians(LRMATE, Candidates(joints, nests))
    return observability_o1(jacobians.reshape(-1, jacobians.shape[2]), len(stops))


POOL = draw_candidates(LRMATE, 60, np.random.default_rng(1)).joints_rad


def unused(order, _):
    return np.setdiff1d(np.arange(len(POOL)), order)


@settings(max_examples=20)
@given(st.permutations(range(len(POOL))), st.integers(2, 12), st.booleans())
def test_an_order_is_mended_wherever_it_touches_and_only_there(rows, n, comes_from_somewhere):
    pool, order = pool_of(LRMATE, POOL), rows[:n]
    start = rows[-1] if comes_from_somewhere and pool.stand(np.array(rows[-1:]), 0.0)[0] else None
    before = [order[0] if start is None else start, *order]

    found = repair_order(pool, order, unused, start=start)

    after = [found[0] if start is None else start, *found]
    assert len(set(found)) == n
    assert not touches(pool, after)
    if not touches(pool, before):
        assert list(found) == order


def touches(pool, rows):
    ways = list(pairwise(rows))
    return touching(pool.bodies, pool.legs(ways)).size > 0


def test_an_order_that_is_not_allowed_is_not_chosen():
    pool = pool_of(LRMATE, POOL)
    orders = (np.random.default_rng(k).permutation(len(POOL))[:12].tolist() for k in range(99))
    order = next(order for order in orders if touches(pool, order))
    first = repair_order(pool, order, unused).tolist()

    other = repair_order(pool, order, unused, allowed=lambda found: list(found) != first).tolist()

    assert other != first
    assert not touches(pool, other)


@pytest.mark.parametrize("role", ["calibration", "validation"])
def test_where_nothing_can_be_clear_one_sentence_says_what_touches_and_what_to_look_at(role, monkeypatch):
    straight = (*LRMATE.ranges[:4], JointRange(-0.02, 0.02), LRMATE.ranges[5])
    behind = replace(LRMATE, ranges=straight, nests=(Nest((0.0, 0.0, -600.0), 0.002),))  # through the elbow
    monkeypatch.setitem(SPACES, "behind", behind)

    with pytest.raises(NoWayError) as refused:
        plan_of("behind", role, 6, 1)

    sentence = str(refused.value)
    assert "of 6 configurations cannot be reached" in sentence
    assert "tool nest 1 would be" in sentence
    assert "mm inside the arm itself" in sentence
    assert "Check the floor, the centres of the tool nests and the joint ranges" in sentence
