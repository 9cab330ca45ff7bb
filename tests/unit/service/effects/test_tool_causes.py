"""Causes in the tool and in single readings: nests, seats, labels, bad readings, the instrument's scale."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.diagnosis.point_scenes import (
    START,
    rows_at_start,
    telling_campaign,
    telling_problem,
    telling_scene,
)
from tests.helpers.diagnosis.seats import GROUPS, SHIFT_MM, TURN_RAD, WIDTHS, posterior
from truepose.domain.robot import Nest
from truepose.effects.causes import FittedCause
from truepose.effects.frames.tool_certificate import certificate_specs, moves
from truepose.effects.ports import PortKind
from truepose.effects.readings.label_swap import pair_subject
from truepose.effects.registry import CAUSES
from truepose.effects.setup.tool_reseating import deviations
from truepose.identification.model.evaluation import evaluate
from truepose.identification.problem.build import build
from truepose.messages.catalogue import english


def one_known_nest():
    campaign = telling_campaign()
    known, *others = campaign.nests
    return replace(campaign, nests=(known, *(Nest(None) for _ in others)))


def mounted(attachment):
    campaign = telling_campaign()
    readings = campaign.calibration
    stops = replace(readings.stops, attachment=attachment)
    return replace(campaign, calibration=replace(readings, stops=stops))


def share(value, uncertainty):
    return FittedCause((), np.array([value]), np.array([[uncertainty**2]]))


def test_each_certified_nest_may_be_off_as_long_as_another_is_not():
    scene = telling_scene()

    subjects = [candidate.subject for candidate in CAUSES["nest_offset"].candidates(scene)]
    left = CAUSES["nest_offset"].candidates(replace(scene, present=scene.present | {"offset_2_x"}))
    none_left = CAUSES["nest_offset"].candidates(
        replace(scene, present=scene.present | {"offset_2_x", "offset_3_x"})
    )

    assert subjects == ["nest 1", "nest 2", "nest 3"]
    assert [candidate.subject for candidate in left] == ["nest 1", "nest 3"]
    assert none_left == ()


def test_a_single_certified_nest_tells_nothing_of_its_own_offset():
    scene = telling_scene(("base", "tool", "geometry", "compliance"), one_known_nest())

    assert "read another certified nest" in english(CAUSES["nest_offset"].unseen(scene))
    assert CAUSES["nest_offset"].candidates(scene) == ()
    assert CAUSES["nest_offset"].specs(scene.setting) == ()


def test_offsets_by_name_count_from_the_first_nest():
    names = [spec.name for spec in CAUSES["nest_offset"].specs(telling_scene().setting)]

    assert names == [f"offset_{nest}_{axis}" for nest in (2, 3) for axis in "xyz"]


def test_an_offset_nest_is_where_its_certificate_and_the_offset_put_it():
    campaign = telling_campaign()
    problem = build(campaign, (*START, "nest_offset"))
    values = problem.start.copy()
    values[problem.structure.index_of("offset_2_y")] = 0.5
    state = evaluate(problem.structure, values, problem.blocks[0].targets)
    x, y, z = campaign.nests[1].centre_mm

    there = replace(campaign, nests=(campaign.nests[0], Nest((x, y + 0.5, z), 0.002), campaign.nests[2]))

    expected = build(there, START)
    moved = evaluate(expected.structure, expected.start, expected.blocks[0].targets)
    assert state.position_mm == pytest.approx(moved.position_mm, abs=1e-9)


def test_an_offset_is_shown_as_its_length():
    names = ("offset_2_x", "offset_2_y", "offset_2_z")
    fitted = FittedCause(names, np.array([0.02, -0.04, 0.04]), 1e-12 * np.eye(3))

    shown = CAUSES["nest_offset"].describe("nest 2", fitted, telling_scene())

    assert (shown.amplitude, shown.unit) == (pytest.approx(0.06), "mm")
    assert [detail.value for detail in shown.details] == pytest.approx([0.02, -0.04, 0.04])
    assert english(shown.sentence).startswith("Tool nest 2 is 0.060 mm from its certified position")


@pytest.mark.parametrize("attachment", [None, np.ones(24, dtype=np.int64)])
def test_one_mounting_tells_nothing_of_the_next(attachment):
    scene = telling_scene(campaign=mounted(attachment))

    assert "mount it again" in english(CAUSES["tool_reseating"].unseen(scene))
    assert CAUSES["tool_reseating"].candidates(scene) == ()


def test_all_mountings_together_are_one_candidate():
    scene = telling_scene()

    (candidate,) = CAUSES["tool_reseating"].candidates(scene)

    assert len(candidate.specs) == 4 * 6
    assert CAUSES["tool_reseating"].candidates(replace(scene, present=frozenset(candidate.names))) == ()


def test_a_seat_acts_in_its_own_mounting_alone():
    here, elsewhere = CAUSES["tool_reseating"].terms(
        ("seat_3_x", "seat_9_rz"), rows_at_start(telling_problem())
    )

    assert here.weight.tolist() == [0.0] * 12 + [1.0] * 6 + [0.0] * 6
    assert not elsewhere.weight.any()
    assert here.port.kind is PortKind.MOTION
    assert (here.port.number, elsewhere.port.number) == (36, 41)  # body 6 carries the tool


def test_seats_are_shown_as_a_standard_deviation_whatever_the_order_of_their_names():
    rng = np.random.default_rng(2)
    (candidate,) = CAUSES["tool_reseating"].candidates(telling_scene())
    names, values = np.array(candidate.names), WIDTHS[np.tile(np.arange(6), 4)] * rng.standard_normal(24) / 5
    shuffled = rng.permutation(24)

    straight = CAUSES["tool_reseating"].describe(
        "tool", FittedCause(tuple(names), values, 1e-12 * np.eye(24)), telling_scene()
    )
    mixed = CAUSES["tool_reseating"].describe(
        "tool", FittedCause(tuple(names[shuffled]), values[shuffled], 1e-12 * np.eye(24)), telling_scene()
    )

    assert mixed.amplitude == pytest.approx(straight.amplitude)
    assert straight.unit == "mm"
    assert "4 mountings" in english(straight.sentence)


def test_seats_that_differ_by_noise_alone_have_a_deviation_that_zero_is_near():
    rng = np.random.default_rng(3)
    mean, covariance = posterior(np.zeros((4, 6)), 0.2, rng)

    (shift, turn), (shift_u, turn_u) = deviations(mean, covariance, WIDTHS, GROUPS)

    assert shift < 0.2 * SHIFT_MM + 2.0 * shift_u  # the noise itself is the most that could hide
    assert turn < 0.2 * TURN_RAD + 2.0 * turn_u


def test_swapped_labels_need_two_nests():
    campaign = telling_campaign()
    one = replace(telling_scene(), nest=np.ones(len(campaign.calibration), dtype=np.int64))

    assert "no other nest to mix it up with" in english(CAUSES["label_swap"].unseen(one))
    assert CAUSES["label_swap"].unseen(telling_scene()) is None


def test_swapped_labels_are_counted_among_the_readings_of_their_two_nests():
    shown = CAUSES["label_swap"].describe(pair_subject(3, 1), share(0.25, 0.1), telling_scene())

    assert shown.subject == "nest 1, nest 3"
    assert "Nests 1 and 3 were mixed up in 4 of their 16 readings" in english(shown.sentence)


@pytest.mark.parametrize(
    ("value", "words"), [(1 / 24, "1 of 24 readings is an outlier"), (0.125, "3 of 24 readings are outliers")]
)
def test_bad_readings_are_counted_among_all(value, words):
    shown = CAUSES["outliers"].describe("readings", share(value, 0.02), telling_scene())

    assert (shown.amplitude, shown.standard_uncertainty) == (value, pytest.approx(0.02))
    assert words in english(shown.sentence)


@pytest.mark.parametrize("cause", ["label_swap", "outliers"])
def test_what_is_wrong_with_single_readings_is_no_parameter(cause):
    scene = telling_scene()

    assert CAUSES[cause].specs(scene.setting) == ()
    assert CAUSES[cause].candidates(scene) == ()
    assert CAUSES[cause].terms((), rows_at_start(telling_problem())) == []


def test_a_scale_is_seen_on_fixed_nests_or_on_a_second_certified_nest():
    start = ("base", "tool", "geometry", "compliance")
    alone = replace(telling_scene(start, one_known_nest()), reference_s=np.zeros(0))

    assert "reference nests" in english(CAUSES["instrument_scale"].unseen(alone))
    assert CAUSES["instrument_scale"].candidates(alone) == ()
    assert CAUSES["instrument_scale"].unseen(replace(alone, reference_s=np.array([1.0]))) is None
    assert CAUSES["instrument_scale"].unseen(telling_scene()) is None


def test_an_arm_whose_lengths_are_given_shows_the_scale_by_itself():
    scene = telling_scene(("base", "tool", "joint_offset"), one_known_nest())

    assert CAUSES["instrument_scale"].unseen(replace(scene, reference_s=np.zeros(0))) is None


@pytest.mark.parametrize(("scale", "word"), [(2e-5, "long"), (-2e-5, "short")])
def test_a_scale_is_told_in_micrometres_per_metre(scale, word):
    fitted = FittedCause(("scale",), np.array([scale]), np.array([[1e-12]]))

    shown = CAUSES["instrument_scale"].describe("tracker", fitted, telling_scene())

    assert (shown.amplitude, shown.standard_uncertainty) == (scale, pytest.approx(1e-6))
    assert f"reads {word} by 20.0 \u00b5m per metre" in english(shown.sentence)


def test_certified_nests_err_as_their_certificates_say_and_exact_ones_not_at_all():
    specs = certificate_specs({2: 0.004, 1: 0.002, 3: 0.0})

    names = [spec.name for spec in specs]
    assert names == [f"certified_{nest}_{axis}" for nest in (1, 2) for axis in "xyz"]
    assert [spec.prior_width for spec in specs] == [0.002] * 3 + [0.004] * 3
    assert [moves(nest, names) for nest in (1, 2, 3)] == [True, True, False]
