"""When a scripted fault strikes, and what it is said to have done."""

import pytest

from truepose_simulators.errors import ScenarioError
from truepose_simulators.faults.kinds import (
    BallbarZeroJumps,
    BeamBroken,
    EmergencyStop,
    LinkCut,
    RobotHangs,
    TrackerBlinded,
    TrackerDrifts,
    TripodKicked,
    WrongCup,
)
from truepose_simulators.faults.scripted import Faults


class Time:
    now_s = 0.0


@pytest.fixture
def time():
    return Time()


@pytest.fixture
def faults(time):
    return Faults(lambda: time.now_s)


def measure(faults, *stops):
    """Move to stops and read something on the tool there; returns what befell each reading."""
    hits = []
    for stop in stops:
        faults.next_move()
        faults.measured_at(stop)
        hits.append(faults.next_reading() is not None)
    return hits


def test_a_fault_of_a_configuration_befalls_its_reading(faults):
    faults.add(BeamBroken(configuration=3))

    assert measure(faults, "a", "b", "c", "d") == [False, False, True, False]


def test_the_same_stop_measured_again_is_the_same_configuration(faults):
    faults.add(BeamBroken(configuration=3))

    assert measure(faults, "a", "b", "b", "b", "c") == [False] * 4 + [True]


def test_a_configuration_begins_with_the_motion_to_it(faults, time):
    faults.add(TrackerBlinded(configuration=2, for_s=5.0))
    measure(faults, "a")
    assert not faults.holds(TrackerBlinded, time.now_s)

    time.now_s = 30.0
    faults.next_move()

    assert [faults.holds(TrackerBlinded, at_s) for at_s in (29.9, 30.0, 34.9, 35.0)] == [
        False,
        True,
        True,
        False,
    ]


def test_a_motion_is_stopped_some_time_after_it_began(faults, time):
    faults.add(EmergencyStop(move=2, after_s=0.4, for_s=60.0))
    faults.next_move()
    time.now_s = 10.0

    faults.next_move()

    assert faults.begins_s(EmergencyStop, until_s=12.0) == pytest.approx(10.4)
    assert faults.begins_s(EmergencyStop, until_s=10.1) == 10.1
    assert not faults.holds(EmergencyStop, 10.3)
    assert faults.holds(EmergencyStop, 10.5)


def test_what_strikes_at_a_time_strikes_the_next_one_after_it(faults, time):
    faults.add(RobotHangs(from_s=100.0))

    before = faults.next_move()
    time.now_s = 100.0
    after = [faults.next_move(), faults.next_move()]

    assert before is None
    assert [hit is not None for hit in after] == [True, False]


def test_a_person_errs_at_as_many_connections_as_stated(faults):
    faults.add(WrongCup(cup=2, count=2))

    assert [slip.cup if slip else None for slip in (faults.next_connection() for _ in range(3))] == [
        2,
        2,
        None,
    ]


def test_a_fault_that_is_ended_by_hand_holds_no_more(faults, time):
    number = faults.add(TrackerBlinded())
    time.now_s = 7.0

    faults.end(number)

    assert not faults.holds(TrackerBlinded, 7.0)
    assert faults.given[0].document(8.0)["state"] == "over"
    with pytest.raises(ScenarioError, match="no fault 2: 1 were given"):
        faults.end(2)


def test_what_became_of_a_fault_is_told(faults, time):
    faults.add(LinkCut(device="tracker", from_s=50.0, for_s=8.0))

    documents = [faults.given[0].document(at_s) for at_s in (10.0, 52.0, 60.0)]

    assert [document["state"] for document in documents] == ["waiting", "active", "over"]
    assert documents[2] == {
        "number": 1,
        "kind": "link_cut",
        "keys": {"device": "tracker", "from_s": 50.0, "for_s": 8.0},
        "state": "over",
        "begun_s": 50.0,
        "over_s": 58.0,
        "struck": 0,
    }


def test_a_tripod_that_is_kicked_stands_elsewhere_and_one_that_drifts_stays_where_it_ended(faults):
    faults.add(TripodKicked(by_mm=(0.3, 0.0, 0.0), from_s=10.0))
    faults.add(TrackerDrifts(mm_per_h=(0.0, 3.6, 0.0), from_s=100.0, for_s=50.0))

    motions = [faults.tracker_motion(at_s) for at_s in (0.0, 10.0, 120.0, 1000.0)]

    assert [motion[:3] for motion in motions] == [
        pytest.approx(place)
        for place in ((0.0, 0.0, 0.0), (0.3, 0.0, 0.0), (0.3, 0.02, 0.0), (0.3, 0.05, 0.0))
    ]


@pytest.mark.parametrize(
    ("keys", "sentence"),
    [
        ({"from_s": 3.0, "move": 2}, "a fault takes only one trigger"),
        ({"configuration": 3, "reading": 2}, "a fault takes only one trigger"),
        ({"configuration": 0}, '"configuration" must be 1 or more'),
        ({"for_s": -1.0}, '"for_s" must be 0 or more'),
    ],
)
def test_what_can_never_strike_is_refused(keys, sentence):
    with pytest.raises(ScenarioError, match=sentence):
        BallbarZeroJumps(by_mm=0.1, **keys)
