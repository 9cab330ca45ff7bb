"""Halves of characters are found however JSON may hide them, and whole ones pass."""

import pytest

from truepose.web.middleware.limits import has_half_character

HALF = "\ud83d"


@pytest.mark.parametrize(
    "body",
    [
        rb'"\ud83d"',
        rb'{"reason": "a\uDBFFb"}',
        rb'{"\udc00": 1}',
        rb'[["\ude00\ud83d"]]',
        rb'"\\\ud83d"',
        b'"\xed\xa0\xbd"',
        f'"{HALF}"'.encode("utf-16-le", "surrogatepass"),
        f'"{HALF}"'.encode("utf-32-be", "surrogatepass"),
    ],
)
def test_half_a_character_is_found(body):
    assert has_half_character(body)


@pytest.mark.parametrize(
    "body",
    [
        b"",
        b"{}",
        rb'"\ud83d\ude00"',
        rb'"\uD83D\uDE00 caf\u00e9"',
        rb'"\\ud83d"',
        '"😀"'.encode(),
        '"😀"'.encode("utf-16"),
        rb'{"not JSON": "\ud83d',
        b"[" * 100_000 + rb'"\ud83d"',
    ],
)
def test_whole_characters_and_what_is_no_json_pass(body):
    assert not has_half_character(body)
