"""The clock's lines, both directions."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.instruments.pieces import messages_in
from truepose_drivers.cell_clock.protocol import (
    Now,
    Sleep,
    Time,
    decode_answer,
    decode_request,
    encode,
)
from truepose_drivers.framing import JsonLineError, LineReader, Refusal


def test_requests_and_answers_have_the_published_form():
    assert encode(Now()) == b'{"op": "now"}\n'
    assert encode(Sleep(4.0)) == b'{"op": "sleep", "s": 4.0}\n'
    assert encode(Time(12.5)) == b'{"now_s": 12.5}\n'
    assert encode(Refusal("why")) == b'{"error": "why"}\n'


@given(message=st.one_of(st.just(Now()), st.floats(0.0, 1e9).map(Sleep)))
def test_requests_make_the_round_trip(message):
    assert decode_request(encode(message)) == message


@given(message=st.one_of(st.text().map(Refusal), st.floats(-1e12, 1e12).map(Time)))
def test_answers_make_the_round_trip(message):
    assert decode_answer(encode(message)) == message


@pytest.mark.parametrize(
    "line",
    [
        b"",
        b"now",
        b"[]",
        b"{}",
        b'{"op": "stop"}',
        b'{"op": "sleep"}',
        b'{"op": "sleep", "s": -1}',
        b'{"op": "sleep", "s": 1e300}',
        b'{"op": "sleep", "s": "4"}',
        b'{"op": "sleep", "s": true}',
        b'{"op": "sleep", "s": NaN}',
        b'{"op": "sleep", "s": 1%s}' % (b"0" * 400),
        b"\xff",
    ],
)
def test_a_request_that_is_none_is_refused_with_a_sentence(line):
    with pytest.raises(JsonLineError, match=r"\w+ \w+"):
        decode_request(line)


@pytest.mark.parametrize(
    "line", [b"{}", b'{"now_s": null}', b'{"now_s": Infinity}', b"12.5", b'{"error": 3}']
)
def test_an_answer_that_is_none_is_refused(line):
    with pytest.raises(JsonLineError):
        decode_answer(line)


def test_a_number_that_is_not_finite_is_never_sent():
    with pytest.raises(ValueError, match="JSON"):
        encode(Sleep(float("nan")))


@pytest.mark.parametrize("chunk", [1, 5, 4096])
def test_lines_survive_any_split_of_the_stream(chunk):
    stream = encode(Now()) + encode(Sleep(1.0)) + b'{"op"'
    reader = LineReader()

    lines = messages_in(reader, stream, chunk)

    assert [decode_request(line) for line in lines] == [Now(), Sleep(1.0)]
    assert reader.inside_message


def test_a_line_without_end_is_refused():
    reader = LineReader()
    reader.receive_data(b"x" * 1025)

    with pytest.raises(JsonLineError, match="1024"):
        reader.next_message()
