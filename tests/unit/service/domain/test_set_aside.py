"""Readings that a person sets aside: which rows they are, what is refused, what is left."""

import numpy as np
import pytest

from tests.helpers.domain.builders import (
    make_campaign,
    make_contact_campaign,
    make_contacts,
    make_legs,
    make_points,
    make_stops,
)
from truepose.domain.campaign import ReadingName, ReadingsSetAside
from truepose.domain.errors import ConfigurationError
from truepose.domain.set_aside import found_in, listed, without_readings
from truepose.messages.catalogue import english

# Two tool nests in each of ten configurations.
TWICE = make_points(20, stops=make_stops(20, config=np.repeat(np.arange(1, 11), 2)), nest=np.tile([1, 2], 10))
CAMPAIGN = make_campaign(calibration=TWICE, validation=make_points(3))


def wanted(*names, reason="a cable lay in the beam"):
    return ReadingsSetAside(names, reason, "Ada Byron")


def test_a_reading_is_found_by_its_configuration_and_nest():
    found = found_in(CAMPAIGN, wanted(ReadingName(9, 1), ReadingName(4, 2), ReadingName(9, 1)))

    assert found.rows == (7, 16)
    assert found.readings == (ReadingName(9, 1), ReadingName(4, 2))
    assert english(found.sentence) == "2 readings set aside by Ada Byron: a cable lay in the beam."
    assert english(listed(found)) == "configuration 9, nest 1; configuration 4, nest 2"


@pytest.mark.parametrize("reason", ["it slipped.", " it\n slipped "])
def test_a_reason_is_said_on_one_line_with_one_full_stop(reason):
    found = found_in(CAMPAIGN, wanted(ReadingName(9, 1), reason=reason))

    assert english(found.sentence) == "1 reading set aside by Ada Byron: it slipped."


def test_a_length_is_found_by_both_of_its_ends():
    legs = make_legs(10, base_point=np.arange(10) % 3 + 1, stops=make_stops(10, config=np.repeat([1, 2], 5)))
    campaign = make_campaign(calibration=None, legs=legs)

    assert found_in(campaign, wanted(ReadingName(2, 1, base_point=3))).rows == (5, 8)
    assert english(listed(wanted(ReadingName(2, 1, base_point=3)))) == "configuration 2, base point 3, nest 1"


def test_a_contact_is_found_by_its_target():
    campaign = make_contact_campaign(contacts=make_contacts(6))

    assert found_in(campaign, wanted(ReadingName(3, 1, target=7))).rows == (2,)
    assert english(listed(wanted(ReadingName(3, 1, target=7)))) == "configuration 3, target 7, nest 1"


@pytest.mark.parametrize(
    "name",
    [ReadingName(11, 1), ReadingName(1, 3), ReadingName(1, 1, base_point=1), ReadingName(1, 1, target=1)],
)
def test_a_reading_that_is_not_there_is_refused(name):
    with pytest.raises(ConfigurationError, match=r"has no reading of configuration"):
        found_in(CAMPAIGN, wanted(name))


def test_a_reading_that_judges_the_model_is_refused():
    judging = make_points(3, stops=make_stops(3, config=np.array([21, 22, 23])))
    campaign = make_campaign(calibration=TWICE, validation=judging)

    with pytest.raises(ConfigurationError, match=r"configuration 22, nest 1 judges the model"):
        found_in(campaign, wanted(ReadingName(22, 1)))


def test_a_fifth_is_set_aside_and_no_more():
    five = [ReadingName(config, 1) for config in range(1, 6)]

    assert len(found_in(CAMPAIGN, wanted(*five[:4])).rows) == 4
    with pytest.raises(ConfigurationError, match=r"5 of 20 readings are more than 20%"):
        found_in(CAMPAIGN, wanted(*five))


def test_a_campaign_without_readings_has_none_to_set_aside():
    with pytest.raises(ConfigurationError, match="has no reading"):
        found_in(make_campaign(calibration=None), wanted(ReadingName(1, 1)))


def test_what_is_left_stays_as_it_was_and_says_what_is_missing():
    aside = found_in(CAMPAIGN, wanted(ReadingName(9, 1), ReadingName(4, 2)))

    left = without_readings(CAMPAIGN, aside)

    assert left.set_aside == aside
    assert len(left.calibration) == 18
    kept = [row for row in range(20) if row not in aside.rows]
    assert np.array_equal(left.calibration.position_mm, TWICE.position_mm[kept])
    assert left.validation.position_mm is CAMPAIGN.validation.position_mm
    assert [aside.row_in_table(row) for row in range(18)] == kept


def test_the_arm_came_to_its_next_stop_from_the_one_whose_reading_is_set_aside():
    stops = make_stops(5, time_s=np.arange(5.0))
    campaign = make_campaign(calibration=make_points(5, stops=stops))

    left = without_readings(campaign, found_in(campaign, wanted(ReadingName(2, 1))))

    assert left.calibration.stops.move_rad[1] == pytest.approx(stops.joints_rad[2] - stops.joints_rad[1])
