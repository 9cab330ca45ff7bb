"""Whether a cause has changed between two diagnoses, and by how much."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.diagnosis.answers import make_diagnosis, make_finding, make_wave
from truepose.diagnosis.history import DatedDiagnosis, Sighting, Variant, compare
from truepose.domain.diagnosis import Detail, RuledOut

SPRING, SUMMER, AUTUMN = "2026-03-03", "2026-06-14", "2026-10-02"


def dated(number, day, *findings, **changes):
    return DatedDiagnosis(number, day, make_diagnosis(findings=findings, ruled_out=(), **changes))


def backlash(amplitude, u=0.003, **changes):
    return make_finding(amplitude=amplitude, amplitude_standard_uncertainty=u, **changes)


def test_a_backlash_that_grew_beyond_chance_has_changed():
    (cause,) = compare([
        dated(1, SPRING, backlash(0.021, 0.0024)),
        dated(2, AUTUMN, backlash(0.033, 0.0032)),
    ])

    (change,) = cause.changes
    assert (cause.effect, cause.subject, cause.unit) == ("backlash", "joint 3", "deg")
    assert change.difference == pytest.approx(0.012)
    assert change.standard_uncertainty == pytest.approx(0.004)
    # two-sided tail of a standard normal beyond 3, any table
    assert change.p_value == pytest.approx(0.0026998, rel=1e-4)
    assert change.significant


def test_a_difference_that_noise_explains_is_no_change():
    (cause,) = compare([dated(1, SPRING, backlash(0.021)), dated(2, AUTUMN, backlash(0.018))])

    assert not cause.changes[0].significant


def test_a_small_finding_is_followed_as_any_other():
    small = make_diagnosis(findings=(make_wave(),), small=(backlash(0.004, 0.003),), ruled_out=())

    causes = compare([DatedDiagnosis(1, SPRING, small), dated(2, AUTUMN, backlash(0.033))])

    (cause,) = [one for one in causes if one.effect == "backlash"]
    assert [sign.sighting for sign in cause.signs] == [Sighting.FOUND, Sighting.FOUND]
    assert cause.changes[0].significant


def test_diagnoses_stand_in_the_order_of_their_readings_not_of_their_numbers():
    (cause,) = compare([dated(1, AUTUMN, backlash(0.033)), dated(2, SPRING, backlash(0.021))])

    assert [sign.diagnosis_id for sign in cause.signs] == [2, 1]
    assert cause.changes[0].difference > 0.0


def test_many_small_steps_are_seen_from_first_to_last():
    (cause,) = compare([
        dated(1, SPRING, backlash(0.020)),
        dated(2, SUMMER, backlash(0.027)),
        dated(3, AUTUMN, backlash(0.036)),
    ])

    # each step is about 2 u, the whole way almost 4
    assert [change.significant for change in cause.changes] == [False, False]
    assert (cause.overall.from_id, cause.overall.to_id, cause.overall.significant) == (1, 3, True)


def test_tests_share_one_level():
    joints = [f"joint {k}" for k in range(1, 7)]
    before = [backlash(0.020, subject=joint) for joint in joints]
    after = [backlash(0.020 + (0.010 if joint == "joint 3" else 0.0), subject=joint) for joint in joints]

    alone = compare([dated(1, SPRING, before[2]), dated(2, AUTUMN, after[2])])
    among_six = compare([dated(1, SPRING, *before), dated(2, AUTUMN, *after)])

    p = alone[0].changes[0].p_value
    assert among_six[2].changes[0].p_value == pytest.approx(6 * p)  # Holm: the smallest of six
    assert alone[0].changes[0].significant
    assert not among_six[2].changes[0].significant


def test_no_change_is_seen_more_often_than_the_level_allows():
    rng = np.random.default_rng(5)
    false_alarms = 0
    for _ in range(400):
        days = [
            dated(
                k,
                f"2026-0{k}-01",
                *(backlash(0.02 + 0.003 * rng.normal(), subject=f"joint {j}") for j in (1, 2)),
            )
            for k in (1, 2, 3)
        ]
        causes = compare(days)
        false_alarms += any(
            change.significant for cause in causes for change in (*cause.changes, cause.overall)
        )

    # Holm keeps 5 % whatever depends on what; 20 expected at most, standard deviation below 4.4
    assert false_alarms <= 20 + 3 * 4.4


@pytest.mark.parametrize(
    ("changes", "sighting"),
    [
        ({"ruled_out": (RuledOut("backlash", "joint 3", "no sign of it", 0.4),)}, Sighting.NOT_FOUND),
        ({"ruled_out": (RuledOut("backlash", "", "one direction only", None, False),)}, Sighting.NOT_VISIBLE),
        ({"ruled_out": (RuledOut("backlash", "joint 2", "no sign of it", 0.4),)}, Sighting.NOT_MENTIONED),
        ({"start_effects": ("base", "geometry", "backlash")}, Sighting.PART_OF_START),
        ({"findings": (make_finding(subject="joints"),)}, Sighting.WITH_OTHERS),
    ],
)
def test_what_was_not_found_is_not_taken_for_zero(changes, sighting):
    earlier = DatedDiagnosis(1, SPRING, make_diagnosis(**{"findings": (), "ruled_out": (), **changes}))

    causes = compare([earlier, dated(2, AUTUMN, backlash(0.033))])

    (joint,) = (cause for cause in causes if cause.subject == "joint 3")
    assert [sign.sighting for sign in joint.signs] == [sighting, Sighting.FOUND]
    assert joint.signs[0].amplitude is None
    assert joint.changes == ()


def test_waves_are_compared_order_by_order():
    two_waves = make_wave(
        details=(
            Detail("order", 2.0, "1", 0.0),
            Detail("amplitude", 0.010, "deg", 0.001),
            Detail("phase", 5.0, "deg", 1.0),
            Detail("order", 101.0, "1", 0.0),
            Detail("amplitude", 0.029, "deg", 0.002),
        )
    )

    causes = compare([dated(1, SPRING, make_wave(order=2.0)), dated(2, AUTUMN, two_waves)])

    second, high = causes
    assert (second.variant, high.variant) == (Variant("order", 2.0), Variant("order", 101.0))
    assert second.changes[0].difference == pytest.approx(0.010 - 0.029)
    assert high.changes == ()


def test_couplings_are_compared_by_the_joint_that_drags():
    from_5 = make_finding(
        effect="joint_coupling",
        subject="joint 6",
        unit="rad/rad",
        details=(Detail("source joint", 5.0, "1", 0.0),),
    )
    from_both = replace(
        from_5,
        details=(
            Detail("source joint", 4.0, "1", 0.0),
            Detail("coupling", 0.001, "rad/rad", 0.0001),
            Detail("source joint", 5.0, "1", 0.0),
            Detail("coupling", 0.071, "rad/rad", 0.004),
        ),
    )

    causes = compare([dated(1, SPRING, from_5), dated(2, AUTUMN, from_both)])

    assert [cause.variant for cause in causes] == [Variant("source joint", 5.0), Variant("source joint", 4.0)]
    assert causes[0].changes[0].difference == pytest.approx(0.05)


def test_a_joint_is_found_again_among_several_that_share_a_cause():
    shared = backlash(
        0.050,
        subject="joints",
        details=tuple(Detail(f"gap of joint {k}", 0.01 * k, "deg", 0.002) for k in (3, 4, 5)),
    )

    causes = compare([dated(1, SPRING, backlash(0.021)), dated(2, AUTUMN, shared)])

    assert [cause.subject for cause in causes] == ["joint 3", "joint 4", "joint 5"]
    assert causes[0].changes[0].difference == pytest.approx(0.009)


def test_details_in_another_unit_are_no_amplitudes_of_their_own():
    sag = make_finding(
        effect="link_bending",
        subject="links",
        unit="mm",
        details=(Detail("1/EI of link 2", 1e-9, "1/(N*mm2)", 1e-10),),
    )

    (cause,) = compare([dated(1, SPRING, sag), dated(2, AUTUMN, sag)])

    assert (cause.subject, cause.changes[0].difference) == ("links", 0.0)


def test_amplitudes_in_different_units_are_not_subtracted():
    causes = compare([dated(1, SPRING, backlash(0.021)), dated(2, AUTUMN, backlash(0.021, unit="mrad"))])

    assert [cause.unit for cause in causes] == ["deg", "mrad"]
    assert [cause.changes for cause in causes] == [(), ()]


@pytest.mark.parametrize(("effect", "subject"), [("base_shift", "base"), ("unnamed", "joint 3, time, jump")])
def test_two_jumps_are_two_events_and_no_change(effect, subject):
    jump = make_finding(effect=effect, subject=subject, amplitude=0.08, unit="mm")

    (cause,) = compare([dated(1, SPRING, jump), dated(2, AUTUMN, replace(jump, amplitude=0.5))])

    assert [sign.amplitude for sign in cause.signs] == [0.08, 0.5]
    assert cause.changes == ()


@pytest.mark.parametrize("unknown", [0.0, math.nan])
def test_without_an_uncertainty_nothing_is_tested(unknown):
    (cause,) = compare([
        dated(1, SPRING, backlash(0.021, unknown)),
        dated(2, AUTUMN, backlash(0.05, unknown)),
    ])

    assert (cause.changes[0].p_value, cause.changes[0].significant) == (None, False)


def test_nothing_found_is_nothing_to_compare():
    assert compare([]) == ()
    assert compare([dated(1, SPRING), dated(2, AUTUMN)]) == ()


def test_what_nobody_dated_stands_last_and_is_subtracted_from_nothing():
    (cause,) = compare([
        dated(1, None, backlash(0.5)),
        dated(2, AUTUMN, backlash(0.033)),
        dated(3, SPRING, backlash(0.021)),
        dated(4, None, backlash(0.9)),
    ])

    assert [sign.diagnosis_id for sign in cause.signs] == [3, 2, 1, 4]
    assert [(change.from_id, change.to_id) for change in cause.changes] == [(3, 2)]
    assert cause.overall is None
