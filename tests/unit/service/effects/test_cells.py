"""The table of cells: where every cause acts, over what, with which shape."""

import re
from typing import get_args

import pytest

from tests.helpers.diagnosis.point_scenes import telling_scene
from truepose.domain.diagnosis import Cause, Shape
from truepose.effects.causes import Candidate
from truepose.effects.registry import CAUSES
from truepose.effects.signatures import (
    alike,
    amplitude_of,
    curve_kind,
    has_trade_name,
    named_signature,
    of_instrument,
    of_legs,
    place_of,
    plural_of,
    signature_of,
)

WHERE = re.compile(
    r"joint \d+|joints|link \d+|links|flange|base|tool|nest \d+|tracker|ballbar|placement \d+|readings"
)
OVER = re.compile(
    r"angle of joint \d+|angles of joints \d+ and \d+|torque of (joint \d+|joints)|load|direction|last move"
    r"|time|temperature|mounting|azimuth|elevation|range|constant"
)


@pytest.mark.parametrize("cause", CAUSES)
def test_every_candidate_of_every_cause_has_a_place_a_variable_and_a_shape(cause):
    candidates = CAUSES[cause].candidates(telling_scene()) or (Candidate(cause, "joint 2", ()),)

    cells = [signature_of(candidate) for candidate in candidates]

    assert all(WHERE.fullmatch(cell.where) for cell in cells)
    assert all(OVER.fullmatch(cell.over) for cell in cells)
    assert {cell.shape for cell in cells} <= set(get_args(Shape))


@pytest.mark.parametrize(
    ("candidate", "cell"),
    [
        (Candidate("joint_coupling", "joint 6", (), 5.0), ("joint 6", "angle of joint 5", "line")),
        (Candidate("joint_harmonics", "joint 4", (), 2.0), ("joint 4", "angle of joint 4", "wave")),
        (
            Candidate("joint_harmonics", "joint 4", (), 60.0, function=True),
            ("joint 4", "angle of joint 4", "curve"),
        ),
        (Candidate("base_drift", "base", ()), ("base", "time", "drift")),
        (Candidate("base_drift", "base", (), 600.0), ("base", "time", "settling")),
        (Candidate("unnamed", "link 2, temperature, line", ()), ("link 2", "temperature", "line")),
    ],
)
def test_what_was_searched_over_is_part_of_the_cell(candidate, cell):
    assert signature_of(candidate) == cell


@pytest.mark.parametrize("effect", CAUSES)
def test_every_cause_says_what_its_amplitude_is(effect):
    assert amplitude_of(effect)


def test_what_another_version_named_is_a_cell_without_words():
    assert named_signature("gear_resonance", "joint 3").where == "joint 3"
    assert amplitude_of("gear_resonance") == ""


@pytest.mark.parametrize(
    ("one", "other", "similar"),
    [
        (("payload", "tool"), ("compliance", "joint 2"), True),  # both follow loads
        (("unnamed", "joint 3, time, jump"), ("base_shift", "base"), True),  # both over time
        (
            ("unnamed", "joint 3, angle of joint 2, wave"),
            ("unnamed", "joint 5, angle of joint 2, wave"),
            True,
        ),
        (("backlash", "joint 2"), ("backlash", "joint 3"), False),
        (("nest_offset", "nest 1"), ("axis_parallelism", "joint 3"), False),  # constants of two places
    ],
)
def test_cells_are_alike_by_place_variable_or_kin(one, other, similar):
    assert alike(named_signature(*one), named_signature(*other)) is similar
    assert alike(named_signature(*other), named_signature(*one)) is similar


@pytest.mark.parametrize(
    ("effect", "subject", "place", "curve", "several"),
    [
        ("backlash", "joint 3", ("joint 3", "direction"), "joint", "joints"),
        ("base_drift", "", ("base", "time"), "shift", ""),
        ("joint_gain", "joint 2", ("joint 2", "angle of joint 2"), "joint", ""),
        ("link_mass", "link 2", ("link 2", "load"), "agreement", "links"),
        ("nest_offset", "nest 1", ("nest 1", "constant"), "level", ""),
        ("unnamed", "link 2, time, wave", ("link 2", "time"), "agreement", ""),
        ("joint_coupling", "joint 5", None, "joint", ""),
        ("gone since", "joint 5", None, "agreement", ""),
    ],
)
def test_a_cause_is_placed_by_its_name_where_that_says_it(effect, subject, place, curve, several):
    assert place_of(Cause(effect, subject)) == place
    assert curve_kind(effect) == curve
    assert plural_of(effect) == several
    assert has_trade_name(effect) is (effect != "unnamed")


def test_what_lies_in_the_instrument_and_what_only_legs_show_is_told_by_the_signature():
    assert {name for name in CAUSES if of_instrument(name)} == {"instrument_drift", "instrument_scale"}
    assert of_legs(named_signature("ballbar_zero", ""))
    assert of_legs(named_signature("fixture_shift", "placement 2"))
    assert not of_legs(named_signature("base_drift", ""))
