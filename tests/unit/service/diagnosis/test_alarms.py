"""What a service visit looks at first, and what it does not."""

import pytest

from tests.helpers.diagnosis.answers import make_diagnosis, make_finding, make_wave
from truepose.diagnosis.alarms import CauseGrowth, NewCause, alarms
from truepose.diagnosis.history import DatedDiagnosis, compare
from truepose.domain.diagnosis import Confidence, EffectSize, RuledOut

SPRING, SUMMER, AUTUMN = "2026-03-03", "2026-06-14", "2026-10-02"
LOOKED_FOR = RuledOut("backlash", "joint 3", "chance", p_value=1.0, upper_limit_mm=0.005)


def dated(number, day, *findings, ruled_out=()):
    return DatedDiagnosis(number, day, make_diagnosis(findings=findings, ruled_out=ruled_out))


def backlash(amplitude, u=0.003, **changes):
    return make_finding(amplitude=amplitude, amplitude_standard_uncertainty=u, **changes)


def raised(*diagnoses):
    return alarms(compare(diagnoses), diagnoses)


def test_a_cause_that_grew_beyond_chance_is_an_alarm_and_one_that_fell_is_none():
    def wave(amplitude):
        return make_wave(amplitude=amplitude, amplitude_standard_uncertainty=0.002)

    (alarm,) = raised(
        dated(1, SPRING, backlash(0.021), wave(0.05)), dated(2, AUTUMN, backlash(0.045), wave(0.02))
    )

    assert isinstance(alarm, CauseGrowth)
    assert (alarm.cause.effect, alarm.change.from_id, alarm.change.to_id) == ("backlash", 1, 2)


def test_slow_growth_is_an_alarm_by_all_of_it_though_no_step_is():
    (alarm,) = raised(*[dated(n, f"2026-0{n}-01", backlash(0.020 + 0.004 * n, 0.0035)) for n in range(1, 7)])

    assert not any(change.significant for change in alarm.cause.changes)
    assert (alarm.change.from_id, alarm.change.to_id) == (1, 6)


def test_what_was_repaired_since_is_no_alarm():
    assert not raised(
        dated(1, SPRING, backlash(0.021)),
        dated(2, SUMMER, backlash(0.060)),
        dated(3, AUTUMN, backlash(0.020)),
    )


def test_what_noise_explains_is_no_alarm():
    assert not raised(dated(1, SPRING, backlash(0.021)), dated(2, AUTUMN, backlash(0.024)))


def test_a_cause_larger_than_it_can_have_been_has_appeared():
    found = backlash(0.021, worth=EffectSize(0.03, 0.05, 0.02), confidence=Confidence.CERTAIN)

    (alarm,) = raised(dated(1, SPRING, ruled_out=(LOOKED_FOR,)), dated(2, AUTUMN, found))

    assert alarm == NewCause(alarm.cause, SPRING, 0.005, AUTUMN, 0.02)


@pytest.mark.parametrize(
    ("ruled_out", "changes"),
    [
        ((), {}),  # nobody looked for it
        ((LOOKED_FOR,), {"confidence": Confidence.LIKELY}),
        ((LOOKED_FOR,), {"worth": EffectSize(0.03, 0.05, 0.006)}),  # of which 0.0043 mm are sure
        ((RuledOut("backlash", "joint 3", "not shown", visible=False),), {}),
    ],
)
def test_a_cause_that_may_have_been_there_before_is_no_alarm(ruled_out, changes):
    found = backlash(
        0.021, **{"worth": EffectSize(0.03, 0.05, 0.02), "confidence": Confidence.CERTAIN, **changes}
    )

    assert not raised(dated(1, SPRING, ruled_out=ruled_out), dated(2, AUTUMN, found))


def test_of_a_cause_of_size_zero_nothing_is_sure():
    """Its uncertainty may be anything beside it: 2e-4 mm of nothing are no share of it."""
    found = backlash(0.0, 1e-4, worth=EffectSize(0.03, 0.05, 0.02), confidence=Confidence.CERTAIN)

    assert not raised(dated(1, SPRING, ruled_out=(LOOKED_FOR,)), dated(2, AUTUMN, found))


def test_measurements_without_a_day_raise_nothing():
    found = backlash(0.045, worth=EffectSize(0.03, 0.05, 0.02), confidence=Confidence.CERTAIN)

    assert not raised(dated(1, None, backlash(0.021)), dated(2, None, found))
