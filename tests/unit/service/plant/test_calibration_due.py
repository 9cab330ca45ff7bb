"""Which robots are to be measured next: each reason with its figures, in an order that can be defended."""

from datetime import date, timedelta

import pytest

from truepose.messages.catalogue import english
from truepose.plant.calibration_due import DueAfter, DueReason, Evidence, standing_robots
from truepose.storage.caches import FleetComparison, LimitForecast
from truepose.storage.plant.overview import ResultFacts, RobotMeasured

TODAY = date(2026, 11, 23)
NUMBERS = {"campaign": 1, "model": 2, "validation": 3, "diagnosis": 4}


def day(ago):
    return (TODAY - timedelta(days=ago)).isoformat()


def robot(serial="120-1", ago=3, instrument="T-7", robot_type="IRB 120"):
    return RobotMeasured(serial, robot_type, "" if ago is None else day(ago), "left arm", instrument)


def told(kind, ago=3, verdict="", figure_mm=None, limit_mm=None, **document):
    number = NUMBERS[kind]
    return kind, ResultFacts(
        number, 1, "left arm", kind, number, "120-1", day(ago), verdict, figure_mm, limit_mm, document
    )


def reasons(*results, of=None, expires=None, due=None):
    """Return what speaks for measuring one robot, of whom some results tell something."""
    of = of or robot()
    evidence = Evidence({of.serial_number: dict(results)}, expires or {})
    (found,) = standing_robots([of], evidence, due or DueAfter(), TODAY)
    return [(reason.why, english(reason.sentence)) for reason in found.reasons]


def test_where_nothing_speaks_for_it_nothing_is_said():
    sound = [
        told("campaign", tool="plate 1", base=[0.0]),
        told("model", tool="plate 1", base=[0.0]),
        told("validation", verdict="passed", figure_mm=0.02, limit_mm=0.1),
        told("diagnosis", verdict="explained", figure_mm=0.02, asks=0),
    ]

    assert reasons(*sound, expires={"T-7": day(2)}) == []
    assert reasons(of=robot(ago=30)) == []
    assert reasons(expires={"T-8": day(400)}) == []


def test_a_validation_that_failed_says_by_how_much():
    beyond = told("validation", 3, "failed", 0.412, 0.3, promised=False)

    assert reasons(beyond) == [
        (
            DueReason.FAILED,
            "Validation 3 of 2026-11-20 failed: largest error 0.412 mm, limit 0.3 mm.",
        )
    ]


def test_without_a_limit_nothing_fails_but_a_model_that_breaks_its_promise_is_due():
    kept = told("validation", 3, "no_limit", 0.021, 0.031, promised=True)
    broken = told("validation", 3, "worse", 0.412, 0.031, promised=True)
    useless = told("validation", 3, "worse", 0.412, None, promised=True)

    assert reasons(kept) == []
    ((why, sentence),) = reasons(broken)
    assert why is DueReason.WORSE
    assert sentence.endswith(
        "mean error 0.412 mm, compared with 0.0310 mm predicted by the model; no limit was set."
    )
    assert "failed" not in sentence + reasons(useless)[0][1]


def test_a_validation_that_cannot_be_decided_is_due_and_did_not_fail():
    undecided = told("validation", 3, "undecided", 0.29, 0.3, promised=False)

    ((why, sentence),) = reasons(undecided)

    assert why is DueReason.UNDECIDED
    assert sentence.startswith(
        "Validation 3 of 2026-11-20 cannot be decided: largest error 0.290 mm, limit 0.3 mm;"
    )
    assert reasons(undecided, told("model", 2)) == []


def test_an_error_without_a_finite_figure_is_a_failure_before_all_others():
    endless = told("validation", 3, "failed", None, 0.3, promised=False)

    (found,) = reasons(endless)

    assert found == (
        DueReason.FAILED,
        "Validation 3 of 2026-11-20 failed: its error is not a finite number.",
    )
    assert reasons(endless, told("model", 2)) == []


def test_a_model_that_was_made_after_it_answers_a_failed_validation():
    failed = told("validation", 9, "failed", 0.412, 0.3, promised=False)

    assert reasons(failed, told("model", 3)) == []
    assert [why for why, _ in reasons(failed, told("model", 20))] == [DueReason.FAILED]


def test_a_certificate_counts_on_the_day_of_the_measurement():
    assert reasons(expires={"T-7": day(3)}) == []
    (found,) = reasons(expires={"T-7": day(4)})
    assert found == (
        DueReason.UNCERTIFIED,
        "Last measured on 2026-11-20 with T-7, whose certificate expired on 2026-11-19.",
    )


@pytest.mark.parametrize(
    ("now", "said"),
    [
        (
            {"tool": "plate 2", "base": [0.0]},
            "identified with plate 1: on 2026-11-20 the robot carried plate 2.",
        ),
        ({"tool": "plate 1", "base": [5.0]}, "base has been moved since model"),
        ({"tool": "plate 1", "base": [0.0]}, None),
        ({}, None),
    ],
)
def test_a_model_is_older_than_what_the_robot_carries_and_where_it_stands(now, said):
    found = reasons(told("model", 9, tool="plate 1", base=[0.0]), told("campaign", 3, **now))

    assert [why for why, _ in found] == ([DueReason.CHANGED] if said else [])
    assert said is None or said in found[0][1]


def test_a_model_made_with_what_it_carries_now_is_not_older():
    assert reasons(told("model", 3, tool="plate 2"), told("campaign", 9, tool="plate 1")) == []


def test_a_diagnosis_says_what_it_leaves_open_until_the_robot_is_measured_again():
    open_one = told("diagnosis", 3, "unexplained", 0.21, asks=2)

    assert [why for why, _ in reasons(open_one)] == [DueReason.UNEXPLAINED, DueReason.ASKED]
    assert reasons(open_one)[0][1] == (
        "Diagnosis 4 of 2026-11-20 leaves a mean error of 0.210 mm unexplained."
    )
    assert reasons(open_one, of=robot(ago=1)) == []


def test_a_type_has_its_own_interval():
    due = DueAfter(30.0, {"IRB 6700": 7.0})

    assert reasons(of=robot(ago=8), due=due) == []
    assert reasons(of=robot(ago=8, robot_type="IRB 6700"), due=due) == [
        (DueReason.OVERDUE, "Last measured on 2026-11-15, 8 days ago; due after 7 days.")
    ]


def test_the_first_is_the_most_urgent():
    robots = [
        robot("asked", 2), robot("late", 45), robot("later", 90), robot("never", None),
        robot("bad", 2), robot("worse", 2), robot("worst", 2), robot("tomorrows", -400),
        robot("unproved", 2, "T-9"), robot("fresh", 2),
    ]  # fmt: skip
    evidence = Evidence(
        {
            "asked": dict([told("diagnosis", 2, "explained", 0.02, asks=1)]),
            "bad": dict([told("validation", 2, "failed", 0.2, 0.1, promised=False)]),
            "worse": dict([told("validation", 2, "failed", 0.4, 0.1, promised=False)]),
            "worst": dict([told("validation", 2, "failed", None, 0.1, promised=False)]),
        },
        {"T-9": day(10)},
    )

    found = standing_robots(robots, evidence, DueAfter(), TODAY)

    order = ["never", "tomorrows", "worst", "worse", "bad", "unproved", "later", "late", "asked", "fresh"]
    assert [one.measured.serial_number for one in found] == order
    assert found[-1].reasons == ()


def compared(*foreseen):
    return FleetComparison("IRB 120", "2026-11-21 08:00 UTC", 7, 0.1, foreseen)


def growing(passes=60, earliest=20, since=150, last=3, serial="120-1"):
    """Return that a gap grows, and in how many days it passes the limit."""
    days = day(-passes), day(-earliest)
    return LimitForecast(serial, "backlash", "joint 5", 0.0, day(since), 0.06, 0.012, day(last), *days)


def foretold(*foreseen, of=None, due=None):
    """Return what a comparison gives as reasons."""
    robots = [of or robot()]
    (found,) = standing_robots(robots, Evidence(compared=[compared(*foreseen)]), due or DueAfter(), TODAY)
    return [(reason.why, english(reason.sentence)) for reason in found.reasons]


def test_a_robot_that_passes_a_limit_before_it_is_due_is_measured_before():
    assert foretold(growing()) == [
        (
            DueReason.WORSENING,
            "Backlash, joint 5: growing by 0.012 mm a month since 2026-06-26. This error is expected to "
            "exceed 0.1 mm about 2027-01-22; the probability that it does so before 2026-12-13 is 5 %. "
            "Measure the robot before 2026-12-13; do not wait for the due date, 2026-12-20.",
        )
    ]


def test_a_comparison_that_finds_nothing_and_one_of_others_give_no_reason():
    assert foretold() == []
    assert foretold(growing(serial="120-2")) == []


def test_a_robot_that_is_due_before_it_passes_the_limit_is_measured_in_its_time():
    assert foretold(growing(earliest=28)) == []
    assert foretold(growing(), due=DueAfter(10.0)) == []


def test_a_measurement_after_the_comparison_answers_it():
    assert foretold(growing(last=3), of=robot(ago=2)) == []


def test_a_limit_that_was_passed_says_since_when():
    ((why, sentence),) = foretold(growing(passes=-20, earliest=-40))

    assert why == DueReason.WORSENING
    assert "exceeded 0.1 mm about 2026-11-03; " in sentence
    assert sentence.endswith("the robot has not been measured since the comparison.")


def test_a_change_at_once_beyond_the_limit_is_a_reason():
    step = LimitForecast("120-1", "joint_harmonics", "joint 2", 60.0, day(40), 0.21, None, day(3))

    ((why, sentence),) = foretold(step)

    assert why == DueReason.WORSENING
    assert sentence.startswith("Joint")
    assert (
        "60 per turn: changed abruptly by 0.210 mm, first seen on 2026-10-14; this exceeds 0.1 mm" in sentence
    )


def test_what_is_foreseen_comes_after_what_was_measured_and_before_age_the_soonest_first():
    robots = [robot(serial, 3) for serial in ("soon", "sooner", "open")] + [robot("late", 45)]
    told_open = {"open": dict([told("diagnosis", 3, "unexplained", 0.21)])}
    both = compared(growing(serial="soon"), growing(serial="sooner", earliest=5))

    found = standing_robots(robots, Evidence(told_open, compared=[both]), DueAfter(), TODAY)

    assert [one.measured.serial_number for one in found] == ["open", "sooner", "soon", "late"]
    assert found[1].reasons[0].compared == both
