"""What changed of robots since a day: sentences with figures, the largest worsening first."""

from datetime import date, timedelta

import pytest

from truepose.domain.cell import Paper
from truepose.messages.catalogue import LANGUAGES, catalogue, english
from truepose.plant.changes import ChangeKind, certificates_ended, robots_changed
from truepose.storage.plant.certificates import CertificateRecord
from truepose.storage.plant.overview import ResultFacts, RobotMeasured

TODAY = date(2026, 11, 23)
SINCE = date(2026, 11, 16)


def day(ago):
    return (TODAY - timedelta(days=ago)).isoformat()


def told(kind, number, ago, figure_mm=None, limit_mm=None, serial="120-1", **document):
    of = (number, 1, "left arm", kind, number, serial, day(ago))
    return {kind: ResultFacts(*of, "", figure_mm, limit_mm, document)}


def named(*causes):
    """Return causes as a diagnosis tells them, each with how far it moves the tool."""
    return [{"effect": effect, "subject": of, "worth_mm": mm} for effect, of, mm in causes]


def changes(before, now, upto=TODAY):
    """Return what changed of one robot, as who reads English is told."""
    found = robots_changed({"120-1": before}, {"120-1": now}, upto)
    return [(one.what, english(one.sentence)) for robot in found for one in robot.changes]


def test_where_nothing_changed_nothing_is_said():
    known = {
        **told("identification", 1, 40, 0.041),
        **told("validation", 1, 40, 0.2, 0.3),
        **told("diagnosis", 1, 40, causes=named(("backlash", "joint 4", 0.03))),
        **told("model", 1, 40),
    }
    repeated = {
        **told("identification", 2, 3, 0.0413),
        **told("diagnosis", 2, 3, causes=named(("backlash", "joint 4", 0.05))),
    }

    assert changes(known, known) == []
    assert changes(known, {**known, **repeated}) == []
    assert changes({}, {}) == []
    assert robots_changed({}, {}, TODAY) == []


def test_an_error_says_from_what_to_what_and_by_which_records():
    assert changes(told("identification", 4, 33, 0.041), told("identification", 9, 3, 0.055)) == [
        (
            ChangeKind.ERROR,
            "Mean error of the identified model rose from 0.0410 mm on 2026-10-21 to 0.0550 mm on 2026-11-20 "
            "(identification 9).",
        )
    ]
    assert changes(told("validation", 4, 33, 0.31, 0.3), told("validation", 9, 3, 0.08, 0.3)) == [
        (
            ChangeKind.ERROR,
            "Largest error in validation fell from 0.310 mm on 2026-10-21 to 0.0800 mm on 2026-11-20 "
            "(validation 9).",
        )
    ]


def test_a_mean_is_not_compared_with_a_largest_error():
    largest, mean = told("validation", 4, 33, 0.31, 0.3), told("validation", 9, 3, 0.08, 0.03, promised=True)

    ((what, sentence),) = changes(largest, mean)

    assert what == ChangeKind.ERROR
    assert sentence.startswith(
        "Mean error in validation: 0.0800 mm on 2026-11-20 (validation 9); there is no"
    )


@pytest.mark.parametrize("before", [{}, told("identification", 4, 33, None)])
def test_a_first_figure_is_compared_with_nothing(before):
    (found,) = robots_changed({"120-1": before}, {"120-1": told("identification", 9, 3, 0.05)}, TODAY)

    (change,) = found.changes
    assert (change.before_mm, change.after_mm) == (None, 0.05)
    assert found.worsening_mm == 0.0


def test_an_error_without_a_finite_figure_says_no_figure():
    assert changes(told("validation", 4, 33, 0.31, 0.3), told("validation", 9, 3, None, 0.3)) == []


def test_causes_that_appear_and_go_away_are_named_with_their_figures():
    before = told("diagnosis", 4, 33, causes=named(("backlash", "joint 4", 0.03), ("drift", "", 0.02)))
    now = told(
        "diagnosis", 9, 3, causes=named(("backlash", "joint 4", 0.05), ("compliance", "joint 2", 0.021))
    )

    assert changes(before, now) == [
        (
            ChangeKind.CAUSE_NAMED,
            "Diagnosis 9 of 2026-11-20 finds causes that were not found on 2026-10-21: compliance, joint 2 "
            "(0.021 mm on average).",
        ),
        (
            ChangeKind.CAUSE_GONE,
            "Diagnosis 9 of 2026-11-20 no longer finds causes that were found on 2026-10-21: drift "
            "(0.020 mm on average).",
        ),
    ]


def test_a_first_diagnosis_says_that_it_is_the_first_and_one_that_names_nothing_says_nothing():
    found = told("diagnosis", 9, 3, causes=[{"effect": "backlash", "subject": "joint 4"}])

    assert changes({}, found) == [
        (
            ChangeKind.CAUSE_NAMED,
            "Diagnosis 9 of 2026-11-20, the first for this robot, finds backlash, joint 4.",
        )
    ]
    assert changes({}, told("diagnosis", 9, 3, causes=[])) == []


def test_a_model_is_the_first_replaces_one_or_was_accepted():
    made, before = told("model", 9, 3), told("model", 4, 33)

    assert [sentence for _, sentence in changes({}, made)] == [
        "Model 9 of 2026-11-20 is the first for this robot."
    ]
    assert [sentence for _, sentence in changes(before, made)] == [
        "Model 9 of 2026-11-20 replaces model 4 of 2026-10-21."
    ]
    assert [sentence for _, sentence in changes(before, told("model", 9, 3, accepted_by="Grace Hopper"))] == [
        "Model 9, sent by the plant, was accepted on 2026-11-20 by Grace Hopper."
    ]


def test_what_is_dated_in_the_future_changes_nothing():
    assert changes(told("model", 4, 33), told("model", 9, -400)) == []


def test_robots_whose_error_grew_most_come_first_and_those_that_got_better_last():
    def of(serial, before_mm, after_mm):
        known = {} if before_mm is None else told("identification", 1, 40, before_mm, serial=serial)
        return serial, known, told("identification", 2, 3, after_mm, serial=serial)

    robots = [of("better", 0.09, 0.05), of("worse", 0.05, 0.07), of("new", None, 0.5), of("worst", 0.05, 0.2)]

    found = robots_changed(
        {serial: before for serial, before, _ in robots}, {serial: now for serial, _, now in robots}, TODAY
    )

    assert [robot.serial_number for robot in found] == ["worst", "worse", "new", "better"]
    assert [round(robot.worsening_mm, 3) for robot in found] == [0.15, 0.02, 0.0, -0.04]


def test_certificates_that_ended_since_then_say_whom_that_concerns():
    def paper(serial, expires):
        return CertificateRecord(Paper("tracker", serial, f"report {serial}", expires), "left arm", day(400))

    papers = [paper("T-1", day(1)), paper("T-2", day(0)), paper("T-3", day(7)), paper("T-4", day(8))]
    robots = [RobotMeasured(serial, "IRB 120", day(40), "left arm", "T-3") for serial in ("a", "b")]

    found = certificates_ended([*papers, paper("", "")], robots, SINCE, TODAY)

    beside = "robots last measured with it"
    assert [english(one.sentence) for one in found] == [
        f"Certificate report T-3 of tracker T-3 expired on 2026-11-16; {beside}: 2.",
        f"Certificate report T-1 of tracker T-1 expired on 2026-11-22; {beside}: 0.",
    ]


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_language_says_an_error_in_the_units_of_its_reader(language):
    before, now = told("identification", 4, 33, 0.0508), told("identification", 9, 3, 0.0762)
    (found,) = robots_changed({"120-1": before}, {"120-1": now}, TODAY)

    words = catalogue(f"{language}-x-inch")
    spoken = words.spoken(found.changes[0].sentence)

    assert f"0{words.units.decimal}002000 in" in spoken
    assert f"0{words.units.decimal}003000 in" in spoken
    assert "mm" not in spoken
