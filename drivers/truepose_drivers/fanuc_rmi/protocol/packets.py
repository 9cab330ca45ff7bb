"""Packets of the Remote Motion Interface (RMI): JSON objects, each ended by CR LF.

Source: the packet definitions of FANUC's own public driver, which follow the operator's manual B-84184EN/03.
A packet names itself under one of three keys: what concerns the session, a command that is carried out at
once, or an instruction that is queued behind those before it. A reply has key and name of its request.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

from truepose_drivers.errors import RemoteProtocolError
from truepose_drivers.json_lines import LineReader, decode_object, finite_number


class RmiProtocolError(RemoteProtocolError):
    """The other side sent what is no packet of the Remote Motion Interface."""


class Kind(StrEnum):
    """The key under which a packet names itself."""

    SESSION = "Communication"
    COMMAND = "Command"
    INSTRUCTION = "Instruction"


@dataclass(frozen=True, slots=True)
class Packet:
    """One packet in either direction."""

    kind: Kind
    name: str
    fields: Mapping[str, object] = field(default_factory=dict)

    def number(self, name: str) -> float:
        """Return a number of the packet; raises RmiProtocolError."""
        value = finite_number(self.fields.get(name))
        if value is None:
            raise RmiProtocolError(f"{self.name} states {name} as {self.fields.get(name)!r}: no number")
        return value

    def whole(self, name: str) -> int:
        """Return a whole number of the packet; raises RmiProtocolError."""
        value = self.number(name)
        if value != int(value):
            raise RmiProtocolError(f"{self.name} states {name} as {value!r}: no whole number")
        return int(value)

    def part(self, name: str) -> "Packet":
        """Return an object inside the packet as one of its own; raises RmiProtocolError."""
        value = self.fields.get(name)
        if not isinstance(value, Mapping):
            raise RmiProtocolError(f"{self.name} has no {name}")
        return Packet(self.kind, f"{name} of {self.name}", value)


class PacketReader:
    """Reassembles packets from a byte stream; serves both sides of the wire."""

    def __init__(self) -> None:
        self._lines = LineReader()

    @property
    def inside_message(self) -> bool:
        """Whether more stands here than was taken."""
        return self._lines.inside_message

    def receive_data(self, data: bytes) -> None:
        """Append what the stream delivered."""
        self._lines.receive_data(data)

    def next_message(self) -> Packet | None:
        """Take the oldest whole packet, None until more arrives; raises RemoteProtocolError."""
        line = self._lines.next_message()
        return None if line is None else decode(line)


def encode(packet: Packet) -> bytes:
    """Return the line of a packet; raises ValueError when a number is not finite."""
    return json.dumps({packet.kind: packet.name, **packet.fields}, allow_nan=False).encode() + b"\r\n"


def decode(line: bytes) -> Packet:
    """Read a line without its line feed; raises RemoteProtocolError."""
    document = decode_object(line)
    kinds = [kind for kind in Kind if kind in document]
    name = document.pop(kinds[0]) if kinds else None
    if len(kinds) != 1 or not isinstance(name, str):
        raise RmiProtocolError(f"{line[:80]!r} does not name one packet of the Remote Motion Interface")
    return Packet(kinds[0], name, document)
