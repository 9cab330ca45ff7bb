"""Durations as people type them."""

import pytest
import typer

from truepose.cli.services import seconds


@pytest.mark.parametrize(
    ("text", "expected"),
    [("90s", 90.0), ("30m", 1800.0), (" 24H ", 86400.0), ("7d", 604800.0), ("1.5h", 5400.0)],
)
def test_a_duration_has_a_unit(text, expected):
    assert seconds(text) == expected


@pytest.mark.parametrize("text", ["", "h", "-1h", "0h", "24 hours", "1w", "inf"])
def test_what_is_no_duration_is_refused(text):
    with pytest.raises(typer.BadParameter, match="not a duration"):
        seconds(text)
