from dataclasses import replace

from truepose.domain.results.diagnosis import RuledOut
from truepose.reports.causes_found.ruled_out import ruled_out_rows, subjects


def entry(subject, reason="nothing", p_value=0.5, effect="joint_gain"):
    return RuledOut(effect, subject, reason, p_value)


def test_subjects_with_the_same_reason_share_a_row():
    rows = ruled_out_rows([
        entry("joint 1", p_value=0.9),
        entry("joint 2", p_value=0.03),
        entry("joint 3", "other"),
    ])

    assert [(row.effect, row.subjects, row.reason, row.p_value) for row in rows] == [
        ("joint gain", "joints 1, 2", "nothing", "0.03 to 0.9"),
        ("joint gain", "joint 3", "other", "0.5"),
    ]


def test_equal_values_are_said_once_and_missing_ones_not_at_all():
    equal = ruled_out_rows([entry("joint 1"), entry("joint 2"), entry("joint 3", p_value=None)])
    missing = ruled_out_rows([entry("joint 1", p_value=None)])

    assert equal[0].p_value == "0.5"
    assert missing[0].p_value == "–"  # noqa: RUF001 - as it is printed


def test_subjects_of_all_kinds_make_one_phrase():
    assert (
        subjects(["joint 1", "tool", "joint 4", "nest 1, nest 2", ""]) == "joints 1, 4; tool; nest 1, nest 2"
    )
    assert subjects([""]) == ""
    assert subjects(["joint 2", "joint 2"]) == "joint 2"
    assert subjects(["joint 10", "joint 2"]) == "joints 2, 10"
    assert subjects(["joint 3, time, jump", "joint 1, time, jump", "joint 1, time, drift"]) == (
        "joints 1, 3, time, jump; joint 1, time, drift"
    )


def test_a_hundred_nests_do_not_fill_the_page():
    phrase = subjects(f"nest {k}" for k in range(1, 101))

    assert phrase == "nests 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12 and 88 more"


def test_of_several_subjects_the_largest_limit_is_told():
    entries = [
        replace(entry(f"joint {k}"), upper_limit_mm=limit) for k, limit in enumerate((0.012, None, 0.03))
    ]

    assert ruled_out_rows(entries)[0].at_most == "0.0300 mm"
    assert ruled_out_rows(entries[1:2])[0].at_most == "–"  # noqa: RUF001 - as it is printed
