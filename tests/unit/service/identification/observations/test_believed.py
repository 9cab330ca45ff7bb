"""How far a robot lies off what is believed of its type: chances are as often small as they say."""

from types import SimpleNamespace

import numpy as np
import pytest

from truepose.identification.observations.joint_priors import belief_block

NAMES = ("a_2", "a_3", "theta_4")
ROBOTS = 400


def drawn_covariance(rng, size):
    root = size * rng.standard_normal((3, 3))
    return root @ root.T + 0.01 * size**2 * np.eye(3)


def unlikeness(mean, believed, estimate, covariance):
    block = belief_block(NAMES, (np.eye(3), mean), (mean, believed), 6)
    # A parameter that no belief is of stands between those that one is of.
    structure = SimpleNamespace(names=("a_2", "base_x", "a_3", "theta_4"))
    whole = np.insert(np.insert(covariance, 1, 0.0, axis=0), 1, 0.0, axis=1)
    return block.unlikeness(structure, np.insert(estimate, 1, 7.0), whole)


def measured(rng, mean, believed, robot, read):
    """Return estimate and covariance of a robot from `read` sums of its parameters with noise of 1."""
    rows = rng.standard_normal((read, 3))
    values = rows @ robot + rng.standard_normal(read)
    precision = np.linalg.inv(believed)
    covariance = np.linalg.inv(precision + rows.T @ rows)
    return covariance @ (precision @ mean + rows.T @ values), covariance


@pytest.mark.parametrize("read", [1, 2, 8])
def test_robots_of_the_type_are_as_far_off_as_chance_has_it(read):
    from scipy.stats import kstest  # takes each process that collects this a quarter of a second

    rng = np.random.default_rng(read)
    mean, believed = rng.standard_normal(3), drawn_covariance(rng, 2.0)
    robots = rng.multivariate_normal(mean, believed, ROBOTS)

    chances = [unlikeness(mean, believed, *measured(rng, mean, believed, one, read)).chance for one in robots]

    assert kstest(chances, "uniform").pvalue > 1e-3


def test_one_that_is_not_is_named_by_what_is_off_most():
    rng = np.random.default_rng(5)
    mean, believed = np.zeros(3), np.diag([0.5, 0.5, 0.5])

    off = unlikeness(mean, believed, *measured(rng, mean, believed, np.array([0.0, 9.0, 0.0]), 20))

    assert off.chance < 1e-9
    assert off.parameter == "a_3"
    assert off.off_u > 5.0


def test_what_no_reading_told_speaks_against_nothing():
    mean, believed = np.ones(3), np.eye(3)

    assert unlikeness(mean, believed, mean, believed).chance == 1.0
