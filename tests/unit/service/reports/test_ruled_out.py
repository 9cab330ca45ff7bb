from dataclasses import replace

from truepose.domain.diagnosis import RuledOut
from truepose.reports.diagnosis.rows import ruled_out_table, subjects


def entry(subject, reason="nothing", p_value=0.5, effect="joint_gain"):
    return RuledOut(effect, subject, reason, p_value)


def rows_of(entries):
    return ruled_out_table(entries, tried=True).rows


def test_subjects_with_the_same_reason_share_a_row():
    rows = rows_of([
        entry("joint 1", p_value=0.9),
        entry("joint 2", p_value=0.03),
        entry("joint 3", "other"),
    ])

    assert [(cause, cause.remark, reason, p_value) for cause, reason, p_value, _ in rows] == [
        ("joint gain", "joints 1, 2", "nothing", "0.03 to 0.9"),
        ("joint gain", "joint 3", "other", "0.5"),
    ]


def test_equal_values_are_said_once_and_missing_ones_not_at_all():
    equal = rows_of([entry("joint 1"), entry("joint 2"), entry("joint 3", p_value=None)])
    missing = rows_of([entry("joint 1", p_value=None)])

    assert equal[0][2] == "0.5"
    assert missing[0][2] == "–"  # noqa: RUF001 - as it is printed


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

    assert rows_of(entries)[0][3] == "0.0300 mm"
    assert rows_of(entries[1:2])[0][3] == "–"  # noqa: RUF001 - as it is printed
