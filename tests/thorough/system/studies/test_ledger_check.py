"""The check of a ledger after a kill finds what it is there to find."""

import pytest

from tests.studies.interruptions.ledger_check import faults
from truepose.demo.simulated_operator import Acknowledgement, OwnLedger

MOVE = "placement-1/pose-1/move"
LEG = "placement-1/pose-1/leg-1-1"


def entry(number, kind, step_id=LEG, key=None, text=""):
    return {"number": number, "kind": kind, "step_id": step_id, "key": key, "text": text}


RESTART = entry(2, "control", "", text="awaiting_confirmation: The service was started anew.")


def knows(*acts):
    return OwnLedger([Acknowledgement(key, LEG, "store", number, "stored") for key, number in acts])


SOUND = [
    entry(1, "control", "", "k1"),
    entry(2, "confirmed", MOVE, "k2"),
    entry(3, "moved", MOVE),
    entry(4, "measured", LEG, "k3"),
]


def test_a_sound_ledger_has_no_faults():
    assert not faults(knows(("k1", 1), ("k3", 4)), SOUND[:3], SOUND)


def test_what_was_acknowledged_and_is_gone_is_lost():
    found = faults(knows(("k3", 4)), [], SOUND[:3])

    assert len(found.lost) == 1


def test_a_number_that_was_given_to_another_act_is_a_loss():
    found = faults(knows(("k9", 4)), [], SOUND)

    assert len(found.lost) == 1


def test_what_was_read_before_must_be_there_as_it_was():
    found = faults(knows(), SOUND, [*SOUND[:3], entry(4, "measured", LEG, "other")])

    assert len(found.lost) == 1


@pytest.mark.parametrize(
    "more",
    [entry(5, "measured", LEG, "k4"), entry(5, "skipped", "tool/side-1-2", "k3")],
    ids=["a length", "a key"],
)
def test_what_is_kept_twice_is_doubled(more):
    assert len(faults(knows(), [], [*SOUND, more]).doubled) == 1


def test_a_length_that_was_reopened_may_be_kept_again():
    again = [entry(5, "reopened", LEG, "k4"), entry(6, "measured", LEG, "k5")]

    assert not faults(knows(), [], [*SOUND, *again])


@pytest.mark.parametrize(
    "ledger",
    [
        [entry(1, "moved", MOVE)],
        [entry(1, "confirmed", "placement-1/pose-2/move"), entry(2, "moved", MOVE)],
        # confirmed before the restart: that says nothing of the cell now
        [entry(1, "confirmed", MOVE), RESTART, entry(3, "moved", MOVE)],
    ],
    ids=["never confirmed", "another motion confirmed", "confirmed before the restart"],
)
def test_a_motion_that_nobody_confirmed_is_named(ledger):
    assert len(faults(knows(), [], ledger).moved) == 1


def test_a_pause_that_was_asked_for_during_a_confirmed_motion_is_no_fault():
    pausing = entry(2, "control", "", text="pausing: A pause was asked for.")

    assert not faults(knows(), [], [entry(1, "confirmed", MOVE), pausing, entry(3, "moved", MOVE)])
