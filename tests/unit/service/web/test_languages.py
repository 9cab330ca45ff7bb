"""Which language a browser prefers, by its header, and what pages say in it."""

from types import SimpleNamespace

import pytest

from truepose.domain.errors import UnsuitableModelError
from truepose.messages.catalogue import catalogue
from truepose.messages.message import message
from truepose.web.middleware.language import preferred_languages
from truepose.web.pages import cell, identification


@pytest.mark.parametrize(
    ("accepted", "languages"),
    [
        ("", []),
        ("fr", ["fr"]),
        ("fr-CH, fr;q=0.9, en;q=0.8", ["fr", "fr", "en"]),
        ("en;q=0.2, fr;q=0.7", ["fr", "en"]),
        ("en, fr", ["en", "fr"]),
        ("fr;q=0, en;q=0.1", ["en"]),
        ("fr;q=many, en;q=0.1", ["en"]),
        ("de;q=0.5, fr;q=nan, en;q=0.9", ["en", "de"]),
        ("fr;q=inf, en;q=0.1", ["en"]),
        ("fr;q=1e-1, de;q=0.0_1, en;q=0.1", ["en"]),
        ("fr ; Q=0.1, en;q=1.000", ["en", "fr"]),
        ("*;q=0.5", ["*"]),
        (",,;", []),
    ],
)
def test_languages_come_in_the_order_of_their_weights(accepted, languages):
    assert [language for language in preferred_languages(accepted) if language] == languages


@pytest.mark.parametrize(
    ("page", "work", "why"),
    [
        (identification, "export", lambda words: identification._refusal(None, None, words)),
        (
            cell,
            "fitting_model",
            lambda words: cell._check(SimpleNamespace(handed_down=SimpleNamespace(document={})), None, words),
        ),
    ],
)
def test_a_page_says_in_its_language_why_something_cannot_be(page, work, why, monkeypatch):
    def refused(*of):
        raise UnsuitableModelError(message("refused.sign_in"))

    monkeypatch.setattr(page, work, refused)

    assert why(catalogue("de")) == catalogue("de").say("refused.sign_in")
