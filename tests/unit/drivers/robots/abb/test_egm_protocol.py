"""EGM messages against those of the maker's descriptor, and whatever else may arrive."""

import importlib
import json
import struct
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.machine import ABB_ROBOT_CLIENT
from tests.helpers.refusals import assert_refused_at_worst
from truepose_drivers.abb_egm.protocol import (
    EgmProtocolError,
    Motors,
    Rapid,
    RobotFrame,
    decode_robot,
    encode_robot,
)

VECTORS = json.loads((Path(__file__).parents[4] / "vectors" / "egm_messages.json").read_text())
MEASURED, PLANNED = (10.5, -20.25, 30.125, 0.0, 45.0, -0.001), (11.0, -20.0, 30.0, 0.0, 45.0, 0.0)
FRAME = RobotFrame(12, 3456, MEASURED, PLANNED, Motors.ON, Rapid.RUNNING)


def message(number, part):
    return bytes([number << 3 | 2, len(part)]) + part


def data_of(joints=(1.0, 2.0, 3.0, 4.0, 5.0, 6.0), header=b"\x08\x01\x10\x02\x18\x02"):
    angles = b"".join(b"\x09" + struct.pack("<d", angle) for angle in joints)
    return message(1, header) + message(2, message(1, angles))


def test_a_frame_with_everything_in_it_is_read():
    assert decode_robot(bytes.fromhex(VECTORS["full"])) == FRAME


def test_a_frame_with_the_least_in_it_is_read():
    frame = decode_robot(bytes.fromhex(VECTORS["least"]))

    assert frame == RobotFrame(0, 0, (1.0, 2.0, 3.0, 4.0, 5.0, 6.0), (), Motors.OFF, Rapid.STOPPED)


def test_a_frame_survives_its_bytes():
    assert decode_robot(encode_robot(FRAME)) == FRAME


def test_the_makers_descriptor_reads_our_frames_and_we_read_its_own():
    pb2 = pytest.importorskip("abb_robot_client._egm_protobuf.egm_pb2", reason=ABB_ROBOT_CLIENT.reason)
    theirs = pb2.EgmRobot.FromString(encode_robot(FRAME))

    assert (theirs.header.seqno, theirs.header.tm, theirs.header.mtype) == (12, 3456, 2)
    assert tuple(theirs.feedBack.joints.joints) == FRAME.joints_deg
    assert tuple(theirs.planned.joints.joints) == FRAME.planned_deg
    assert (theirs.motorState.state, theirs.rapidExecState.state) == (1, 2)
    assert decode_robot(theirs.SerializeToString()) == FRAME
    assert importlib.import_module("google.protobuf")


def test_packed_angles_and_unknown_fields_are_read_and_passed_over():
    packed = struct.pack("<6d", 1, 2, 3, 4, 5, 6)
    unknown = b"\x98\x06\x01" + b"\xa1\x06" + bytes(8) + b"\xad\x06" + bytes(4) + b"\xb2\x06\x02hi"
    data = message(1, b"\x08\x01\x10\x02\x18\x02") + unknown + message(2, message(1, message(1, packed)))

    assert decode_robot(data).joints_deg == (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"\x0a",
        b"\x0a\x05\x08\x01",
        b"\x0b\x00",
        b"\xff" * 11,
        data_of(header=b"\x08\x01\x10\x02\x18\x03"),
        data_of(header=b"\x08\x01\x10\x02"),
        data_of(joints=(1.0,) * 5),
        data_of(joints=(1.0,) * 7),
        data_of(joints=(float("nan"),) * 6),
        data_of(joints=(float("inf"),) * 6),
        data_of(joints=(1e4,) * 6),
        data_of() + b"\x20\x01",
        data_of() + message(4, b"\x08\x09"),
        message(1, b"\x08\x01\x10\x02\x18\x02") + b"\x10\x01",
        b"4 1 10 20 30 40 50 60",
    ],
)
def test_what_is_no_frame_is_refused(data):
    with pytest.raises(EgmProtocolError):
        decode_robot(data)


@given(st.binary(max_size=120), st.integers(0, 40))
def test_any_bytes_are_a_frame_or_refused(data, kept):
    for attempt in (data, bytes.fromhex(VECTORS["full"])[:kept] + data):
        assert_refused_at_worst(EgmProtocolError, decode_robot, attempt)


@pytest.mark.parametrize(
    ("sequence", "time_ms", "follows"),
    [
        (13, 3460, True), (12, 3460, False), (11, 3460, False),
        (13, 3456, False), (13, 3450, False), (2000, 9000, True),
    ],
)  # fmt: skip
def test_only_what_moves_on_in_number_and_time_follows(sequence, time_ms, follows):
    assert replace(FRAME, sequence=sequence, time_ms=time_ms).follows(FRAME) is follows


def test_numbers_that_begin_anew_at_32_bits_go_on():
    last = replace(FRAME, sequence=2**32 - 1, time_ms=2**32 - 2)

    assert replace(FRAME, sequence=0, time_ms=2).follows(last)
    assert not last.follows(replace(FRAME, sequence=0, time_ms=2))
