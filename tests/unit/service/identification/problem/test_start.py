"""Which effects a model may be asked to start with."""

import pytest

from tests.helpers.diagnosis.point_scenes import telling_campaign
from truepose.domain.errors import ConfigurationError
from truepose.effects.registry import CAUSES
from truepose.identification.problem.build import build

SEARCHED = ("base_shift", "fixture_shift", "label_swap", "outliers", "unnamed")


@pytest.mark.parametrize("effect", SEARCHED)
def test_what_only_a_search_finds_is_refused_and_the_search_is_named(effect):
    with pytest.raises(
        ConfigurationError, match=rf"'{effect}' has no parameters .* `diagnose` searches for it"
    ):
        build(telling_campaign(), ("base", "geometry", effect))


@pytest.mark.parametrize("effect", sorted(set(CAUSES) - set(SEARCHED) - {"axis_parallelism", "ballbar_zero"}))
def test_every_other_cause_may_be_named_outright(effect):
    others = tuple(name for name in ("base", "geometry", "compliance") if name != effect)

    problem = build(telling_campaign(), (*others, effect))

    assert effect in problem.structure.owners
