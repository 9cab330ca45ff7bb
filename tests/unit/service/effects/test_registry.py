"""The registry is the only place that lists effects: no other room asks for one by name."""

import ast

import pytest

from tests.helpers.checkout import CHECKOUT
from truepose.domain.errors import ConfigurationError
from truepose.effects.registry import CAUSES, EFFECTS, chosen_effects, compliant_effects, unusable_causes

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
    with pytest.raises(ConfigurationError, match="'tool' is named twice"):
        chosen_effects(["tool", "base", "tool"])


def test_joints_yield_by_the_effects_that_are_springs():
    assert compliant_effects() == {name: EFFECTS[name] for name in ("compliance", "compliance_nonlinear")}
    assert unusable_causes() == ()
