"""Fixed nests as witnesses: against which findings they speak, and whom they accuse instead."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.diagnosis.point_scenes import telling_campaign
from tests.helpers.diagnosis.selections import left_of, make_selected, make_start, planted, started
from truepose.diagnosis.evidence.residual_structure import fixed_nests_contradict, instrument_suspects
from truepose.domain.diagnosis import Cause
from truepose.effects.causes import ErrorSignature
from truepose.identification.fit.robust import robust_fit
from truepose.identification.problem.build import build

JUMPED = ErrorSignature("base", "time", "jump")
DRIFTED = ErrorSignature("base", "time", "drift")
KICK = ("unnamed", "tracker, time, jump")
DRIFT = ("instrument_drift", "tracker")


def fitted(step_mm):
    campaign = telling_campaign(24)
    looks = campaign.reference
    late = looks.time_s > np.median(looks.time_s)
    noise = 0.015 * np.random.default_rng(1).standard_normal(looks.position_mm.shape)
    moved = replace(looks, position_mm=looks.position_mm + noise + step_mm * late[:, None])
    problem = build(replace(campaign, reference=moved), ("base", "joint_offset"), with_reference=True)
    return robust_fit(problem.structure, problem.blocks, problem.start)


@pytest.mark.parametrize("cell", [JUMPED, DRIFTED, ErrorSignature("joint 3", "time", "jump")])
def test_nests_that_moved_speak_against_what_is_said_over_time(cell):
    assert fixed_nests_contradict(fitted(0.2), cell)
    assert not fixed_nests_contradict(fitted(0.0), cell)


def test_they_know_nothing_of_what_does_not_follow_time():
    assert not fixed_nests_contradict(fitted(0.2), ErrorSignature("joint 3", "angle of joint 3", "wave"))


def test_without_fixed_nests_nobody_speaks():
    problem = build(replace(telling_campaign(24), reference=None), ("base", "joint_offset"))

    assert not fixed_nests_contradict(robust_fit(problem.structure, problem.blocks, problem.start), JUMPED)


@pytest.fixture(scope="module")
def start():
    return make_start({})


@pytest.mark.parametrize(("cell", "cause"), [(JUMPED, KICK), (DRIFTED, DRIFT)])
def test_the_same_of_the_instrument_is_accused_where_it_was_tried(start, cell, cause):
    tried = make_selected(start, [], rivals=[KICK, DRIFT, ("base_shift", "base")])

    assert instrument_suspects(tried, cell) == (Cause(*cause),)
    assert instrument_suspects(make_selected(start, [], rivals=[("base_shift", "base")]), cell) == ()


def test_what_was_found_besides_is_not_accused_again(start):
    assert instrument_suspects(make_selected(start, [KICK], rivals=[KICK]), JUMPED) == ()


@pytest.mark.parametrize(("step_mm", "left_over"), [(0.2, True), (0.0, False)])
def test_nests_that_nothing_explains_are_left_over(step_mm, left_over):
    campaign = planted({})
    looks = campaign.reference
    late = looks.time_s > np.median(looks.time_s)
    moved = replace(looks, position_mm=looks.position_mm + step_mm * late[:, None])
    start = started(replace(campaign, reference=moved))

    left = left_of(start, make_selected(start, []))

    assert ("time (frame of the instrument)" in {one.variable for one in left.depends}) is left_over
    assert left.structure is left_over
