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
from truepose.domain.set_aside import found_in, listed, named_by_numbers, without_readings
from truepose.messages.catalogue import catalogue, english

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


LEGS = make_campaign(
    calibration=None,
    legs=make_legs(10, base_point=np.arange(10) % 3 + 1, stops=make_stops(10, config=np.repeat([1, 2], 5))),
)


@pytest.mark.parametrize(
    ("campaign", "numbers", "rows"),
    [
        (CAMPAIGN, (9, 2), (17,)),
        (make_campaign(calibration=make_points(6)), (3,), (2,)),  # its one reading
        (LEGS, (2, 3, 1), (5, 8)),
        (make_contact_campaign(contacts=make_contacts(6)), (3, 7, 1), (2,)),
        (make_contact_campaign(contacts=make_contacts(6)), (3,), (2,)),
    ],
)
def test_a_reading_is_named_by_its_numbers_as_reports_order_them(campaign, numbers, rows):
    named = named_by_numbers(campaign, [(numbers, "it slipped")], "Ada Byron")

    assert found_in(campaign, named).rows == rows


@pytest.mark.parametrize(
    ("numbers", "why"),
    [
        ((9,), r"^Configuration 9 has 2 readings: name one of them, 9/1, 9/2\.$"),
        ((12,), r"no reading of configuration 12 .* nearest is configuration 10, nest 1 \(10/1\)\.$"),
        ((7, 4), r"no reading of 7/4 to identify from; the nearest is configuration 7, nest 2 \(7/2\)\.$"),
        ((7, 1, 2), r"no reading of 7/1/2 to identify from; the nearest is configuration 7, nest 2"),
    ],
)
def test_numbers_of_no_reading_or_of_several_are_refused_with_those_that_are_near(numbers, why):
    with pytest.raises(ConfigurationError, match=why):
        named_by_numbers(CAMPAIGN, [(numbers, "it slipped")], "Ada Byron")


def test_of_a_configuration_with_many_readings_the_first_are_listed():
    points = make_points(9, stops=make_stops(9, config=np.ones(9, dtype=int)), nest=np.arange(1, 10))

    with pytest.raises(ConfigurationError, match=r"has 9 readings: .* 1/5, 1/6, \.\.\.\.$"):
        named_by_numbers(make_campaign(calibration=points), [((1,), "it slipped")], "Ada Byron")


def test_a_reading_named_twice_is_refused_however_it_is_named():
    campaign = make_campaign(calibration=make_points(6))

    with pytest.raises(ConfigurationError, match=r"configuration 3, nest 1 is set aside twice"):
        named_by_numbers(campaign, [((3,), "it slipped"), ((3, 1), "a cable")], "Ada Byron")


def test_each_reading_keeps_its_own_reason():
    wanted = [((9, 1), "it slipped."), ((4, 2), "a cable"), ((2, 2), "a cable")]

    found = found_in(CAMPAIGN, named_by_numbers(CAMPAIGN, wanted, "Ada Byron"))

    assert english(found.sentence) == "3 readings set aside by Ada Byron: it slipped; a cable."
    assert catalogue("fr").spoken(found.sentence).endswith("\u00a0: it slipped\u00a0; a cable.")
    assert found.reason_of_each == ("it slipped.", "a cable", "a cable")
    assert english(listed(found)) == (
        "configuration 9, nest 1 (it slipped.); configuration 4, nest 2 (a cable); "
        "configuration 2, nest 2 (a cable)"
    )


def test_one_reason_is_that_of_each_reading_also_of_results_from_before_there_were_several():
    found = found_in(CAMPAIGN, wanted(ReadingName(9, 1), ReadingName(4, 2)))

    assert found.reason_of_each == ("a cable lay in the beam",) * 2
    assert wanted(ReadingName(9, 1)).reason_of_each == ("a cable lay in the beam",)
