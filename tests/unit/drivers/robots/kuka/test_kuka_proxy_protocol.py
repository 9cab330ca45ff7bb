"""The codec of the variable proxy against what a public client sends and the public server answers."""

import json
import struct
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.instruments.pieces import messages_in
from tests.helpers.refusals import assert_refused_at_worst
from truepose_drivers.kuka_variable_proxy.protocol import (
    Answer,
    AnswerReader,
    Mode,
    ProgramState,
    ProxyProtocolError,
    Request,
    RequestReader,
    decode_aggregate,
    decode_axes,
    decode_count,
    decode_state,
    decode_text,
    encode_answer,
    encode_axes,
    encode_real,
    encode_request,
    encode_state,
    following,
)

VECTORS = json.loads((Path(__file__).parents[4] / "vectors" / "kuka_variable_proxy.json").read_text())
AXES = VECTORS["axes"]


@pytest.mark.parametrize("row", VECTORS["requests"], ids=lambda row: row["name"])
@pytest.mark.parametrize("chunk", [1, 7, 4096])
def test_requests_of_the_public_client_are_read_and_met_byte_for_byte(row, chunk):
    request, data = Request(row["number"], row["name"], row["value"]), bytes.fromhex(row["hex"])

    assert messages_in(RequestReader(), data, chunk) == [request]
    assert encode_request(request) == data


@pytest.mark.parametrize("row", VECTORS["answers"], ids=lambda row: row["value"] or "nothing")
@pytest.mark.parametrize("chunk", [1, 7, 4096])
def test_answers_of_the_public_server_are_read_and_met_byte_for_byte(row, chunk):
    answer, data = (
        Answer(row["number"], Mode(row["mode"]), row["value"], row["done"]),
        bytes.fromhex(row["hex"]),
    )

    assert messages_in(AnswerReader(), data, chunk) == [answer]
    assert encode_answer(answer) == data


def test_frames_that_run_into_each_other_are_told_apart():
    rows = VECTORS["answers"]

    found = messages_in(AnswerReader(), b"".join(bytes.fromhex(row["hex"]) for row in rows), 5)

    assert [answer.number for answer in found] == [row["number"] for row in rows]


@pytest.mark.parametrize(
    "bad",
    [
        "000b0009050003313030000101",  # mode 5
        "000b0000000003313030000101",  # no content
        "000bffff000003313030000101",  # endless
        "000b0009000004313030000101",  # text longer than its frame
        "000b0009000002313030000101",  # text shorter than its frame
        "000b0009000003313030000201",  # a tail that is none
        "000b0009000003ff3030000101",  # no letter
        "000b000400000101",  # no text at all
    ],
)
def test_what_is_no_answer_is_refused(bad):
    with pytest.raises(ProxyProtocolError):
        messages_in(AnswerReader(), bytes.fromhex(bad) + bytes(40))


@given(data=st.binary(max_size=300))
def test_any_bytes_are_frames_or_refused(data):
    for reader in (AnswerReader(), RequestReader()):
        try:
            for message in messages_in(reader, data):
                assert isinstance(message, Answer | Request)
        except ProxyProtocolError:
            continue


@given(text=st.text(max_size=200))
def test_any_text_is_a_value_or_refused(text):
    for decode in (decode_axes, decode_state, decode_count):
        assert_refused_at_worst(ProxyProtocolError, decode, text)


def test_a_frame_that_the_proxy_would_not_read_is_never_sent():
    with pytest.raises(ValueError, match="longer"):
        encode_request(Request(1, "X" * 2048))


def test_axes_are_read_as_the_controller_shows_them():
    assert decode_axes(AXES["text"]) == pytest.approx(AXES["deg"], abs=1e-12)
    assert decode_axes(AXES["text"].replace("E6AXIS: ", "")) == pytest.approx(AXES["deg"], abs=1e-12)


@given(axes=st.lists(st.floats(-3600.0, 3600.0), min_size=6, max_size=12))
def test_axes_keep_what_a_real_of_24_bits_keeps(axes):
    kept = [struct.unpack("f", struct.pack("f", angle))[0] for angle in axes]

    assert decode_axes(encode_axes(axes)) == pytest.approx(kept, rel=1e-8, abs=1e-12)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0.0"),
        (-0.0, "0.0"),
        (10.0, "10.0"),
        (-20.25, "-20.25"),
        (93.452713, "93.452713"),
        (1e-7, "1.00000001E-07"),
    ],
)
def test_a_real_is_written_with_a_point(value, text):
    assert encode_real(value) == text


@pytest.mark.parametrize("angle", [float("nan"), float("inf"), 3601.0])
def test_an_absurd_angle_never_reaches_the_robot(angle):
    with pytest.raises(ValueError, match="out of any robot"):
        encode_axes((0.0, angle, 0.0, 0.0, 0.0, 0.0))


@pytest.mark.parametrize(
    "text",
    [
        "",
        "0.0",
        VECTORS["position"],
        "{E6AXIS: A1 0.0, A2 0.0, A3 0.0, A4 0.0, A5 0.0}",
        "{E6AXIS: A2 0.0, A1 0.0, A3 0.0, A4 0.0, A5 0.0, A6 0.0}",
        "{E6AXIS: A1 0.0, A1 0.0, A3 0.0, A4 0.0, A5 0.0, A6 0.0}",
        "{E6AXIS: A1 0.0, A2 nan, A3 0.0, A4 0.0, A5 0.0, A6 0.0}",
        "{E6AXIS: A1 0.0, A2 #NONE, A3 0.0, A4 0.0, A5 0.0, A6 0.0}",
        "{E6AXIS: A1 0.0, A2 9000.0, A3 0.0, A4 0.0, A5 0.0, A6 0.0}",
        "{E6AXIS: A1 0.0, A2 1E999, A3 0.0, A4 0.0, A5 0.0, A6 0.0}",
        "{E6AXIS: A1 0.0, A2 0.0, A3 0.0, A4 0.0, A5 0.0, A6 0.0",
        "{E6AXIS: A1 0.0, A2 0.0, A3 0.0, A4 0.0, A5 0.0, A6 0.0, X 1.0}",
    ],
)
def test_axes_that_are_none_are_refused(text):
    with pytest.raises(ProxyProtocolError):
        decode_axes(text)


def test_the_state_of_our_program_comes_back_as_it_was_stated():
    state = ProgramState(5, 3, 4, 0)

    assert encode_state(state) == "{TP_STATE_TYPE: BEGUN 5, ARRIVED 3, GIVEN_UP 4, REFUSED 0}"
    assert decode_state(encode_state(state)) == state
    assert state.moves
    assert not ProgramState(5, 3, 5, 0).moves
    assert state.unused_number == 6


@pytest.mark.parametrize(
    "text",
    [
        "{TP_STATE_TYPE: BEGUN 5, ARRIVED 3, GIVEN_UP 4}",
        "{TP_STATE_TYPE: BEGUN 5, ARRIVED 3, GIVEN_UP 4, REFUSED -1}",
        "{TP_STATE_TYPE: BEGUN 5.5, ARRIVED 3, GIVEN_UP 4, REFUSED 0}",
        "{E6AXIS: BEGUN 5, ARRIVED 3, GIVEN_UP 4, REFUSED 0}",
    ],
)
def test_a_state_that_is_none_is_refused(text):
    with pytest.raises(ProxyProtocolError):
        decode_state(text)


def test_counts_go_on_for_ever():
    assert [following(count) for count in (0, 1, -5, 2**30)] == [1, 2, 1, 1]


def test_other_values_are_read():
    assert decode_text('"#KR6R900 Z200 C4SR FLR"') == "#KR6R900 Z200 C4SR FLR"
    assert decode_text("#P_ACTIVE") == "#P_ACTIVE"
    assert decode_aggregate(VECTORS["position"], "E6POS")["X"] == "1339.90503"
