"""What a judgement does not contain is said beside it."""

import pytest

from tests.helpers.identification.closed_loops import contact_campaign
from tests.helpers.identification.synthetic import NESTS, nominal_campaign
from truepose.domain.contacts import TargetKind
from truepose.identification import identify
from truepose.validation.cautions import prediction_cautions, validation_cautions
from truepose.validation.validate import validate

LOOP = contact_campaign(TargetKind.SPHERE)
POINTS = nominal_campaign(20, nests=NESTS[:1])


@pytest.fixture(scope="module")
def model():
    return identify(LOOP).model


def keys(sentences):
    return [sentence.key for sentence in sentences]


def test_positions_of_a_closed_loop_stand_or_fall_with_the_stated_base(model):
    assert "cautions.unseen_base" in keys(validation_cautions(model, POINTS.calibration))
    assert "cautions.unseen_base" in keys(prediction_cautions(model, POINTS.calibration.stops))


def test_contacts_judge_it_whatever_the_base(model):
    assert keys(validation_cautions(model, LOOP.contacts)) == []
    assert validate(model, LOOP.contacts).quantity == "length"


def test_positions_of_a_model_that_saw_them_need_no_caution():
    model = identify(POINTS, ("base",)).model

    assert keys(validation_cautions(model, POINTS.calibration)) == []
