"""Reports of the open HID ballbar and the descriptor that explains them."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from truepose_drivers.ballbar_hid.protocol import (
    BAR_BYTES,
    RATE_BYTES,
    READING_BYTES,
    BarIdentity,
    BarReading,
    HidBallbarError,
    Rate,
    Status,
    decode_bar,
    decode_rate,
    decode_reading,
    encode_bar,
    encode_rate,
    encode_reading,
    report_bytes,
    report_descriptor,
)

INPUT, FEATURE = 1, 3  # kinds of report
READING = BarReading(0.1234, False, Status(0), 7, 8_000_000, 21.37)


def test_a_reading_has_the_published_bytes():
    # id 1; 1234 = 0x04d2; in range; no status; number 7; 8 s = 0x7a1200 us; 21.37 deg C = 0x0859
    assert encode_reading(READING).hex(" ") == "01 d2 04 00 00 00 00 07 00 00 00 00 12 7a 00 59 08"


def test_no_value_is_the_one_number_outside_the_fields_range():
    report = encode_reading(BarReading(math.nan, False, Status(0), 0, 0, 0.0))

    assert report[1:5].hex() == "00000080"
    assert math.isnan(decode_reading(report).deviation_mm)


def test_features_have_the_published_bytes():
    assert encode_bar(BarIdentity(100.0, "BAR-7")).hex(" ") == "02 40 42 0f 00 42 41 52 2d 37" + " 00" * 7
    assert encode_rate(Rate(200, running=True)).hex(" ") == "03 c8 00 01"


@given(
    reading=st.builds(
        BarReading,
        st.integers(-(2**31) + 1, 2**31 - 1).map(lambda counts: counts / 10_000),
        st.booleans(),
        st.integers(0, 7).map(Status),
        st.integers(0, 2**32 - 1),
        st.integers(0, 2**32 - 1),
        st.integers(-27_315, 32_767).map(lambda counts: counts / 100),
    )
)
def test_readings_make_the_round_trip(reading):
    assert decode_reading(encode_reading(reading)) == reading


@given(rate=st.builds(Rate, st.integers(0, 65_535), st.booleans()))
def test_rates_make_the_round_trip(rate):
    assert decode_rate(encode_rate(rate)) == rate


@pytest.mark.parametrize("deviation_mm", [1e9, -1e9, math.inf])
def test_what_does_not_fit_is_limited_and_never_read_as_no_value(deviation_mm):
    shown = decode_reading(encode_reading(BarReading(deviation_mm, True, Status(0), 0, 0, 1e6))).deviation_mm

    assert math.copysign(1.0, shown) == math.copysign(1.0, deviation_mm)
    assert abs(shown) > 1e5


def test_a_report_that_comes_padded_is_read_all_the_same():
    assert decode_bar(encode_bar(BarIdentity(100.0, "BAR-7")) + bytes(3)) == BarIdentity(100.0, "BAR-7")


@pytest.mark.parametrize("report", [b"", b"\x01", bytes(17), encode_rate(Rate(1, True)), b"\x01" + bytes(15)])
def test_a_report_of_something_else_is_refused(report):
    with pytest.raises(HidBallbarError, match="is not report 1"):
        decode_reading(report)


def test_the_descriptor_begins_as_written_out_by_hand():
    # usage page sensors, usage distance 1D, application collection, report 1, sensors, distance,
    # from -(2^31 - 1) to 2^31 - 1, centimetre, 1e-5, 32 bits, once, input: variable with null state
    expected = (
        "05 20 09 87 a1 01 85 01 05 20 0a 79 04 17 01 00 00 80 27 ff ff ff 7f 65 11 55 0b 75 20 95 01 81 42"
    )

    assert report_descriptor().hex(" ").startswith(expected)
    assert report_descriptor()[-1:] == b"\xc0"


def test_another_parser_finds_every_field_where_the_codec_puts_it():
    hid = pytest.importorskip("usbip.classes.host.hid", reason="usbip is not installed: no other parser")

    reports, numbered = hid.parse_report_descriptor(report_descriptor())

    assert numbered
    sizes = {number: 1 + report.size for number, report in reports.items()}
    assert sizes == {(INPUT, 1): READING_BYTES, (FEATURE, 2): BAR_BYTES, (FEATURE, 3): RATE_BYTES}
    assert [report_bytes(number) for number in (1, 2, 3)] == [READING_BYTES, BAR_BYTES, RATE_BYTES]
    fields = [(f.usage_page, f.usages, f.report_size, f.report_count) for f in reports[INPUT, 1].fields]
    assert fields == [
        (0x20, (0x479,), 32, 1),
        (0x20, (0x47D,), 8, 1),
        (0xFF42, (1,), 8, 1),
        (0xFF42, (2,), 32, 1),
        (0xFF42, (3,), 32, 1),
        (0xFF42, (4,), 16, 1),
    ]
    assert reports[INPUT, 1].fields[0].logical_min == -(2**31) + 1
