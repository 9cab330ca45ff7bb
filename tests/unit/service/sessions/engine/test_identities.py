"""Whether the device that answers is the expected one: told by serial numbers, and by nothing else."""

import pytest

from truepose.domain.session import IdentityTaken
from truepose.messages.catalogue import english
from truepose.sessions.engine.identity_check import KnownDevice, acceptance_entry, judge, sentence

A, B, C = "390003", "777777", "391111"


def known_device(device, record):
    """Return what a session knows of a device after these lines of its record, oldest first."""
    known = KnownDevice()
    for taken in record:
        if taken.device == device:
            known = known.after(taken)
    return known


def met(*answers, expected="", device="tracker"):
    """Return what a session knows after these answers; a pair (serial, person) is a foreign one accepted."""
    record = []
    for answer in answers:
        serial, person = answer if isinstance(answer, tuple) else (answer, None)
        found = judge(device, serial, expected, known_device(device, record))
        if found is not None:
            record.append(found)
        if person is not None:
            record.append(acceptance_entry(found, person))
    return known_device(device, record)


def finding(answered, expected="", known=None, device="tracker"):
    found = judge(device, answered, expected, known or KnownDevice())
    return None if found is None else found.finding


@pytest.mark.parametrize("expected", ["", A, f" {A} "])
def test_the_first_one_that_the_cell_file_does_not_contradict_is_met_without_a_question(expected):
    assert finding(A, expected) == "first"


def test_the_first_one_is_foreign_where_the_cell_file_names_another():
    found = judge("tracker", B, A, KnownDevice())

    assert (found.finding, found.serial, found.expected) == ("foreign", B, A)


def test_the_same_one_again_is_no_news():
    assert finding(A, "", met(A)) is None
    assert finding(A, A, met(A, expected=A)) is None


def test_case_and_blanks_make_no_other_number():
    assert finding(" b-7 ", "", met("B-7")) is None


def test_another_one_is_foreign_even_where_the_cell_file_names_none():
    found = judge("ballbar", B, "", met(A, device="ballbar"))

    assert (found.finding, found.expected) == ("foreign", A)


def test_one_that_a_person_accepted_is_the_expected_one_from_then_on():
    known = met(A, (B, "Eva"), expected=A)

    assert finding(B, A, known) is None
    assert finding(A, A, known) == "foreign"
    assert finding(C, A, known) == "foreign"


def test_two_that_are_swapped_and_swapped_back_are_questioned_both_times():
    known = met(A, (B, "Eva"), (A, "Eva"))

    assert (known.serial, known.by_person) == (A, True)
    assert finding(A, "", known) is None
    assert finding(B, "", known) == "foreign"


def test_one_that_comes_back_before_anybody_accepted_the_other_is_noted():
    known = met(A, B)

    assert known.foreign is not None
    assert finding(A, "", known) == "same"
    assert met(A, B, A).foreign is None


def test_a_question_is_not_put_twice_and_a_third_one_is_a_question_of_its_own():
    known = met(A, B)

    assert finding(B, "", known) is None
    assert finding(C, "", known) == "foreign"


@pytest.mark.parametrize("nothing", ["", "unknown", "Unknown", " "])
def test_one_that_never_tells_its_number_is_never_questioned(nothing):
    assert finding(nothing) is None
    assert finding(nothing, A) is None


def test_one_that_falls_silent_is_noted_once_and_told_when_it_speaks_again():
    silent = met(A, "unknown")

    assert silent.silent
    assert finding("unknown", "", silent) is None
    assert finding(A, "", silent) == "same"
    assert finding(B, "", silent) == "foreign"


def test_a_foreign_one_that_falls_silent_still_waits_for_a_person():
    known = met(A, B)

    assert finding("unknown", "", known) is None
    assert known.foreign is not None


def test_one_that_begins_to_tell_its_number_is_judged_by_the_cell_file():
    assert finding(A, A, met("unknown")) == "first"
    assert finding(A, "", met("unknown")) == "first"
    assert finding(B, A, met("unknown")) == "foreign"


def test_a_cell_file_that_was_changed_meanwhile_makes_the_old_one_foreign():
    found = judge("tracker", A, B, met(A))

    assert (found.finding, found.expected) == ("foreign", B)


def test_a_cell_file_does_not_speak_against_what_a_person_accepted():
    assert finding(B, C, met(A, (B, "Eva"))) is None


def test_a_robot_that_was_exchanged_is_foreign_even_where_the_cell_file_was_mended_for_it():
    assert finding(B, B, met(A, device="robot"), device="robot") == "foreign"


def test_devices_are_told_apart():
    record = [IdentityTaken("tracker", "first", A), IdentityTaken("robot", "first", B)]

    assert known_device("tracker", record).serial == A
    assert known_device("robot", record).serial == B


@pytest.mark.parametrize("device", ["tracker", "ballbar"])
def test_a_question_names_both_and_says_what_accepting_means(device):
    text = sentence(IdentityTaken(device, "foreign", B, A))

    assert A in english(text)
    assert B in english(text)
    assert "again" in english(text)
    assert "certificate" in english(text)


def test_another_robot_is_not_for_a_person_to_accept():
    text = sentence(IdentityTaken("robot", "foreign", B, A))

    assert "accept" not in english(text)
    assert "cell file" in english(text)


def test_who_accepted_what_in_whose_place_is_told():
    text = sentence(acceptance_entry(IdentityTaken("tracker", "foreign", B, A), "Eva"))

    assert all(part in english(text) for part in ("Eva", A, B))
