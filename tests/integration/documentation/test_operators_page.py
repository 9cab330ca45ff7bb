"""What the operator's page quotes is what the program says."""

import re
from pathlib import Path

import pytest

from truepose.messages.catalogue import ENGLISH
from truepose.messages.translations import translations

_CHECKOUT = Path(__file__).parents[3]
_PAGE = (_CHECKOUT / "docs" / "operator.md").read_text(encoding="utf-8")
_BLANK = re.compile(r"\{[^}\s]*(?P<unit>[^}]*)\}")  # with the word for its unit, where it has one
_QUOTES = re.findall(r"^\| “(.+?)” \|", _PAGE, flags=re.MULTILINE)


@pytest.fixture(scope="module")
def said():
    """Everything that sessions may say, one text after the other; what is filled in stands as an ellipsis."""
    texts = translations(ENGLISH, "sessions").texts()
    return "\n".join(_BLANK.sub(r"…\g<unit>", text) for text in texts.values())


def test_the_page_quotes_what_sessions_ask():
    assert len(_QUOTES) >= 10


@pytest.mark.parametrize("quote", _QUOTES)
def test_the_service_says_what_the_page_quotes(quote, said):
    pieces = [piece.strip() for piece in quote.split("…")]

    missing = [piece for piece in pieces if len(piece) > 3 and piece not in said]

    assert missing == []
