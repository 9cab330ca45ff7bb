"""Who is to be measured next and why, and what is said of a fleet in every language."""

from dataclasses import replace
from datetime import date

import numpy as np
import pytest

from tests.helpers.fleet.linear import drawn
from truepose.analysis.fleets.comparison import foretold
from truepose.domain.errors import ConfigurationError
from truepose.fleet.changes import account_of
from truepose.fleet.interim_check import checked_causes
from truepose.fleet.outlying_campaigns import OutlyingCampaign
from truepose.fleet.sentences import change_sentences, comparison_sentence, headline, next_said
from truepose.fleet.trend import along, due, passing
from truepose.messages.catalogue import LANGUAGES, catalogue, english
from truepose.messages.message import leading_key
from truepose.storage.caches import from_bytes, to_bytes

FIRST = date(2026, 3, 2).toordinal()
_GAP = np.array([0.0, 0.0, 1.0, 0.0])
_SCALE = np.array([0.0, 0.0, 0.0, 1.0])


def account(seed, drift=None, **options):
    """Compare a fleet whose days are those of the calendar."""
    fleet = drawn(seed, readings=40, drift=drift, **options).fleet()
    return account_of(replace(fleet, day=fleet.day + FIRST))


@pytest.fixture(scope="module")
def ageing():
    return account(21, lambda i, k, month: 0.6 * month * (i == 4) * _GAP)


@pytest.fixture(scope="module")
def steady():
    return account(10)


@pytest.fixture(scope="module")
def drifting():
    options = {"robots": 10, "months": 6, "day": 0.0}
    return account(23, lambda i, k, month: 0.4 * month * (k == 1) * _SCALE, **options)


def test_where_nothing_changes_all_are_due_by_the_day_that_they_were_measured_last(steady):
    robots = due(steady, 0.1)

    assert [one.why for one in robots] == ["longest_ago"] * 6
    assert english(headline(steady)).startswith("No significant change. ")
    assert english(next_said(robots[0], 0.1)) == (
        "Measure robot 0 next. No robot needs measuring urgently; this robot was last measured on 2026-05-31."
    )


def test_the_robot_that_ages_is_due_first_and_the_day_of_the_limit_says_why(ageing):
    size = ageing.named[0].size_mm

    first = due(ageing, 2.0 * size)[0]

    assert (first.robot, first.why) == ("robot 4", "passes")
    assert date.fromordinal(round(first.passing.day)) == date(2026, 8, 29)  # as far again as it came
    assert f"before {date.fromordinal(int(first.passing.earliest))}" in english(next_said(first, 2.0 * size))
    passed = english(next_said(due(ageing, 0.5 * size)[0], 0.5 * size))
    assert "exceeded" in passed
    assert passed.endswith("before the robot was last measured.")


def test_what_an_account_foretells_is_kept_as_it_was_found(ageing, steady):
    size = ageing.named[0].size_mm
    passes = due(ageing, 2.0 * size)[0].passing

    found = foretold(ageing, "ABB IRB 120", 240, 2.0 * size, "2026-06-01 08:00 UTC")

    assert from_bytes(to_bytes(found)) == found
    (robot,) = found.foreseen
    assert (robot.robot, robot.size_mm, robot.last_measured_on) == ("robot 4", size, "2026-05-31")
    assert robot.day == date.fromordinal(int(passes.day)).isoformat()
    assert robot.earliest == date.fromordinal(int(passes.earliest)).isoformat()
    months = (passes.day - date.fromisoformat(robot.since).toordinal()) / 30.4375
    assert robot.rate_mm * months == pytest.approx(2.0 * size)
    assert foretold(steady, "ABB IRB 120", 240, 0.1, "").foreseen == ()


def test_a_change_at_once_has_no_forecast_and_is_due_by_its_size():
    found = account(22, lambda i, k, month: 2.0 * (month >= 3) * (i == 1) * _GAP, months=6)
    size = found.named[0].size_mm

    small, large = (due(found, limit)[0] for limit in (2.0 * size, 0.5 * size))

    assert (small.robot, small.why, small.passing) == ("robot 1", "changed", None)
    assert (large.robot, large.why, large.passing) == ("robot 1", "passes", None)
    assert "goes on" not in english(next_said(small, 2.0 * size))
    keys = [leading_key(one) for one in change_sentences(found, found.named[0], None)]
    assert "fleet.no_forecast" in keys


def test_a_robot_whose_instrument_may_be_it_as_well_is_measured_with_another(ageing):
    named = ageing.named[0]
    doubtful = replace(named.trial, change=replace(named.change, scope="instrument", of="tracker 0"))
    unsure = replace(ageing, named=(replace(named, rivals=(doubtful,)),))

    first = due(unsure, 1.0)[0]

    assert first.instrument == "tracker 1"
    assert "Measure it with tracker 1" in english(next_said(first, 1.0))


def test_a_robot_whose_newest_campaign_was_left_out_is_measured_again(steady):
    other = OutlyingCampaign(9, "robot 3", FIRST + 120.0, ratio=300.0, excess=1.0)

    first = due(replace(steady, unlike=(other,)), 0.1)[0]

    assert (first.robot, first.why) == ("robot 3", "unlike")
    assert english(next_said(first, 0.1)) == (
        "Measure robot 3 next. Its campaign of 2026-06-30 differs from its other campaigns and was left out: "
        "measure this robot again."
    )


def test_what_all_robots_show_on_one_day_sends_to_what_they_had_in_common():
    found = account(27, lambda i, k, month: 1.0 * (month == 2) * _GAP, months=5)

    told = [english(one) for one in change_sentences(found, found.named[0], None)]

    assert any("check what all campaigns of that day had in common" in one for one in told)
    assert {one.why for one in due(found, 1e-9)} == {"longest_ago"}


def test_a_tracker_that_drifts_sends_nobody_to_a_robot(drifting):
    named = drifting.named[0]

    assert {one.why for one in due(drifting, 1e-9)} == {"longest_ago"}
    told = [english(one) for one in change_sentences(drifting, named, passing(drifting.fleet, named, 1.0))]
    assert any(one.startswith("Have tracker 1 checked against a certified length") for one in told)


@pytest.mark.parametrize("fleet", ["ageing", "drifting"])
def test_a_course_runs_along_its_line(fleet, request):
    found = request.getfixturevalue(fleet)
    named = found.named[0]

    course = along(found, named)

    days = course.day - FIRST
    line = named.size_mm * days / days[-1]
    assert np.all(np.abs(course.size_mm - line) < 4.0 * course.u_mm)
    assert course.size_mm[-1] > 4.0 * course.u_mm[-1]


def test_a_course_of_the_type_runs_along_its_line():
    found = account(24, lambda i, k, month: 0.4 * month * _GAP)

    course = along(found, found.named[0])

    assert len(course.day) == 3
    assert course.size_mm[-1] == pytest.approx(found.named[0].size_mm, abs=4.0 * course.u_mm[-1])


@pytest.mark.parametrize("language", LANGUAGES)
def test_everything_is_said_in_every_language(ageing, language):
    words, named = catalogue(language), ageing.named[0]
    passes = passing(ageing.fleet, named, 0.1)
    sentences = [comparison_sentence(ageing), headline(ageing), *change_sentences(ageing, named, passes)]
    sentences += [next_said(one, 0.1) for one in due(ageing, 0.1)]

    said = [words.spoken(one) for one in sentences]

    assert not any("fleet." in one or "{" in one for one in said)
    assert "robot 4" in said[2]


def test_a_check_of_a_fleet_in_which_nothing_ages_is_refused(steady):
    """A ballbar without masses tells of geometry alone."""
    aged = replace(steady.fleet, owners=("geometry",) * len(steady.fleet.owners))

    with pytest.raises(ConfigurationError, match="no joint compliance, no gear harmonics"):
        checked_causes(replace(steady, fleet=aged, named=()))
