"""Dataclasses survive their JSON form."""

import json
import math
from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.ballbar.sessions import make_ballbar_plan
from truepose.domain.ballbar import BallbarPlan, PlannedAway
from truepose.domain.diagnosis import Noise, Remaining
from truepose.domain.identification import Parameter
from truepose.domain.robot import FramePlacement, JointRow, Robot
from truepose.domain.session import (
    PlannedStop,
    PointTaken,
    Registration,
    SessionPlan,
    SessionState,
    StopSkipped,
)
from truepose.messages.message import message, together
from truepose.storage.documents import from_document, to_document
from truepose.storage.errors import DamagedDatabaseError


def through_json(value):
    return from_document(type(value), json.loads(json.dumps(to_document(value), allow_nan=False)))


SENTENCES = [
    "In words of their own.",
    message("message.unexplained"),
    together(
        message(
            "causes.drift",
            rate_mm_per_h=0.1,
            settling=(message("span.seconds", seconds=5),),
            links=(2, 3),
        ),
        message("span.seconds", seconds=math.inf),
        message("span.seconds", seconds=-math.inf),
        "Theirs.",
    ),
]
(PLACEMENT,) = make_ballbar_plan().placements
NOUNS = [
    *(Remaining(structure=True, depends_on=(), sentence=sentence) for sentence in SENTENCES),
    *(Noise(1.2, None, sentence) for sentence in SENTENCES),
    Parameter("d_1", "geometry", 0.0, "mm", 0.1, prior_width=math.inf),  # without bound
    Robot("arm", (JointRow(0.0, 1.0, 0.5, 2.0, sign=-1),), gear_ratios=(100.0,), source="a table"),
    FramePlacement(1, 2, 3),
    BallbarPlan((replace(PLACEMENT, away=PlannedAway((0.1,) * 6, ((0.2,) * 6,))),)),
]


@pytest.mark.parametrize("noun", NOUNS, ids=lambda noun: type(noun).__name__)
def test_a_noun_survives_its_json_form(noun):
    assert through_json(noun) == noun


@given(
    joints=st.lists(st.floats(-10, 10), min_size=1, max_size=9).map(tuple),
    repeat_of=st.none() | st.integers(0, 10**6),
    offset=st.none() | st.floats(-1, 1),
)
def test_a_plan_survives_its_json_form(joints, repeat_of, offset):
    plan = SessionPlan("calibration", (PlannedStop(1, joints, 2, repeat_of),), approach_offset_rad=offset)

    assert through_json(plan) == plan


def test_arrays_keep_their_shape_and_every_digit():
    place = Registration(np.eye(3) / 3, np.array([0.1, 0.2, 0.3]), np.eye(6) * 1e-9, 0.01, None)

    back = through_json(place)

    np.testing.assert_array_equal(back.rotation, place.rotation)
    np.testing.assert_array_equal(back.covariance, place.covariance)
    assert back.two_face_mm is None


@dataclass(frozen=True)
class _Spread:
    values: set[float]


def test_a_form_that_nothing_reads_is_refused_rather_than_handed_on_as_it_is():
    with pytest.raises(DamagedDatabaseError, match="nothing says how"):
        from_document(_Spread, {"values": [1.0]})


def test_a_number_that_is_not_known_is_null_in_json_and_nan_again_after():
    point = PointTaken(1, 1, (0.0,), (0.0,), (1,), 0.0, math.nan, 1, (0, 0, 0), (0, 0, 0), 0.01, 0.0, 3)

    document = to_document(point)

    assert document["temperature_c"] is None
    assert math.isnan(through_json(point).temperature_c)


def test_a_field_that_an_older_document_lacks_takes_its_default():
    document = to_document(StopSkipped(3, 1.0, "no reflector"))
    robot = {"name": "arm", "joints": []}

    assert from_document(StopSkipped, document) == StopSkipped(3, 1.0, "no reflector")
    assert from_document(Robot, robot).repeatability_mm == 0.0


def test_a_ballbar_plan_that_was_stored_before_the_arm_backed_off_the_cups_is_read_as_it_was_meant():
    plan = make_ballbar_plan()
    document = to_document(plan)
    del document["placements"][0]["away"]

    assert from_document(BallbarPlan, document) == plan
    assert plan.placements[0].away is None


def test_an_enum_is_its_word():
    @dataclass(frozen=True)
    class Standing:
        state: SessionState

    assert to_document(Standing(SessionState.PAUSED)) == {"state": "paused"}


@pytest.mark.parametrize("value", [object(), {1, 2}])
def test_what_json_cannot_say_is_refused(value):
    with pytest.raises(TypeError, match="no JSON form"):
        to_document(value)
