"""No English is left where French was asked for: in texts, in names, in a report of planted causes."""

from dataclasses import replace

import pytest

from tests.helpers.diagnosis.point_scenes import telling_campaign, telling_scene
from tests.helpers.diagnosis.selections import PRESENT, planted
from tests.helpers.identification.synthetic import configurations
from tests.helpers.web.pages import Page
from tests.helpers.words.english import FUNCTION_WORDS, NOUNS, english_in
from tests.helpers.words.translations import every_text, without_blanks
from truepose.cli.diagnosis_text import diagnosis_lines
from truepose.diagnosis.diagnose import diagnose
from truepose.diagnosis.screening.smooth_functions import families
from truepose.domain.diagnosis import Shape
from truepose.effects.registry import CAUSES, EFFECTS
from truepose.effects.signatures import amplitude_of, named_signature, plural_of, signature_of
from truepose.effects.unclassified.cause import OWN
from truepose.messages.catalogue import catalogue
from truepose.reports.diagnosis.report import DiagnosisReport

FRENCH = catalogue("fr")
PAINTED_ELSEWHERE = pytest.mark.usefixtures("empty_pictures")


def test_no_french_text_has_an_english_word():
    left = {key: english_in(without_blanks(text)) for key, text in every_text("fr")}

    assert {key: words for key, words in left.items() if words} == {}


def names():
    """Yield every name of a place, a variable, a shape and an amplitude that a diagnosis of ours may tell."""
    scene = telling_scene()
    for name, cause in CAUSES.items():
        yield amplitude_of(name)
        yield plural_of(name)
        yield from named_signature(name, "joint 1") if name != "unnamed" else ()
        for candidate in cause.candidates(scene):
            yield from signature_of(candidate)
            yield candidate.subject
    for kind in OWN.values():
        yield kind.subject((1, 2))
    yield from (family.variable for family in families(scene))
    yield from Shape.__args__


def test_every_name_of_a_cell_has_its_french_word():
    left = {name: english_in(FRENCH.name(name), NOUNS | FUNCTION_WORDS) for name in names()}

    assert {name: words for name, words in left.items() if words} == {}


def test_every_effect_has_its_french_name():
    same = {"base"}

    assert {name for name in EFFECTS if FRENCH.effect(name) == name.replace("_", " ")} == same


@pytest.fixture(scope="module")
def diagnosed():
    """A joint's gain, another's wave and a base that drifts, with readings to judge them."""
    causes = {
        "joint_gain": {"gain_4": 4e-4},
        "joint_harmonics": {"wave_2_2_sin": 4e-4, "wave_2_2_cos": 2e-4},
        "base_drift": {"drift_linear_x": 0.2},
    }
    unseen = planted(causes, telling_campaign(40, joints_rad=configurations(40, seed=9)), seed=11)
    return diagnose(replace(planted(causes), validation=unseen.calibration), PRESENT)


def test_a_report_of_planted_causes_is_french_throughout(diagnosed):
    page = Page(DiagnosisReport(diagnosed, language="fr").content())

    assert len(diagnosed.findings) >= 2
    assert "tourne trop" in page.text
    assert english_in(page.text) == []


def test_a_terminal_speaks_french_too(diagnosed):
    text = "\n".join(diagnosis_lines(diagnosed, FRENCH))

    assert "À mesurer ensuite" in text or "Les résidus" in text
    assert english_in(text) == []


@PAINTED_ELSEWHERE
def test_what_is_said_in_english_is_seen(diagnosed):
    assert {"the", "of", "with"} <= set(english_in(Page(DiagnosisReport(diagnosed).content()).text))


@PAINTED_ELSEWHERE
def test_a_cause_of_a_package_keeps_its_own_words(diagnosed):
    told = "The gear of joint 2 rubs under load."
    first, *others = diagnosed.findings
    brought = replace(diagnosed, findings=(replace(first, effect="acme_friction", sentence=told), *others))

    page = Page(DiagnosisReport(brought, language="fr").content())

    assert told in page.text
    assert "Acme friction, axe 4" in page.text
