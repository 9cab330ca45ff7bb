"""The open_abb codec against what the public client sends and the public server answers."""

import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from truepose_drivers.abb_open_abb.protocol import (
    Code,
    LogLine,
    LogReader,
    OpenAbbProtocolError,
    Reply,
    Request,
    decimal,
    decode_reply,
    decode_request,
    encode_joint_target,
    encode_log_line,
    encode_reply,
    encode_request,
    rapid_number,
    reply_extent,
    reply_numbers,
)

DIALOGUE = json.loads((Path(__file__).parents[4] / "vectors" / "open_abb_dialogue.json").read_text())

anything = st.floats(-3600.0, 3600.0)


@pytest.mark.parametrize("row", DIALOGUE["requests"], ids=lambda row: row["text"])
def test_requests_of_the_public_client_are_read(row):
    assert decode_request(row["text"].encode()) == Request(row["code"], tuple(row["values"]))


@pytest.mark.parametrize("row", DIALOGUE["replies"], ids=lambda row: row["text"])
def test_replies_of_the_public_server_are_met_byte_for_byte(row):
    reply = Reply(row["code"], row["status"], row["reply"])

    assert decode_reply(row["text"].encode()) == reply
    assert encode_reply(reply) == row["text"].encode()


def test_a_joint_target_goes_out_with_five_decimals():
    data = encode_joint_target([10.12345, -20.5, 0.0, 180.0, -0.00001, 359.999999])

    assert data == b"2 +0010.12345 -0020.50000 +0000.00000 +0180.00000 -0000.00001 +0360.00000 #"


@given(target_deg=st.lists(anything, min_size=6, max_size=6))
def test_six_joints_always_fit_a_rapid_string_and_keep_their_value(target_deg):
    data = encode_joint_target(target_deg)

    request = decode_request(data)

    assert len(data) <= 80
    assert request.code == Code.MOVE_JOINTS
    # five decimals round by half a unit of the last one; the rest is the float's own spacing at 3600
    assert request.values == pytest.approx(target_deg, abs=0.5e-5 + 1e-9, rel=0.0)


@pytest.mark.parametrize("angle", [float("nan"), float("inf"), 3601.0])
def test_an_absurd_joint_angle_never_reaches_the_robot(angle):
    with pytest.raises(ValueError, match="joint angle"):
        encode_joint_target([0.0, angle, 0.0, 0.0, 0.0, 0.0])


def test_numbers_are_sent_without_an_exponent():
    assert decimal(1e-9, 4) == "0.0000"
    assert decimal(123456789.0, 1) == "123456789.0"
    with pytest.raises(ValueError, match="nan"):
        decimal(float("nan"), 2)


def test_a_request_of_81_characters_is_refused():
    fitting = ["1" * 38, "1" * 37]

    assert len(encode_request(2, fitting)) == 80
    with pytest.raises(ValueError, match="81 characters"):
        encode_request(2, ["1" * 39, "1" * 37])


def test_a_request_of_eleven_values_is_refused():
    with pytest.raises(ValueError, match="11 values"):
        encode_request(2, ["1"] * 11)


@pytest.mark.parametrize("text", ["02 1 #", "2 1 #", "002 1 #", "2 +1.0 # 4 #", "2.0 1 #"])
def test_the_code_is_a_number_and_what_follows_the_mark_is_lost(text):
    assert decode_request(text.encode()) == Request(2, (1.0,))


def test_a_value_that_runs_into_the_mark_is_not_counted():
    assert decode_request(b"2 1 2#") == Request(2, (1.0,))


@pytest.mark.parametrize(
    "text",
    [
        "",
        "4",
        "4 ",
        "#",
        " #",
        "4#",
        " 4 #",
        "2  1 #",
        "x #",
        "4 nan #",
        "4 1_0 #",
        "4 1e999 #",
        "2.5 #",
        "4" + " 1" * 11 + " #",
    ],
)
def test_a_corrupt_request_is_refused(text):
    with pytest.raises(OpenAbbProtocolError):
        decode_request(text.encode())


def test_a_mark_behind_the_80th_character_is_not_seen():
    assert decode_request(b"4 " + b"1" * 76 + b" #").code == Code.GET_JOINTS
    with pytest.raises(OpenAbbProtocolError, match="80"):
        decode_request(b"4 " + b"1" * 77 + b" #")


@given(data=st.binary(max_size=100))
def test_any_bytes_are_a_request_or_refused(data):
    try:
        request = decode_request(data)
    except OpenAbbProtocolError:
        return
    assert len(request.values) <= 10


@pytest.mark.parametrize("text", ["", "2", "x 1 ", "2 y ", "-2 1 ", "# 0 2013-01-01", "²  1"])
def test_what_is_no_reply_is_refused(text):
    with pytest.raises(OpenAbbProtocolError, match="not an open_abb reply"):
        decode_reply(text.encode())


@pytest.mark.parametrize(
    ("data", "words", "extent"),
    [
        (b"", 0, "part"),
        (b"4", 6, "part"),
        (b"4 ", 6, "part"),
        (b"4 1", 6, "part"),
        (b"4 1 1 2 3 4 5", 6, "part"),
        (b"4 1 1 2 3 4 5 6", 6, "maybe whole"),
        (b"4 1 1 2 3 4 5 6.5", 6, "maybe whole"),
        (b"4 1 1 2 3 4 5 6.50", 6, "maybe whole"),
        (b"4 1 1.00", 6, "part"),
        (b"4 1 1.12345 2 3 4 5 6.12", 6, "maybe whole"),
        (b"4 1 1.12345 2 3 4 5 6.12345", 6, "whole"),
        (b"4 0 ", 6, "whole"),
        (b"4 1", 0, "maybe whole"),
        (b"4 1 ", 0, "whole"),
        (b"2 ", 6, "whole"),
        (b"hello", 6, "whole"),
        (b"4 1 " + b"1" * 77, 6, "whole"),
    ],
)
def test_the_extent_of_a_reply_is_told_from_what_may_still_follow(data, words, extent):
    assert reply_extent(data, Code.GET_JOINTS, words) == extent


def test_numbers_of_a_reply_are_counted():
    reply = decode_reply(b"4 1 10 -20.55 30 0 9E+09 1.5")

    assert reply_numbers(reply, 6) == (10.0, -20.55, 30.0, 0.0, 9e9, 1.5)
    with pytest.raises(OpenAbbProtocolError, match="7 numbers"):
        reply_numbers(reply, 7)


def test_a_reply_that_exceeds_a_rapid_string_is_refused():
    with pytest.raises(ValueError, match="81 characters"):
        encode_reply(Reply(98, 1, "x" * 76))


@pytest.mark.parametrize(
    ("value", "text"),
    [(10.0, "10"), (-20.554, "-20.55"), (-0.001, "0"), (9e9, "9E+09"), (45.1, "45.10")],
)
def test_numbers_leave_the_controller_as_rapid_writes_them(value, text):
    assert rapid_number(value, 2) == text


@pytest.mark.parametrize("chunk", [1, 7, 4096])
def test_the_logger_stream_survives_any_split(chunk):
    pose = LogLine(0, "2013-01-01", "12:00:00", 0.5, (400.1, 0.0, -20.5, 0.707, 0.0, 0.707, 0.0))
    joints = LogLine(1, "2013-01-01", "12:00:00", 0.51, (1.25, -2.5, 0.0, 0.0, 90.0, 0.0))
    stream = encode_log_line(pose) + encode_log_line(joints) + encode_log_line(pose)
    reader, found = LogReader(), []

    for start in range(0, len(stream), chunk):
        reader.receive_data(stream[start : start + chunk])
        while (line := reader.next_line()) is not None:
            found.append(line)

    assert found == [pose, joints]  # the last record may still grow: nothing ends it


def test_a_logger_that_begins_no_record_is_refused():
    reader = LogReader()
    reader.receive_data(b"1 " * 1000)

    with pytest.raises(OpenAbbProtocolError, match="not a logger record"):
        reader.next_line()


def test_a_broken_record_is_refused_and_the_next_is_read():
    good = LogLine(1, "d", "t", 1.0, (1.0, 2.0, 3.0, 4.0, 5.0, 6.0))
    reader = LogReader()
    reader.receive_data(b"# 0 d t 1 2 3" + encode_log_line(good) + b"#")

    with pytest.raises(OpenAbbProtocolError, match="not a logger record"):
        reader.next_line()

    assert reader.next_line() == good
