"""Errors of orientation: told where orientations were read and used, else nothing."""

from dataclasses import replace

import numpy as np
import pytest

from tests.unit.service.identification.problem.test_certified_artefact import poses
from truepose.exchange.results.identification import identification_document
from truepose.exchange.results.validation import validation_document
from truepose.identification import identify
from truepose.identification.verdict.relative_accuracy import turn_errors
from truepose.kinematics.frames import (
    quaternion_from_rotation,
    rotation_from_quaternion,
    rotation_from_vector,
)
from truepose.messages.catalogue import IN_ENGLISH, catalogue
from truepose.reports.error_tables import turns_table
from truepose.validation.validate import validate

RIGHT = np.zeros(3)


@pytest.fixture(scope="module")
def campaign():
    return poses(RIGHT, RIGHT)


@pytest.fixture(scope="module")
def model(campaign):
    return identify(campaign).model


def turned(points, vector_rad):
    turns = rotation_from_vector(np.array(vector_rad)) @ rotation_from_quaternion(points.quaternion)
    return replace(points, quaternion=quaternion_from_rotation(turns))


def test_orientations_that_are_off_by_an_angle_show_that_angle(campaign, model):
    found = turn_errors(model, turned(campaign.calibration, [0.0, 0.003, -0.004]))

    assert found.identified.mean_rad == pytest.approx(0.005, rel=0.01)  # the model itself is off by 1e-5
    assert found.identified.max_rad == pytest.approx(0.005, rel=0.02)
    assert found.identified.n == len(campaign.calibration)


def test_what_stated_noise_alone_gives_is_the_mean_of_its_angle(campaign, model):
    u_rad = campaign.calibration.rotation_uncertainty_rad[0]

    found = turn_errors(model, campaign.calibration)

    assert found.identified.noise_rad == pytest.approx(np.sqrt(8.0 / np.pi) * u_rad)  # Maxwell's mean


def test_readings_that_state_nothing_let_no_noise_be_expected(campaign, model):
    silent = replace(campaign.calibration, rotation_uncertainty_rad=None)

    assert np.isnan(turn_errors(model, silent).identified.noise_rad)


def test_without_orientations_there_is_nothing_to_say(campaign, model):
    alone = replace(campaign.calibration, quaternion=None, rotation_uncertainty_rad=None)

    assert turn_errors(model, alone) is None
    assert turns_table(validate(model, alone)).rows == []


def test_a_model_of_positions_knows_no_orientation_of_the_readings(campaign):
    alone = replace(campaign.calibration, quaternion=None, rotation_uncertainty_rad=None)
    answer = identify(replace(campaign, calibration=alone))

    assert turn_errors(answer.model, campaign.calibration) is None
    assert turns_table(answer, IN_ENGLISH).rows == []


def test_documents_say_degrees_and_only_where_orientations_were_read(campaign, model):
    off = turned(campaign.calibration, [0.0, 0.0, np.radians(0.2)])
    answer = identify(replace(campaign, validation=off))

    blocks = identification_document(answer, "arm")["statistics"]
    judged = validation_document(validate(model, off))

    assert blocks["validation_orientation"]["identified"]["mean_deg"] == pytest.approx(0.2, rel=0.01)
    assert judged["orientation"]["identified"]["mean_deg"] == pytest.approx(0.2, rel=0.01)
    plain = replace(campaign.calibration, quaternion=None, rotation_uncertainty_rad=None)
    without = identification_document(identify(replace(campaign, calibration=plain)), "arm")["statistics"]
    assert not [name for name in without if "orientation" in name]


@pytest.mark.parametrize("language", ["en", "fr"])
def test_a_reader_sees_held_out_orientations_before_those_of_the_calibration(campaign, language):
    answer = identify(replace(campaign, validation=campaign.calibration))

    rows = turns_table(answer, catalogue(language)).rows

    assert len(rows) == 4
    assert rows[0][0] == catalogue(language).say("turns.validation")
    assert (rows[1][0], rows[1][2]) == ("", str(len(campaign.calibration)))
