"""Which language a browser prefers, by its header."""

import pytest

from truepose.web.middleware.language import preferred_languages


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
