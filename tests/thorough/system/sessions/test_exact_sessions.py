"""How exact tracker sessions are: on other controllers, and where the tracker is said to stand."""

import numpy as np
import pytest

from tests.system.session_bench import bench
from tests.system.sessions.test_session_on_simulated_cell import SCENARIO, run, true_errors
from truepose.domain.session import SessionState
from truepose.planning.tracker.plans import plan_calibration, plan_validation

pytestmark = pytest.mark.usefixtures("forked_processes")


async def whole_session(scenario, n, n_candidates):
    """Run a session that skips nothing; return its errors, the robot's identity and its motion guard."""
    async with bench(scenario, seed=11) as opened:
        ended = await run(opened, plan_calibration(opened.space, n, seed=1, n_candidates=n_candidates))

        errors = await true_errors(opened)
        identity, guard = await opened.robot.identify(), opened.robot.motion_guard
    assert ended is SessionState.FINISHED
    assert opened.journal.skipped == []
    return errors, identity, guard


async def test_a_session_on_a_fanuc_that_counts_joint_3_from_the_horizontal_is_as_exact():
    errors, identity, guard = await whole_session("lrmate-fanuc", 12, 200)

    assert (identity.manufacturer, identity.model) == ("FANUC", "LR Mate 200iC")
    assert guard.stops_unheard_s == 1.0
    # as on the IRB 120; of 15 x 3 values a third more or less than their standard deviation is chance
    assert np.sqrt(np.mean(errors**2)) == pytest.approx(0.016, rel=0.35)


async def test_a_session_on_a_ur10_is_as_exact_as_the_arm_repeats():
    errors, identity, _ = await whole_session("ur10-clean", 6, 120)

    assert (identity.manufacturer, identity.model) == ("Universal Robots", "UR10")
    # tracker and registration 0.016 mm as above, robot 0.033: 0.037; of 9 x 3 values 40 % may be chance
    assert np.sqrt(np.mean(errors**2)) == pytest.approx(0.037, rel=0.4)


async def test_the_registration_agrees_with_the_true_frame_within_its_stated_covariance():
    squares = []
    for seed in (21, 22, 23):
        async with bench(SCENARIO, seed=seed) as opened:
            await run(opened, plan_validation(opened.space, 1, seed=1))
            frame = (await opened.ask(op="plant"))["tracker_frame"]
        registration = opened.journal.registrations[0]
        rotation = np.array(frame["rotation"])
        turn = registration.rotation @ rotation.T - np.eye(3)
        small = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]) / 2
        shift = registration.translation_mm - registration.rotation @ rotation.T @ frame["translation_mm"]
        motion = np.concatenate([shift, small])
        squares.append(float(motion @ np.linalg.solve(registration.covariance, motion)))

    # chi-squared with 18 degrees of freedom: 4.9 to 42 holds 99.8 % of all cases
    assert 4.9 < sum(squares) < 42.0
