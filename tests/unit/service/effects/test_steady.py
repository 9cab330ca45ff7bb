"""Effects that say no load changes them are asked once: they must not look at loads or frames."""

import numpy as np
import pytest

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.models import EXTENSIONS, extended, stops_and_nests
from truepose.effects.ports import Rows, Trait
from truepose.effects.registry import effect_named, effects_with
from truepose.identification.model.estimates import structure_of


def unseen():
    raise AssertionError("a steady effect looked at the frames of the arm")


def rows(torque_n_mm):
    stops, nest = stops_and_nests(IRB_120, 20)
    gravity = np.array([0.0, 0.0, -9.81])
    return Rows(stops, nest, torque_n_mm, stops.joints_rad, unseen, gravity, IRB_120)


@pytest.mark.parametrize("effect", effects_with(Trait.STEADY))
def test_what_says_that_it_is_steady_looks_at_no_load_and_no_frame(effect):
    names = structure_of(extended(IRB_120, *({effect} & {*EXTENSIONS}))).names_of(effect)

    without = effect_named(effect).terms(names, rows(None))
    loaded = effect_named(effect).terms(names, rows(np.full((20, 6), 1e5)))

    assert [(term.parameter, term.port) for term in without] == [(t.parameter, t.port) for t in loaded]
    assert all(np.array_equal(one.weight, other.weight) for one, other in zip(without, loaded, strict=True))
