"""Bytes of USB/IP, of setup packets and of descriptors; golden ones from the kernel's documentation."""

import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from truepose_drivers.errors import RemoteProtocolError
from truepose_drivers.usb import usbip
from truepose_drivers.usb.protocol import (
    Configuration,
    DescriptorError,
    Device,
    Endpoint,
    Interface,
    Setup,
    configuration_total_bytes,
    decode_configuration,
    decode_device,
    decode_setup,
    encode_configuration,
    encode_device,
    encode_languages,
    encode_setup,
    encode_string,
)
from truepose_drivers.usb.usbip import (
    DeviceRecord,
    Operation,
    Submit,
    SubmitReply,
    Unlink,
    UnlinkReply,
    UsbipProtocolError,
    decode_operation,
    decode_record,
    decode_reply,
    decode_request,
    encode_busid,
    encode_operation,
    encode_record,
    encode_reply,
    encode_request,
)

VECTORS = json.loads((Path(__file__).parents[3] / "vectors" / "usbip_transfers.json").read_text())
bytes_ = st.integers(0, 255)
words = st.integers(0, 65_535)
longs = st.integers(0, 2**32 - 1)
statuses = st.integers(-(2**31), 2**31 - 1)


def golden(name: str) -> bytes:
    return bytes.fromhex(VECTORS[name]["hex"])


@pytest.mark.parametrize("name", ["submit_in", "submit_out"])
def test_the_kernels_transfers_are_read(name):
    expected = {key: value for key, value in VECTORS[name].items() if key != "hex"}

    request, following = decode_request(golden(name))

    assert {key: getattr(request, key) for key in expected} == expected
    assert following == (0 if expected["is_in"] else expected["length"])


def test_the_kernels_reply_is_read_and_written():
    expected = SubmitReply(3334, 0, 64)

    assert decode_reply(golden("return_out")) == expected
    assert encode_reply(expected) == golden("return_out")


def test_giving_up_has_the_documented_form_both_ways():
    assert encode_request(Unlink(3335, 65_551, 3333)) == golden("unlink")
    assert decode_request(golden("unlink")) == (Unlink(3335, 65_551, 3333), 0)
    assert encode_reply(UnlinkReply(3335, -104)) == golden("unlinked")
    assert decode_reply(golden("unlinked")) == UnlinkReply(3335, -104)


def test_operations_have_the_documented_form():
    assert encode_operation(Operation(usbip.LIST_REQUEST)) == golden("list_request")
    importing = encode_operation(Operation(usbip.IMPORT_REQUEST)) + encode_busid("1-1")
    assert importing == golden("import_request")
    assert usbip.RECORD_BYTES == 312  # table of the documentation


@given(
    submit=st.builds(
        Submit, longs, longs, st.integers(0, 15), st.booleans(), st.integers(0, 4096), st.just(bytes(8))
    )
)
def test_transfers_make_the_round_trip(submit):
    request, following = decode_request(encode_request(submit))

    assert request == submit
    assert following == (0 if submit.is_in else submit.length)


@given(
    reply=st.one_of(st.builds(SubmitReply, longs, statuses, words), st.builds(UnlinkReply, longs, statuses))
)
def test_replies_make_the_round_trip(reply):
    assert decode_reply(encode_reply(reply)) == reply


@given(
    record=st.builds(
        DeviceRecord,
        st.just("/sys/x"),
        st.just("1-1"),
        *[longs] * 3,
        *[words] * 3,
        *[bytes_] * 6,
    )
)
def test_records_make_the_round_trip(record):
    assert decode_record(encode_record(record)) == record


@pytest.mark.parametrize("data", [b"GET / HT", bytes(8), b"\x01\x06\x80\x05\x00\x00\x00\x00"])
def test_another_protocol_or_version_is_told(data):
    with pytest.raises(UsbipProtocolError, match="is not USB/IP"):
        decode_operation(data)


@pytest.mark.parametrize("head", [0, 3, 4, 99])
def test_what_is_no_request_is_told(head):
    with pytest.raises(UsbipProtocolError, match="not a USB/IP request"):
        decode_request(head.to_bytes(4, "big") + bytes(44))


@pytest.mark.parametrize("length", [-1, 2**31 - 1])
def test_a_transfer_of_an_impossible_length_is_never_waited_for(length):
    header = bytearray(encode_request(Submit(1, 2, 0, False, 0)))
    header[24:28] = length.to_bytes(4, "big", signed=True)

    with pytest.raises(UsbipProtocolError, match="bytes"):
        decode_request(bytes(header))


@given(setup=st.builds(Setup, bytes_, bytes_, words, words, words))
def test_setup_packets_make_the_round_trip(setup):
    assert decode_setup(encode_setup(setup)) == setup


def test_a_setup_packet_is_little_endian():
    # USB 2.0, section 9.4.3: GET_DESCRIPTOR of the device, 18 bytes
    assert encode_setup(Setup(0x80, 6, 0x0100, 0, 18)).hex(" ") == "80 06 00 01 00 00 12 00"


def test_a_setup_packet_of_another_size_is_told():
    with pytest.raises(RemoteProtocolError, match="8 bytes"):
        decode_setup(bytes(7))


def test_a_device_descriptor_has_the_standards_bytes():
    device = Device(0x0FE7, 0x4001, 0x0100, packet_bytes=8)

    encoded = encode_device(device)

    # USB 2.0, table 9-8, field by field
    assert encoded.hex(" ") == "12 01 00 02 00 00 00 08 e7 0f 01 40 00 01 01 02 03 01"
    assert decode_device(encoded) == device


def test_a_boot_keyboards_configuration_is_the_one_of_the_hid_specification():
    endpoint = Endpoint(0x81, 3, 8, 10)
    interface = Interface(0, 3, 1, 1, (endpoint,), report_descriptor_bytes=63)

    encoded = encode_configuration(Configuration(1, (interface,), attributes=0xA0))

    # HID 1.11, appendix E.2 to E.5, of a keyboard
    assert encoded.hex(" ") == (
        "09 02 22 00 01 01 00 a0 32 09 04 00 00 01 03 01 01 00"
        " 09 21 11 01 00 01 22 3f 00 07 05 81 03 08 00 0a"
    )
    assert configuration_total_bytes(encoded) == len(encoded)
    assert decode_configuration(encoded).interfaces == (interface,)


def test_descriptors_of_kinds_unknown_here_are_passed_over():
    interface = Interface(0, 0xFF, 0, 0, (Endpoint(0x81, 3, 8, 10),))
    head = encode_configuration(Configuration(1, (interface,)))
    data = head[:18] + b"\x05\x24\x00\x10\x01" + head[18:]

    assert decode_configuration(data).interfaces == (interface,)


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"\x09\x02",
        b"\x00\x02" + bytes(7),
        b"\x09\x04" + bytes(7),
        b"\x09\x02\x22\x00" + bytes(5) + b"\x07\x05",
    ],
)
def test_a_broken_configuration_is_told(data):
    with pytest.raises(DescriptorError):
        decode_configuration(data)


def test_strings_are_utf_16_and_never_longer_than_they_may_be():
    assert encode_string("é") == b"\x04\x03\xe9\x00"
    assert len(encode_string("x" * 200)) <= 255
    assert encode_string("x" * 200)[0] == len(encode_string("x" * 200))
    assert encode_languages() == b"\x04\x03\x09\x04"
