"""What the extended model leaves: the size of the noise, what revisits say of it, what it depends on."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.diagnosis.point_scenes import START, telling_campaign
from tests.helpers.diagnosis.selections import left_of, make_selected, make_start, planted, started
from tests.helpers.identification.synthetic import NOISE_MM, configurations
from truepose.diagnosis.evidence.residual_structure import Relation

# The median of 80 squared radii has a relative standard deviation of 0.12, its root half of that.
SPREAD = 4 * 0.06


def left_beside(start, *picked, without=(), rivals=()):
    return left_of(start, make_selected(start, picked, rivals), without)


def test_noise_as_stated_is_of_size_one_and_leaves_no_structure():
    left = left_beside(make_start({}))

    assert left.noise_scale == pytest.approx(1.0, abs=SPREAD)
    assert not left.more_than_stated
    assert left.depends == ()
    assert not left.structure


def test_what_is_added_stands_where_its_chance_puts_it_and_replaces_nothing():
    def on(variable, chance, kind="angle"):
        return Relation(variable, chance, kind, None, None)

    left = left_beside(make_start({})).also([on("time", 1e-4), on("angle of joint 2", 1e-3)])
    more = left.also([on("torque of joint 3", 1e-9), on("time", 1e-12, kind="place")])

    assert more.depends == (on("torque of joint 3", 1e-9), on("time", 1e-4), on("angle of joint 2", 1e-3))


def test_noise_twice_as_large_as_stated_is_said_to_be():
    left = left_beside(make_start({}, noise_mm=2 * NOISE_MM))

    assert left.noise_scale == pytest.approx(2.0, abs=2 * SPREAD)
    assert left.more_than_stated
    assert not left.explained_by_repeats  # nothing was measured twice
    assert left.structure


def test_revisits_that_scatter_as_much_make_it_noise():
    joints = np.vstack([configurations(60), configurations(60)[:20]])
    campaign = telling_campaign(80, joints_rad=joints)
    points = campaign.calibration
    nest = points.nest.copy()
    nest[60:] = nest[:20]
    repeat_of = np.where(np.arange(80) < 60, -1, np.arange(80) - 59)
    # from the same side: backlash would be no scatter, and there is none
    stops = replace(points.stops, repeat_of=repeat_of)
    again = replace(campaign, calibration=replace(points, stops=stops, nest=nest))

    left = left_beside(make_start({}, campaign=again, noise_mm=2 * NOISE_MM))

    assert left.more_than_stated
    assert left.explained_by_repeats
    assert not left.structure


def test_what_depends_on_time_is_named():
    start = make_start({"base_drift": {"drift_linear_x": 0.4}})

    left = left_beside(start)

    assert left.structure
    assert any(one.kind == "time" for one in left.depends)
    assert [one.p_value for one in left.depends] == sorted(one.p_value for one in left.depends)
    assert len({one.variable for one in left.depends}) == len(left.depends) <= 4


def test_a_cause_that_is_fitted_leaves_nothing():
    left = left_beside(make_start({"joint_gain": {"gain_4": 1e-3}}), ("joint_gain", "joint 4"))

    assert left.depends == ()
    assert left.noise_scale == pytest.approx(1.0, abs=SPREAD)


@pytest.mark.parametrize("order", [9, 11])
def test_a_fast_wave_is_seen_also_where_waves_are_left_out_of_the_library(order):
    # faster than any smooth family
    start = make_start({"joint_harmonics": {f"wave_6_{order}_sin": 1e-3}})

    left = left_beside(start, without=("joint_harmonics",))

    wave = next(one for one in left.depends if one.order)
    assert (wave.variable, wave.order, wave.kind) == ("angle of joint 6", order, "angle")


def test_heavy_tails_are_noise():
    quiet = planted({}, n=160, noise_mm=0.0)
    rng = np.random.default_rng(2)
    heavy = rng.standard_normal((160, 3)) / np.sqrt(rng.chisquare(3, 160) / 3)[:, None]
    points = quiet.calibration
    noisy = replace(points, position_mm=points.position_mm + NOISE_MM * heavy)

    left = left_beside(started(replace(quiet, calibration=noisy), START))

    assert left.tails.degrees_of_freedom is not None
    assert not left.tails.bad.any()
    assert left.depends == ()
