"""The one sentence of a fleet: robots within the limit, the largest change, pass, fail or what is missing."""

import re
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.fleet.linear import drawn
from truepose.fleet.changes import account_of
from truepose.fleet.minimum_detectable_change import least_of_robots
from truepose.fleet.outcome import fleet_missing, fleet_outcome
from truepose.messages.catalogue import LANGUAGES, catalogue, english

_GAP = np.array([0.0, 0.0, 1.0, 0.0])


@pytest.fixture(scope="module")
def grown():
    """Six robots in four months; in robot 4 a gap grows."""
    return account_of(drawn(41, readings=40, drift=lambda i, k, month: 1.5 * month * (i == 4) * _GAP).fleet())


@pytest.fixture(scope="module")
def steady():
    return account_of(drawn(42, readings=40).fleet())


def largest_mm(account):
    return max(one.size_mm for one in account.named if one.change.scope == "robot")


def least_mm(account):
    return max(float(one.size_mm.max()) for one in least_of_robots(account) if one.of)


def test_a_robot_that_changed_by_more_than_the_limit_fails_the_fleet_and_is_named(grown):
    size_mm = largest_mm(grown)

    said = english(fleet_outcome(grown, 0.5 * size_mm))

    assert re.fullmatch(
        r"Change within the limit of \S+ mm in 5 of 6 robots; beyond it in 1 "
        r"\(largest: robot 4, \S+ mm\); overall: fail\.",
        said,
    )


def test_a_change_within_the_limit_is_named_too(grown):
    limit_mm = 2.0 * max(largest_mm(grown), least_mm(grown))

    said = english(fleet_outcome(grown, limit_mm))

    assert "in 6 of 6 robots; largest: robot 4, " in said
    assert said.endswith(" mm; overall: pass.")


def test_where_nothing_changed_it_passes_if_a_change_as_large_would_have_been_detected(steady):
    least = least_mm(steady)

    assert steady.named == ()
    assert english(fleet_outcome(steady, 1.1 * least)).endswith(
        "in 6 of 6 robots; no significant change found; overall: pass."
    )
    assert re.search(
        r"found; overall: cannot be decided, as a change of up to \S+ mm may be undetected\.$",
        english(fleet_outcome(steady, 0.5 * least)),
    )


def test_robots_that_were_measured_on_one_day_are_not_known():
    made = drawn(42, readings=40)
    made.day[:] = [0.0 if robot in {1, 2} else day for robot, day in zip(made.robot, made.day, strict=True)]

    said = english(fleet_outcome(account_of(made.fleet()), 1e6))

    assert said == (
        "Change within the limit of 1e+06 mm in 4 of 6 robots; no significant change found; not known in 2, "
        "measured on one day only; overall: measure these on another day to get a pass or fail."
    )


def _changed(named, **differing):
    """Return a change that is another one."""
    return replace(named, trial=replace(named.trial, change=replace(named.change, **differing)))


def test_what_was_so_on_one_day_is_over_and_an_instrument_is_no_robot(grown):
    (named,) = (one for one in grown.named if one.change.of == "robot 4")
    limit_mm = 0.5 * named.size_mm
    on_one_day = _changed(named, kind="day")
    of_instrument = _changed(named, scope="instrument", of="tracker 1")
    of_type = _changed(named, scope="type", of="")

    said = [
        english(fleet_outcome(replace(grown, named=(one,)), limit_mm))
        for one in (on_one_day, of_instrument, of_type)
    ]

    assert ["in 6 of 6 robots; no significant change" in one for one in said] == [True, True, False]
    assert "in 0 of 6 robots; beyond it in 6 (largest: the whole type, " in said[-1]


def test_fewer_robots_than_can_be_compared_are_told_what_is_missing():
    assert english(fleet_missing(0.1)).startswith("No robot can be held against the limit of 0.1 mm yet: ")


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_language_says_it_in_the_units_of_its_reader(language, grown):
    spoken = catalogue(f"{language}-x-inch").spoken(fleet_outcome(grown, 0.5 * largest_mm(grown)))

    assert " in" in spoken
    assert "robot 4" in spoken
    assert "mm" not in spoken
