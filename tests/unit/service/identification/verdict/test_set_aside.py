"""A campaign without the readings that a person set aside gives what it gives without them, and says so."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.identification.synthetic import measured, nominal_campaign
from truepose.diagnosis.diagnose import diagnose
from truepose.domain.campaign import ReadingName, ReadingsSetAside
from truepose.domain.set_aside import found_in, without_readings
from truepose.exchange.results.diagnosis import diagnosis_document
from truepose.exchange.results.identification import identification_document
from truepose.identification import identify
from truepose.messages.catalogue import english

ROWS = (7, 12)
SPOILT = 20
EFFECTS = ("base", "geometry")


@pytest.fixture(scope="module")
def campaign():
    """A campaign with a reading that the fit finds gross, behind those that are set aside."""
    whole = measured(nominal_campaign(60), effects=EFFECTS)[0]
    position = whole.calibration.position_mm.copy()
    position[SPOILT] += 3.0
    return replace(whole, calibration=replace(whole.calibration, position_mm=position))


@pytest.fixture(scope="module")
def aside(campaign):
    stops, nest = campaign.calibration.stops, campaign.calibration.nest
    names = tuple(ReadingName(int(stops.config[row]), int(nest[row])) for row in ROWS)
    return found_in(campaign, ReadingsSetAside(names, "the tool was touched", "Ada Byron"))


@pytest.fixture(scope="module")
def never_there(campaign):
    return campaign.of_rows(np.setdiff1d(np.arange(len(campaign.calibration)), ROWS))


def test_an_identification_is_that_of_a_campaign_that_never_had_them(campaign, aside, never_there):
    found, other = (identify(one, EFFECTS) for one in (without_readings(campaign, aside), never_there))

    assert found.parameters == other.parameters
    assert (found.calibration, found.cross_validation) == (other.calibration, other.cross_validation)
    assert np.array_equal(found.model.covariance, other.model.covariance)
    assert [outlier.row for outlier in found.outliers] == [SPOILT]
    assert [outlier.row for outlier in other.outliers] == [SPOILT - len(ROWS)]


def test_an_identification_says_who_set_what_aside_and_why(campaign, aside):
    found = identify(without_readings(campaign, aside), EFFECTS)
    document = identification_document(found, "arm")

    assert english(found.message).endswith("2 readings set aside by Ada Byron: the tool was touched.")
    assert found.model.identified_from["readings_set_aside"] == 2
    assert document["set_aside"]["person"] == "Ada Byron"
    assert document["set_aside"]["rows"] == list(ROWS)
    assert [one["config"] for one in document["set_aside"]["readings"]] == [8, 13]


def test_what_could_not_be_fitted_says_it_as_well(campaign, aside):
    few = without_readings(campaign, aside).of_rows(np.arange(2))

    found = identify(few, EFFECTS)

    assert found.model is None
    assert found.set_aside == aside
    assert "set aside by Ada Byron" in english(found.message)


def test_all_readings_are_said_to_have_taken_part_where_none_was_set_aside(campaign):
    found = identify(campaign, EFFECTS)

    assert identification_document(found, "arm")["set_aside"] is None
    assert "readings_set_aside" not in found.model.identified_from


def test_a_diagnosis_is_that_of_a_campaign_that_never_had_them_and_says_so(campaign, aside, never_there):
    found, other = (diagnose(one, EFFECTS) for one in (without_readings(campaign, aside), never_there))

    assert found.model.parameters == other.model.parameters
    assert (found.before, found.after) == (other.before, other.after)
    assert english(found.message) == (
        f"{english(other.message)} 2 readings set aside by Ada Byron: the tool was touched."
    )
    assert diagnosis_document(found)["set_aside"]["reason"] == "the tool was touched"
    assert found.model.identified_from["readings_set_aside"] == 2
