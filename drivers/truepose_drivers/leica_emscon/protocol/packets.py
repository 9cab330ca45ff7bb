"""Packets as values: encode for either side of the wire, decode for each.

Members of the result packets 2..7 and 9..11 (SDK 3.6, C header) start at byte 12 behind the status. The
packets of continuous measurements hold a block of elements behind their members.

A client decodes with `decode_from_server`, a server with `decode_request`: requests and answers share the
packet type and only the direction tells them apart.
"""

import struct
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

from truepose_drivers.leica_emscon.protocol.command_members import exchange
from truepose_drivers.leica_emscon.protocol.packet_layouts import (
    LONGEST_PACKET_BYTES,
    Frame,
    Layout,
    PacketError,
    PacketType,
    Record,
    frame,
)
from truepose_drivers.leica_emscon.protocol.statuses import ResultStatus

_AIR = "f64 temperature pressure humidity"
_STD = "f64 std1 std2 std3 std_total"
_APRIORI_STD = "f64 apriori_std1 apriori_std2 apriori_std3 apriori_std_total"
_APRIORI_COVARIANCE = "f64 apriori_covar12 apriori_covar13 apriori_covar23"
_QUATERNION_AND_ANGLES = (
    "f64 quaternion0 quaternion1 quaternion2 quaternion3 rotation_angle_x rotation_angle_y rotation_angle_z"
)
_POSITION_STD = (
    "f64 std_dev_position1 std_dev_position2 std_dev_position3 std_dev_position_total"
    " covar_position12 covar_position13 covar_position23"
)
_POSITION_APRIORI_STD = (
    "f64 apriori_std_dev_position1 apriori_std_dev_position2 apriori_std_dev_position3"
    " apriori_std_dev_position_total apriori_covar_position12 apriori_covar_position13"
    " apriori_covar_position23"
)
_ROTATION_STD = (
    "f64 std_dev_rotation_angle_x std_dev_rotation_angle_y std_dev_rotation_angle_z"
    " std_dev_rotation_angle_total covar_rotation_angle_xy covar_rotation_angle_xz"
    " covar_rotation_angle_yz"
)
_ROTATION_APRIORI_STD = (
    "f64 apriori_std_dev_rotation_angle_x apriori_std_dev_rotation_angle_y"
    " apriori_std_dev_rotation_angle_z apriori_std_dev_rotation_angle_total"
    " apriori_covar_rotation_angle_xy apriori_covar_rotation_angle_xz apriori_covar_rotation_angle_yz"
)
_POSITION = "f64 position1 position2 position3"
_MODE = "MeasMode meas_mode; bool is_try_mode"
_COUNT = "i32 number_of_results"
_TIP = "MeasurementTipStatus tip_status; i32 internal_tip_adapter_id tip_adapter_interface"
_STAMP = "i32 time1 time2"  # seconds, then microseconds since the start of the measurement


def _layout(*groups: str) -> Layout:
    return Layout.of("; ".join(groups))


RESULTS: Mapping[int, Layout] = {
    PacketType.SINGLE_MEAS_RESULT: _layout(
        _MODE,
        "f64 val1 val2 val3",
        _STD,
        "f64 pointing_error1 pointing_error2 pointing_error3",
        _APRIORI_STD,
        _AIR,
    ),
    PacketType.SINGLE_MEAS_RESULT_2: _layout(
        _MODE,
        "f64 val1 val2 val3",
        _STD,
        "f64 covar12 covar13 covar23",
        "f64 pointing_error_h pointing_error_v pointing_error_d",
        _APRIORI_STD,
        _APRIORI_COVARIANCE,
        _AIR,
    ),
    PacketType.MULTI_MEAS_RESULT: _layout(_COUNT, _MODE, _AIR),
    PacketType.MULTI_MEAS_RESULT_2: _layout(_COUNT, _MODE, _AIR),
    PacketType.STATIONARY_PROBE_MEAS_RESULT: _layout(
        _MODE,
        "TriggerStatus trigger_status; i32 rotation_status internal_probe_id field_number",
        _TIP,
        _POSITION,
        _POSITION_STD,
        _POSITION_APRIORI_STD,
        _QUATERNION_AND_ANGLES,
        _ROTATION_STD,
        _ROTATION_APRIORI_STD,
        _AIR,
    ),
    PacketType.CONTINUOUS_PROBE_MEAS_RESULT: _layout(
        _COUNT, _MODE, "i32 internal_probe_id field_number", _TIP, _AIR
    ),
    PacketType.NIVEL_RESULT: _layout("NivelStatus nivel_status; f64 x_tilt y_tilt nivel_temperature"),
    PacketType.REFLECTOR_POS_RESULT: _layout("f64 val1 val2 val3"),
    PacketType.PROBE_POS_RESULT: _layout("i32 rotation_status", _TIP, _POSITION, _QUATERNION_AND_ANGLES),
}
"""Members that every packet of the type has, elements not included."""

ELEMENTS: Mapping[int, Layout] = {
    PacketType.MULTI_MEAS_RESULT: _layout("MeasurementStatus status", _STAMP, "f64 val1 val2 val3"),
    PacketType.MULTI_MEAS_RESULT_2: _layout(
        "MeasurementStatus status", _STAMP, "f64 val1 val2 val3", _APRIORI_STD, _APRIORI_COVARIANCE
    ),
    PacketType.CONTINUOUS_PROBE_MEAS_RESULT: _layout(
        "MeasurementStatus status; TriggerStatus trigger_status; i32 rotation_status",
        _STAMP,
        _POSITION,
        _POSITION_STD,
        _QUATERNION_AND_ANGLES,
        _ROTATION_STD,
    ),
}
"""One element of the packet types that carry blocks; member number_of_results counts them."""


_WORD = struct.Struct("<I")
_WORDS = struct.Struct("<II")
_FIRST_MEMBER = 8  # behind packet size and type
_REQUEST_MEMBERS = 12  # behind the command
_ANSWER_MEMBERS = 16  # behind command and status
_RESULT_MEMBERS = 12  # behind the status


@dataclass(frozen=True, slots=True)
class Request:
    """A command and its members; `command` may be a number that the protocol does not assign."""

    command: int
    values: Record = field(default_factory=Record)


@dataclass(frozen=True, slots=True)
class Answer:
    """The answer to a command; has members only when `status` is 0."""

    command: int
    status: int = ResultStatus.ALL_OK
    values: Record = field(default_factory=Record)


@dataclass(frozen=True, slots=True)
class ErrorReport:
    """A failure, unasked or in place of an answer; `command` is the one that was active."""

    command: int
    status: int


@dataclass(frozen=True, slots=True)
class StatusChange:
    """An unasked announcement; `event` is a SystemStatusChange or a number unknown to this header."""

    event: int


@dataclass(frozen=True, slots=True)
class Result:
    """Measured values; `elements` only in the packets of continuous measurements."""

    packet_type: int
    values: Record
    status: int = ResultStatus.ALL_OK
    elements: tuple[Record, ...] = ()


FromServer: TypeAlias = Answer | ErrorReport | StatusChange | Result


class ShortRequestError(PacketError):
    """A request lacks members; a server answers it with WrongParameter and reads on."""

    def __init__(self, command: int, message: str) -> None:
        super().__init__(message)
        self.command = command


def encode(packet: Request | FromServer) -> bytes:
    """Return the bytes of a packet; raises ValueError when its members do not fit its layout."""
    match packet:
        case Request(command, values):
            return frame(PacketType.COMMAND, _WORD.pack(command) + _request_members(command, values))
        case Answer(command, status, values):
            members = _answer_members(command, status, values)
            return frame(PacketType.COMMAND, _WORDS.pack(command, status) + members)
        case ErrorReport(command, status):
            return frame(PacketType.ERROR, _WORDS.pack(command, status))
        case StatusChange(event):
            return frame(PacketType.SYSTEM_STATUS_CHANGE, _WORD.pack(event))
        case Result():
            return _encode_result(packet)


def decode_request(packet: Frame) -> Request:
    """Read a packet as a server does.

    A number without a layout keeps its place, without members. Raises ShortRequestError when members
    are missing and PacketError when the packet is not a command; bytes too many are ignored.
    """
    # Clients send nothing else; results and announcements go the other way only.
    if packet.packet_type != PacketType.COMMAND:
        raise PacketError(f"a client sent a packet of type {packet.packet_type}; requests have type 0")
    (command,) = _WORD.unpack_from(packet.data, _FIRST_MEMBER)
    layouts = exchange(command)
    if layouts is None:
        return Request(command)
    try:
        return Request(command, layouts.request.unpack(packet.data, _REQUEST_MEMBERS))
    except PacketError as error:
        raise ShortRequestError(command, f"request of command {command}: {error}") from error


def decode_from_server(packet: Frame) -> FromServer:
    """Read a packet as a client does; raises PacketError for an unknown type or missing members."""
    match packet.packet_type:
        case PacketType.COMMAND:
            return _decode_answer(packet.data)
        case PacketType.ERROR:
            return ErrorReport(*_two_words(packet.data))
        case PacketType.SYSTEM_STATUS_CHANGE:
            return StatusChange(_WORD.unpack_from(packet.data, _FIRST_MEMBER)[0])
        case known if known in RESULTS:
            return _decode_result(packet)
        case unknown:
            raise PacketError(f"the tracker sent a packet of type {unknown}; types 0 to 11 are known")


def _request_members(command: int, values: Record) -> bytes:
    layouts = exchange(command)
    if layouts is None:
        if values:
            raise ValueError(f"command {command} is not assigned: its members are unknown")
        return b""
    return layouts.request.pack(values)


def _answer_members(command: int, status: int, values: Record) -> bytes:
    layouts = exchange(command)
    if layouts is None:
        return b""
    if status != ResultStatus.ALL_OK:
        # Known clients unpack a failed answer at its full size before they look at the status.
        return bytes(layouts.answer.size)
    return layouts.answer.pack(values)


def _two_words(data: bytes) -> tuple[int, int]:
    if len(data) < _FIRST_MEMBER + _WORDS.size:
        raise PacketError(f"a packet of {len(data)} bytes should have {_FIRST_MEMBER + _WORDS.size}")
    first, second = _WORDS.unpack_from(data, _FIRST_MEMBER)
    return first, second


def _decode_answer(data: bytes) -> Answer:
    command, status = _two_words(data)
    layouts = exchange(command)
    # Members of a failed answer are not valid; no source says whether servers send them.
    if layouts is None or status != ResultStatus.ALL_OK:
        return Answer(command, status)
    return Answer(command, status, layouts.answer.unpack(data, _ANSWER_MEMBERS))


def _encode_result(result: Result) -> bytes:
    if result.packet_type not in RESULTS:
        raise ValueError(f"{result.packet_type} is not a type of result packet")
    kind = PacketType(result.packet_type)
    members, elements = result.values, b""
    if kind in ELEMENTS:
        members = Record(members, number_of_results=len(result.elements))
        elements = b"".join(ELEMENTS[kind].pack(element) for element in result.elements)
    elif result.elements:
        raise ValueError(f"packets of type {kind.name} carry no elements")
    return frame(kind, _WORD.pack(result.status) + RESULTS[kind].pack(members) + elements)


def _decode_result(packet: Frame) -> Result:
    (status,) = _WORD.unpack_from(packet.data, _FIRST_MEMBER)
    layout = RESULTS[packet.packet_type]
    # How long a failed result is no source says: it is read at either length.
    if status != ResultStatus.ALL_OK and len(packet.data) < _RESULT_MEMBERS + layout.size:
        return Result(packet.packet_type, layout.zeros(), status)
    values = layout.unpack(packet.data, _RESULT_MEMBERS)
    return Result(packet.packet_type, values, status, _decode_elements(packet, values))


def _decode_elements(packet: Frame, values: Record) -> tuple[Record, ...]:
    layout = ELEMENTS.get(packet.packet_type)
    if layout is None:
        return ()
    start = _RESULT_MEMBERS + RESULTS[packet.packet_type].size
    count = values.integer("number_of_results")
    if not 0 <= count <= (LONGEST_PACKET_BYTES - start) // layout.size:
        raise PacketError(f"a packet of type {packet.packet_type} announces {count} elements")
    return tuple(layout.unpack(packet.data, start + index * layout.size) for index in range(count))
