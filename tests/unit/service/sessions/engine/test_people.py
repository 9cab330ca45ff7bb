"""Who may have the arm move: somebody whose name can be read, one of the people that a cell announces."""

import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from truepose.domain.people import LONGEST_NAME, NAME_PATTERN, fault_of_name, tidy_name
from truepose.sessions.engine.prompts import require_announced, require_person
from truepose.sessions.errors import PersonMissingError, PersonUnknownError

NAMES = [
    "Ada Byron",
    "Gerard 't Hooft",
    "Jean-Pierre O'Neill Jr.",
    "Žofie",
    "Ольга",
    "李小龙",
    "علي",
    "सीता",
    "नीरज",
    "ไพลิน",
    "7",
    "𠮷田",
]
NOBODY = {
    "zero width space": "\u200b",
    "only blanks": " \u00a0\u3000",
    "nothing": "",
    "a word joiner beside a name": "Ada\u2060",
    "text from right to left over": "\u202eadA",
    "a line break": "Ada\nconfirmed by Grace",
    "a control": "Ada\u0007",
    "a lone accent": "\u0301",
    "an accent on a blank": "Ada \u0301",
    "a Hangul filler": "\u3164",
    "a blank of Braille": "\u2800",
    "a soft hyphen": "\u00ad",
    "private use": "\ue000Ada",
    "private use beyond the first plane": "Ada\U000f0000",
    "unassigned": "Ada\u0378",
    "a tag": "Ada\U000e0041",
    "signs": "!?-",
    "a picture": "\U0001f642",
    "too long": "A" * (LONGEST_NAME + 1),
}


@pytest.mark.parametrize("name", NAMES)
def test_names_of_the_world_are_names(name):
    assert require_person(f"  {name} ") == tidy_name(name)
    assert re.search(NAME_PATTERN, name)


@pytest.mark.parametrize("kind", NOBODY)
def test_what_nobody_can_read_confirms_nothing(kind):
    with pytest.raises(PersonMissingError, match="A confirmation needs"):
        require_person(NOBODY[kind])


def test_a_name_is_kept_composed_and_without_blanks_around_it():
    assert require_person(" Zoe\u0308   Doe\t") == "Zo\u00eb Doe"


def test_one_of_the_people_announced_is_kept_as_they_were_announced():
    people = ("Ada Lovelace", "Zo\u00eb Doe")

    assert require_announced("ada  LOVELACE", people) == "Ada Lovelace"
    assert require_announced("zoe\u0308 doe", people) == "Zo\u00eb Doe"


def test_others_are_told_who_may():
    with pytest.raises(PersonUnknownError, match=r"Mallory is not among .* \(Ada Lovelace\)"):
        require_announced("Mallory", ("Ada Lovelace",))


def test_a_cell_that_announces_nobody_takes_every_name_that_can_be_read():
    assert require_announced("Mallory", ()) == "Mallory"
    with pytest.raises(PersonMissingError):
        require_announced("\u200b", ())


@settings(max_examples=500)
@given(st.text(max_size=8))
def test_the_schema_refuses_no_name_of_letters_and_passes_nothing_invisible_alone(text):
    tidy = tidy_name(text)
    if tidy and fault_of_name(tidy) is None and any(sign.isalpha() and sign < "\u02b0" for sign in tidy):
        assert re.search(NAME_PATTERN, tidy)
    if not any(sign.isprintable() and not sign.isspace() for sign in text):
        assert not re.search(NAME_PATTERN, text) or fault_of_name(tidy) is not None
