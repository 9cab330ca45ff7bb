"""Addresses that a result page names for its document: they lead to the numbers that it shows."""

from types import SimpleNamespace

from truepose.web.pages.accuracy_results import _address
from truepose.web.pages.session_results import Choice


def test_a_limit_is_named_with_all_its_digits():
    """The hash beside the address is that of the document with this very limit."""
    origin, model = SimpleNamespace(record=SimpleNamespace(id=3)), SimpleNamespace(id=7)

    address = _address(origin, model, Choice(7, 0.12345678901, "simple"))

    assert address == "/api/v1/sessions/3/accuracy?model_id=7&limit_mm=0.12345678901&rule=simple"
    assert _address(origin, model, Choice(7)) == "/api/v1/sessions/3/accuracy?model_id=7"
