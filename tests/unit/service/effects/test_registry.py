"""The registry is the only place that lists effects: no other room asks for one by name."""

import ast
from dataclasses import replace

import pytest

from tests.helpers.checkout import CHECKOUT
from tests.helpers.diagnosis.point_scenes import telling_campaign
from truepose.domain.errors import ConfigurationError
from truepose.effects.registry import (
    CAUSES,
    EFFECTS,
    chosen_effects,
    compliant_effects,
    unmodelled_in,
    unusable_causes,
)
from truepose.identification.problem.problem_setup import setting_of

_ROOMS = ("kinematics", "identification", "diagnosis", "fleet", "planning", "validation", "correction")
_OWN_LIST = "thesis_procedure.py"  # a procedure is the effects that its author chose


@pytest.mark.parametrize("room", _ROOMS)
def test_no_room_of_the_numerics_names_a_cause(room):
    files = (CHECKOUT / "service" / "truepose" / room).rglob("*.py")
    texts = {file.name: file.read_text(encoding="utf-8") for file in files if file.name != _OWN_LIST}

    named = {
        (name, node.value)
        for name, text in texts.items()
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Constant) and node.value in CAUSES
    }

    assert texts
    assert not named


def test_effects_are_chosen_by_name_once_each():
    assert chosen_effects(["base", "tool"]) == ("base", "tool")
    assert chosen_effects([]) == ()
    with pytest.raises(ConfigurationError, match="'tool' is given twice"):
        chosen_effects(["tool", "base", "tool"])


def test_joints_yield_by_the_effects_that_are_springs():
    assert compliant_effects() == {name: EFFECTS[name] for name in ("compliance", "compliance_nonlinear")}
    assert unusable_causes() == ()


@pytest.mark.parametrize("source", ["masses", "measured", "unknown"])
def test_a_model_may_lack_what_no_target_rules_out(source):
    campaign = telling_campaign()
    stops = campaign.calibration.stops
    setting = setting_of(campaign, stops)._replace(torque_source=source)
    springs = ("compliance",) if source == "masses" else ()

    assert unmodelled_in(setting, stops) == ("backlash", *springs, "joint_harmonics")
    assert unmodelled_in(setting, replace(stops, direction=None)) == (*springs, "joint_harmonics")
