"""Wrong connections at drawn stops: named, and no needless question where they are right."""

import numpy as np

from tests.helpers.ballbar.coded_stops import BALLBAR, READINGS, coded_stop
from truepose.validation.connection_check import judge_leg, judge_pose


def test_of_many_coded_stops_wrong_connections_are_named_and_right_ones_left_alone():
    # 0.2 % of needless questions and 97 % named are expected; the limits leave three standard errors
    rng = np.random.default_rng(4)
    stops = [coded_stop(rng) for _ in range(40)]
    questions = singles = 0
    for stop in stops:
        taken = {}
        for leg in stop.legs:
            length = stop.read(leg)
            questions += judge_leg(leg, length, taken, stop.forecast, **BALLBAR) is not None
            taken[leg] = length
        assert judge_pose(taken, stop.forecast, **READINGS) == ()
        asked, connected = (stop.legs[k] for k in rng.choice(6, 2, replace=False))
        one = judge_leg(asked, stop.read(connected), {}, stop.forecast, **BALLBAR)
        singles += one is not None and one.suspected == connected
        last = judge_leg(stop.legs[5], stop.read(stop.legs[2]), _first(taken, 5), stop.forecast, **BALLBAR)
        assert (last.kind, last.suspected) == ("same_pair", stop.legs[2])

    assert questions <= 4  # of 240
    assert singles >= 35


def _first(taken, count):
    return dict(list(taken.items())[:count])
