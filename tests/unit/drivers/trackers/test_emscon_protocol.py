"""The emScon codec against bytes that it did not make, and against itself on anything else."""

import contextlib
import json
import struct
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.instruments.pieces import messages_in
from truepose_drivers.leica_emscon.protocol import (
    ELEMENTS,
    EXCHANGES,
    RESULTS,
    Answer,
    Command,
    ErrorReport,
    Frame,
    FrameReader,
    Layout,
    PacketError,
    Record,
    Request,
    Result,
    ResultStatus,
    ShortRequestError,
    StatusChange,
    SystemStatusChange,
    decode_from_server,
    decode_request,
    encode,
    exchange,
)

VECTORS = Path(__file__).parents[3] / "vectors"
SIZES = json.loads((VECTORS / "emscon_sizes.json").read_text())
CESAPI = json.loads((VECTORS / "emscon_cesapi.json").read_text())
DIALOGUE = json.loads((VECTORS / "emscon_dialogue.json").read_text())

INITIALIZED = encode(Answer(Command.INITIALIZE))


def frames(data: bytes) -> list[Frame]:
    return messages_in(FrameReader(), data)


def received(data: bytes):
    (packet,) = frames(data)
    return decode_from_server(packet)


def captured_value(index: int, kind_code: str, zero: object):
    """What the capture put into member `index`; see "rule" in the vector file."""
    if kind_code == "d":
        return index + 1.5
    if kind_code.endswith("s"):
        return f"T{index}"
    return True if zero is False else index + 1


def captured_record(layout: Layout) -> Record:
    return Record({
        name: captured_value(i, kind.code, kind.zero) for i, (name, kind) in enumerate(layout.members)
    })


@pytest.mark.parametrize("row", SIZES["commands"], ids=lambda row: row["name"])
def test_every_command_has_the_sizes_of_the_c_header(row):
    layouts = exchange(row["command"])

    assert layouts is not None
    assert 12 + layouts.request.size == row["request"]
    assert 16 + layouts.answer.size == row["answer"]


def test_the_table_of_commands_is_complete():
    assert {row["command"] for row in SIZES["commands"]} == set(Command)
    assert [number for number in range(143) if exchange(number) is None] == [50, 64, 141]


@pytest.mark.parametrize("row", SIZES["results"], ids=lambda row: row["name"])
def test_every_result_has_the_sizes_of_the_c_header(row):
    element = ELEMENTS.get(row["packet_type"])

    assert 12 + RESULTS[row["packet_type"]].size == row["members"]
    assert (element.size if element else 0) == row["element"]


@pytest.mark.parametrize("row", CESAPI["commands"], ids=lambda row: f"{row['command']}-{row['side']}")
def test_commands_are_packed_as_an_independent_client_packs_them(row):
    data = bytes.fromhex(row["hex"])
    layout = getattr(exchange(row["command"]), row["side"])
    values = captured_record(layout)

    (packet,) = frames(data)

    assert list(layout.names) == row["members"]
    if row["side"] == "request":
        assert decode_request(packet) == Request(row["command"], values)
        assert encode(Request(row["command"], values)) == data
    else:
        assert decode_from_server(packet) == Answer(row["command"], ResultStatus.ALL_OK, values)
        assert encode(Answer(row["command"], ResultStatus.ALL_OK, values)) == data


@pytest.mark.parametrize("row", CESAPI["results"], ids=lambda row: str(row["packet_type"]))
def test_results_are_packed_as_an_independent_client_packs_them(row):
    data = bytes.fromhex(row["hex"])
    result = Result(row["packet_type"], captured_record(RESULTS[row["packet_type"]]))

    assert received(data) == result
    assert encode(result) == data


@pytest.mark.parametrize("row", DIALOGUE["requests"], ids=lambda row: row["name"])
def test_requests_written_by_hand_are_met_byte_for_byte(row):
    data = bytes.fromhex(row["hex"])
    request = Request(row["command"], Record(row["values"]))

    assert encode(request) == data
    assert [decode_request(packet) for packet in frames(data)] == [request]


@pytest.mark.parametrize("row", DIALOGUE["from_server"], ids=lambda row: row["name"])
def test_packets_of_the_server_written_by_hand_are_met_byte_for_byte(row):
    packet = {
        "answer": lambda: Answer(row["command"], row["status"], Record(row["values"])),
        "error": lambda: ErrorReport(row["command"], row["status"]),
        "event": lambda: StatusChange(row["event"]),
        "result": lambda: Result(row["packet_type"], Record(row["values"]), row["status"]),
    }[row["kind"]]()

    assert received(bytes.fromhex(row["hex"])) == packet
    assert encode(packet).hex() == bytes.fromhex(row["hex"]).hex()


@given(cuts=st.lists(st.integers(1, 40), max_size=20))
def test_packets_survive_any_split_of_the_stream(cuts):
    packets = [
        Answer(Command.INITIALIZE),
        StatusChange(SystemStatusChange.MEAS_STATUS_BUSY),
        Result(7, Record(val1=1.0, val2=2.0, val3=3.0)),
        ErrorReport(Command.START_MEASUREMENT, ResultStatus.NO_DISTANCE_SET),
    ]
    stream = b"".join(map(encode, packets))
    reader = FrameReader()
    found = []

    for cut in [*cuts, len(stream)]:
        reader.receive_data(stream[:cut])
        stream = stream[cut:]
        while (packet := reader.next_message()) is not None:
            found.append(decode_from_server(packet))

    assert found == packets
    assert not reader.inside_message


def values_of(layout: Layout) -> st.SearchStrategy[Record]:
    by_code = {
        "d": st.floats(allow_nan=False),
        "i": st.integers(-(2**31), 2**31 - 1),
        "B3x": st.integers(0, 255),
        "64s": st.text(st.characters(codec="utf-16", exclude_characters="\0"), max_size=16),
        "256s": st.text(st.characters(codec="utf-16", exclude_characters="\0"), max_size=64),
    }
    return st.fixed_dictionaries({
        name: st.booleans() if kind.zero is False else by_code[kind.code] for name, kind in layout.members
    }).map(Record)


@given(data=st.data(), command=st.sampled_from(sorted(EXCHANGES)))
def test_every_request_and_answer_makes_the_round_trip(data, command):
    layouts = EXCHANGES[command]
    request = Request(command, data.draw(values_of(layouts.request)))
    answer = Answer(command, ResultStatus.ALL_OK, data.draw(values_of(layouts.answer)))

    assert decode_request(frames(encode(request))[0]) == request
    assert received(encode(answer)) == answer


@given(data=st.data(), packet_type=st.sampled_from(sorted(RESULTS)))
def test_every_result_makes_the_round_trip_with_its_elements(data, packet_type):
    values = data.draw(values_of(RESULTS[packet_type]))
    elements: list[Record] = []
    if packet_type in ELEMENTS:
        elements = data.draw(st.lists(values_of(ELEMENTS[packet_type]), max_size=3))
        values["number_of_results"] = len(elements)
    result = Result(packet_type, values, ResultStatus.ALL_OK, tuple(elements))

    assert received(encode(result)) == result


@given(body=st.binary(min_size=4, max_size=400), packet_type=st.integers(0, 12))
def test_any_body_is_decoded_or_refused_and_the_stream_goes_on(body, packet_type):
    reader = FrameReader()
    reader.receive_data(struct.pack("<iI", 8 + len(body), packet_type) + body + INITIALIZED)

    garbled = reader.next_message()
    for decode in (decode_request, decode_from_server):
        with contextlib.suppress(PacketError):  # any other exception fails the test
            decode(garbled)

    assert decode_from_server(reader.next_message()) == Answer(Command.INITIALIZE)


@pytest.mark.parametrize("size", [-1, 0, 8, 11, 65_537, 2**31 - 1])
def test_a_nonsense_size_is_refused_at_once_and_named(size):
    reader = FrameReader()
    reader.receive_data(INITIALIZED + struct.pack("<iI", size, 0))

    assert reader.next_message() is not None
    with pytest.raises(PacketError, match=f"of {size} bytes"):
        reader.next_message()


def test_a_packet_of_the_greatest_size_is_read():
    data = struct.pack("<iIII", 65_536, 0, Command.INITIALIZE, 0) + bytes(65_536 - 16)

    assert received(data) == Answer(Command.INITIALIZE)


@pytest.mark.parametrize("extra_bytes", [0, 8])
def test_a_failed_answer_is_read_short_and_at_full_size(extra_bytes):
    command = Command.GET_OBJECT_TEMPERATURE
    short = struct.pack("<iIII", 16 + extra_bytes, 0, command, ResultStatus.SERVER_BUSY) + bytes(extra_bytes)

    assert received(short) == Answer(command, ResultStatus.SERVER_BUSY)


def test_a_failed_answer_is_sent_at_full_size():
    data = encode(Answer(Command.GET_OBJECT_TEMPERATURE, ResultStatus.NOT_IMPLEMENTED))

    assert len(data) == 24


def test_an_answer_that_promises_members_and_lacks_them_is_refused():
    data = struct.pack("<iIII", 16, 0, Command.GET_FACE, ResultStatus.ALL_OK)

    with pytest.raises(PacketError, match="16 bytes should have 20"):
        received(data)


def test_an_error_packet_of_twelve_bytes_is_refused():
    with pytest.raises(PacketError, match="12 bytes should have 16"):
        received(struct.pack("<iII", 12, 1, Command.FIND_REFLECTOR))


def test_a_request_that_lacks_members_names_its_command():
    data = struct.pack("<iII", 12, 0, Command.SET_UNITS)

    with pytest.raises(ShortRequestError, match="command 5") as caught:
        decode_request(frames(data)[0])

    assert caught.value.command == Command.SET_UNITS


def test_an_unassigned_command_reaches_the_server_with_its_number():
    data = struct.pack("<iIIi", 16, 0, 141, 5)

    assert decode_request(frames(data)[0]) == Request(141)
    assert received(encode(Answer(141, ResultStatus.NOT_IMPLEMENTED))) == Answer(141, 2)


def test_a_client_that_sends_a_result_packet_is_refused():
    with pytest.raises(PacketError, match="type 8"):
        decode_request(frames(encode(StatusChange(1)))[0])


def test_an_unknown_packet_type_is_refused_by_its_number():
    with pytest.raises(PacketError, match="type 12"):
        received(struct.pack("<iII", 12, 12, 0))


def test_unknown_statuses_events_and_enumerations_stay_numbers():
    face = struct.pack("<iIIIi", 20, 0, Command.GET_FACE, 0, 77)

    assert received(face) == Answer(Command.GET_FACE, 0, Record(tracker_face=77))
    assert received(encode(ErrorReport(49, 123_456))) == ErrorReport(49, 123_456)
    assert received(encode(StatusChange(4711))) == StatusChange(4711)


@pytest.mark.parametrize("count", [-1, 2, 1_000_000])
def test_a_block_that_announces_elements_it_does_not_hold_is_refused(count):
    block = Result(
        3,
        Record(meas_mode=1, is_try_mode=False, temperature=20.0, pressure=1.0, humidity=50.0),
        elements=(Record(status=0, time1=0, time2=0, val1=0.0, val2=0.0, val3=0.0),),
    )
    data = bytearray(encode(block))
    struct.pack_into("<i", data, 12, count)

    with pytest.raises(PacketError):
        received(bytes(data))


def test_a_result_with_a_bad_status_may_lack_its_members():
    data = struct.pack("<iII", 12, 9, ResultStatus.NO_STATIONARY_RESULT)

    result = received(data)

    assert isinstance(result, Result)
    assert result.status == ResultStatus.NO_STATIONARY_RESULT


@pytest.mark.parametrize(
    ("values", "complaint"),
    [
        ({}, "needed"),
        ({"meas_time": 1, "use_adm": True, "more": 1}, "needed"),
        ({"meas_time": 1.5, "use_adm": True}, "not an integer"),
        ({"meas_time": 2**31, "use_adm": True}, "does not fit"),
    ],
)
def test_our_own_mistakes_are_refused_before_they_reach_the_wire(values, complaint):
    with pytest.raises(ValueError, match=complaint):
        encode(Request(Command.SET_STATIONARY_MODE_PARAMS, Record(values)))


def test_a_name_longer_than_its_field_is_refused():
    values = exchange(Command.GET_REFLECTORS).answer.zeros()
    values["reflector_name"] = "x" * 33

    with pytest.raises(ValueError, match="longer than 32"):
        encode(Answer(Command.GET_REFLECTORS, ResultStatus.ALL_OK, values))


def test_a_name_that_is_no_utf16_does_not_hide_the_numbers_beside_it():
    values = exchange(Command.GET_REFLECTORS).answer.zeros() | {"internal_reflector_id": 3}
    data = bytearray(encode(Answer(Command.GET_REFLECTORS, ResultStatus.ALL_OK, Record(values))))
    data[36:40] = b"\x00\xd8\x41\x00"  # a lone high surrogate, then A

    answer = received(bytes(data))

    assert answer.values["internal_reflector_id"] == 3
    assert "A" in answer.values["reflector_name"]


def test_members_are_read_as_what_they_are():
    record = Record(val1=1.0, val2=2, val3=3.0, reflector_name="RRR")

    assert record.vector() == (1.0, 2.0, 3.0)
    with pytest.raises(PacketError, match="text"):
        record.number("reflector_name")
    with pytest.raises(PacketError, match="integer"):
        record.integer("val1")
    with pytest.raises(PacketError, match="expected text"):
        record.text("val1")
