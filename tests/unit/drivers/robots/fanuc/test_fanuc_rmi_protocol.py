"""The codec of FANUC's Remote Motion Interface against what public clients send."""

import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.instruments.pieces import messages_in
from tests.helpers.refusals import assert_refused_at_worst
from truepose_drivers.errors import RemoteProtocolError
from truepose_drivers.fanuc_rmi import protocol
from truepose_drivers.fanuc_rmi.protocol import (
    Command,
    JointMotion,
    Kind,
    Packet,
    PacketReader,
    RmiProtocolError,
    Session,
    StatedAxes,
    Status,
    command,
    decode,
    decode_axes,
    decode_status,
    encode,
    encode_motion,
    encode_status,
    error_of,
    error_texts,
    handed_over,
    reply,
    session,
)

DIALOGUE = json.loads((Path(__file__).parents[4] / "vectors" / "fanuc_rmi_dialogue.json").read_text())
REPLIES = {name: decode(text.encode()) for name, text in DIALOGUE["replies"].items()}
THEIR_MOTION = DIALOGUE["requests"][5]
anything = st.floats(-3600.0, 3600.0)


def packet_of(row):
    return Packet(Kind(row["kind"]), row["name"], row["fields"])


@pytest.mark.parametrize("row", DIALOGUE["requests"], ids=lambda row: row["name"])
@pytest.mark.parametrize("chunk", [1, 7, 4096])
def test_requests_of_public_clients_are_read_and_met_byte_for_byte(row, chunk):
    data = row["text"].encode()

    assert messages_in(PacketReader(), data[:-1], chunk) == []
    assert messages_in(PacketReader(), data, chunk) == [packet_of(row)]
    assert encode(packet_of(row)) == data


@pytest.mark.parametrize(
    ("packet", "row"),
    [
        (session(Session.CONNECT), 0),
        (command(Command.RESET), 2),
        (command(Command.INITIALIZE), 3),
        (command(Command.JOINTS), 6),
        (command(Command.STATUS), 8),
        (command(Command.ABORT), 10),
        (session(Session.DISCONNECT), 11),
    ],
)
def test_what_the_driver_says_is_what_public_clients_say(packet, row):
    assert encode(packet).decode() == DIALOGUE["requests"][row]["text"]


def test_a_motion_is_that_of_the_public_client_with_a_term_value():
    motion = encode_motion(JointMotion(1, (5, -10.5, 20, 0, 30, 0, 0, 0, 0), 20))

    assert motion == Packet(
        Kind.INSTRUCTION, THEIR_MOTION["name"], THEIR_MOTION["fields"] | {"TermType": "FINE", "TermValue": 0}
    )


def test_replies_say_what_they_mean():
    assert handed_over(REPLIES["connect"]) == (16002, "RMI 9.0")
    assert decode_status(REPLIES["status"]) == Status(True, False, True, False, 7, 10)
    assert decode_axes(REPLIES["joints"]) == StatedAxes(123456, (5.0, -10.5, 20.0, 0.0, 30.0, *(0.0,) * 4))
    assert error_of(REPLIES["refused"]) == protocol.WRONG_SEQUENCE
    assert error_texts(REPLIES["errors"]) == ["SRVO-002 Teach pendant E-stop", "MOTN-017 Limit error"]
    assert error_texts(REPLIES["no_errors"]) == []


def test_keys_of_a_packet_have_no_order():
    joints, errors = REPLIES["joints"].fields, REPLIES["errors"].fields
    turned = dict(reversed(joints["JointAngle"].items()))

    assert decode_axes(command(Command.JOINTS, **joints | {"JointAngle": turned})) == StatedAxes(
        123456, (5.0, -10.5, 20.0, 0.0, 30.0, *(0.0,) * 4)
    )
    assert error_texts(command(Command.ERROR_TEXTS, **dict(reversed(errors.items())))) == [
        "SRVO-002 Teach pendant E-stop",
        "MOTN-017 Limit error",
    ]


def test_a_status_comes_back_as_it_was_stated():
    status = Status(True, False, True, True, 12, 55)

    assert decode_status(reply(command(Command.STATUS), fields=encode_status(status))) == status


@pytest.mark.parametrize(
    ("later", "earlier", "newer"),
    [(11, 10, True), (10, 10, False), (9, 10, False), (3, 2**32 - 5, True), (2**32 - 5, 3, False)],
)
def test_time_tags_begin_anew_after_some_weeks(later, earlier, newer):
    assert StatedAxes(later, ()).is_newer_than(StatedAxes(earlier, ())) is newer


@pytest.mark.parametrize("percent", [0, -1, 101])
def test_an_absurd_speed_never_reaches_the_robot(percent):
    with pytest.raises(ValueError, match="speed"):
        encode_motion(JointMotion(1, (0.0,) * 6, percent))


@pytest.mark.parametrize("angle", [float("nan"), float("inf"), 3601.0])
def test_an_absurd_angle_never_reaches_the_robot(angle):
    with pytest.raises(ValueError, match="out of any robot"):
        encode_motion(JointMotion(1, (0.0, angle, 0.0, 0.0, 0.0, 0.0), 1))


@pytest.mark.parametrize(
    "changed",
    [
        {"JointAngle": {"J1": 1.0}},
        {"JointAngle": None},
        {"JointAngle": {f"J{n}": 0.0 for n in (1, 2, 3, 4, 5, 7)}},
        {"JointAngle": {**{f"J{n}": 0.0 for n in range(1, 7)}, "J10": 0.0}},
        {"JointAngle": {**{f"J{n}": 0.0 for n in range(1, 6)}, "J6": "0.0"}},
        {"JointAngle": {**{f"J{n}": 0.0 for n in range(1, 6)}, "J6": True}},
        {"JointAngle": {**{f"J{n}": 0.0 for n in range(1, 6)}, "J6": 3600.1}},
        {"TimeTag": 1.5},
        {"TimeTag": None},
    ],
)
def test_joints_that_are_none_are_refused(changed):
    joints = REPLIES["joints"]

    with pytest.raises(RmiProtocolError):
        decode_axes(Packet(joints.kind, joints.name, {**joints.fields, **changed}))


@pytest.mark.parametrize("name", ["ServoReady", "TPMode", "RMIMotionStatus", "NextSequenceID", "Override"])
def test_a_status_with_a_gap_is_none(name):
    fields = {key: value for key, value in REPLIES["status"].fields.items() if key != name}

    with pytest.raises(RmiProtocolError, match=name):
        decode_status(Packet(Kind.COMMAND, Command.STATUS, fields))


@pytest.mark.parametrize("override", [0, 101, -5])
def test_an_override_that_is_none_is_refused(override):
    fields = {**REPLIES["status"].fields, "Override": override}

    with pytest.raises(RmiProtocolError, match="override"):
        decode_status(Packet(Kind.COMMAND, Command.STATUS, fields))


@pytest.mark.parametrize("port", [0, 65_536, -1])
def test_a_port_that_is_none_is_refused(port):
    fields = {**REPLIES["connect"].fields, "PortNumber": port}

    with pytest.raises(RmiProtocolError, match="port"):
        handed_over(Packet(Kind.SESSION, Session.CONNECT, fields))


@pytest.mark.parametrize(
    "line",
    [
        b"",
        b"{}",
        b"[]",
        b"1",
        b'{"ErrorID": 0}',
        b'{"Command": 7}',
        b'{"Command": "FRC_Reset", "Instruction": "FRC_Call"}',
        b'{"Command": "FRC_Reset", "Command": "FRC_Abort"}',
        b'{"Command": "FRC_Reset"',
        b"\xff\xfe",
    ],
)
def test_what_is_no_packet_is_refused(line):
    with pytest.raises(RemoteProtocolError):
        decode(line)


@given(data=st.binary(max_size=400))
def test_any_bytes_are_packets_or_refused(data):
    reader = PacketReader()
    reader.receive_data(data)

    while (packet := assert_refused_at_worst(RemoteProtocolError, reader.next_message)) is not None:
        for read in (error_of, handed_over, decode_status, decode_axes, error_texts):
            assert_refused_at_worst(RemoteProtocolError, read, packet)


def test_a_line_without_end_is_refused():
    reader = PacketReader()
    reader.receive_data(b"x" * 2000)

    with pytest.raises(RemoteProtocolError, match="right port"):
        reader.next_message()


@given(axes=st.lists(anything, min_size=6, max_size=9), percent=st.integers(1, 100))
def test_a_motion_keeps_its_values(axes, percent):
    sent = decode(encode(encode_motion(JointMotion(3, tuple(axes), percent))))

    assert list(sent.fields["JointAngle"].values()) == pytest.approx(axes, abs=0.51e-6, rel=0.0)


def test_refusals_are_said_in_words():
    assert "out of sequence" in protocol.in_words(2_556_957)
    assert "delete it on the pendant" in protocol.in_words(7015)
    assert "999" in protocol.in_words(999)
    assert [protocol.is_of_target(error) for error in (2_556_964, 15_017, 2_556_957, 7015)] == [
        True,
        True,
        False,
        False,
    ]
