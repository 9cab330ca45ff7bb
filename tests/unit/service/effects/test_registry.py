"""The registry is the only place that lists effects: no other room asks for one by name."""

import ast

import pytest

from tests.helpers.checkout import CHECKOUT
from truepose.effects.registry import CAUSES

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
