"""What is promised and planned with what a fleet says, in the cell of the simulated arm."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eigvalsh
from scipy.stats import ncx2

from tests.helpers.fleet.recorded import recorded_campaign
from truepose.domain.errors import ConfigurationError
from truepose.exchange.cells.file import simulated_cell
from truepose.fleet.campaigns import effects_of_robot, information_of
from truepose.fleet.causes import AgeingCause
from truepose.fleet.interim_check import LEVEL, of_one_mm, quick_check
from truepose.fleet.predicted_accuracy import lacking_mm, promise
from truepose.fleet.sentences import new_robot_said
from truepose.identification.problem.build import JointPrior
from truepose.messages.catalogue import english
from truepose.planning.prediction.expected_covariance import ArmKnowledge, PriorKnowledge
from truepose.planning.workspace.candidates import draw_candidates
from truepose.planning.workspace.space import space_to_measure

_LIMIT_MM = 0.05


@pytest.fixture(scope="module")
def cell():
    return simulated_cell("irb120-clean", 0)


@pytest.fixture(scope="module")
def space(cell):
    return space_to_measure(cell, -0.0872664626)


@pytest.fixture(scope="module")
def knowns(cell):
    return PriorKnowledge(fixed_nests=cell.fixed_nests)


@pytest.fixture(scope="module")
def campaign():
    return recorded_campaign(60)


@pytest.fixture(scope="module")
def belief(campaign):
    """Robots of the type differ by a fiftieth of what is stated, and have one wave."""
    told = information_of(campaign, effects_of_robot(campaign))
    widths = np.array([spec.prior_width for spec in told.specs])
    mean = np.array([spec.prior_mean for spec in told.specs])
    mean = np.where(np.array(told.names) == "wave_6_100_sin", 5e-4, mean)
    return JointPrior(told.specs, told.owners, mean, np.diag((0.02 * widths) ** 2))


@pytest.fixture(scope="module")
def planned(space, belief, knowns):
    """Return what plans a check of the wave, from so many candidates."""

    def check(count, seed, limit_mm=_LIMIT_MM, causes=None):
        candidates = draw_candidates(space, count, np.random.default_rng(seed))
        asked = [_wave(belief)] if causes is None else causes
        return quick_check(space, candidates, belief, asked, limit_mm, knowns)

    return check


def _wave(belief):
    place = [belief.names.index(f"wave_6_100_{part}") for part in ("sin", "cos")]
    return AgeingCause("joint_harmonics", "joint 6", np.eye(len(belief.names) + 1)[:, place], 100.0)


def test_few_readings_with_the_type_promise_more_than_many_without(space, belief, campaign, knowns):
    found = promise(space, belief, campaign, knowns=knowns)

    assert (found.pooled.n, found.alone.n) == (15, 50)
    assert found.pooled.mean_mm < found.alone.mean_mm
    assert lacking_mm(belief, campaign) > 0.02  # the wave alone is 0.5 mrad on a lever of some 100 mm
    assert found.is_worth
    assert found.needed > 20  # a robot's 90 parameters from what is stated of any robot
    assert found.same_mm > 2.0 * found.pooled.mean_mm
    sentence = english(new_robot_said(found))
    assert f"{found.pooled.mean_mm:.3f} mm with 15 configurations and the type data" in sentence
    assert f"the same parameters need {found.needed} configurations" in sentence


def test_a_type_whose_robots_have_nothing_in_common_saves_no_reading(space, belief, campaign, knowns):
    widths = np.array([spec.prior_width for spec in belief.specs])
    means = np.array([spec.prior_mean for spec in belief.specs])
    wild = replace(belief, mean=means, covariance=np.diag((1.01 * widths) ** 2))

    found = promise(space, wild, campaign, readings=8, without=12, knowns=knowns)

    assert not found.is_worth
    assert found.same_mm == pytest.approx(found.pooled.mean_mm, rel=1e-6)
    assert "save no readings for another robot: 8 configurations give" in english(new_robot_said(found))


def test_a_type_of_which_nothing_is_believed_beyond_the_usual_lacks_nothing(belief, campaign):
    usual = [k for k, owner in enumerate(belief.owners) if owner in {"geometry", "compliance"}]
    few = JointPrior(
        tuple(belief.specs[k] for k in usual),
        tuple(belief.owners[k] for k in usual),
        belief.mean[usual],
        belief.covariance[np.ix_(usual, usual)],
    )

    assert lacking_mm(few, campaign) == 0.0


def test_a_quick_check_tells_what_was_asked_with_few_configurations(planned):
    found = planned(150, seed=0)

    assert found.enough
    assert 1 <= len(found.nest) < 40


@pytest.mark.parametrize(("left_out", "shows"), [(0, True), (1, False)])
def test_a_quick_check_shows_what_was_asked_with_95_percent_and_no_fewer_configurations_do(
    space, belief, knowns, left_out, shows
):
    candidates = draw_candidates(space, 60, np.random.default_rng(1))
    cause = _wave(belief)
    found = quick_check(space, candidates, belief, [cause], _LIMIT_MM, knowns)
    knowledge = ArmKnowledge(space, candidates, knowns.believing(belief))
    place = [knowledge.structure.index_of(f"wave_6_100_{part}") for part in ("sin", "cos")]
    n = len(found.nest) - left_out
    # As one regression: the wave as it was, with what is believed of it, and a second one on top of it.
    rows = knowledge.told(found.joints_rad[:n], found.nest[:n]).rows.reshape(3 * n, -1)
    both = np.hstack([rows, rows[:, place]])
    prior = np.zeros((both.shape[1],) * 2)
    prior[: rows.shape[1], : rows.shape[1]] = knowledge.prior()
    motion = knowledge.places(candidates.joints_rad, candidates.nest).motion[:, :, place]
    moved = np.einsum("ndq,ndr->qr", motion, motion) / len(motion)  # mm2 that a wave of any phase moves
    prior[rows.shape[1] :, rows.shape[1] :] = moved / _LIMIT_MM**2
    both_known = np.linalg.inv(np.linalg.inv(both.T @ both + prior)[-2:, -2:])
    alone = both_known - moved / _LIMIT_MM**2  # what readings say of a growth
    least = eigvalsh(alone, moved)[0]  # of 1 mm, in the phase in which it shows least
    beyond = ncx2.isf(LEVEL, 2, 0.0)

    assert (ncx2.sf(beyond, 2, _LIMIT_MM**2 * least) >= 0.95) == shows


def test_a_larger_growth_needs_fewer_configurations(planned):
    fine, coarse = (planned(100, seed=2, limit_mm=limit_mm) for limit_mm in (0.05, 0.2))

    assert len(coarse.nest) < len(fine.nest)


def test_what_cannot_be_told_is_said_not_to_be(planned):
    assert not planned(20, seed=3, limit_mm=1e-4).enough


def test_an_instruments_scale_is_no_part_of_a_quick_check(planned, belief):
    wave = _wave(belief)
    scale = replace(wave, directions=np.zeros_like(wave.directions))

    with pytest.raises(ConfigurationError, match="not of the scale of an instrument"):
        planned(20, seed=2, causes=[wave, scale])


def test_a_quick_check_of_nothing_is_refused(planned):
    with pytest.raises(ConfigurationError, match="at least one cause"):
        planned(20, seed=2, causes=[])


def test_a_cause_that_moves_the_tool_by_rounding_alone_moves_nothing():
    spring = np.array([[0.0], [1.0]])  # about a plumb axis, which gravity does not load

    still = of_one_mm(spring, np.diag([0.01, 1e-32]))
    moving = of_one_mm(spring, np.diag([0.01, 0.25]))

    assert not still.any()
    np.testing.assert_allclose(moving, 2.0 * spring)
