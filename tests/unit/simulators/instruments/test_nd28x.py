"""The simulated counter, asked character by character."""

import pytest

from tests.helpers.ballbar.length_sources import FakeBar, electronics
from truepose_drivers.heidenhain_nd.protocol import RequestReader, encode_reply
from truepose_simulators.faults.kinds import BallbarTooFast
from truepose_simulators.faults.scripted import Faults
from truepose_simulators.instruments.gauges.nd28x import Counter, nd28x_endpoint

NO_SIGNAL = b"\x02SIGNAL ERROR \r\n"
ACK, NAK = b"\x06", b"\x15"


def typed(counter: Counter, characters: bytes) -> bytes:
    """What the counter says to `characters`."""
    reader, said = RequestReader(), b""
    reader.receive_data(characters)
    while (request := reader.next_message()) is not None:
        said += b"".join(map(encode_reply, counter.answer(request)))
    return said


def keys(text: str) -> bytes:
    names = {"-": "T0101", ".": "T0102", "\n": "T0104", "c": "T0100"}
    return b"".join(b"\x1b%s\r" % names.get(key, f"T000{key}").encode() for key in text)


@pytest.fixture
def bar():
    return FakeBar()


@pytest.fixture
def counter(bar):
    return Counter(electronics(bar))


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (b"\x1bA0100\r", b"\x02   +0.1234\r\n"),
        (b"\x1bA0200\r", b"\x02+000001234\r\n"),
        (b"\x1bA0301\r", NAK),
        (b"\x1bA0400\r", b"\x02349797-04 \r\n"),
        (b"\x1bA0800\r", b"\x0201000000100000\r\n"),
        (b"\x02", b"+    0.1234  =\r\n"),
        (b"\x1bF0001\r", ACK + b"+    0.1234  =\r\n"),
        (b"\x05", NAK),
        (b"\x1bS0001\r\x1bS0002\r", ACK + ACK),
    ],
)
def test_every_question_has_the_manuals_answer(counter, asked, said):
    assert typed(counter, asked) == said


@pytest.mark.parametrize("asked", [b"\x1bA0201\r", b"\x1bX0000\r", b"A0200\r", b"\x1bA20\r", b"\x1bT9999\r"])
def test_what_it_does_not_know_is_refused(counter, asked):
    assert set(typed(counter, asked)) == set(NAK)


def test_the_identity_has_37_characters(counter):
    assert typed(counter, b"\x1bA0000\r") == b"\x02ND-287    \r\n349797-04 \r\n2001-05-04\r\n"


@pytest.mark.parametrize(("deviation_mm", "lamp"), [(-1.2, 7), (1.2, 9)])
def test_beyond_its_range_the_bar_is_sorted_out(bar, counter, deviation_mm, lamp):
    bar.deviation_mm, bar.signal = deviation_mm, "out_of_range"

    lamps = typed(counter, b"\x1bA0800\r")[1:-2].decode()

    assert [index for index, shown in enumerate(lamps) if shown == "1"] == [1, lamp]
    assert typed(counter, b"\x02")[-3:-2] == b"<>"[deviation_mm > 0 :][:1]


def test_without_a_signal_it_says_why_and_no_value(bar, counter):
    bar.signal = "none"

    assert typed(counter, b"\x1bA0200\r") == NAK
    assert typed(counter, b"\x02") == NAK
    assert (
        typed(counter, b"\x1bA0301\r")
        == typed(counter, b"\x05")
        == typed(counter, b"\x1bA0100\r")
        == NO_SIGNAL
    )


def test_a_bar_that_was_too_fast_says_so(bar):
    faults = Faults()
    faults.add(BallbarTooFast())
    counter = Counter(electronics(bar, faults))

    assert typed(counter, b"\x1bA0200\r") == NAK
    assert typed(counter, b"\x1bA0301\r") == b"\x02FREQU. ERROR \r\n"


def test_the_display_can_be_set_and_reset_by_its_keys(counter):
    assert typed(counter, keys("1.5\n")) == ACK * 4
    assert typed(counter, b"\x1bA0200\r") == b"\x02+000015000\r\n"

    assert typed(counter, keys("-2\n")) == ACK * 3
    assert typed(counter, b"\x1bA0200\r") == b"\x02-000020000\r\n"

    assert typed(counter, b"\x1bS0000\r") == ACK
    assert typed(counter, b"\x1bA0200\r") == b"\x02+000001234\r\n"


def test_an_entry_that_is_none_sets_nothing(counter):
    typed(counter, keys("9c\n") + keys("-\n") + keys(".\n") + keys("\n"))

    assert typed(counter, b"\x1bA0200\r") == b"\x02+000001234\r\n"


def test_reference_mode_shows_in_lamps_and_print(counter):
    assert typed(counter, b"\x1bF0000\r") == ACK

    assert typed(counter, b"\x1bA0800\r")[1:2] == b"1"
    assert typed(counter, b"\x02") == b"+    0.1234 R=\r\n"


class FakeStream:
    """What a client sends, piece by piece, and what it hears."""

    def __init__(self, *pieces: bytes) -> None:
        self._pieces = [*pieces, b""]
        self.heard: list[bytes] = []

    async def read(self, limit: int) -> bytes:
        return self._pieces.pop(0)

    def write(self, data: bytes) -> None:
        self.heard.append(data)

    async def drain(self) -> None: ...


async def test_xoff_holds_answers_back_until_xon(bar):
    stream = FakeStream(b"\x13\x1bA0200\r", b"\x1bA0400\r", b"\x11")

    await nd28x_endpoint(electronics(bar))._serve(stream, stream)

    assert [data for data in stream.heard if data] == [b"\x02+000001234\r\n\x02349797-04 \r\n"]


async def test_with_its_cable_out_the_line_is_dead_and_what_was_said_into_it_is_lost(bar):
    bar.plugged = False
    stream = FakeStream(b"\x1bA0200\r", b"\x1bA02")

    await nd28x_endpoint(electronics(bar))._serve(stream, stream)

    assert b"".join(stream.heard) == b""
