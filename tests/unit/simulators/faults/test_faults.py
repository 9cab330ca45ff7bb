import pytest

from truepose_simulators.errors import ScenarioError
from truepose_simulators.faults.kinds import (
    BeamBroken,
    FixedNestMoved,
    IdentityChanged,
    RobotRefuses,
    SmrMissing,
    TrackerBlinded,
    TrackerSilent,
)
from truepose_simulators.faults.scripted import Faults


def test_a_beam_is_broken_for_as_many_readings_as_stated():
    faults = Faults()
    faults.add(BeamBroken(reading=2, count=2))

    hits = [isinstance(faults.next_reading(), BeamBroken) for _ in range(5)]

    assert hits == [False, True, True, False, False]


def test_counts_begin_when_the_fault_is_given():
    faults = Faults()
    for _ in range(10):
        faults.next_reading()
        faults.next_move()
    faults.add(TrackerSilent(reading=1))
    faults.add(RobotRefuses(move=2))

    readings = [faults.next_reading() for _ in range(2)]
    moves = [faults.next_move() for _ in range(2)]

    assert [type(item) for item in readings] == [TrackerSilent, type(None)]
    assert [type(item) for item in moves] == [type(None), RobotRefuses]


def test_states_hold_between_their_times():
    faults = Faults()
    faults.add(TrackerBlinded(from_s=10.0, until_s=20.0))
    faults.add(SmrMissing(nest=2, from_s=5.0))

    assert [faults.holds(TrackerBlinded, time) for time in (9.9, 10.0, 20.0)] == [False, True, False]
    assert [faults.smr_missing(2, time) for time in (4.9, 5.0, 1e9)] == [False, True, True]
    assert not faults.smr_missing(1, 6.0)


def test_knocks_of_a_fixed_nest_add_up():
    faults = Faults()
    faults.add(FixedNestMoved(1, (0.1, 0.0, 0.0), from_s=10.0))
    faults.add(FixedNestMoved(1, (0.0, 0.2, 0.0), from_s=20.0))

    assert faults.fixed_nest_shift_mm(1, 15.0) == (0.1, 0.0, 0.0)
    assert faults.fixed_nest_shift_mm(1, 25.0) == (0.1, 0.2, 0.0)
    assert faults.fixed_nest_shift_mm(2, 25.0) == (0.0, 0.0, 0.0)


def test_another_device_answers_from_its_moment_on_and_the_last_one_counts():
    faults = Faults()
    faults.add(IdentityChanged("ballbar", "B-9", from_s=10.0))
    faults.add(IdentityChanged("ballbar", "B-7", from_s=20.0))

    assert [faults.serial("ballbar", "B-1", time_s) for time_s in (0.0, 10.0, 25.0)] == ["B-1", "B-9", "B-7"]
    assert faults.serial("tracker", "390001", 25.0) == "390001"


@pytest.mark.parametrize(
    ("device", "serial"), [("lamp", "1"), ("tracker", "A-1"), ("robot", "é"), ("robot", "x" * 13)]
)
def test_an_identity_that_no_protocol_could_tell_is_refused(device, serial):
    with pytest.raises(ScenarioError, match="must be"):
        IdentityChanged(device, serial)
