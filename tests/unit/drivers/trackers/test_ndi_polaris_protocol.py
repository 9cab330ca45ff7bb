"""The codec of NDI's cameras against bytes that it did not make, and against itself on anything else."""

import json
import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.instruments.pieces import messages_in
from tests.helpers.refusals import assert_refused_at_worst
from truepose_drivers.errors import RemoteProtocolError
from truepose_drivers.ndi_polaris.protocol import (
    Binary,
    DamagedRequest,
    NdiProtocolError,
    PortStatus,
    ReplyReader,
    Request,
    RequestReader,
    Text,
    ToolFrame,
    ToolPose,
    crc16,
    decode_binary,
    decode_handle,
    decode_handles,
    decode_text,
    encode_binary,
    encode_handles,
    encode_reply,
    encode_request,
    encode_text,
    error_code,
    facts,
    identity_of,
    page_writes,
)

GOLDEN = json.loads((Path(__file__).parents[3] / "vectors" / "ndi_polaris.json").read_text())
VERSION = "Polaris Vega Control Firmware\nNDI S/N: P9-00123\nFreeze Tag: Polaris Vega Rev 002.001\n"

components = st.floats(-1.0, 1.0)
quaternions = st.tuples(components, components, components, components).filter(
    lambda parts: math.hypot(*parts) > 0.1
)
poses = st.builds(
    lambda parts, place, error: ToolPose(tuple(part / math.hypot(*parts) for part in parts), place, error),
    quaternions,
    st.tuples(*[st.floats(-5000.0, 5000.0)] * 3),
    st.floats(0.0, 9.0),
)
tools = st.builds(
    ToolFrame,
    st.integers(0, 255),
    st.none() | poses,
    st.sampled_from([PortStatus(0x31), PortStatus(0x71), PortStatus(0xB1)]),
    st.integers(0, 2**32 - 1),
)


@pytest.mark.parametrize(("text", "crc"), GOLDEN["requests"].items())
def test_requests_have_the_checksum_that_other_programs_give_them(text, crc):
    name, _, arguments = text.partition(":")

    assert encode_request(Request(name, arguments)) == f"{text}{crc}\r".encode()


@pytest.mark.parametrize(("text", "crc"), GOLDEN["replies"].items())
def test_replies_have_the_checksum_that_other_programs_expect(text, crc):
    assert encode_reply(Text(text)) == f"{text}{crc}\r".encode()


@given(st.binary())
def test_a_checksum_behind_its_data_leaves_nothing(data):
    assert crc16(data + crc16(data).to_bytes(2, "little")) == 0


def test_a_binary_frame_is_read_field_by_field():
    seen, missing = decode_binary(Binary(bytes.fromhex(GOLDEN["binary_body"])))

    assert seen.pose.quaternion == (0.5, -0.5, 0.5, 0.5)
    assert seen.pose.position_mm == (100.0, -200.0, -1002.0)
    assert seen.pose.error_mm == pytest.approx(0.05, rel=1e-7)  # a single float
    assert (seen.handle, seen.status, seen.frame) == (1, 0x31, 2607)
    assert missing == ToolFrame(2, None, PortStatus(0x71), 2607)
    assert PortStatus.OUT_OF_VOLUME in missing.status


def test_a_text_frame_is_read_digit_by_digit():
    seen, missing = decode_text(Text(GOLDEN["text_frame"]))

    assert seen.pose.quaternion == pytest.approx((0.7071, -0.7071, 0.0, 0.0), abs=1e-15)
    assert seen.pose.position_mm == pytest.approx((-123.45, 1.0, -2345.67), abs=1e-12)
    assert seen.pose.error_mm == pytest.approx(0.0045, abs=1e-15)
    assert (seen.handle, seen.status, seen.frame) == (1, 0x31, 2607)
    assert missing == ToolFrame(2, None, PortStatus(0x71), 2607)
    assert encode_text([seen, missing]).text == GOLDEN["text_frame"]


@given(st.lists(tools, max_size=3))
def test_frames_make_the_round_trip_within_what_each_form_writes(sent):
    for received, q_step, mm_step, error_step in (
        (decode_binary(encode_binary(sent)), 1e-7, 5e-4, 1e-6),  # half a unit of a single float's last place
        (decode_text(encode_text(sent)), 0.5001e-4, 0.005001, 0.5001e-4),
    ):
        assert [(tool.handle, tool.status, tool.frame) for tool in received] == [
            (tool.handle, tool.status, tool.frame) for tool in sent
        ]
        for here, there in zip(received, sent, strict=True):
            assert (here.pose is None) == (there.pose is None)
            if here.pose is not None:
                assert here.pose.quaternion == pytest.approx(there.pose.quaternion, abs=q_step)
                assert here.pose.position_mm == pytest.approx(there.pose.position_mm, abs=mm_step)
                assert here.pose.error_mm == pytest.approx(there.pose.error_mm, abs=error_step)


@pytest.mark.parametrize(
    ("quaternion", "position_mm", "error_mm"),
    [
        ((0.5, 0.5, 0.5, 0.4), (0.0, 0.0, 0.0), 0.1),
        ((1.0, 0.0, 0.0, math.nan), (0.0, 0.0, 0.0), 0.1),
        ((1.0, 0.0, 0.0, 0.0), (0.0, math.inf, 0.0), 0.1),
        *(((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0), error_mm) for error_mm in (-0.1, math.nan, math.inf)),
    ],
)
def test_a_pose_that_is_none_is_refused(quaternion, position_mm, error_mm):
    frame = encode_binary([ToolFrame(1, ToolPose(quaternion, position_mm, error_mm))])

    with pytest.raises(NdiProtocolError, match="not a valid pose"):
        decode_binary(frame)


@pytest.mark.parametrize("form", [encode_binary, encode_text])
def test_a_tool_that_was_disabled_says_so(form):
    decode = decode_binary if form is encode_binary else decode_text

    (tool,) = decode(form([ToolFrame(7, None, disabled=True)]))

    assert tool.disabled
    assert tool.pose is None


@pytest.mark.parametrize("chunk", [1, 5, 4096])
def test_replies_of_both_kinds_survive_any_split(chunk):
    sent = [Text("OKAY"), Binary(b"\x00\x00\x00"), Text("a\nb"), Binary(bytes(range(256))), Text("")]

    assert messages_in(ReplyReader(), b"".join(map(encode_reply, sent)), chunk) == sent


@given(
    data=st.binary(max_size=200),
    begin=st.sampled_from([b"", b"\xc4\xa5", b"OKAYA896\r", encode_reply(Binary(b"\x01"))]),
    chunk=st.integers(1, 64),
)
def test_hostile_bytes_are_a_reply_or_a_protocol_error(data, begin, chunk):
    found = assert_refused_at_worst(NdiProtocolError, messages_in, ReplyReader(), begin + data, chunk)
    for reply in found or ():
        decode = decode_binary if isinstance(reply, Binary) else decode_text
        assert_refused_at_worst(NdiProtocolError, decode, reply)


@given(st.binary(max_size=120))
def test_a_hostile_body_is_a_frame_or_a_protocol_error(body):
    try:
        for tool in decode_binary(Binary(body)):
            assert tool.pose is None or all(map(math.isfinite, tool.pose.position_mm))
    except NdiProtocolError:
        return


@given(st.integers(0, 8 * len(encode_reply(Binary(bytes(40)))) - 1))
def test_a_bit_that_flipped_is_never_a_reply(bit):
    data = bytearray(encode_reply(Binary(bytes(40))))
    data[bit // 8] ^= 1 << bit % 8

    with pytest.raises(NdiProtocolError):
        assert messages_in(ReplyReader(), bytes(data) + b"\r", 64) == []
        raise NdiProtocolError("waits for what does not come")


def test_a_reply_without_an_end_is_an_error():
    with pytest.raises(NdiProtocolError, match="does not end"):
        messages_in(ReplyReader(), b"O" * 20_000, 4096)


@pytest.mark.parametrize(
    ("line", "request_read"),
    [
        (b"TSTOP:2C14\r", Request("TSTOP")),
        (b"TSTOP \r", Request("TSTOP")),
        (b"TX 0801\r", Request("TX", "0801")),
        (b"BX2:--6d=tools%04X\r" % crc16(b"BX2:--6d=tools"), Request("BX2", "--6d=tools")),
        (b"TSTOP:2C15\r", DamagedRequest(checksum=True)),
        (b"tstop\r", DamagedRequest()),
        (b"\xff\r", DamagedRequest()),
        (b"PVWR:" + b"0" * 3_000 + b"\r", DamagedRequest(too_long=True)),
    ],
)
def test_requests_are_read_with_and_without_checksum(line, request_read):
    assert messages_in(RequestReader(), line, 7) == [request_read]


def test_a_request_without_an_end_is_an_error():
    with pytest.raises(RemoteProtocolError, match="does not end"):
        messages_in(RequestReader(), b"A" * 10_000, 4096)


def test_a_definition_is_written_in_sixteen_pages():
    writes = list(page_writes(0x0A, b"\x4e\x44\x49" + bytes(700)))

    assert len(writes) == 16
    assert writes[0].arguments == "0A0000" + "4E4449" + "00" * 61
    assert writes[15].arguments == "0A03C0" + "00" * 64


def test_handles_are_listed_with_their_status():
    assert encode_handles([(1, 0x31), (0x0A, 0x1)]).text == "02010310A001"
    assert decode_handles(Text("02010310A001")) == [(1, 0x31), (0x0A, 0x1)]
    assert decode_handles(Text("00")) == []
    assert decode_handle(Text("0A")) == 10


@pytest.mark.parametrize("reply", ["OKAY", "", "0101", "02010310", "zz"])
def test_what_is_no_list_of_handles_is_an_error(reply):
    with pytest.raises(NdiProtocolError, match="instead of a list"):
        decode_handles(Text(reply))
    with pytest.raises(NdiProtocolError, match="instead of a"):
        decode_handle(Text(reply + "0"))


def test_errors_are_told_by_number():
    assert error_code(Text("ERROR0C")) == 12
    assert error_code(Text("OKAY")) is None
    assert error_code(Binary(b"ERROR0C")) is None


def test_a_camera_is_known_by_its_own_words():
    version = facts(Text(VERSION))

    who = identity_of(version, {})
    assert (who.model, who.serial, who.firmware) == ("Polaris Vega", "P9-00123", "002.001")
    told = facts(Text("Features.Hardware.Model=Polaris Vega VT\nFeatures.Hardware.Serial Number=P9-7: x\n"))
    who = identity_of(version, told)
    assert (who.model, who.serial) == ("Polaris Vega VT", "P9-7: x")
    assert identity_of({}, {}).serial == ""
