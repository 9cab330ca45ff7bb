"""The MAPPDK codec against what the public client sends and what the public server's format strings make."""

import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from truepose_drivers.fanuc_mappdk.protocol import (
    LONGEST_MESSAGE_CHARS,
    Command,
    MappdkProtocolError,
    Motion,
    Reply,
    Request,
    RequestReader,
    TimedMotion,
    decode_identity,
    decode_motion,
    decode_reply,
    decode_request,
    decode_timed_motion,
    encode_identity,
    encode_joints,
    encode_motion,
    encode_reply,
    encode_request,
    encode_timed_motion,
    encode_watch,
    joint_angles_deg,
    joint_resolution_deg,
    reply_extent,
    require,
)

DIALOGUE = json.loads((Path(__file__).parents[4] / "vectors" / "mappdk_dialogue.json").read_text())
JOINTS = b"0:j=   0.000,j= -20.500,j= 130.250,j=-180.000,j=  45.000,j=  -0.010,j=none,j=none,j=none"

anything = st.floats(-3600.0, 3600.0)


@pytest.mark.parametrize("row", DIALOGUE["requests"], ids=lambda row: row["text"].strip())
def test_requests_of_the_public_client_are_read(row):
    reader = RequestReader()
    reader.receive_data(row["text"].encode())

    assert decode_request(reader.next_message()) == Request(row["name"], tuple(row["fields"]))
    assert reader.next_message() is None


@pytest.mark.parametrize("row", DIALOGUE["replies"], ids=lambda row: row["text"][:20])
def test_replies_of_the_public_server_are_met_byte_for_byte(row):
    reply = Reply(row["code"], row["message"])

    assert decode_reply(row["text"].encode()) == reply
    assert encode_reply(reply) == row["text"].encode()


def test_a_motion_goes_out_as_the_public_client_sends_it():
    theirs = DIALOGUE["requests"][2]["text"].encode()

    assert encode_motion(Command.MOVE_TO_JOINTS, Motion((10, -20.5, 30, 0, 45, 0), 50)) == theirs


def test_a_motion_of_the_public_client_is_read():
    motion = decode_motion(decode_request(DIALOGUE["requests"][3]["text"].strip()))

    assert motion == Motion((-0.0, 360.0, 1.0, 2.0, 3.0, 4.0), 7, 80, 25, linear=True)


@given(target_deg=st.lists(anything, min_size=6, max_size=6), speed=st.integers(1, 100))
def test_six_joints_fit_a_karel_string_and_keep_their_value(target_deg, speed):
    data = encode_motion(Command.MOVE_TO_JOINTS, Motion(tuple(target_deg), speed))
    motion = decode_motion(decode_request(data.decode().removesuffix("\n")))

    assert len(data) <= 255
    assert motion.speed == speed
    assert motion.values == pytest.approx(target_deg, abs=0.5e-6 + 1e-9, rel=0.0)


@pytest.mark.parametrize("angle", [float("nan"), float("inf"), 3601.0])
def test_an_absurd_angle_never_reaches_the_robot(angle):
    with pytest.raises(ValueError, match="joint angles"):
        encode_motion(Command.MOVE_TO_JOINTS, Motion((0.0, angle, 0.0, 0.0, 0.0, 0.0), 1))
    with pytest.raises(ValueError, match="joint angles"):
        encode_timed_motion(TimedMotion((angle,) * 6, 1.0))


@pytest.mark.parametrize("speed", [0, -1, 10_000])
def test_an_absurd_speed_never_reaches_the_robot(speed):
    with pytest.raises(ValueError, match="speed"):
        encode_motion(Command.MOVE_TO_JOINTS, Motion((0.0,) * 6, speed))


@pytest.mark.parametrize("duration_s", [0.0, -1.0, 3201.0, float("nan")])
def test_an_absurd_time_never_reaches_the_robot(duration_s):
    with pytest.raises(ValueError, match="take"):
        encode_timed_motion(TimedMotion((0.0,) * 6, duration_s))


@pytest.mark.parametrize(("duration_s", "sent_s"), [(0.01, 0.1), (1.0, 1.0), (1.01, 1.1), (12.34, 12.4)])
def test_a_time_is_never_sent_shorter(duration_s, sent_s):
    data = encode_timed_motion(TimedMotion((1.0,) * 6, duration_s))

    assert decode_timed_motion(decode_request(data.decode().strip())).duration_s == pytest.approx(sent_s)


def test_a_silence_goes_out_in_milliseconds():
    assert encode_watch(0.8) == b"watch:0800\n"


def test_a_request_of_255_characters_is_refused():
    with pytest.raises(ValueError, match="characters"):
        encode_request(Command.CALL, "A" * 250)


@pytest.mark.parametrize(
    ("fields", "reply"),
    [
        ("", "error-in-joint-values"),
        ("005x:0100:000:0:1:+1.0", r"R\[81\]-was-not-set"),
        ("0050:x:000:0:1:+1.0", r"R\[82\]-was-not-set"),
        ("0050:0100::0:1:+1.0", r"R\[83\]-was-not-set"),
        ("0050:0100:000:0:2:+1.0", "error-in-joint-values"),
        ("0050:0100:000:0:1:nan", "error-in-joint-values"),
        ("0050:0100:000:0:1:1e3", "error-in-joint-values"),
    ],
)
def test_a_motion_that_is_none_is_answered_with_what_was_wrong(fields, reply):
    with pytest.raises(MappdkProtocolError, match=f"^{reply}$"):
        decode_motion(decode_request(f"movej:{fields}"))


@given(data=st.binary(max_size=400))
def test_any_bytes_are_lines(data):
    reader = RequestReader()
    reader.receive_data(data)
    while (line := reader.next_message()) is not None:
        assert len(line) <= 254
        request = decode_request(line)
        for decode in (decode_motion, decode_timed_motion):
            try:
                decode(request)
            except MappdkProtocolError as error:
                encode_reply(Reply(1, str(error)))


def test_a_line_without_end_is_cut_and_not_collected():
    reader = RequestReader()
    for _ in range(100):
        reader.receive_data(b"movej" * 100)
        assert reader.next_message() is None

    assert len(reader._buffer) <= LONGEST_MESSAGE_CHARS
    reader.receive_data(b"\ncurjpos\n")
    assert reader.next_message() == ("movej" * 51)[:LONGEST_MESSAGE_CHARS]
    assert reader.next_message() == "curjpos"


@given(data=st.binary(max_size=300), expected=st.sampled_from(["success", "joints", "identity"]))
def test_any_bytes_are_a_reply_or_refused(data, expected):
    reply_extent(data, expected)
    try:
        reply = decode_reply(data)
        require(reply, expected)
    except MappdkProtocolError:
        return
    assert reply.code == 1 or expected != "success" or reply.message == "success"


@given(angles=st.lists(anything, min_size=6, max_size=6), decimals=st.integers(3, 6))
def test_joints_are_whole_at_their_end_and_never_before(angles, decimals):
    data = encode_reply(encode_joints(angles, decimals))

    assert [reply_extent(data[:end], "joints") for end in range(len(data))] == ["part"] * len(data)
    assert reply_extent(data, "joints") == "whole"
    assert joint_angles_deg(decode_reply(data)) == pytest.approx(angles, abs=0.51 * 10.0**-decimals)
    assert joint_resolution_deg(decode_reply(data)) == pytest.approx(10.0**-decimals)


@pytest.mark.parametrize(
    ("data", "expected", "extent"),
    [
        (b"", "success", "part"),
        (b"0", "success", "part"),
        (b"0:", "success", "part"),
        (b"0:succ", "success", "part"),
        (b"0:success", "success", "whole"),
        (b"0:success\r\n", "success", "whole"),
        (b"0:successor", "success", "whole"),
        (b"0:success", "joints", "whole"),
        (b"0:j=", "success", "whole"),
        (b"1:", "success", "maybe whole"),
        (b"1:wrong-comm", "success", "maybe whole"),
        (b"1:wrong-command", "identity", "whole"),
        (b"1:something-new", "success", "maybe whole"),
        (b"0:truepose 1,LR Mate,F1", "identity", "part"),
        (b"0:truepose 1,LR Mate,F1,V7;", "identity", "whole"),
        (b"2:success", "success", "whole"),
        (b"hello", "success", "whole"),
        (b"0:j= 1.000,k= 1.000", "joints", "whole"),
        (JOINTS + b",j=none", "joints", "whole"),
        (JOINTS[:-4] + b"1.000", "joints", "maybe whole"),
        (b"0:truepose" + b"x" * 300, "identity", "whole"),
        (b"1:" + b"x" * 300, "success", "whole"),
        (b"\r\n" * 200, "success", "whole"),
    ],
)
def test_the_extent_of_a_reply_is_told_from_its_form(data, expected, extent):
    assert reply_extent(data, expected) == extent


@pytest.mark.parametrize("text", ["", "0", "2:success", "success", "0:a:b", "0:" + "x" * 260, "x:1"])
def test_what_is_no_reply_is_refused(text):
    with pytest.raises(MappdkProtocolError, match="not a MAPPDK reply"):
        decode_reply(text.encode())


@pytest.mark.parametrize(
    ("was", "bad"),
    [
        (b" -20.500", b" -20.50"),  # a digit lost
        (b" -20.500", b" -20.5000"),  # one came twice
        (b" -20.500", b"    none"),
        (b"j=none", b"j=   7.000"),  # a seventh axis
        (b" -20.500", b" 3600.001"),
        (b"j=none,", b""),
        (b"j= -20", b"j = -20"),
        (b" -20.500", b" -2e.500"),
    ],
)
def test_joints_that_are_none_are_refused(was, bad):
    with pytest.raises(MappdkProtocolError):
        joint_angles_deg(decode_reply(JOINTS.replace(was, bad, 1)))


def test_the_identity_of_our_own_server_is_read():
    reply = decode_reply(encode_reply(encode_identity("LR Mate 200iC", "F123456", "V7.70P")))

    assert decode_identity(reply) == ("LR Mate 200iC", "F123456", "V7.70P")
    assert decode_identity(Reply(1, "wrong-command")) is None
    with pytest.raises(MappdkProtocolError, match="not an identity"):
        decode_identity(Reply(0, "truepose 1,LR Mate;"))


@pytest.mark.parametrize(
    ("reply", "expected"),
    [
        (Reply(0, "success"), "joints"),
        (Reply(0, "success"), "identity"),
        (Reply(0, JOINTS[2:].decode()), "success"),
        (Reply(0, "1"), "success"),
    ],
)
def test_a_reply_to_something_else_is_refused(reply, expected):
    with pytest.raises(MappdkProtocolError):
        require(reply, expected)


def test_a_reply_that_clients_could_not_take_apart_is_never_sent():
    with pytest.raises(ValueError, match="colon"):
        encode_reply(Reply(0, "a:b"))
    with pytest.raises(ValueError, match="too long"):
        encode_reply(Reply(0, "x" * 253))
