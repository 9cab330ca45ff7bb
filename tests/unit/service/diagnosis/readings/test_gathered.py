"""Bad readings that gather are told by what they share; those that fall anywhere share nothing."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.diagnosis.point_scenes import telling_campaign, telling_scene
from truepose.diagnosis.reading_faults import shared_properties
from truepose.messages.catalogue import english

N = 96


@pytest.fixture(scope="module")
def scene():
    return telling_scene(campaign=telling_campaign(N))


def some_of(readings, count):
    """The first few of what is marked."""
    marked = np.zeros_like(readings)
    marked[np.flatnonzero(readings)[:count]] = True
    return marked


@pytest.mark.parametrize("count", [0, 1, 2])
def test_one_or_two_bad_readings_cannot_gather(count, scene):
    assert shared_properties(scene, some_of(scene.nest == 2, count)) is None


def test_a_nest_that_is_bad_in_one_mounting_is_told_with_both(scene):
    bad = some_of((scene.nest == 2) & (scene.stops.attachment == 3), 6)

    found = shared_properties(scene, bad)

    assert english(found.sentence).startswith(
        "6 of these readings were taken at nest 2 in mounting 3 of the tool, as were 8 of all readings"
    )
    assert found.on.variable == "nest and attachment of the tool"
    assert found.p_value < 1e-4


def test_bad_readings_of_one_nest_are_told_by_it(scene):
    bad = (scene.nest == 1) & (np.arange(N) % 2 == 0)

    assert shared_properties(scene, bad).on.variable == "nest"


def test_bad_readings_in_one_part_of_a_joints_range_are_told_by_its_angle(scene):
    angle_deg = np.rad2deg(scene.stops.joints_rad[:, 4])
    ends = np.quantile(angle_deg, [0.5, 0.75])
    bad = some_of((angle_deg >= ends[0]) & (angle_deg < ends[1]), 12)

    found = shared_properties(scene, bad)

    assert (found.on.variable, found.on.joint) == ("angle of joint 5", 4)
    assert f"with joint 5 between {ends[0]:.0f} and {ends[1]:.0f} deg, as were 24 of all readings" in english(
        found.sentence
    )


def test_bad_readings_of_one_part_of_the_campaign_are_told_by_time(scene):
    scene = replace(scene, stops=replace(scene.stops, attachment=None))

    found = shared_properties(scene, some_of(scene.stops.time_s >= np.median(scene.stops.time_s), 12))

    assert found.on.kind == "time"
    assert "between 24 min and 36 min after the first reading" in english(found.sentence)


def test_what_the_readings_of_a_stop_share_counts_once(scene):
    three_each = replace(scene, stops=replace(scene.stops, config=np.arange(N) // 3, attachment=None))
    two_stops = three_each.stops.config < 2  # their six readings are near in time

    assert shared_properties(three_each, two_stops) is None
    assert (
        shared_properties(replace(scene, stops=replace(scene.stops, attachment=None)), two_stops) is not None
    )


def test_readings_that_tell_neither_time_nor_mounting_still_tell_their_nest(scene):
    stops = replace(scene.stops, time_s=None, attachment=None)

    assert shared_properties(replace(scene, stops=stops), scene.nest == 3).on.variable == "nest"
