"""What the operator's page quotes is what the program says."""

import ast
import re
from pathlib import Path

import pytest

_CHECKOUT = Path(__file__).parents[3]
_PAGE = (_CHECKOUT / "docs" / "operator.md").read_text(encoding="utf-8")
_QUOTES = re.findall(r"^\| “(.+?)” \|", _PAGE, flags=re.MULTILINE)


def _texts(tree):
    """String literals of a module; what is filled in stands as an ellipsis."""
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr):
            yield "".join(part.value if isinstance(part, ast.Constant) else "…" for part in node.values)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.value


@pytest.fixture(scope="module")
def said():
    """Everything that the service may say, one text after the other."""
    modules = (_CHECKOUT / "service").rglob("*.py")
    return "\n".join(text for path in modules for text in _texts(ast.parse(path.read_text(encoding="utf-8"))))


def test_the_page_quotes_what_sessions_ask():
    assert len(_QUOTES) >= 10


@pytest.mark.parametrize("quote", _QUOTES)
def test_the_service_says_what_the_page_quotes(quote, said):
    pieces = [piece.strip() for piece in quote.split("…")]

    missing = [piece for piece in pieces if len(piece) > 3 and piece not in said]

    assert missing == []
