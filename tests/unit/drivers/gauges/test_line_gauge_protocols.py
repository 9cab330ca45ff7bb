"""Lines of boxes of gauges; the golden ones are the manuals'."""

import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.instruments.pieces import messages_in
from truepose_drivers.errors import RemoteProtocolError
from truepose_drivers.keyence_gt2 import protocol as keyence
from truepose_drivers.line_gauges.protocol import TextLines, Value, ValueForm
from truepose_drivers.mitutoyo_eh import protocol as eh
from truepose_drivers.mitutoyo_serial import protocol as serial

VECTORS = json.loads((Path(__file__).parents[3] / "vectors" / "line_gauges.json").read_text())
READERS = {"mitutoyo_serial": serial, "mitutoyo_eh": eh, "keyence_gt2": keyence}


def messages(protocol, data: bytes, chunk: int = 4096) -> list[object]:
    return messages_in(protocol.reply_reader(), data, chunk)


@pytest.mark.parametrize("chunk", [1, 4096])
@pytest.mark.parametrize("vector", VECTORS["mitutoyo_serial"]["values"])
def test_a_multiplexers_line_is_read(vector, chunk):
    value = Value(vector["shown"], vector["decimals"])

    assert messages(serial, bytes.fromhex(vector["hex"]), chunk) == [
        serial.ChannelValue(vector["channel"], value)
    ]
    assert serial.encode(serial.ChannelValue(vector["channel"], value)).hex() == vector["hex"]


def test_a_multiplexer_without_a_value_says_so_and_is_asked_by_a_digit():
    vectors = VECTORS["mitutoyo_serial"]

    assert messages(serial, bytes.fromhex(vectors["no_value"]["hex"])) == [serial.NoValue(911)]
    assert serial.encode_question(1).hex() == vectors["question"]["hex"]


@pytest.mark.parametrize("vector", VECTORS["mitutoyo_eh"]["values"])
def test_a_counters_line_is_read(vector):
    value = Value(vector["shown"], vector["decimals"])

    assert messages(eh, bytes.fromhex(vector["hex"]), 1) == [eh.CounterValue(vector["channel"], value)]
    assert eh.encode(eh.CounterValue(vector["channel"], value), b"\r\n").hex() == vector["hex"]


def test_a_counters_other_lines_are_told_apart():
    vectors = VECTORS["mitutoyo_eh"]

    assert messages(eh, bytes.fromhex(vectors["greatest"]["hex"]))[0].mode == "X"
    assert messages(eh, bytes.fromhex(vectors["done"]["hex"])) == [eh.Done(1)]
    assert messages(eh, bytes.fromhex(vectors["refused"]["hex"])) == [eh.Refusal(1, "10")]
    assert eh.encode_question(eh.Question("GA", 1), eh.ENDS["CR LF"]).hex() == vectors["question"]["hex"]


def test_amplifiers_are_read_with_and_without_their_states():
    vectors = VECTORS["keyence_gt2"]
    (values,) = messages(keyence, bytes.fromhex(vectors["values"]["hex"]), 1)
    (states,) = messages(keyence, bytes.fromhex(vectors["states"]["hex"]))

    assert [amplifier.value.shown for amplifier in values.all] == vectors["values"]["shown"]
    assert [amplifier.value.shown for amplifier in states.all] == vectors["states"]["shown"]
    assert [amplifier.state for amplifier in states.all] == vectors["states"]["states"]
    assert keyence.encode(states).hex() == vectors["states"]["hex"]
    assert messages(keyence, bytes.fromhex(vectors["refused"]["hex"])) == [keyence.Refusal("MS", "00")]
    assert keyence.encode_question(keyence.STATES_AND_VALUES).hex() == vectors["question"]["hex"]


@pytest.mark.parametrize("field", ["-----", "+-----.---", "+99999.999", "-99999.999"])
def test_an_amplifier_without_a_value_has_none(field):
    (amplifiers,) = messages(keyence, f"MS,00,{field}\r\n".encode())

    assert amplifiers.all == (keyence.Amplifier(None),)


@pytest.mark.parametrize(
    ("name", "line"),
    [
        *(("mitutoyo_serial", line) for line in ("", "0", "01A+0.1", "01B+0000.123", "01A+0000.12.3", "9")),
        *(
            ("mitutoyo_eh", line)
            for line in ("GN01,+1", "GN1,+0016.2345", "GN01+0016.2345", "GQ01,+0016.2345")
        ),
        *(
            ("keyence_gt2", line)
            for line in ("M0", "MS,00", "MS,07,+00012.345", "M0,+1", "M0,+00012.345,", "X")
        ),
    ],
)
def test_what_is_no_answer_is_told(name, line):
    with pytest.raises(RemoteProtocolError):
        READERS[name].decode(line)


@pytest.mark.parametrize("name", READERS)
@given(data=st.binary(max_size=60))
def test_after_anything_the_second_good_line_is_read(name, data):
    protocol = READERS[name]
    good = {
        "mitutoyo_serial": b"01A+0000.123\r",
        "mitutoyo_eh": b"GN01,+0016.2345\r\n",
        "keyence_gt2": b"MS,04,+00012.345\r\n",
    }[name]
    reader, found = protocol.reply_reader(), []
    reader.receive_data(data + b"\r" + good + good)
    while True:
        try:
            message = reader.next_message()
        except RemoteProtocolError:
            continue
        if message is None:
            break
        found.append(message)

    assert found[-1] == protocol.decode(good.decode().strip())
    assert not reader.inside_message


def test_lines_end_as_the_box_is_set():
    reader = TextLines(str)
    reader.receive_data(b"one\rtwo\nthree\r\nfour\r\n\r\nfi")

    assert [reader.next_message() for _ in range(5)] == ["one", "two", "three", "four", None]
    assert reader.inside_message


def test_a_line_without_end_is_told():
    reader = TextLines(str)
    reader.receive_data(b"x" * 401)

    with pytest.raises(RemoteProtocolError, match="does not end"):
        reader.next_message()


def test_a_form_is_learnt_from_two_values_that_agree():
    form = ValueForm(None, RemoteProtocolError)
    form.learn(Value(0.1, 3, 8), Value(0.12, 4, 8))
    assert not form.known

    form.learn(Value(0.1, 3, 8), Value(0.2, 3, 8))

    assert form.resolution_mm == pytest.approx(1e-3)
    form.require(Value(0.3, 3, 8))
    with pytest.raises(RemoteProtocolError, match="inches"):
        form.require(Value(0.3, 3, 9))


def test_inches_are_learnt_from_nothing():
    form = ValueForm(None, RemoteProtocolError)

    form.learn(Value(0.1, 5, 8), Value(0.1, 5, 8))

    assert not form.known
