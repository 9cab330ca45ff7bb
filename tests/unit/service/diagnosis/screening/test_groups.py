"""Which picks make one finding."""

from truepose.diagnosis.screening.selection import group_by_subject
from truepose.effects.causes import Candidate


def pick(effect, subject, variant=0.0):
    return Candidate(effect, subject, (), variant)


def waves(*orders, joint=4):
    return [pick("joint_harmonics", f"joint {joint}", order) for order in orders]


def test_causes_and_subjects_stand_apart_in_the_order_in_which_they_were_found():
    picks = [pick("joint_gain", "joint 5"), pick("base_drift", "base"), pick("joint_gain", "joint 2")]

    assert group_by_subject(picks) == (
        ("joint 5", (picks[0],)),
        ("base", (picks[1],)),
        ("joint 2", (picks[2],)),
    )


def test_two_orders_of_one_joint_are_two_findings():
    picks = waves(2.0, 7.0)

    assert group_by_subject(picks) == (("joint 4", (picks[0],)), ("joint 4", (picks[1],)))


def test_many_orders_of_one_joint_are_one_finding_and_another_joint_keeps_its_own():
    many, other = waves(1.0, 2.0, 3.0), waves(2.0, joint=6)

    assert group_by_subject([*many, *other]) == (("joint 4", tuple(many)), ("joint 6", tuple(other)))


def test_two_joints_with_backlash_are_named_one_by_one():
    picks = [pick("backlash", "joint 2"), pick("backlash", "joint 3")]

    assert [subject for subject, _ in group_by_subject(picks)] == ["joint 2", "joint 3"]


def test_three_joints_with_backlash_share_it():
    picks = [pick("backlash", f"joint {joint}") for joint in (2, 3, 5)]

    assert group_by_subject(picks) == (("joints", tuple(picks)),)


def test_a_joint_beside_all_joints_belongs_to_them():
    picks = [pick("compliance_nonlinear", "joints"), pick("compliance_nonlinear", "joint 2")]

    assert group_by_subject(picks) == (("joints", tuple(picks)),)


def test_gains_of_three_joints_are_three_causes():
    # every gear has its own ratio; nothing makes them wrong together
    picks = [pick("joint_gain", f"joint {joint}") for joint in (2, 3, 5)]

    assert len(group_by_subject(picks)) == 3


def test_nothing_picked_is_nothing_found():
    assert group_by_subject([]) == ()
