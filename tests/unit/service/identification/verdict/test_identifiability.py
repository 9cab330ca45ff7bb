"""What the data leave open, on cases made by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from tests.helpers.domain.robots import IRB_120
from truepose.domain.robot import JointRow, Robot
from truepose.effects.ports import ParameterSpec, Setting
from truepose.identification.fit.solver import posterior_covariance
from truepose.identification.model.structure import Structure
from truepose.identification.verdict.identifiability import _reason, not_identifiable
from truepose.messages.catalogue import english

ROBOT = Robot("skew", tuple(JointRow(0.0 if k == 0 else 1.5, 100.0, 0.0, 50.0) for k in range(4)))
SETTING = Setting(ROBOT, (), has_orientations=False, torque_source="masses", largest_torque_n_mm=np.zeros(4))
ALL_MOVED = np.ones(4, dtype=bool)


def named(jacobian, names, widths=None, moved=ALL_MOVED):
    """What is said of parameters with these whitened derivatives, shape (P, m)."""
    widths = np.ones(len(names)) if widths is None else np.asarray(widths)
    structure = Structure(
        robot=ROBOT,
        base_rotation=np.eye(3),
        base_origin_mm=np.zeros(3),
        nests_mm=np.zeros((1, 3)),
        tool_rotation=np.eye(3),
        gravity_m_s2=np.zeros(3),
        effects=("geometry",),
        specs=tuple(ParameterSpec(name, "mm", 0.0, float(w)) for name, w in zip(names, widths, strict=True)),
        owners=("geometry",) * len(names),
    )
    covariance = posterior_covariance(np.asarray(jacobian), 1.0 / widths**2)
    return not_identifiable(structure, covariance, np.asarray(jacobian), SETTING, moved)


def test_what_is_seen_well_is_not_mentioned():
    assert named(np.diag([100.0, 50.0, 10.0]), ["a_3", "a_4", "x"]) == ()


def test_two_pairs_seen_only_together_are_named_as_two_pairs():
    jacobian = np.array([[50.0, 0, 0], [50.0, 0, 0], [0, 30.0, 0], [0, -30.0, 0], [0, 0, 20.0]])

    groups = [entry.parameters for entry in named(jacobian, ["a_3", "a_4", "alpha_3", "alpha_4", "x"])]

    assert sorted(groups) == [("a_3", "a_4"), ("alpha_3", "alpha_4")]


def test_what_moves_nothing_is_named_alone():
    (entry,) = named(np.array([[50.0, 0.0], [0.0, 0.0]]), ["a_3", "a_4"])

    assert entry.parameters == ("a_4",)
    assert "its value comes from its prior" in english(entry.reason)


def test_half_the_prior_width_is_the_border():
    # posterior variance 1 / (1 + j^2) of the squared width: one quarter at j^2 = 3
    below, above = named([[np.sqrt(3.1)]], ["a_3"]), named([[np.sqrt(2.9)]], ["a_3"])

    assert below == ()
    assert [entry.parameters for entry in above] == [("a_3",)]


def test_parameters_of_other_units_are_judged_by_their_own_widths():
    # seen a hundred times better than believed, in numbers of 1e-8
    assert named(np.diag([1e10, 100.0]), ["c_3", "a_3"], widths=[1e-8, 1.0]) == ()


def test_a_joint_that_stood_still_is_the_reason_given():
    jacobian = np.array([[50.0, 0], [50.0, 0]])

    (entry,) = named(jacobian, ["theta_3", "theta_4"], moved=np.array([True, True, False, True]))

    assert english(entry.reason).startswith("joint 3 never moved")


@pytest.mark.parametrize(
    ("members", "joints"), [(("theta_2", "a_3"), (2,)), (("d_5",), (4,)), (("theta_2", "d_5"), (2, 4))]
)
def test_joints_that_stood_still_are_named_where_their_own_or_the_next_link_is_open(members, joints):
    moved = np.array([True, False, True, False, True, True])

    found = _reason(members, SimpleNamespace(robot=IRB_120), moved)

    assert found.key == "open.standing_joints"
    assert dict(found.values) == {"n": len(joints), "joints": joints}
