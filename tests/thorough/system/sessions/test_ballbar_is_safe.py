"""A thousand sessions in which persons do anything and anything fails: nothing moves that must not."""

import pytest

from tests.helpers.ballbar.crowd import PLAN, SPHERE, require_safe, went_well

SESSIONS = 1000
GROUPS = 20  # of sessions, so that a failure names few
SPHERES = 100  # more, of a sphere test


@pytest.fixture(scope="module")
def whole():
    """The ledger of a six-leg session in which all went well."""
    return went_well(PLAN)


@pytest.mark.parametrize("group", range(GROUPS))
def test_nothing_moves_that_must_not_and_no_reading_is_lost_or_doubled(whole, group):
    seeds = range(group * SESSIONS // GROUPS, (group + 1) * SESSIONS // GROUPS)

    require_safe(PLAN, whole, seeds)


def test_nor_in_a_sphere_test():
    require_safe(SPHERE, went_well(SPHERE), range(SPHERES))
