"""The present situation is what the ledger says, and nothing else."""

import pytest

from tests.unit.service.sessions.ballbar.sessions import (
    Story,
    found,
    joints,
    make_plan,
    make_pose,
    make_sphere_plan,
    without_away,
)
from truepose.domain.ballbar import Suspicion
from truepose.domain.ledger import Control, EntryKind
from truepose.domain.session import SessionState
from truepose.sessions.ballbar import step_ids
from truepose.sessions.ballbar.state import READINGS
from truepose.sessions.engine.commands import CommandName
from truepose.sessions.engine.prompts import CELL_CLEAR

PLAN = make_plan((1, 2, 3), precalibrate_after=2)
DOUBT = Suspicion("same_pair", (1, 2), (1, 1), 300.1, 300.0)


def test_a_session_done_as_asked_ends_with_every_step_done():
    story = Story(PLAN)

    done = []
    while story.now.step is not None:
        done.append(story.do())

    assert done == [step.id for step in story.now.steps]
    assert "open" not in {outcome.kind for outcome in story.now.outcomes.values()}


def test_the_ballbar_counts_as_attached_from_the_prompt_until_it_is_confirmed_off():
    story = Story(PLAN)
    assert not story.now.attached

    story.show()

    assert story.now.attached
    story.until("tool/detach")
    assert story.now.attached
    story.do()
    assert not story.now.attached


def test_no_motion_is_ever_the_present_step_while_the_ballbar_may_be_attached():
    story = Story(PLAN)
    while (step := story.now.step) is not None:
        assert not (story.now.attached and step_ids.kind_of(step.id) not in READINGS and step.target_rad)
        story.do()


def test_a_motion_is_confirmed_until_its_prompt_is_shown_anew():
    story = Story(PLAN).until("placement-1/cup-1/move")
    story.add(story.show(), EntryKind.CONFIRMED)
    assert story.now.confirmed
    assert story.now.busy

    story.show()

    assert not story.now.confirmed
    assert not story.now.busy


@pytest.mark.parametrize("state", [SessionState.PAUSED, SessionState.AWAITING_CONFIRMATION])
def test_a_motion_is_confirmed_no_more_once_the_session_was_held(state):
    story = Story(PLAN).until("placement-1/cup-1/move")
    story.add(story.show(), EntryKind.CONFIRMED)

    story.control(state)
    story.control(SessionState.RUNNING)

    assert not story.now.confirmed


def test_skipping_a_leg_skips_the_rest_of_its_pose_but_not_taking_the_ballbar_off():
    story = Story(PLAN).until("placement-1/pose-1/leg-2-1")

    story.skip()

    assert story.present == "placement-1/pose-1/detach"
    kinds = {name: outcome.kind for name, outcome in story.now.outcomes.items() if "pose-1/" in name}
    assert kinds["placement-1/pose-1/leg-1-2"] == "measured"  # what is read stays
    assert kinds["placement-1/pose-1/leg-3-1"] == "skipped"
    assert story.now.outcomes["placement-1/pose-1/leg-3-1"].text == "out of range"
    assert CommandName.SKIP not in story.now.acts


def test_a_pose_skipped_before_the_arm_moves_is_skipped_whole():
    story = Story(PLAN).until("placement-1/pose-1/move")

    story.skip()

    assert story.present == "placement-1/pose-2/move"
    assert story.now.progress.skipped_poses == 1


def test_back_reopens_the_step_before():
    story = Story(PLAN).until("placement-1/pose-1/leg-2-1")

    reopened = story.back()

    assert reopened == "placement-1/pose-1/leg-1-2"
    assert story.present == reopened
    assert "placement-1/pose-1/leg-1-1" not in story.now.earlier_legs()
    assert (1, 1) in story.now.earlier_legs()


def test_reopening_the_calibrator_reopens_the_readings_that_count_from_it():
    story = Story(PLAN).until("placement-1/pose-1/leg-1-2")

    story.add("placement-1/pose-1/initialise", EntryKind.REOPENED)

    assert story.now.outcomes["placement-1/pose-1/leg-1-1"].kind == "open"
    assert story.present == "placement-1/pose-1/initialise"


def test_back_across_a_motion_asks_for_the_ballbar_to_be_off_and_for_the_motion_again():
    story = Story(PLAN).until("placement-1/pose-1/initialise")
    story.show()

    assert story.back() == "placement-1/pose-1/move"

    assert story.present == "placement-1/pose-1/move/detach"
    story.do()
    assert story.present == "placement-1/pose-1/move"
    assert not story.now.confirmed


def test_back_to_a_pose_that_the_arm_has_left_begins_that_pose_anew():
    story = Story(PLAN).until("placement-1/pose-2/initialise")
    assert story.back() == "placement-1/pose-2/move"

    reopened = story.back()

    assert reopened == "placement-1/pose-1/move"
    assert {o.kind for name, o in story.now.outcomes.items() if "/pose-1/" in name} == {"open"}


def test_back_to_a_pose_where_the_arm_still_stands_keeps_its_readings():
    story = Story(PLAN).until("placement-1/pose-2/move")

    assert story.back() == "placement-1/pose-1/detach"
    assert story.now.attached  # as far as anyone knows
    assert story.back() == "placement-1/pose-1/leg-3-1"

    assert story.now.outcomes["placement-1/pose-1/leg-2-3"].kind == "measured"


def test_back_undoes_a_skip():
    story = Story(PLAN).until("placement-1/pose-1/move")
    story.skip()

    story.back()

    assert story.present == "placement-1/pose-1/move"
    assert story.now.progress.skipped_poses == 0


def test_back_to_a_cup_has_the_ball_fitted_again_and_the_triangle_measured_again():
    story = Story(PLAN).until("placement-1/initialise")

    assert story.back() == "placement-1/ball-out"
    assert story.back() == "placement-1/away/move"
    assert story.back() == "placement-1/cup-3/move"  # the arm is not over the cup any more

    assert story.present == "placement-1/cup-3/move/ball"
    story.do()
    assert story.now.step.via_rad == (joints(-14.5),)  # the way off the cup, back
    assert [story.do() for _ in range(4)] == [
        "placement-1/cup-3/move",
        "placement-1/cup-3/clamp",
        "placement-1/away/move",
        "placement-1/ball-out",
    ]


def test_in_a_plan_without_a_motion_off_the_cups_the_ball_is_fitted_again_over_the_last_cup():
    story = Story(without_away(PLAN)).until("placement-1/initialise")

    assert story.back() == "placement-1/ball-out"
    assert story.back() == "placement-1/cup-3/clamp"

    assert story.present == "placement-1/cup-3/clamp/ball"
    story.do()
    assert story.present == "placement-1/cup-3/clamp"


def test_the_arm_backs_off_the_cups_only_after_a_person_has_said_that_the_cell_is_clear():
    story = Story(PLAN).until("placement-1/away/move")

    assert story.now.question == CELL_CLEAR
    assert not story.now.confirmed
    story.do()
    assert story.present == "placement-1/ball-out"


def test_there_is_no_way_back_behind_a_pre_calibration():
    story = Story(PLAN).until("placement-1/pose-3/move")

    assert story.now.back_to is None
    assert CommandName.BACK not in story.now.acts


def test_there_is_no_way_back_to_a_fixture_that_was_taken_up():
    story = Story(make_plan((1,), (2,))).until("placement-1/precalibrate-1")
    story.do(found(exchanged=()))

    assert story.present == "placement-2/place"
    assert story.now.back_to is None


def test_a_suspicion_holds_the_session_at_its_step_until_it_is_answered():
    story = Story(PLAN).until("placement-1/pose-1/leg-1-2")
    story.suspect(DOUBT)

    assert story.present == "placement-1/pose-1/leg-1-2"
    assert story.now.acts >= {CommandName.ANSWER, CommandName.RETRY, CommandName.SKIP, CommandName.STOP}
    assert not story.now.acts & {CommandName.STORE, CommandName.BACK, CommandName.CONFIRM}
    story.add("placement-1/pose-1/leg-1-2", EntryKind.ANSWERED, text="reconnected")
    assert story.now.suspicion is None
    assert CommandName.STORE in story.now.acts


def test_a_reading_counts_from_the_calibrator_of_its_own_group():
    story = Story(PLAN).until("placement-1/pose-2/leg-1-1")

    zero = story.now.zero

    assert zero is not None
    assert zero.initialisation == 4  # tool, base, pose 1, pose 2


def test_the_first_tablet_acts_until_another_takes_over():
    story = Story(PLAN)
    story.add("", EntryKind.CONTROL, person="Ada", tablet="two", entered=SessionState.PAUSED, text="Lunch.")
    assert story.now.acting.tablet == "one"

    story.add("", EntryKind.CONTROL, person="Ada", tablet="two", control=Control.HAND_OVER)

    assert (story.now.acting.tablet, story.now.acting.person) == ("two", "Ada")
    assert story.now.state is SessionState.PAUSED


def test_the_way_to_a_stop_leads_through_the_stops_that_were_left_out():
    story = Story(PLAN).until("placement-1/pose-1/move")
    story.skip()

    step = story.now.step

    assert step.id == "placement-1/pose-2/move"
    assert step.via_rad == (joints(1.5), joints(1), joints(2.5))


def test_the_way_back_is_the_way_forth_reversed():
    story = Story(PLAN).until("placement-1/pose-2/initialise")
    story.back()
    story.back()

    step = story.now.step

    assert step.id == "placement-1/pose-1/move"
    assert step.via_rad == (joints(2.5),)


def test_minutes_left_follow_the_operators_own_pace():
    story = Story(PLAN).until("placement-1/pose-1/leg-1-1")
    by_the_thesis_s = story.now.progress.remaining_s
    assert by_the_thesis_s > 0

    story.until("placement-1/pose-2/move")

    left = sum(outcome.kind == "open" for name, outcome in story.now.outcomes.items() if "leg" in name)
    legs_s = story.now.progress.pace_s_per_reading
    assert legs_s == pytest.approx(20.0)  # two lines of ten seconds each in these ledgers
    assert story.now.progress.remaining_s > left * legs_s


def test_a_pose_measured_again_has_steps_of_its_own():
    story = Story(PLAN).until("placement-1/precalibrate-1")
    story.do(found(make_pose(3), make_pose(1), exchanged=(1,)))

    story.until("placement-1/pose-1/again/leg-1-1")

    assert story.now.step.attempt == 2
    assert story.now.outcomes["placement-1/pose-1/leg-1-1"].kind == "measured"


def test_every_prefix_of_a_ledger_has_a_situation_that_the_rest_continues():
    story = Story(PLAN)
    while story.now.step is not None:
        story.do()
    whole = list(story.entries)

    for cut in range(1, len(whole)):
        story.entries = whole[:cut]
        step = story.now.step
        assert step is not None
        assert whole[cut].step_id in {step.id, ""}


def test_a_ballbar_that_was_without_supply_is_put_on_its_calibrator_and_keeps_what_was_read():
    story = Story(PLAN).until("placement-1/pose-1/leg-1-2")
    story.add("", EntryKind.CONTROL, control=Control.ZERO_LOST)

    assert story.present == "placement-1/pose-1/leg-1-2/initialise"
    story.do()

    assert story.present == "placement-1/pose-1/leg-1-2"
    assert story.now.zero.initialisation == 4  # tool, base, pose 1, and this one
    assert (1, 1) in story.now.earlier_legs()
    story.until("placement-1/pose-1/detach")
    assert story.now.outcomes["placement-1/pose-1/leg-3-1"].kind == "measured"


def test_a_doubt_ends_with_the_stop_that_its_reading_was_of():
    story = Story(PLAN).until("placement-1/pose-1/leg-1-2")
    story.suspect(DOUBT)

    story.add("placement-1/pose-1/move", EntryKind.REOPENED)

    assert story.now.suspicion is None
    assert story.present == "placement-1/pose-1/move/detach"


def test_the_time_in_which_the_service_was_off_is_nobodys_pace():
    story = Story(PLAN).until("placement-1/place")
    before = story.now.progress
    awaits = SessionState.AWAITING_CONFIRMATION
    story.add("", EntryKind.CONTROL, entered=awaits, control=Control.RESTARTED, time_s=1e6)

    assert story.now.progress.elapsed_s == before.elapsed_s
    assert story.now.progress.remaining_s == before.remaining_s


def test_a_skipped_side_is_left_out_and_the_session_goes_on():
    story = Story(PLAN).until("placement-1/side-2-3")

    story.skip()

    assert story.present == "placement-1/side-1-3"
    story.until("placement-1/pose-1/move")
    assert story.now.progress.skipped_poses == 0


def test_a_pose_that_is_tried_again_counts_as_skipped_no_more_and_never_twice():
    story = Story(PLAN).until("placement-1/pose-1/leg-2-1")
    story.skip()
    assert story.now.progress.skipped_poses == 1

    story.until("placement-1/precalibrate-1")
    story.do(found(make_pose(1)))
    assert story.now.progress.skipped_poses == 0  # another attempt is open
    story.until("placement-1/pose-1/again/leg-2-1")
    story.skip()

    assert story.now.progress.skipped_poses == 1


def test_stops_of_a_sphere_test_count_from_the_last_calibrator():
    story = Story(make_sphere_plan(11)).until("placement-1/pose-3/leg-1-2")

    assert story.now.zero.initialisation == 1
    assert story.until("placement-1/pose-11/leg-1-2").now.zero.initialisation == 2


def test_a_sphere_test_is_done_without_a_motion_with_the_ballbar_on():
    story = Story(make_sphere_plan(11))

    while story.now.step is not None:
        assert not (story.now.attached and story.now.step.id.endswith("/move"))
        story.do()

    assert "open" not in {outcome.kind for outcome in story.now.outcomes.values()}


def test_a_stop_that_was_skipped_at_the_calibrator_leaves_it_to_the_next():
    story = Story(make_sphere_plan(2)).until("placement-1/pose-1/initialise")
    story.skip()

    story.until("placement-1/pose-2/leg-1-2/initialise").do()

    assert story.now.step.id == "placement-1/pose-2/leg-1-2"
    assert story.now.zero.initialisation == 1


def test_a_ballbar_without_supply_is_put_on_its_calibrator_in_a_sphere_test_too():
    story = Story(make_sphere_plan(3)).until("placement-1/pose-2/leg-1-2")
    story.add("", EntryKind.CONTROL, control=Control.ZERO_LOST)

    assert story.now.step.id == "placement-1/pose-2/leg-1-2/initialise"
    story.do()
    assert story.now.zero.initialisation == 2
