"""The codec of Universal Robots against packets that do not come from it."""

import json
import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.instruments.pieces import messages_in
from tests.helpers.refusals import assert_refused_at_worst
from truepose_drivers.universal_robots.protocol import (
    GREETING,
    Kind,
    LineReader,
    Packet,
    PacketReader,
    Recipe,
    UrProtocolError,
    agreed_recipe,
    controller_version,
    encode,
    encode_line,
    inputs_request,
    is_accepted,
    operator_message,
    outputs_request,
    recipe_reply,
    recipe_stated,
    requested_outputs,
    requested_version,
    require_greeting,
    stated_name,
    stated_version,
    text_message,
    verdict,
    version_request,
    words,
)
from truepose_drivers.universal_robots.script import (
    INPUTS,
    OUTPUTS,
    PROGRAM,
    Order,
    following,
    obstacle,
    order_in,
    robot_state,
)

DIALOGUE = json.loads((Path(__file__).parents[4] / "vectors" / "ur_rtde_dialogue.json").read_text())
STATE = {name: (1.0,) * (6 if kind == "VECTOR6D" else 1) for name, kind in OUTPUTS.items()}


def only_packet(data: bytes) -> Packet:
    reader = PacketReader()
    reader.receive_data(data)
    packet = reader.next_message()
    assert packet is not None
    assert not reader.inside_message
    return packet


def golden(name: str) -> bytes:
    return bytes.fromhex(DIALOGUE[name])


def test_requests_go_out_as_the_independent_client_sends_them():
    assert encode(version_request()) == golden("version_request")
    assert encode(Packet(Kind.CONTROLLER)) == golden("controller_request")


def test_requests_of_the_independent_client_are_read():
    frequency_hz, names = requested_outputs(only_packet(golden("outputs_request")).payload)

    assert (frequency_hz, names) == (DIALOGUE["frequency_hz"], DIALOGUE["outputs"])
    assert requested_version(only_packet(golden("version_request")).payload) == 2


def test_a_data_packet_is_read_and_written_byte_for_byte():
    example = DIALOGUE["data"]
    recipe = Recipe(1, example["fields"])
    values = {name: tuple(numbers) for name, numbers in example["values"].items()}

    packet = only_packet(bytes.fromhex(example["packet"]))

    assert recipe.unpack(packet.payload) == values
    assert encode(recipe.pack(values)) == bytes.fromhex(example["packet"])


def test_what_the_controller_tells_people_is_read():
    assert (
        operator_message(only_packet(bytes.fromhex(DIALOGUE["text"]["packet"])).payload)
        == DIALOGUE["text"]["said"]
    )


@pytest.mark.parametrize(
    ("packet", "read", "content"),
    [
        (verdict(Kind.START, accepted=True), is_accepted, True),
        (verdict(Kind.PAUSE, accepted=False), is_accepted, False),
        (controller_version((5, 11, 0, 108249)), stated_version, "5.11.0.108249"),
        (recipe_reply(Kind.INPUTS, 3, ["INT32", "IN_USE"]), recipe_stated, (3, ["INT32", "IN_USE"])),
        (inputs_request(["a", "b"]), words, ["a", "b"]),
        (outputs_request(20.0, ["timestamp"]), requested_outputs, (20.0, ["timestamp"])),
        (text_message("joint limits", "RTMachine", 0), operator_message, "joint limits"),
    ],
)
def test_each_side_reads_what_the_other_writes(packet, read, content):
    assert read(only_packet(encode(packet)).payload) == content


@given(cuts=st.lists(st.integers(1, 40)))
def test_packets_survive_any_split_and_any_merger(cuts):
    packets = [version_request(), Packet(Kind.DATA, bytes(50)), verdict(Kind.START, accepted=True)]
    stream = b"".join(map(encode, packets))
    reader, found = PacketReader(), []

    for size in [*cuts, len(stream)]:
        reader.receive_data(stream[:size])
        stream = stream[size:]
        while (packet := reader.next_message()) is not None:
            found.append(packet)

    assert found == packets


@given(st.binary(max_size=200))
def test_no_bytes_do_worse_than_to_be_no_packet(data):
    reader = PacketReader()
    reader.receive_data(data)
    recipe = Recipe(1, OUTPUTS)

    while (packet := assert_refused_at_worst(UrProtocolError, reader.next_message)) is not None:
        for read in (
            recipe.unpack,
            operator_message,
            is_accepted,
            recipe_stated,
            stated_version,
            requested_outputs,
        ):
            assert_refused_at_worst(UrProtocolError, read, packet.payload)


@pytest.mark.parametrize("data", [b"HTTP/1.1 400", b"\x00\x02V", b"\x00\x05X\x00\x02"])
def test_what_begins_no_packet_is_known_at_once(data):
    reader = PacketReader()
    reader.receive_data(data)

    with pytest.raises(UrProtocolError, match="is not the start of an RTDE packet"):
        reader.next_message()


@pytest.mark.parametrize("payload", [b"", b"\x02" + bytes(148), b"\x01" + bytes(3)])
def test_data_of_another_recipe_are_none(payload):
    with pytest.raises(UrProtocolError, match="expected"):
        Recipe(1, OUTPUTS).unpack(payload)


@pytest.mark.parametrize("number", [math.nan, math.inf])
def test_what_is_no_number_is_no_state(number):
    recipe = Recipe(1, {"timestamp": "DOUBLE"})
    packet = recipe.pack({"timestamp": (number,)})

    with pytest.raises(UrProtocolError, match="timestamp"):
        recipe.unpack(packet.payload)


def test_other_types_than_expected_are_not_taken():
    with pytest.raises(UrProtocolError, match="types INT32 were reported; expected DOUBLE"):
        agreed_recipe(1, ["INT32"], {"timestamp": "DOUBLE"})


def test_an_order_survives_the_registers():
    order = Order(7, 3, (0.1, -0.2, 0.3, 1e-9, 6.0, -6.0), 250.0, 0.349)

    recipe = Recipe(1, INPUTS)
    read = order_in(recipe.unpack(recipe.pack(order.values()).payload))

    assert (read.number, read.beat, read.target_rad) == (order.number, order.beat, order.target_rad)
    assert (read.tool_speed_mm_s, read.turning_speed_rad_s) == pytest.approx((250.0, 0.349), rel=1e-15)


def test_a_new_motion_has_a_number_that_none_of_the_last_had():
    state = robot_state(STATE | {"output_int_register_25": (41.0,)})

    assert state.unused_number == 42
    assert 0 < following(2**30) < 2**30


def test_the_program_is_balanced_and_reads_the_registers_that_are_written():
    opened = sum(line.split()[0] in {"def", "thread", "while", "if"} for line in PROGRAM.splitlines() if line)

    assert sum(line.strip() == "end" for line in PROGRAM.splitlines()) == opened
    assert PROGRAM.endswith("\nend\n")
    assert all(f"register({number})" in PROGRAM for number in (24, 25, 30, 31))


@pytest.mark.parametrize(
    ("robot_mode", "safety_mode", "says"),
    [
        (7, 3, "protective stop"),
        (7, 5, "safeguard"),
        (7, 6, "emergency stop of the cell"),
        (3, 7, "its emergency stop"),
        (7, 12, "mode 12"),
        (3, 1, "switched off"),
        (5, 1, "brakes"),
        (8, 2, "mode 8"),
    ],
)
def test_what_keeps_the_arm_from_moving_is_said_with_what_to_do(robot_mode, safety_mode, says):
    assert says in str(obstacle(robot_mode, safety_mode))


@pytest.mark.parametrize("safety_mode", [1, 2])
def test_nothing_is_said_of_an_arm_that_may_move(safety_mode):
    assert obstacle(7, safety_mode) is None


@given(st.binary(max_size=60), st.integers(1, 9))
def test_lines_come_whole_or_are_no_lines(data, size):
    found = messages_in(LineReader(), data + b"\n", size)

    assert found == [line.decode(errors="replace").strip() for line in data.split(b"\n")]


def test_a_line_without_end_is_no_line():
    reader = LineReader()
    reader.receive_data(b"x" * 1001)

    with pytest.raises(UrProtocolError, match="no line end"):
        reader.next_message()


def test_a_dashboard_says_who_it_is():
    require_greeting(GREETING)
    with pytest.raises(UrProtocolError, match="not an answer"):
        require_greeting("SSH-2.0-OpenSSH")


@pytest.mark.parametrize(
    ("line", "name"),
    [("20185000123", "20185000123"), ("UR10", "UR10"), ("could not understand: 'get robot model'", None)],
)
def test_a_name_is_taken_or_unknown(line, name):
    assert stated_name(line) == name
    assert encode_line(line).endswith(b"\n")


@pytest.mark.parametrize("line", ["", "<html>", "x" * 41])
def test_what_is_no_name_is_nonsense(line):
    with pytest.raises(UrProtocolError, match="not a name"):
        stated_name(line)
