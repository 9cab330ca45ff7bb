"""Wire protocol of Leica emScon laser trackers: bytes in, packets out, no I/O.

Source: the C header of the public emScon SDK 3.6 and two open clients (see the folder's README). Binary,
little endian, structures packed to 4 bytes, strings UTF-16LE, port 700.

A side of the wire feeds a `FrameReader` and decodes its frames (`decode_request` in a server,
`decode_from_server` in a client); `encode` makes the bytes of any packet.
"""

from truepose_drivers.leica_emscon.protocol.command_members import EXCHANGES, exchange
from truepose_drivers.leica_emscon.protocol.commands import Command
from truepose_drivers.leica_emscon.protocol.packet_layouts import (
    Frame,
    FrameReader,
    Layout,
    PacketError,
    PacketType,
    Record,
    Value,
)
from truepose_drivers.leica_emscon.protocol.packets import (
    ELEMENTS,
    RESULTS,
    Answer,
    ErrorReport,
    FromServer,
    Request,
    Result,
    ShortRequestError,
    StatusChange,
    decode_from_server,
    decode_request,
    encode,
)
from truepose_drivers.leica_emscon.protocol.statuses import (
    MeasurementStatus,
    MeasurementStatusInfo,
    ResultStatus,
    RotationStatus,
    SystemStatusChange,
)

DEFAULT_PORT = 700

__all__ = [
    "DEFAULT_PORT",
    "ELEMENTS",
    "EXCHANGES",
    "RESULTS",
    "Answer",
    "Command",
    "ErrorReport",
    "Frame",
    "FrameReader",
    "FromServer",
    "Layout",
    "MeasurementStatus",
    "MeasurementStatusInfo",
    "PacketError",
    "PacketType",
    "Record",
    "Request",
    "Result",
    "ResultStatus",
    "RotationStatus",
    "ShortRequestError",
    "StatusChange",
    "SystemStatusChange",
    "Value",
    "decode_from_server",
    "decode_request",
    "encode",
    "exchange",
]
