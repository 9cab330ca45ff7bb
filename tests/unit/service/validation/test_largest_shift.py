"""How far a model moves the tool, against arms whose largest shift follows on paper."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.identification.models import model_of, parameters_of
from truepose.domain.identification import NestCentre, Parameter
from truepose.domain.robot import FramePlacement, JointRange, JointRow, Robot
from truepose.validation.model_comparison import FLANGE, far_values, largest_shift, moved_to

FIRST_MM, SECOND_MM = 300.0, 200.0
PLANAR = Robot(
    "planar",
    (
        JointRow(0.0, 0.0, 0.0, 0.0),
        JointRow(0.0, FIRST_MM, 0.0, 0.0),
        JointRow(0.0, SECOND_MM, 0.0, 0.0),
    ),
)
TURNS = (JointRange(-math.pi, math.pi),) * 3


def planar(*parameters):
    at_flange = (NestCentre(1, (0.0, 0.0, 0.0)),)
    here = FramePlacement(5000.0, 0.0, 800.0)
    return model_of(
        PLANAR, *parameters, base=here, nominal_base=here, nests=at_flange, nominal_nests=at_flange
    )


def test_an_arm_that_bends_less_than_a_registration_hides_is_off_by_what_that_leaves():
    """The best turn about axis 1 is arg(a^2 + b^2 e^i); what it leaves is largest where both parts add up."""
    offset = 0.02
    model = planar(*parameters_of("geometry", [("theta_2", offset, "rad")]))
    turn = np.angle(FIRST_MM**2 + SECOND_MM**2 * np.exp(1j * offset))
    left_mm = FIRST_MM * abs(1 - np.exp(1j * turn)) + SECOND_MM * abs(np.exp(1j * offset) - np.exp(1j * turn))

    found = largest_shift(model, TURNS)

    assert found.shift_mm == pytest.approx(left_mm, rel=0.1)  # the registration is that of drawn places


@pytest.mark.parametrize("joint", [1, 2])
def test_an_offset_of_40_deg_counts_whole(joint):
    model = planar(*parameters_of("geometry", [(f"theta_{joint}", math.radians(40.0), "rad")]))
    reach_mm = FIRST_MM + SECOND_MM if joint == 1 else SECOND_MM

    found = largest_shift(model, TURNS)

    assert found.shift_mm == pytest.approx(2 * reach_mm * math.sin(math.radians(20.0)), rel=1e-3)


def test_a_base_far_away_is_a_registration_and_one_that_was_moved_from_there_is_none():
    moved = planar(*parameters_of("base", [("base_x", 5000.0, "mm")]))

    assert largest_shift(planar(), TURNS).shift_mm == pytest.approx(0.0, abs=1e-9)
    assert largest_shift(moved, TURNS).shift_mm == pytest.approx(5000.0, abs=1e-6)
    assert largest_shift(moved_to(planar(), FramePlacement(), nests_known=True), TURNS).shift_mm > 5000.0


def test_a_base_within_its_prior_is_registered():
    moved = planar(*parameters_of("base", [("base_x", 6.0, "mm")]))

    assert largest_shift(moved, TURNS).shift_mm == pytest.approx(0.0, abs=1e-6)


def test_the_point_that_moves_most_is_named():
    longer = [NestCentre(1, (0.0, 0.0, 0.0)), NestCentre(2, (400.0, 0.0, 0.0))]
    turned = planar(*parameters_of("geometry", [("theta_3", 0.5, "rad")]))
    model = replace(turned, nests=tuple(longer), nominal_nests=tuple(longer))

    assert largest_shift(model, TURNS).nest == 2
    assert largest_shift(replace(turned, nests=(), nominal_nests=()), TURNS).nest == FLANGE


def test_values_far_from_their_priors_are_named_farthest_first():
    far = Parameter("theta_2", "geometry", 0.7, "rad", 0.0, 0.005)
    further = Parameter("base_x", "base", 5000.0, "mm", 0.0, 10.0)
    near = Parameter("a_2", "geometry", 0.3, "mm", 0.0, 1.0)
    free = Parameter("wave_2_1_sin", "joint_harmonics", 1.0, "rad", 0.0, math.inf)

    found = far_values(planar(far, near, further, free))

    assert [(one.parameter.name, round(one.widths)) for one in found] == [("base_x", 500), ("theta_2", 140)]


def test_a_base_found_from_the_data_is_expected_where_it_was_found():
    found_there = Parameter("base_x", "base", 5000.0, "mm", 0.0, 10.0)
    model = replace(planar(found_there), base=FramePlacement(), nominal_base=FramePlacement(5001.0))

    assert far_values(model) == ()
