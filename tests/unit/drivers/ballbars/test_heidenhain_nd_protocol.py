"""Characters of the ND counters, both directions; the golden ones are the manual's and another client's."""

import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.instruments.pieces import messages_in
from truepose_drivers.heidenhain_nd.protocol import (
    DC1,
    DC3,
    STX,
    Acknowledgement,
    Command,
    Control,
    Lamps,
    Line,
    NdProtocolError,
    Refusal,
    ReplyReader,
    RequestReader,
    Unreadable,
    decode_count,
    decode_identity,
    decode_lamps,
    display_line,
    encode_reply,
    encode_request,
    error_line,
    identity_lines,
    lamps_line,
    printed_line,
    reply_kind,
    to_mm,
    value_line,
)

VECTORS = json.loads((Path(__file__).parents[3] / "vectors" / "nd28x_dialogue.json").read_text())


def replies(data: bytes, chunk: int = 4096) -> list[object]:
    return messages_in(ReplyReader(), data, chunk)


def requests(data: bytes, chunk: int = 4096) -> list[object]:
    return messages_in(RequestReader(), data, chunk)


@pytest.mark.parametrize("vector", VECTORS["requests"], ids=lambda vector: vector["code"])
def test_requests_are_those_of_another_client(vector):
    golden = bytes.fromhex(vector["hex"])

    assert encode_request(Command(vector["code"])) == golden
    assert requests(golden) == [Command(vector["code"])]


def test_the_manuals_value_is_read_and_written():
    golden = bytes.fromhex(VECTORS["value"]["hex"])

    (line,) = replies(golden)

    assert decode_count(line) == VECTORS["value"]["count"]
    assert encode_reply(value_line(VECTORS["value"]["count"])) == golden


def test_the_manuals_identity_is_read_and_written():
    golden = bytes.fromhex(VECTORS["identity"]["hex"])

    lines = replies(golden)

    assert list(decode_identity(lines)) == VECTORS["identity"]["lines_as_printed"]
    written = identity_lines(*VECTORS["identity"]["lines_as_printed"])
    assert [line.text.strip() for line in lines] == [line.text.strip() for line in written]
    # STX and three times ten characters with CR LF: the 37 bytes that pymeasure reads
    assert len(b"".join(map(encode_reply, written))) == 37


def test_the_manuals_lamps_are_read():
    (line,) = replies(bytes.fromhex(VECTORS["lamps"]["hex"]))

    lamps = decode_lamps(line)

    expected = {name: VECTORS["lamps"][name] for name in ("reference", "inch", "below", "inside", "above")}
    assert {name: getattr(lamps, name) for name in expected} == expected


def test_the_manuals_error_text_is_no_value_and_no_lamps():
    golden = bytes.fromhex(VECTORS["error"]["hex"])

    (line,) = replies(golden)

    assert reply_kind(line) == "text"
    assert line.text.strip() == VECTORS["error"]["text"]
    assert encode_reply(error_line(VECTORS["error"]["text"])) == golden


@pytest.mark.parametrize("width", [12, 14, 32, 34])
def test_a_text_of_another_width_is_no_error_text(width):
    with pytest.raises(NdProtocolError, match="check cable"):
        reply_kind(Line("SIGNAL ERROR".ljust(width)))


def test_the_manuals_display_has_the_point_where_ours_has_it():
    golden = bytes.fromhex(VECTORS["display"]["hex"])

    assert encode_reply(display_line(VECTORS["display"]["count"])) == golden


@pytest.mark.parametrize(("inch", "length_mm"), [(False, 0.1234), (True, 0.313436)])
def test_a_count_is_a_tenth_of_a_micron_or_a_hundredth_of_a_thousandth(inch, length_mm):
    # 1234 counts: 0.1234 mm, or 0.01234 in = 0.313436 mm; exact but for rounding of doubles
    assert to_mm(1234, Lamps(inch=inch)) == pytest.approx(length_mm, rel=1e-14)


@given(count=st.integers(-999_999_999, 999_999_999))
def test_values_make_the_round_trip(count):
    (line,) = replies(encode_reply(value_line(count)))

    assert reply_kind(line) == "value"
    assert decode_count(line) == count


@given(lamps=st.builds(Lamps, *[st.booleans()] * 5))
def test_lamps_make_the_round_trip(lamps):
    (line,) = replies(encode_reply(lamps_line(lamps)))

    assert reply_kind(line) == "lamps"
    assert decode_lamps(line) == lamps


def test_a_printed_value_has_sign_value_unit_and_sorting_in_their_columns():
    line = printed_line(-12_345, Lamps(below=True))

    assert encode_reply(line) == b"-    1.2345  <\r\n"


@pytest.mark.parametrize("chunk", [1, 3, 4096])
def test_replies_survive_any_split_of_the_stream(chunk):
    sent = [Acknowledgement(), value_line(7), Refusal(), Line("+  0.0001", opened=False), lamps_line(Lamps())]

    assert replies(b"".join(map(encode_reply, sent)), chunk) == sent


@pytest.mark.parametrize("chunk", [1, 3, 4096])
def test_requests_survive_any_split_of_the_stream(chunk):
    sent = [Command("A0200"), Control(STX), Command("T0104"), Control(DC3)]

    assert requests(b"".join(map(encode_request, sent)), chunk) == sent


def test_flow_control_between_characters_is_no_reply():
    assert replies(bytes([DC3]) + b"\x02+0000" + bytes([DC1]) + b"00001\r\n") == [Line("+000000001")]


@pytest.mark.parametrize("data", [b"\x1bA02\r", b"\x1bA020A\r", b"A", b"\x1b\r", b"\x1b" + b"9" * 101])
def test_what_is_no_command_is_told_from_one(data):
    assert [type(request) for request in requests(data)] == [Unreadable]


@pytest.mark.parametrize("data", [b"\x02" + b"x" * 100, b"\x02\xff\xfe\r\n"])
def test_noise_is_refused_with_what_to_check(data):
    with pytest.raises(NdProtocolError, match=r"check baud rate"):
        replies(data)


@pytest.mark.parametrize("text", ["", "+12345678", "+1234567890", " 123456789", "+12345.789"])
def test_a_value_of_another_form_is_never_read_as_one(text):
    with pytest.raises(NdProtocolError, match="9 digits"):
        decode_count(Line(text))
