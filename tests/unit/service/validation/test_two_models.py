"""Two models of one robot: what changed is named, and where nothing changed nothing is."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain.builders import make_model, make_parameter, make_robot
from tests.helpers.domain.two_models import seen_by, with_values
from truepose.domain.errors import ConfigurationError
from truepose.domain.robot import FramePlacement
from truepose.validation.model_comparison import compare_models

_U = np.array([1e-4, 0.01])  # of the two parameters of `make_model`


def test_the_parameter_that_changed_is_named_and_the_other_is_not():
    earlier, later = with_values(1e-3, 0.2), with_values(1e-3, 0.3)

    found = compare_models(earlier, later, seen_by(later))

    angle, length = found.changes
    assert (length.name, length.significant, angle.significant) == ("a_3", True, False)
    assert length.difference == pytest.approx(0.1)
    assert length.standard_uncertainty == pytest.approx(0.01 * np.sqrt(2.0))
    assert found.p_value < 1e-6


def test_a_base_that_stands_elsewhere_is_no_change_of_the_robot():
    earlier = make_model()
    later = replace(earlier, base=FramePlacement(500.0, -20.0, 7.0, 0.0, 0.0, 1.0))

    found = compare_models(earlier, later, seen_by(later))

    assert not any(change.significant for change in found.changes)
    assert found.moved.max_mm < 1e-6


def test_where_the_tool_goes_now_is_what_the_earlier_model_misses():
    earlier, later = with_values(1e-3, 0.2), with_values(1e-3, 0.5)

    found = compare_models(earlier, later, seen_by(later))

    assert found.moved.mean_mm == pytest.approx(found.earlier_now.mean_mm, rel=1e-6)
    assert 0.01 < found.moved.mean_mm < 0.3
    assert found.later_now.max_mm < 1e-9


def test_parameters_that_only_one_model_has_are_told_and_not_subtracted():
    more = make_parameter(name="theta_2")
    later = make_model()
    earlier = replace(later, parameters=(*later.parameters, more), covariance=np.diag([1e-8, 1e-4, 1e-8]))

    found = compare_models(earlier, later, seen_by(later))

    assert "theta_2" in {*found.gone, *(change.name for change in found.changes)}
    assert len(found.changes) + len(found.gone) == 3 - len(found.new)


def test_models_of_different_robots_are_not_compared():
    other = make_robot(joints=make_robot().joints[:2])

    with pytest.raises(ConfigurationError, match="different nominal tables"):
        compare_models(make_model(), make_model(robot=other), seen_by(make_model()))
