"""The variables of our RAPID program: an order to it, the beat of whoever waits for it, its report.

The program copies an order into its report and moves nothing before a beat has come, which is given only once
the report says what was ordered.
"""

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import Final

from truepose_drivers.abb_rws.protocol.errors import RwsProtocolError
from truepose_drivers.abb_rws.protocol.rapid import array_text, numbers, single
from truepose_drivers.abb_rws.protocol.resources import JOINTS

SERVER: Final = '"truepose rws 1"'  # value of the variable NAME, where our program is loaded
NAME: Final = "tpServer"
ORDER: Final = "tpOrder"
BEAT: Final = "tpBeat"
REPORT: Final = "tpReport"

SILENCE_S: Final = 0.8  # after which the program stops the arm; it looks every 0.1 s
FIRST_BEAT_S: Final = 3.0  # after which an order is given up that nobody gave a beat to; nothing has moved
BEAT_S: Final = 0.2  # so often the driver is heard while the arm moves
STOPS_WITHIN_S: Final = 1.0  # silence, look and deceleration

_ORDER_NUMBERS: Final = 3 + JOINTS
_COUNTED_TO: Final = 1_000_000  # a single float counts to 16 million


class Progress(IntEnum):
    """First number of a report."""

    IDLE = 0
    TAKEN = 1
    MOVING = 2
    ARRIVED = 3
    GIVEN_UP = 4
    REFUSED = 5


@dataclass(frozen=True, slots=True)
class Order:
    """Where to go and how fast; an order of another number is a new one."""

    number: int = 0
    target_deg: tuple[float, ...] = (0.0,) * JOINTS
    tool_speed_mm_s: float = 0.0
    turning_speed_deg_s: float = 0.0

    def values(self) -> tuple[float, ...]:
        """Return it as RAPID keeps it, in single floats."""
        given = (float(self.number), *self.target_deg, self.tool_speed_mm_s, self.turning_speed_deg_s)
        return tuple(map(single, given))

    def encode(self) -> str:
        """Return the value of the variable."""
        return array_text(self.values())


@dataclass(frozen=True, slots=True)
class Report:
    """What becomes of an order."""

    progress: Progress
    order: tuple[float, ...]

    def is_about(self, order: Order) -> bool:
        """Whether the program understood this order, as far as RAPID's numbers go."""
        pairs = zip(self.order, order.values(), strict=True)
        return all(math.isclose(told, given, rel_tol=1e-6, abs_tol=1e-4) for told, given in pairs)

    @property
    def next_number(self) -> int:
        """A number that the present order does not have."""
        return int(self.order[0]) % _COUNTED_TO + 1

    def encode(self) -> str:
        """Return the value of the variable."""
        return array_text((float(self.progress), *self.order))


def decode_order(value: str) -> Order:
    """Read an order; raises RwsProtocolError."""
    count, *target, tool_speed, turning_speed = numbers(value, _ORDER_NUMBERS)
    return Order(int(count), tuple(target), tool_speed, turning_speed)


def decode_report(value: str) -> Report:
    """Read a report; raises RwsProtocolError."""
    progress, *order = numbers(value, 1 + _ORDER_NUMBERS)
    if progress not in set(Progress):
        raise RwsProtocolError(f"the robot's program reports {progress:g}, which it does not know")
    return Report(Progress(int(progress)), tuple(order))


def beat_after(beat: float) -> float:
    """Return the beat that follows one."""
    return float(int(beat) % _COUNTED_TO + 1)
