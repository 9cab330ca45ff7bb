"""A catalogue fills in texts with numbers, names and sentences, in the words of its language."""

import pytest

from truepose.messages.catalogue import IN_ENGLISH, Catalogue, Names, catalogue, english
from truepose.messages.message import leading_key, message, together

FRENCH = catalogue("fr")
JAPANESE = catalogue("ja")


def test_a_sentence_is_filled_in_with_numbers_names_and_sentences():
    after = message("span.minutes", minutes=45.2)
    sentence = message("causes.zero_jump", joint="joint 3", turn_deg=0.0343, after=after)

    assert english(sentence) == (
        "The zero of joint 3 jumped by 0.0343 deg, 45 min after the first reading; nothing else moved then."
    )
    assert FRENCH.spoken(sentence) == (
        "Le zéro de l\u2019axe 3 a sauté de 0,0343 deg, 45 min après la première mesure\u00a0; "
        "rien d\u2019autre n\u2019a bougé alors."
    )


def test_japanese_joins_without_spaces_and_opens_a_sentence_without_its_full_stop():
    after = message("span.minutes", minutes=45.2)
    sentence = message("causes.zero_jump", joint="joint 3", turn_deg=0.0343, after=after)
    impossible = JAPANESE.spoken(
        message("causes.impossible", sentence=sentence, why=message("limits.friction"))
    )

    assert JAPANESE.spoken(together(sentence, sentence)) == JAPANESE.spoken(sentence) * 2
    assert "軸3の原点が0.0343 deg飛びました" in impossible
    assert "。。" not in impossible


def test_several_sentences_are_one_text_and_empty_ones_are_none():
    first, last = message("message.unexplained"), message("remaining.as_stated")

    assert together(first, "", last) == together(first, together(last))
    assert english(together(first, "In words of their own.", last)) == (
        "The residuals contain an error that no known cause explains. In words of their own. "
        "The residuals are consistent with the stated noise."
    )
    assert together("", "") == ""


def test_a_text_is_known_by_its_first_sentence():
    as_stated, full = message("remaining.as_stated"), message("remaining.full")

    assert leading_key(together(as_stated, full)) == leading_key(as_stated) == "remaining.as_stated"
    assert leading_key("The residuals are consistent with the stated noise.") == ""
    assert leading_key(together("Theirs.", full)) != "remaining.full"


def test_somebodys_own_words_stay_in_every_language():
    told = "The gear of joint 2 rubs, tool, base."

    assert FRENCH.spoken(told) == told
    assert FRENCH.spoken(together(told, message("remaining.as_stated"))).startswith(told)


def test_a_key_of_another_version_is_shown_as_it_is():
    assert IN_ENGLISH.spoken(message("of.tomorrow", joint="joint 2")) == "of.tomorrow"


@pytest.mark.parametrize(
    ("name", "french"),
    [
        ("joint 3", "axe 3"),
        ("angle of joint 12", "angle de l\u2019axe 12"),
        ("joint 3, time, jump", "axe 3, temps, saut"),
        ("angle of joint 3, in other joints", "angle de l\u2019axe 3, dans d\u2019autres axes"),
        ("acme 7", "acme 7"),
        ("joint 3, of acme", "joint 3, of acme"),
    ],
)
def test_names_of_documents_have_their_word_or_stay(name, french):
    assert FRENCH.name(name) == french
    assert IN_ENGLISH.name(name) == name


def test_a_language_bends_its_names_where_it_must():
    bent = Names({"joint {n}": {"": "axe {n}", "of": "de l\u2019axe {n}"}, "time": {"": "temps"}})

    assert (bent.called("joint 2", "of"), bent.called("joint 2", "the")) == ("de l\u2019axe 2", "axe 2")
    assert bent.called("time", "of") == "temps"


def test_causes_of_a_package_are_called_by_their_names():
    assert FRENCH.effect("acme_friction") == "acme friction"
    assert (IN_ENGLISH.effect("joint_gain"), FRENCH.effect("joint_gain")) == ("joint gain", "gain d\u2019axe")
    assert IN_ENGLISH.effect("unnamed") == "an unnamed cause"


def test_an_unknown_language_has_no_catalogue():
    with pytest.raises(FileNotFoundError):
        Catalogue("xx").effect("joint_gain")


def test_a_message_that_was_stored_with_other_values_is_its_key_and_one_of_the_code_is_a_mistake():
    stored = message("session.reading.scatters", off_um=123.0)

    assert english(stored) == "session.reading.scatters"
    assert english(message("session.while", doing=stored, why="x")) == "While session.reading.scatters: x"
    with pytest.raises(KeyError):
        IN_ENGLISH.say("session.reading.scatters", off_um=123.0)
