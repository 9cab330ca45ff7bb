"""What counts of a ballbar session: nothing superseded, nothing skipped, nothing confused."""

from tests.helpers.ballbar.sessions import LEGS, make_ballbar_plan, measured, moved, skipped
from truepose.domain.ballbar import PreCalibration
from truepose.domain.cell import BallbarKit
from truepose.domain.ledger import EntryKind, LedgerEntry
from truepose.sessions.ballbar.valid_readings import counting

PLAN, KIT = make_ballbar_plan(), BallbarKit()
START = LedgerEntry("tool/initialise", EntryKind.CONTROL, 1.0, "Ada", "t1", "k", "running: started")


def of_pose(config, length_mm=300.0, again=""):
    group = f"placement-1/pose-{config}{again}"
    return [
        moved(f"{group}/move", (0.2 * config,) * 6),
        measured(f"{group}/initialise", 300.0),
        *(measured(f"{group}/leg-{base}-{tool}", length_mm) for base, tool in LEGS),
    ]


def counted(*entries):
    return counting(PLAN, KIT, (START, *entries))


def test_legs_count_with_where_the_arm_stood():
    legs = counted(*of_pose(1)).legs

    assert [kept.leg for kept in legs] == list(LEGS)
    assert {kept.arrival.commanded_rad for kept in legs} == {(0.2,) * 6}
    assert {(kept.placement, kept.config, kept.stop) for kept in legs} == {(1, 1, 1)}


def test_what_was_reopened_counts_no_more_and_what_was_read_again_does():
    leg = "placement-1/pose-1/leg-1-2"
    reopened = LedgerEntry(leg, EntryKind.REOPENED, 90.0, "Ada", "t1", "k2")

    without = counted(*of_pose(1), reopened)
    again = counted(*of_pose(1), reopened, measured(leg, 301.0))

    assert (1, 2) not in [kept.leg for kept in without.legs]
    assert [kept.length.length_mm for kept in again.legs if kept.leg == (1, 2)] == [301.0]


def test_of_a_skipped_pose_the_legs_that_were_read_count_and_the_reason_is_told():
    found = counted(*of_pose(1)[:4], skipped("placement-1/pose-1/leg-2-2", "out of range"))

    assert [kept.leg for kept in found.legs] == [(1, 1), (1, 2)]
    assert found.skipped == ("Skipped: placement-1/pose-1, out of range.",)


def test_sides_and_setups_count_as_they_were_taken():
    found = counted(
        measured("tool/side-1-2", 150.2),
        moved("placement-1/cup-2/move", (0.2,) * 6),
        LedgerEntry("placement-1/cup-2/clamp", EntryKind.CONFIRMED, 60.0, "Ada", "t1"),
        measured("placement-1/side-2-3", 300.2),
    )

    assert [(side.placement, side.points, side.length.length_mm) for side in found.sides] == [
        (0, (1, 2), 150.2),
        (1, (2, 3), 300.2),
    ]
    assert [(kept.placement, kept.base_point) for kept in found.setups] == [(1, 2)]


def test_a_cup_that_was_not_clamped_is_no_setup():
    assert counted(moved("placement-1/cup-2/move", (0.2,) * 6)).setups == ()


def test_a_pose_whose_legs_were_exchanged_counts_only_as_measured_again():
    found = PreCalibration(PLAN.placements[0].poses, (), 0.01, 2, exchanged=(1,))
    computed = LedgerEntry("placement-1/precalibrate-1", EntryKind.COMPUTED, 95.0, precalibration=found)

    confused = counted(*of_pose(1), *of_pose(2), computed)
    again = counted(*of_pose(1), *of_pose(2), computed, *of_pose(1, 300.5, "/again"))

    assert {kept.config for kept in confused.legs} == {2}
    assert confused.exchanged == (1,)
    assert {(kept.config, kept.attempt, kept.stop) for kept in again.legs} == {(2, 1, 2), (1, 2, 3)}


def test_every_further_attempt_has_a_number_that_no_pose_has():
    found = PreCalibration(PLAN.placements[0].poses, (), 0.01, 2, exchanged=(1, 2))
    computed = LedgerEntry("placement-1/precalibrate-1", EntryKind.COMPUTED, 95.0, precalibration=found)
    again = (*of_pose(1, 300.5, "/again"), *of_pose(2, 300.5, "/again"))

    legs = counted(*of_pose(1), *of_pose(2), computed, *again).legs

    assert {(kept.config, kept.attempt) for kept in legs} == {(1, 2), (2, 2)}
    assert {kept.stop for kept in legs} == {3, 4}


def test_the_arm_stands_where_it_moved_last():
    found = counted(*of_pose(1), moved("placement-1/pose-2/move", (0.4,) * 6))

    assert (found.standing.placement, found.standing.joints_rad) == (1, (0.4,) * 6)
    assert counted().standing is None
