"""The study of promises, on few cells: what a plan says is what the simulated cell attains."""

from tests.studies.promise.ballbar import ballbar_promises
from tests.studies.promise.kept import tally
from tests.studies.promise.tracker import tracker_promise

SCENARIO = "irb120-tilted"


def test_tracker_plans_keep_their_promise_on_four_cells():
    found = tally("tracker", [tracker_promise(SCENARIO, seed, 40) for seed in range(2, 6)])

    # One calibration scatters by 15 % about the promise, four by half of that.
    assert abs(found.off_percent) < 20.0
    assert found.inside >= 2


def test_ballbar_plans_keep_their_promise_on_six_cells():
    found = tally("ballbar", ballbar_promises(SCENARIO, range(1, 7), 40))

    # One calibration scatters by 30 % about the promise, six by 12 %.
    assert abs(found.off_percent) < 30.0
    assert found.inside >= 3
