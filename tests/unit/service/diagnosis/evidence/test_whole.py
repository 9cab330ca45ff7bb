"""The whole model: what it describes beside the findings is told once, by its place, the largest first."""

import numpy as np
import pytest

from tests.helpers.diagnosis.selections import everything, make_start, select_from, those_of
from truepose.diagnosis.evidence.sensitivities import CompleteModel, effect_of, worth_of
from truepose.diagnosis.evidence.signature_functions import signatures_in_data
from truepose.diagnosis.screening.candidates import pool_candidates
from truepose.diagnosis.screening.selection import names_of, refit_picks

CURVE = {
    f"wave_2_{order}_{part}": np.deg2rad(0.02) / order for order in (1, 2, 3, 4) for part in ("sin", "cos")
}


@pytest.fixture(scope="module")
def start():
    return make_start({"joint_harmonics": CURVE, "joint_gain": {"gain_4": 1e-3}}, n=120)


@pytest.fixture(scope="module")
def selected(start):
    """Only the gain of joint 4 could be picked."""
    return select_from(
        start, lambda fit: [one for one in those_of(start, "joint_gain")(fit) if one.names == ("gain_4",)]
    )


@pytest.fixture(scope="module")
def whole(start, selected):
    pool = pool_candidates(selected.fit, (*selected.picks, *everything(start)(selected.fit)))
    found = signatures_in_data(pool, selected.picks)
    return CompleteModel(refit_picks(start.fit, selected.fit, found.candidates), found.candidates)


def test_what_is_described_is_told_by_its_place_the_largest_first(whole, selected):
    told = whole.beside(selected)

    own = [one.worth.own_mm for one in told]
    assert (told[0].where, told[0].over) == ("joint 2", "angle of joint 2")
    assert own == sorted(own, reverse=True)
    assert len({(one.where, one.over) for one in told}) == len(told)


def test_a_pick_has_its_own_finding_and_is_not_told_again(whole, selected):
    assert names_of(selected.picks) == ("gain_4",)
    assert set(names_of(selected.picks)) <= set(names_of(whole.cells))

    assert ("joint 4", "angle of joint 4") not in {(one.where, one.over) for one in whole.beside(selected)}


def test_a_model_of_nothing_but_findings_describes_nothing(selected):
    assert CompleteModel(selected.fit, selected.picks).beside(selected) == ()


def test_what_the_other_parameters_can_take_over_is_not_its_own(selected):
    worth = worth_of(selected, ("gain_4",))

    # An offset of joint 4 takes over its mean turn; the turn about that mean is the gain's own.
    alone = np.sqrt((np.linalg.norm(effect_of(selected, ("gain_4",)), axis=1) ** 2).mean())
    assert 0.5 * alone < worth.own_mm < alone
