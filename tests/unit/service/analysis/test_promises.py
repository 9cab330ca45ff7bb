"""What a session under way promises: the curve goes on from its readings."""

import numpy as np
import pytest

from tests.helpers.ballbar.cells import IRB_120, domain_cell
from truepose.analysis.campaigns.tracker import MeasuredSession
from truepose.analysis.predicted_accuracy import promise_of_cell, promise_of_session
from truepose.domain.session import PointTaken
from truepose.kinematics.chain import nominal_chain
from truepose.storage.records import SessionSetup

CELL = domain_cell(IRB_120, tracker_position_mm=(2600.0, -700.0, 500.0))
NOISE_MM = 0.02


def session_after(plan):
    """Return a session in which an arm without errors was read at the configurations of a plan."""
    rng = np.random.default_rng(5)
    chain = nominal_chain(CELL.robot, plan.joints_rad)
    places = np.stack([chain.points(np.array(nest.centre_mm)) for nest in CELL.nests])
    read = places[plan.nest - 1, np.arange(len(plan.nest))] + NOISE_MM * rng.standard_normal((
        len(plan.nest),
        3,
    ))
    rows = enumerate(zip(plan.joints_rad.tolist(), plan.nest.tolist(), read.tolist(), strict=True), start=1)
    points = tuple(
        PointTaken(
            config=config,
            nest=nest,
            commanded_rad=tuple(joints),
            reported_rad=tuple(joints),
            direction=(1,) * 6,
            time_s=30.0 * config,
            temperature_c=22.0,
            attachment=1,
            position_tracker_mm=tuple(place),
            position_world_mm=tuple(place),
            standard_uncertainty_mm=NOISE_MM,
            rms_mm=0.01,
            samples=50,
        )
        for config, (joints, nest, place) in rows
    )
    return MeasuredSession(1, SessionSetup(CELL, 1), points)


@pytest.fixture(scope="module")
def before():
    return promise_of_cell(CELL, 30).plan


def test_the_curve_goes_on_from_what_was_measured(before):
    promised = promise_of_session(session_after(before), 10).plan

    assert promised.measured == promised.curve[0].n == 30
    assert promised.total == 40
    assert promised.assumptions.reading_mm == pytest.approx(NOISE_MM)
    assert promised.promised.mean_mm < promised.curve[0].mean_mm


def test_too_few_readings_for_a_model_count_all_the_same(before):
    whole = session_after(before)
    few = MeasuredSession(1, whole.setup, whole.points[:2])

    promised = promise_of_session(few, 20).plan

    assert promised.measured == 2
    assert promised.assumptions.reading_mm != pytest.approx(NOISE_MM)  # nobody has judged them yet


def test_a_session_without_readings_promises_what_its_cell_does(before):
    nothing = MeasuredSession(1, SessionSetup(CELL, 1), ())

    assert promise_of_session(nothing, 30).plan.promised == before.promised
