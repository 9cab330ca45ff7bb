"""The judge of lengths that nobody foresees knows what the ledger says, and keeps nothing of its own."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.ballbar.cells import ballbar_cell
from tests.helpers.ballbar.early_sessions import KIT, plan_of
from tests.helpers.ballbar.true_session import TrueArm
from tests.unit.service.sessions.ballbar.sessions import Story, length
from truepose.domain.ballbar import PoseForecast, StepKind
from truepose.domain.ledger import EntryKind
from truepose.planning.ballbar.length_forecast import SessionForecast
from truepose.sessions.ballbar.early_length_check import EarlyJudge
from truepose.sessions.ballbar.length_check import Judges, doubt


class TrueStory(Story):
    """A session on an arm that is off its table, every length as it truly is but for those that are given."""

    def __init__(self, arm, plan):
        super().__init__(plan, KIT)
        self.arm = arm

    def true_mm(self, points):
        step = self.now.step
        placement = self.plan.placements[0]
        if step.kind is StepKind.CONNECT_LEG:
            pose = next(pose for pose in placement.poses if pose.config == step.config)
            return self.arm.length(placement, pose.joints_rad, points)
        first, second = (self.arm.cups(placement)[point - 1] for point in points)
        return float(np.linalg.norm(first - second))

    def taken(self, points):
        return length(self.true_mm(points))

    def to(self, step_id, slips=None):
        """Do everything before a step; legs of `slips` are read of other pairs."""
        while self.now.step.id != step_id:
            step = self.now.step
            if step.kind in {StepKind.CONNECT_LEG, StepKind.MEASURE_SIDE} and step.artefact != "tool":
                self.show()
                points = (slips or {}).get(step.id, step.points)
                self.add(step.id, EntryKind.MEASURED, length=self.taken(points))
            else:
                self.do()
        return self


@pytest.fixture(scope="module")
def arm():
    return TrueArm.drawn(ballbar_cell(), 3, angle_rad=0.7e-3, length_mm=0.12)


@pytest.fixture(scope="module")
def plan(arm):
    return plan_of(arm.cell, poses=9)


@pytest.fixture
def judge(arm, plan):
    return EarlyJudge(SessionForecast(arm.cell, plan, KIT), KIT)


def leg_of(plan, config, number):
    pose = plan.placements[0].poses[config - 1]
    cup, nest = pose.legs[number]
    return f"placement-1/pose-{config}/leg-{cup}-{nest}"


def doubted(judge, story, points):
    return doubt(story.taken(points), story.now, story.now.step, KIT, Judges(early=judge))


def test_the_first_leg_of_a_later_pose_is_known_from_the_poses_before(arm, plan, judge):
    story = TrueStory(arm, plan).to(leg_of(plan, 9, 0))
    own = story.now.step.points
    others = [leg for leg in plan.placements[0].poses[8].legs if leg != own]
    other = max(others, key=lambda leg: abs(story.true_mm(leg) - story.true_mm(own)))

    assert doubted(judge, story, own) is None
    assert doubted(judge, story, other).suspected == other


def test_a_judge_that_begins_in_the_middle_says_the_same(arm, plan, judge):
    story = TrueStory(arm, plan).to(leg_of(plan, 3, 0))
    pose = plan.placements[0].poses[2]
    doubted(judge, story, pose.legs[0])  # one that has followed the session
    story.to(leg_of(plan, 3, 4))
    anew = EarlyJudge(SessionForecast(arm.cell, plan, KIT), KIT)

    for leg in pose.legs[:4]:
        assert doubted(judge, story, leg) == doubted(anew, story, leg) is not None


def test_what_was_reopened_counts_no_more(arm, plan, judge):
    first, second = leg_of(plan, 1, 0), leg_of(plan, 1, 1)
    legs = plan.placements[0].poses[0].legs
    story = TrueStory(arm, plan).to(second, {first: legs[1]})
    assert doubted(judge, story, legs[1]).kind == "same_pair"

    story.add(first, EntryKind.REOPENED)
    story.to(second)

    assert doubted(judge, story, legs[1]) is None


def test_sides_of_the_base_are_judged_too(arm, plan, judge):
    story = TrueStory(arm, plan).to("placement-1/side-2-3")

    assert doubted(judge, story, (2, 3)) is None
    assert doubted(judge, story, (1, 2)).kind == "same_pair"


def test_pairs_that_cannot_be_told_apart_are_known_while_a_leg_is_asked_for(arm, plan, judge):
    story = TrueStory(arm, plan).to("placement-1/pose-1/initialise")
    assert judge.alike(story.now) == ()

    story.to(leg_of(plan, 1, 0))

    assert len(judge.alike(story.now)) == 15


def test_a_leg_that_was_skipped_is_no_reading(arm, plan, judge):
    story = TrueStory(arm, plan).to(leg_of(plan, 2, 3))
    story.add(story.now.step.id, EntryKind.SKIPPED, text="out of range")
    story.to(leg_of(plan, 3, 0))

    assert doubted(judge, story, story.now.step.points) is None


def test_a_reading_far_from_everything_is_unlikely(arm, plan, judge):
    story = TrueStory(arm, plan).to(leg_of(plan, 9, 2))
    taken = replace(story.taken(story.now.step.points), length_mm=300.9)

    assert judge.doubt(taken, story.now, story.now.step).kind == "unlikely"


def test_to_look_for_swaps_costs_the_judge_nothing(arm, plan, judge):
    story = TrueStory(arm, plan).to(leg_of(plan, 2, 3))
    before = doubted(judge, story, plan.placements[0].poses[1].legs[0])

    judge.alike(story.now)

    assert doubted(judge, story, plan.placements[0].poses[1].legs[0]) == before is not None


def test_coded_lengths_that_are_foreseen_are_told_apart_and_equal_ones_are_not(arm, plan, judge):
    story = TrueStory(arm, plan).to(leg_of(plan, 1, 0))
    legs = plan.placements[0].poses[0].legs
    covariance = tuple(tuple(0.0036 * (a == b) for a in range(6)) for b in range(6))
    coded = tuple(299.3 + 0.28 * level for level in range(6))
    forecast = PoseForecast(1, legs, coded, covariance)

    apart = judge.alike(replace(story.now, forecast=forecast))
    equal = judge.alike(replace(story.now, forecast=replace(forecast, length_mm=(300.0,) * 6)))

    assert apart == ()
    assert len(equal) == 15
