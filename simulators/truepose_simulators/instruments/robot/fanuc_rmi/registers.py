"""Frames and registers of the controller: where its user frames and tools are, numbers, and positions."""

from collections.abc import Mapping

import numpy as np

from truepose_drivers.fanuc_rmi import protocol
from truepose_drivers.fanuc_rmi.protocol import Packet
from truepose_simulators.cell.robot import nominal_flange
from truepose_simulators.errors import SimulatorError
from truepose_simulators.instruments.robot.kinematics import flange_angles_deg, rotation_of, world
from truepose_simulators.physics.arm import Arm
from truepose_simulators.physics.rigid import FloatArray, inverse, motion


class RefusedError(SimulatorError):
    """The controller refuses with a number."""

    def __init__(self, error: int, shown: str = "") -> None:
        super().__init__(shown or f"error {error}")
        self.error = error
        self.shown = shown  # on its pendant


_KEYS = ("X", "Y", "Z", "W", "P", "R")
_ADDITIONAL = ("Ext1", "Ext2", "Ext3")
_NOWHERE = (0.0,) * 6
# Postures are not told apart here: every one is stated as this.
_POSTURE = {"Front": 1, "Up": 1, "Left": 0, "Flip": 0, "Turn4": 0, "Turn5": 0, "Turn6": 0}

Six = tuple[float, ...]


class Frames:
    """User frames and tools by number; frame 0 is the world, and nothing was taught yet."""

    def __init__(self, arm: Arm) -> None:
        self._arm = arm
        self.user: dict[int, Six] = dict.fromkeys(range(10), _NOWHERE)
        self.tools: dict[int, Six] = dict.fromkeys(range(1, 11), _NOWHERE)
        self.user_number = 0
        self.tool_number = 1

    def position(self, joints_rad: FloatArray) -> Six:
        """Return where the active tool is in the active frame, x y z w p r."""
        flange = nominal_flange(self._arm, joints_rad[np.newaxis])[0]
        return _six(inverse(self._world()) @ flange @ self._tool())

    def flange(self, position: Six) -> FloatArray:
        """Return where the flange is in the drawing's frame when the active tool is at `position`."""
        placed: FloatArray = self._world() @ _placed(position) @ inverse(self._tool())
        return placed

    def stated(self, position: Six) -> dict[str, object]:
        """Return a position as it stands in a packet, with the frames that it is in."""
        numbers = {"UToolNumber": self.tool_number, "UFrameNumber": self.user_number}
        return {"Configuration": {**numbers, **_POSTURE}, "Position": fields_of(position, _ADDITIONAL)}

    def _world(self) -> FloatArray:
        placed: FloatArray = world(self._arm) @ _placed(self.user[self.user_number])
        return placed

    def _tool(self) -> FloatArray:
        return _placed(self.tools[self.tool_number])


def six_in(stated: Packet) -> Six:
    """Return the six numbers of a position or frame; raises RmiProtocolError."""
    return tuple(stated.number(key) for key in _KEYS)


def fields_of(six: Six, further: tuple[str, ...] = ()) -> Mapping[str, float]:
    """Return six numbers as they stand in a packet."""
    rounded = (round(value, 3) + 0.0 for value in (*six, *(0.0 for _ in further)))
    return dict(zip((*_KEYS, *further), rounded, strict=True))


def _placed(six: Six) -> FloatArray:
    return motion(np.array(six[:3]), rotation_of(*six[3:]))


def _six(frame: FloatArray) -> Six:
    return (*frame[:3, 3].tolist(), *flange_angles_deg(frame[:3, :3]))


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
            raise RefusedError(protocol.BAD_POSITION_REGISTER)
        return {"RegisterNumber": register, **self._positions[register]}

    def write_position(self, asked: Packet) -> Fields:
        """Keep a position; raises RefusedError."""
        self._positions[_position_register(asked)] = _position_in(asked)
        return {}


def _position_register(asked: Packet) -> int:
    register = asked.whole("RegisterNumber")
    if not 1 <= register <= _POSITION_REGISTERS:
        raise RefusedError(protocol.BAD_POSITION_REGISTER)
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
            raise RefusedError(protocol.BAD_REPRESENTATION)


def _copied(asked: Packet, representation: str, *parts: str) -> Fields:
    return {"Representation": representation, **{part: asked.part(part).fields for part in parts}}
