"""How a box of gauges puts the questions on its line together."""

import pytest

from truepose_simulators.instruments.gauges.text_boxes import Questions


def test_lines_end_with_cr_lf_or_both_and_empty_ones_are_nothing():
    assert Questions().receive(b"M0\rMS\nM0\r\n\r\n") == ["M0", "MS", "M0"]


def test_a_line_may_come_in_any_pieces():
    questions = Questions()

    assert [questions.receive(bytes([byte])) for byte in b"M0\r\n"] == [[], [], ["M0"], []]


@pytest.mark.parametrize("noise", [b"\xff\xfe", b"Z" * 101, b"Z" * 200_000, b"\xaa" * 5_000])
@pytest.mark.parametrize("piece", [64, 4096, 1_000_000])
def test_after_noise_the_next_line_is_understood(noise, piece):
    stream = noise + b"\r\nM0\r\n"
    questions = Questions()

    heard = [questions.receive(stream[start : start + piece]) for start in range(0, len(stream), piece)]

    assert [line for lines in heard for line in lines] == ["M0"]
