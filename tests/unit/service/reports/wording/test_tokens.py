"""The colours of all pages: text can be read in every look."""

import re
from importlib.resources import files

import pytest

_NEEDED = 7.0  # WCAG 2.2, 1.4.6
_TEXT = ("ink", "muted", "accent", "good", "bad", "warn")
_BACKS = ("paper", "card", "good-back", "bad-back", "warn-back")


def _looks():
    sheet = (files("truepose.reports") / "templates" / "tokens.css").read_text(encoding="utf-8")
    pairs = re.findall(r"--([\w-]+): light-dark\((#\w{6}), (#\w{6})\)", sheet)
    light = {name: one for name, one, _ in pairs}
    dark = {name: other for name, _, other in pairs}
    (block,) = re.findall(r'data-look="contrast"\] \{(.*?)\}', sheet, re.DOTALL)
    contrast = light | dict(re.findall(r"--([\w-]+): (#\w{6})", block))
    return {"light": light, "dark": dark, "contrast": contrast}


def _luminance(colour):
    """WCAG 2.2, relative luminance."""
    channels = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels]
    return sum(weight * c for weight, c in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


def _contrast(one, other):
    dark, light = sorted((_luminance(one), _luminance(other)))
    return (light + 0.05) / (dark + 0.05)


@pytest.mark.parametrize("look", ["light", "dark", "contrast"])
def test_text_can_be_read_on_every_back(look):
    colours = _looks()[look]

    pairs = [(text, back) for text in _TEXT for back in _BACKS] + [("accent-ink", "accent")]
    weak = {pair: _contrast(colours[pair[0]], colours[pair[1]]) for pair in pairs}

    assert {pair: found for pair, found in weak.items() if found < _NEEDED} == {}


def test_contrast_is_measured_as_the_guidelines_do():
    assert _contrast("#000000", "#ffffff") == pytest.approx(21.0)
    assert _contrast("#777777", "#ffffff") == pytest.approx(4.48, abs=0.01)
