import math

import numpy as np
import pytest

from tests.helpers.domain.builders import (
    make_campaign,
    make_identification,
    make_model,
    make_parameter,
    make_robot,
)
from truepose.domain.identification import NotIdentifiable
from truepose.domain.robot import FramePlacement
from truepose.effects.ports import Setting
from truepose.effects.registry import EFFECTS
from truepose.reports.identification.parameters import meaning, parameter_rows


def row_of(parameter, campaign=None, **changes):
    model = make_model(parameters=(parameter,), covariance=np.eye(1), **changes)
    identification = make_identification(parameters=(parameter,), model=model)
    return parameter_rows(identification, campaign or make_campaign())[0]


def test_angles_are_shown_in_degrees_with_nominal_and_identified_value():
    row = row_of(
        make_parameter(name="alpha_2", value=math.radians(0.25), standard_uncertainty=math.radians(0.01))
    )

    shown = (row.nominal, row.change, row.identified, row.standard_uncertainty, row.unit)
    assert shown == ("-90", "0.250", "-89.750", "0.010", "deg")


def test_the_base_stands_where_start_and_parameter_put_it():
    row = row_of(
        make_parameter(name="base_x", effect="base", value=0.5, unit="mm", standard_uncertainty=0.01),
        base=FramePlacement(x_mm=100.0),
    )

    assert (row.nominal, row.identified) == ("100", "100.500")


def test_angles_of_a_turned_base_are_those_of_the_whole_rotation():
    # Turned by 90 deg about z at the start, a parameter about x turns the base about its own -y.
    parameter = make_parameter(
        name="base_rx", effect="base", value=math.radians(1.0), standard_uncertainty=math.radians(0.01)
    )

    row = row_of(parameter, base=FramePlacement(rz_rad=math.pi / 2))

    assert row.identified == "1.000"  # RotX(1 deg) RotZ(90 deg): still RotX RotY RotZ with rx = 1 deg


def test_what_nobody_stated_has_no_nominal_value():
    parameter = make_parameter(name="base_x", effect="base", value=0.5, unit="mm", standard_uncertainty=0.01)

    row = row_of(parameter, make_campaign(base_nominal=None))

    assert row.nominal == row.change == "–"  # noqa: RUF001 -- the sign for nothing


def test_a_parameter_that_its_prior_holds_is_marked():
    row = row_of(make_parameter(standard_uncertainty=3e-3, prior_width=5e-3))

    assert row.standing == "prior"


@pytest.mark.parametrize(
    ("group", "standing"),
    [(("alpha_2", "a_3"), "combination"), (("alpha_2", "d_1"), "determined")],  # d_1 never was a parameter
)
def test_only_combinations_of_parameters_are_marked_as_seen_together(group, standing):
    identification = make_identification(not_identifiable=(NotIdentifiable(group, "why"),))

    row = parameter_rows(identification, make_campaign())[0]

    assert row.standing == standing


@pytest.mark.parametrize("effect", EFFECTS)
@pytest.mark.parametrize("torques", ["masses", "unknown"])
def test_every_parameter_of_every_effect_is_explained(effect, torques):
    setting = Setting(make_robot(), (1,), True, torques, np.full(3, 1e4))

    for spec in EFFECTS[effect].specs(setting):
        assert meaning(spec.name, "unexplained") != "unexplained", spec.name


def test_base_nests_and_the_length_offset_are_explained():
    assert meaning("anchor_1_3_x", "legs") == "position of base nest 3 of placement 1 in the world, x"
    assert meaning("length_offset", "legs") == "offset added to every length"


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("drift_exp1200_rz", "drift of the base that settles with a time constant of 1200 s, about z"),
        ("jump_1234.5_x", "jump of the base between two readings, along x"),
        ("fixture_2_1234.5_ry", "jump of the base fixture during placement 2, about y"),
        ("seat_3_z", "seating of the tool at mounting 3, along z"),
        ("offset_2_y", "offset of tool nest 2 from its certified position, y"),
        ("sag_4", "bending of link 4: 1 / flexural rigidity"),
        ("mass_3", "mass of link 3 in excess of the stated value"),
        ("wave_6_202_cos", "periodic error of joint 6: cos with 202 periods per turn"),
    ],
)
def test_parameters_that_only_data_propose_are_explained(name, words):
    assert meaning(name, "unexplained") == words
