"""What a fleet says of a robot beforehand, and an identification that takes it."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.fleet.linear import drawn
from tests.helpers.fleet.recorded import recorded_campaign
from truepose.domain.errors import ConfigurationError
from truepose.fleet.campaigns import effects_of_robot, information_of
from truepose.fleet.changes import account_of
from truepose.fleet.predicted_accuracy import of_a_new_robot, of_robot_now
from truepose.identification import identify
from truepose.identification.distributions import WITHIN_95
from truepose.identification.problem.build import JointPrior
from truepose.messages.catalogue import english


@pytest.fixture(scope="module")
def campaign():
    return recorded_campaign(15)


@pytest.fixture(scope="module")
def told(campaign):
    return information_of(campaign, effects_of_robot(campaign))


def _stated(specs):
    """Return means and widths of parameters as they are stated of any robot."""
    return (np.array([getattr(spec, name) for spec in specs]) for name in ("prior_mean", "prior_width"))


def _belief(told, seed=0, size=0.02):
    rng = np.random.default_rng(seed)
    means, widths = _stated(told.specs)
    root = size * rng.standard_normal((len(widths), len(widths)))
    covariance = (root @ root.T + 1e-3 * np.eye(len(widths))) * np.outer(widths, widths)
    return JointPrior(
        told.specs, told.owners, means + 0.05 * widths * rng.standard_normal(len(widths)), covariance
    )


def test_an_identification_with_a_belief_is_bayes_theorem(campaign, told):
    belief = _belief(told)
    precision = np.linalg.inv(belief.covariance)
    covariance = np.linalg.inv(told.normal + precision)
    expected = covariance @ (told.right + precision @ belief.mean)

    found = identify(campaign, believed=belief)

    value = {parameter.name: parameter.value for parameter in found.parameters}
    got = np.array([value[name] for name in told.names])
    # Fifteen readings leave a tenth of the widths open to their linearisation.
    assert np.abs((got - expected) / np.sqrt(np.diag(covariance))).max() < 0.02
    assert found.counts.observations == 45


def test_a_belief_that_knows_no_more_than_what_was_stated_changes_nothing(campaign, told):
    means, widths = _stated(told.specs)
    vague = JointPrior(told.specs, told.owners, means, 4.0 * np.diag(widths**2))

    found = identify(campaign, believed=vague)

    left_open = [one for one in found.parameters if one.standard_uncertainty > 0.5 * one.prior_width]
    assert not vague.beyond_stated()[0].any()
    assert left_open  # as fifteen readings leave it
    assert found.counts.observations == 45


def test_a_robot_unlike_its_type_is_said_to_be(campaign, told):
    _, widths = _stated(told.specs)
    found = np.linalg.solve(told.normal + np.diag(widths**-2.0), told.right)
    alike = JointPrior(told.specs, told.owners, found, np.diag((0.3 * widths) ** 2))
    unlike = replace(alike, mean=found + 3.0 * widths * (np.array(told.names) == "theta_3"))

    as_usual, strange = (english(identify(campaign, believed=one).message) for one in (alike, unlike))

    assert "others of its type" not in as_usual
    assert "the robot differs from others of its type, most of all in theta_3" in strange


def test_a_covariance_that_is_none_is_refused(told):
    broken = JointPrior(told.specs, told.owners, np.zeros(len(told.specs)), np.zeros((len(told.specs),) * 2))

    with pytest.raises(ConfigurationError, match="covariance of the prior must be positive definite"):
        broken.beyond_stated()


def test_a_new_robot_is_believed_to_be_as_robots_of_its_type_are():
    made = drawn(31, robots=60, readings=30, day=0.0)
    account = account_of(made.fleet())

    belief = of_a_new_robot(account)

    _, widths = _stated(belief.specs)
    spread = np.sqrt(np.diag(belief.covariance)) / widths
    # Drawn with these; 60 robots tell a spread to a tenth, and its uncertainty is added.
    assert spread == pytest.approx([0.5, 0.2, 0.3], rel=0.4)
    assert np.all(spread**2 > account.estimated.variances.robot)


def test_what_a_few_robots_show_of_their_differences_is_not_taken_at_its_word():
    beyond, drawn_of = [], np.array([0.5, 0.2, 0.3])
    for seed in range(40, 55):
        belief = of_a_new_robot(account_of(drawn(seed, robots=2, months=2, readings=30, day=0.0).fleet()))
        common = np.random.default_rng(seed).standard_normal(3)  # as the type was drawn
        means, widths = _stated(belief.specs)
        # A further robot lies about the type by what robots were drawn with.
        off = (belief.mean - means) / widths - common
        spread = np.sqrt(np.diag(belief.covariance)) / widths
        beyond.append(np.sqrt(off**2 + drawn_of**2) > WITHIN_95 * spread)

    assert np.mean(beyond) < 0.1


def test_a_measured_robot_is_known_better_than_a_new_one():
    account = account_of(drawn(32, readings=30).fleet())

    now = np.diag(of_robot_now(account, "robot 2").covariance)

    assert np.all(now < 0.3 * np.diag(of_a_new_robot(account).covariance))
