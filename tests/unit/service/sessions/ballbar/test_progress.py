"""How far a session is: what will be tried again is planned, what was left out for good is not."""

from tests.unit.service.sessions.ballbar.sessions import Story, make_plan
from truepose.sessions.ballbar.state import READINGS

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


def skipping(story, *poses, attempt=""):
    """Skip these poses at their first leg, do all else, until the next pre-calibration or the end."""
    groups = {f"placement-1/pose-{config}{attempt}" for config in poses}
    while story.now.step is not None and "precalibrate" not in story.present:
        if story.present.rsplit("/", 1)[0] in groups and "leg" in story.present:
            story.skip()
        else:
            story.do()


def test_poses_skipped_twice_are_aimed_once_more_where_others_were_measured_meanwhile():
    story = Story(make_plan((1, 2, 3, 4), precalibrate_after=2))
    skipping(story, 1, 2)
    story.do()  # the pre-calibration
    skipping(story, 1, attempt="/again")

    assert story.present == "placement-1/precalibrate-2"
    story.do()
    skipping(story)
    assert story.now.progress.skipped_poses == 0
    assert story.now.progress.readings == story.now.progress.planned


def test_poses_skipped_twice_are_left_out_where_nothing_was_learnt_meanwhile():
    story = Story(make_plan((1, 2, 3, 4), precalibrate_after=2))
    skipping(story, 1, 2)
    story.do()

    skipping(story, 1, 2, attempt="/again")

    assert story.now.step is None
    assert story.now.progress.skipped_poses == 2
