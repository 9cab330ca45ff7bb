from dataclasses import replace

import pytest

from tests.helpers.diagnosis.diagnosed_cells import make_diagnosis, make_finding
from truepose.domain.diagnosis import Cause, NextMeasurement, RuledOut
from truepose.reports.diagnosis.findings import acts_alike, alternatives


def finding(effect, subject):
    return make_finding(effect=effect, subject=subject, curve=None)


def entry(effect, subject="", visible=True):
    return RuledOut(effect, subject, "why", 0.5 if visible else None, visible)


def answered(found, ruled_out, **changes):
    return alternatives(found, make_diagnosis(findings=(found,), ruled_out=ruled_out, errors=None, **changes))


@pytest.mark.parametrize(
    ("found", "other"),
    [
        (("joint_gain", "joint 2"), ("joint_harmonics", "joint 2")),  # a slow wave
        (("joint_harmonics", "joint 6"), ("joint_harmonics", "joint 5")),  # the neighbour's
        (("backlash", "joint 3"), ("compliance", "joints")),
        (("backlash", "joint 3"), ("joint_coupling", "")),
        (("payload", "tool"), ("link_mass", "links")),
        (("base_drift", "base"), ("thermal_growth", "links")),
        (("base_drift", "base"), ("instrument_drift", "tracker")),
        (("nest_offset", "nest 1"), ("label_swap", "nest 1, nest 2")),
    ],
)
def test_a_sceptic_asks_for_causes_that_act_alike(found, other):
    assert acts_alike(finding(*found), entry(*other))


@pytest.mark.parametrize(
    ("found", "other"),
    [
        (("joint_gain", "joint 2"), ("joint_harmonics", "joint 5")),
        (("joint_gain", "joint 2"), ("joint_gain", "joint 2")),  # itself
        (("outliers", "readings"), ("thermal_growth", "links")),
        (("nest_offset", "nest 1"), ("backlash", "joint 2")),
        (("backlash", "joints"), ("fixture_shift", "")),
    ],
)
def test_nobody_asks_for_causes_that_act_otherwise(found, other):
    assert not acts_alike(finding(*found), entry(*other))


def test_what_cannot_be_seen_is_told_from_what_was_excluded():
    seen, unseen = entry("joint_gain", "joint 6"), entry("backlash", visible=False)

    answer = answered(make_finding(curve=None), (seen, unseen, entry("outliers", "readings")))

    assert [cause.remark for cause, *_ in answer.excluded.rows] == [seen.subject]
    assert [cause for cause, _ in answer.not_excluded.rows] == [unseen.effect]
    assert answer.rivals == ()


def test_a_rival_is_not_said_to_be_excluded_as_well():
    rival = Cause("joint_gain", "joint 6")

    answer = answered(make_finding(confusable_with=(rival,), curve=None), (entry("joint_gain", "joint 6"),))

    assert [r.name for r in answer.rivals] == ["joint gain, joint 6"]
    assert answer.excluded.rows == []


def test_the_measurement_that_separates_both_is_named_first():
    rival, own = Cause("joint_gain", "joint 6"), Cause("joint_harmonics", "joint 6")
    proposals = (
        NextMeasurement("about others", (), (rival, Cause("payload", "tool"))),
        NextMeasurement("about both", (), (rival, own)),
    )

    answer = answered(make_finding(confusable_with=(rival,), curve=None), (), next_measurements=proposals)

    assert answer.rivals[0].separated_by == "about both"


@pytest.mark.parametrize(("effect", "subject"), [("ballbar_zero", "ballbar"), ("fixture_shift", "")])
@pytest.mark.parametrize(("quantity", "asked"), [("position", 0), ("length", 1)])
def test_where_no_ballbar_was_nobody_asks_for_what_it_does(quantity, asked, effect, subject):
    unseen = entry(effect, subject, visible=False)

    answer = answered(finding("thermal_growth", "links"), (unseen,), quantity=quantity)

    assert len(answer.not_excluded.rows) == asked


@pytest.mark.parametrize(
    ("cell", "alike"),
    [
        ("joint 3, time, jump", True),  # the same place
        ("tracker, time, jump", False),
        ("joint 5, angle of joint 2, wave", False),
    ],
)
def test_cells_without_a_name_are_alike_where_place_or_variable_is_the_same(cell, alike):
    found = replace(finding("backlash", "joint 3"), where="joint 3", over="direction")

    assert acts_alike(found, entry("unnamed", cell)) is alike


def test_a_cause_without_a_name_is_asked_for_the_named_ones_of_its_place():
    found = replace(finding("unnamed", "joint 3, time, jump"), where="joint 3", over="time")

    assert acts_alike(found, entry("backlash", "joint 3"))
    assert not acts_alike(found, entry("backlash", "joint 4"))
    assert not acts_alike(found, entry("unnamed", "joint 3, time, jump"))
