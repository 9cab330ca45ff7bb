"""Effects that say no load changes them are asked once: they must not look at loads or frames."""

import numpy as np
import pytest

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.models import EXTENSIONS, extended, stops_and_nests
from truepose.effects.ports import Port, Rows, Trait
from truepose.effects.registry import effect_named, effects_with, summed_effects
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


@pytest.mark.parametrize("effect", sorted(summed_effects()))
def test_what_adds_itself_up_says_the_same_as_its_terms(effect):
    names = tuple(f"wave_{j}_{o}_{part}" for j in (2, 5) for o in range(1, 41) for part in ("sin", "cos"))
    names += ("wave_1_2.5_sin", "wave_1_100_cos", "wave_3_7_sin")
    values = np.random.default_rng(0).standard_normal(len(names))

    sums = summed_effects()[effect].sums(names, values, rows(None))

    terms: dict[Port, np.ndarray] = {}
    for term in effect_named(effect).terms(names, rows(None)):
        terms[term.port] = terms.get(term.port, 0.0) + term.weight * values[term.parameter]
    assert sums.keys() == terms.keys()
    for port, total in terms.items():  # eighty waves of about 1, whose angles are rounded forty times
        assert sums[port] == pytest.approx(total, abs=1e-11)


@pytest.mark.parametrize("effect", sorted(summed_effects()))
def test_without_parameters_nothing_adds_up(effect):
    assert summed_effects()[effect].sums((), np.zeros(0), rows(None)) == {}
