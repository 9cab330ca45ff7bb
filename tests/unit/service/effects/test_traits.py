"""What effects tell of themselves: whoever treats them differently asks for it, and knows no names."""

from dataclasses import replace

import numpy as np
import pytest

from truepose.domain.robot import FramePlacement
from truepose.effects.ports import EffectWithTraits, Trait
from truepose.effects.registry import EFFECTS, automatic_in, effects_with, undetermined_by_construction
from truepose.exchange.campaigns.zip_file import read_campaign_at
from truepose.identification.problem.build import automatic_effects
from truepose.identification.problem.problem_setup import outline, setting_of
from truepose.kinematics.frames import rotation_y
from truepose.messages.catalogue import english


@pytest.mark.parametrize("trait", Trait)
def test_of_some_effects_it_is_so_and_of_others_not(trait):
    told = effects_with(trait)

    assert 0 < len(told) < len(EFFECTS)
    assert set(told) <= set(EFFECTS)


def test_an_effect_that_tells_nothing_has_no_trait():
    silent = [name for name, effect in EFFECTS.items() if not isinstance(effect, EffectWithTraits)]

    assert "link_bending" in silent
    assert not [name for trait in Trait for name in effects_with(trait) if name in silent]


def test_what_is_only_found_by_a_search_brings_no_parameters(example_campaign):
    setting = setting_of(example_campaign, example_campaign.calibration.stops)

    assert {name: EFFECTS[name].specs(setting) for name in effects_with(Trait.SEARCHED)} == dict.fromkeys(
        ("base_shift", "fixture_shift", "label_swap", "outliers", "unnamed"), ()
    )


def test_what_is_identified_where_nobody_says_depends_on_what_is_known(example_campaign):
    setting = outline(example_campaign)
    bare = setting._replace(unknown_nests=(), has_orientations=False, torque_source="unknown")

    assert automatic_in(bare) == ("base", "geometry")
    assert automatic_in(bare._replace(lengths=True)) == ("geometry",)
    assert automatic_in(bare._replace(unknown_nests=(2,))) == ("base", "tool", "geometry")
    assert automatic_in(bare._replace(torque_source="masses")) == ("base", "geometry", "compliance")
    assert automatic_effects(example_campaign) == automatic_in(setting)


def test_what_an_effect_leaves_open_by_construction_it_says_itself(example_campaign):
    setting = setting_of(example_campaign, example_campaign.calibration.stops)
    names = ("base_z", "alpha_2", "c_2", "c_3", "c_5")

    said = undetermined_by_construction(("compliance", "base", "geometry"), names, setting)

    assert [entry.parameters for entry in said] == [
        ("d_1", "theta_1", "base_z", "base_rz"),
        ("d_2", "d_3"),
        ("c_1",),
        ("c_4",),
        ("c_6",),
    ]
    assert "axis 1 is parallel to gravity" in english(said[2].reason)


def test_gravity_is_known_in_the_base_of_a_robot_on_a_wall(example_campaign):
    on_a_wall = replace(example_campaign, base_nominal=FramePlacement(0.0, 0.0, 0.0, 0.0, np.pi / 2, 0.0))
    stops = example_campaign.calibration.stops

    stated = setting_of(on_a_wall, stops)
    found = setting_of(example_campaign, stops, rotation_y(np.pi / 2))

    assert stated.gravity_m_s2 == pytest.approx((9.81, 0.0, 0.0))
    assert found.gravity_m_s2 == stated.gravity_m_s2


def test_an_effect_with_all_its_parameters_leaves_nothing_open(example_campaign):
    setting = setting_of(example_campaign, example_campaign.calibration.stops)
    springs = tuple(f"c_{joint}" for joint in range(1, 7))

    assert undetermined_by_construction(("joint_offset", "compliance"), ("theta_2", *springs), setting) == ()
    assert undetermined_by_construction(("backlash",), ("gap_2",), setting) == ()


@pytest.fixture(scope="module")
def example_campaign(request):
    return read_campaign_at(request.config.rootpath / "docs" / "examples" / "campaign")
