"""The registers of the controller: numbers, and positions, which hold nothing before they are written."""

from collections.abc import Mapping

from truepose_drivers.fanuc_rmi.protocol import refusals
from truepose_drivers.fanuc_rmi.protocol.packets import Packet
from truepose_simulators.instruments.robot.fanuc_rmi.errors import RefusedError
from truepose_simulators.instruments.robot.fanuc_rmi.frames import six_in

Fields = Mapping[str, object]
_POSITION_REGISTERS = 100
_JOINTS = tuple(f"J{number}" for number in range(1, 7))


class Registers:
    """Numeric and position registers; both count from 1."""

    def __init__(self) -> None:
        self._numbers: dict[int, float] = {}
        self._positions: dict[int, Fields] = {}

    def number(self, asked: Packet) -> Fields:
        """Return a number as it stands in a reply."""
        register = asked.whole("RegisterNumber")
        return {"RegisterNumber": register, "RegisterValue": self._numbers.get(register, 0)}

    def write_number(self, asked: Packet) -> Fields:
        """Keep a number."""
        self._numbers[asked.whole("RegisterNumber")] = asked.number("RegisterValue")
        return {}

    def position(self, asked: Packet) -> Fields:
        """Return a position as it was written; raises RefusedError."""
        register = _position_register(asked)
        if register not in self._positions:
            raise RefusedError(refusals.BAD_POSITION_REGISTER)
        return {"RegisterNumber": register, **self._positions[register]}

    def write_position(self, asked: Packet) -> Fields:
        """Keep a position; raises RefusedError."""
        self._positions[_position_register(asked)] = _position_in(asked)
        return {}


def _position_register(asked: Packet) -> int:
    register = asked.whole("RegisterNumber")
    if not 1 <= register <= _POSITION_REGISTERS:
        raise RefusedError(refusals.BAD_POSITION_REGISTER)
    return register


def _position_in(asked: Packet) -> Fields:
    match asked.fields.get("Representation", "Cartesian"):
        case "Cartesian":
            six_in(asked.part("Position"))
            return _copied(asked, "Cartesian", "Configuration", "Position")
        case "Joint":
            angles = asked.part("JointAngle")
            for joint in _JOINTS:
                angles.number(joint)
            return _copied(asked, "Joint", "JointAngle")
        case _:
            raise RefusedError(refusals.BAD_REPRESENTATION)


def _copied(asked: Packet, representation: str, *parts: str) -> Fields:
    return {"Representation": representation, **{part: asked.part(part).fields for part in parts}}
