"""What the service keeps in English is said in the reader's language; what nobody knows stays as it is."""

import ast
import json
import re
from pathlib import Path

import pytest

import truepose
from tests.helpers.kept_sentences import CLEAR, KEPT, SCATTERS
from truepose.domain.measurement.identities import IdentityTaken
from truepose.domain.measurement.session import SessionState
from truepose.sequencing.engine.halting.halts import ENDED_AT_REST
from truepose.sequencing.engine.identity.expected import sentence
from truepose.sequencing.engine.notices import motion_notice
from truepose.sequencing.engine.prompts import CELL_CLEAR
from truepose.sequencing.engine.states import words
from truepose.words.catalogue import ENGLISH, LANGUAGES, STORED, catalogue, texts_file
from truepose_drivers.api import MotionGuard

SERVICE = Path(truepose.__file__).parent
OTHERS = [language for language in LANGUAGES if language != ENGLISH]
STORED_TEXTS = json.loads(texts_file(ENGLISH, STORED).read_text(encoding="utf-8"))


def said(language, text):
    return " ".join(piece for piece, _ in catalogue(language).heard(text))


@pytest.mark.parametrize("language", OTHERS)
def test_every_sentence_is_known_by_its_own_key(language):
    for key, text in STORED_TEXTS.items():
        filled = re.sub(r"\{(\w+)\}", lambda blank: _filling(blank[1]), text)

        ((told, spoken),) = catalogue(language).heard(filled)

        assert spoken == language, key
        assert told == catalogue(language).say(
            key, **{n: _filling(n) for n in re.findall(r"\{(\w+)\}", text)}
        )


def _filling(name):
    return f"{name}-7." if name == "sentence" else f"{name}-7"


@pytest.mark.parametrize("kept", KEPT)
def test_in_english_a_text_is_as_it_was_kept(kept):
    assert said(ENGLISH, kept) == kept


def test_sentences_are_heard_one_by_one_and_within_each_other():
    assert said("de", f"Stop was pressed. {CLEAR}").startswith("STOPP wurde gedrückt. Der Roboter")
    assert "Der Messwert streut um 0.123 mm" in said("de", KEPT[5])
    assert "Es ist die 3. in Folge." in said("de", KEPT[5])


def test_what_is_not_known_stays_and_says_that_it_is_english():
    assert catalogue("ja").heard("Nobody ever said this. Nor that.") == [
        ("Nobody ever said this. Nor that.", "en")
    ]
    assert [language for _, language in catalogue("fr").heard(KEPT[2])] == ["fr", "en"]
    assert catalogue("fr").heard("") == []


def test_kept_lengths_are_in_the_readers_unit():
    assert "0.00484 in" in said("en-x-inch", SCATTERS)
    assert "limit 0.00394 in" in said("en-x-inch", SCATTERS)


@pytest.mark.parametrize(
    "made",
    [
        CELL_CLEAR,
        ENDED_AT_REST,
        motion_notice(MotionGuard()),
        *(
            sentence(IdentityTaken(device, finding, "391", "42"))
            for device in ("tracker", "ballbar")
            for finding in ("first", "same", "silent", "foreign")
        ),
        sentence(IdentityTaken("robot", "foreign", "391", "42")),
    ],
)
def test_what_the_service_makes_is_known(made):
    assert {language for _, language in catalogue("es").heard(made)} == {"es"}


def test_no_sentence_is_known_that_the_service_does_not_say():
    told = " ".join(
        _strings(path) for room in ("sequencing", "storage", "operation") for path in _modules(room)
    ) + " ".join(map(words, SessionState))

    for key, text in STORED_TEXTS.items():
        for said_so in re.split(
            r"\{\w+\}|\b(?:tracker|ballbar|then|agrees with|contradicts|a|and|simulated|real)\b|[:;,.?()]",
            text,
        ):
            assert len(said_so.strip()) < 12 or said_so.strip() in told, key


def _modules(room):
    return (SERVICE / room).rglob("*.py")


def _strings(path):
    nodes = ast.walk(ast.parse(path.read_text(encoding="utf-8")))
    constants = (node.value for node in nodes if isinstance(node, ast.Constant))
    return " ".join(value for value in constants if isinstance(value, str))
