"""The hands' lines, both directions."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from truepose_drivers.cell_hands.protocol import Do, Done, Who, decode_answer, decode_request, encode
from truepose_drivers.framing import JsonLineError, Refusal

names = st.text().filter(lambda name: name not in {"op", "action"})
details = st.one_of(st.text(), st.booleans(), st.integers(-(2**53), 2**53), st.floats(-1e15, 1e15))


def test_requests_and_answers_have_the_published_form():
    deed = Do("connect", {"base": 2, "tool": 3})

    assert encode(deed) == b'{"op": "do", "action": "connect", "base": 2, "tool": 3}\n'
    assert encode(Done()) == b'{"ok": true}\n'
    assert encode(Refusal("why")) == b'{"error": "why"}\n'


@given(request=st.one_of(st.just(Who()), st.builds(Do, st.text(), st.dictionaries(names, details))))
def test_requests_make_the_round_trip(request):
    assert decode_request(encode(request)) == request


@given(answer=st.one_of(st.just(Done()), st.builds(Done, st.text()), st.builds(Refusal, st.text())))
def test_answers_make_the_round_trip(answer):
    assert decode_answer(encode(answer)) == answer


@pytest.mark.parametrize(
    "line",
    [
        b"",
        b"{",
        b"[]",
        b"{}",
        b'{"op": "do"}',
        b'{"op": "do", "action": 3}',
        b'{"op": "fly"}',
        b'{"op": "do", "action": "connect", "base": [1]}',
        b'{"op": "do", "action": "x", "base": NaN}',
        b'{"op": "do", "action": "x", "base": 1e999}',
        b'{"op": "do", "action": "x", "base": %d}' % 10**400,
        b"\xff",
    ],
)
def test_a_request_that_is_none_is_refused_with_a_sentence(line):
    with pytest.raises(JsonLineError, match=r"\w+ \w+"):
        decode_request(line)


@pytest.mark.parametrize("line", [b"{}", b'{"ok": false}', b'{"ok": 1}', b'{"error": 3}', b"ok"])
def test_an_answer_that_is_none_is_refused(line):
    with pytest.raises(JsonLineError):
        decode_answer(line)


def test_a_detail_that_would_hide_the_request_is_not_sent():
    with pytest.raises(ValueError, match="action"):
        encode(Do("connect", {"action": "detach"}))
