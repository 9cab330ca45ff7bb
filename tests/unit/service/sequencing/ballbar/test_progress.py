"""How far a session is: what will be tried again is planned, what was left out for good is not."""

from service.sequencing.ballbar.record import READINGS
from tests.unit.service.sequencing.ballbar.sessions import Story, make_plan

PLAN = make_plan((1, 2, 3), precalibrate_after=2)
PER_POSE = 7  # the calibrator and six legs


def readings_listed(story):
    return sum(step.kind in READINGS for step in story.now.steps)


def test_everything_listed_is_planned_before_the_first_step():
    story = Story(PLAN)

    assert story.now.progress.planned == readings_listed(story)


def test_a_skipped_pose_stays_planned_while_it_will_be_tried_again():
    story = Story(PLAN).until("placement-1/pose-1/leg-2-1")
    before = story.now.progress

    story.skip()

    # four of its legs were open and come again, with the calibrator and the two legs read before
    assert story.now.progress.planned == before.planned + PER_POSE - 4
    assert story.now.progress.remaining_s > before.remaining_s - 60.0


def test_a_session_that_ended_has_read_all_that_was_planned_in_the_end():
    story = Story(PLAN).until("placement-1/pose-1/leg-2-1")
    story.skip()

    while story.now.step is not None:
        story.do()

    progress = story.now.progress
    assert progress.readings == progress.planned
    assert progress.remaining_s == 0.0
