"""The catalogue: every language says everything, fills in the same, and no key stands idle."""

import ast
import functools
import json
import re
import string
from pathlib import Path

import pytest

import truepose
from truepose.domain.sentences import leading_key, said, together
from truepose.words.catalogue import ENGLISH, IN_ENGLISH, LANGUAGES, Catalogue, Names, catalogue, english

ROOT = Path(truepose.__file__).parent
FOLDER = ROOT / "words"
APART = {"names", "tablet", "tracker_tablet"}  # names are no keys; the tablet uses its own in its scripts
FRENCH = catalogue("fr")
JAPANESE = catalogue("ja")


def texts(language):
    files = (path for path in (FOLDER / language).glob("*.json") if path.stem not in APART)
    return {key: text for path in files for key, text in json.loads(path.read_text("utf-8")).items()}


def names(language):
    return json.loads((FOLDER / language / "names.json").read_text("utf-8"))


def blanks(text):
    """Return what a text fills in, with the digits of numbers; forms of names are a language's own."""
    parsed = string.Formatter().parse(text)
    fields = {(field, (spec or "").lstrip(",")) for _, field, spec, _ in parsed if field}
    return {(field, spec if re.fullmatch(r"(\.\d)?[efg]", spec) else "") for field, spec in fields}


def literals(path):
    """Return every text in a module, its templates' and scripts' by what stands between quotes."""
    if path.suffix != ".py":
        return set(re.findall(r"[\"']([a-z_0-9.]+)[\"']", path.read_text("utf-8")))
    return constants_and_keys(path)[0]


@functools.cache
def constants_and_keys(path):
    """Return every constant of a module, and the keys that it says by name; it is parsed once for both."""
    constants, keys = set(), set()
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Constant):
            constants.add(node.value)
        if isinstance(node, ast.Call) and node.args and _called(node.func) in {"said", "say"}:
            keys |= {one.value for one in _ends(node.args[0]) if isinstance(one, ast.Constant)}
    return constants, keys


def said_keys():
    """Return the keys that are said by name: the first argument of `said` and of `say`."""
    for path in ROOT.rglob("*.py"):
        yield from constants_and_keys(path)[1]
    for path in ROOT.rglob("*.html"):
        yield from re.findall(r"\bsay\(\"([a-z_0-9.]+)\"", path.read_text("utf-8"))


def _called(function):
    return getattr(function, "id", getattr(function, "attr", ""))


def _ends(expression):
    """Return what an expression may come to: both ends of a choice."""
    if isinstance(expression, ast.IfExp):
        return [*_ends(expression.body), *_ends(expression.orelse)]
    return [expression]


def test_english_and_french_are_spoken():
    assert set(LANGUAGES) >= {"en", "fr"}


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_language_says_everything_and_nothing_else(language):
    assert set(texts(language)) == set(texts(ENGLISH))
    assert set(names(ENGLISH)) <= set(names(language))


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_language_fills_in_the_same_numbers_alike(language):
    own, documents = texts(language), texts(ENGLISH)

    assert [key for key in documents if blanks(own[key]) != blanks(documents[key])] == []


def test_every_key_that_is_said_is_there():
    assert sorted(set(said_keys()) - set(texts(ENGLISH))) == []


def test_every_key_is_said_somewhere():
    modules = [path for path in ROOT.rglob("*") if path.suffix in {".py", ".html"}]
    written = set().union(*(literals(path) for path in modules))
    apart = ("list.", "error.TP-", "page.errors.group.", "stored.")  # `test_error_codes`, `test_heard`
    idle = {key for key in texts(ENGLISH) if key not in written and not key.startswith(apart)}

    assert idle == set()


def test_french_keeps_its_spaces_before_high_punctuation():
    loose = [text for text in texts("fr").values() if re.search(r"[^\u00a0\w}][:;!?%»](?![\w./])", text)]

    assert loose == []


def test_a_sentence_is_filled_in_with_numbers_names_and_sentences():
    after = said("span.minutes", minutes=45.2)
    sentence = said("causes.zero_jump", joint="joint 3", turn_deg=0.0343, after=after)

    assert english(sentence) == (
        "The zero of joint 3 jumped by 0.0343 deg, 45 min after the first reading; nothing else moved then."
    )
    assert FRENCH.spoken(sentence) == (
        "Le zéro de l\u2019axe 3 a sauté de 0.0343 deg, 45 min après la première mesure\u00a0; "
        "rien d\u2019autre n\u2019a bougé alors."
    )


def test_japanese_joins_without_spaces_and_opens_a_sentence_without_its_full_stop():
    after = said("span.minutes", minutes=45.2)
    sentence = said("causes.zero_jump", joint="joint 3", turn_deg=0.0343, after=after)
    impossible = JAPANESE.spoken(said("causes.impossible", sentence=sentence, why=said("limits.friction")))

    assert JAPANESE.spoken(together(sentence, sentence)) == JAPANESE.spoken(sentence) * 2
    assert "軸3の原点が0.0343 deg飛びました" in impossible
    assert "。。" not in impossible


def test_several_sentences_are_one_text_and_empty_ones_are_none():
    first, last = said("message.unexplained"), said("remaining.as_stated")

    assert together(first, "", last) == together(first, together(last))
    assert english(together(first, "In words of their own.", last)) == (
        "Something is wrong that no known cause explains. In words of their own. "
        "What is left looks like the stated noise."
    )
    assert together("", "") == ""


def test_a_text_is_known_by_its_first_sentence():
    as_stated, full = said("remaining.as_stated"), said("remaining.full")

    assert leading_key(together(as_stated, full)) == leading_key(as_stated) == "remaining.as_stated"
    assert leading_key("What is left looks like the stated noise.") == ""
    assert leading_key(together("Theirs.", full)) != "remaining.full"


def test_somebodys_own_words_stay_in_every_language():
    told = "The gear of joint 2 rubs, tool, base."

    assert FRENCH.spoken(told) == told
    assert FRENCH.spoken(together(told, said("remaining.as_stated"))).startswith(told)


def test_a_key_of_another_version_is_shown_as_it_is():
    assert IN_ENGLISH.spoken(said("of.tomorrow", joint="joint 2")) == "of.tomorrow"


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
    bent = Names({"joint {n}": {"": "axe {n}", "of": "de l\u2019axe {n}"}, "time": "temps"})

    assert (bent.called("joint 2", "of"), bent.called("joint 2", "the")) == ("de l\u2019axe 2", "axe 2")
    assert bent.called("time", "of") == "temps"


def test_causes_of_a_package_are_called_by_their_names():
    assert FRENCH.effect("acme_friction") == "acme friction"
    assert (IN_ENGLISH.effect("joint_gain"), FRENCH.effect("joint_gain")) == ("joint gain", "gain d\u2019axe")
    assert IN_ENGLISH.effect("unnamed") == "a cause without a name"


def test_an_unknown_language_has_no_catalogue():
    with pytest.raises(FileNotFoundError):
        Catalogue("xx").effect("joint_gain")
