"""The study of wrong connections runs, and finds what it must."""

from tests.studies.hardening.wrong_pairs import study, table


def test_slips_of_one_robot_are_judged_before_and_after_its_pre_calibration():
    found = study(("irb120-tilted",), (6,), runs=1, draws=48)

    ((name, slips),) = found.items()
    assert slips["before single"] == slips["before exchanged"] == 5
    assert slips["before repeated, asked at its pose"] >= 4
    assert slips["before right"] > 20
    assert slips["after right"] > 0
    assert table(found).startswith(name)
