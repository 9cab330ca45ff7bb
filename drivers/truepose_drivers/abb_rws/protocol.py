"""Resources of Robot Web Services: joints, panel, and the variables of our RAPID program; no I/O.

Every state is an object of texts, its kind in `_type`; an error has a code and a sentence.

The program copies an order into its report and moves nothing before a beat has come, which is given only once
the report says what was ordered.
"""

import json
import math
import re
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum, StrEnum
from typing import Final, TypeVar

from truepose_drivers.abb_rws.http import HttpResponse, RwsProtocolError

_NUMBER: Final = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,2})?", re.ASCII)
_DIGITS: Final = range(6, 10)  # nine tell every single float from its neighbours
_LARGEST: Final = 3.4028235e38  # of a single float
NO_AXIS: Final = 9e9  # of an external axis that is not there


def number(text: object) -> float:
    """Read a number; raises RwsProtocolError."""
    value = float(text) if isinstance(text, str) and _NUMBER.fullmatch(text.strip()) else math.nan
    if not abs(value) <= _LARGEST:  # a NaN is not
        raise RwsProtocolError(f"{str(text)[:40]!r} is not a RAPID number: connect again")
    return value


def numbers(text: object, count: int) -> tuple[float, ...]:
    """Read an array of `count` numbers; raises RwsProtocolError."""
    stripped = text.strip() if isinstance(text, str) else ""
    words = stripped[1:-1].split(",")
    if not (stripped.startswith("[") and stripped.endswith("]") and len(words) == count):
        raise RwsProtocolError(f"{str(text)[:80]!r} is not an array of {count} numbers: connect again")
    return tuple(map(number, words))


def array_text(values: Sequence[float]) -> str:
    """Return an array as RAPID reads it."""
    return f"[{','.join(map(number_text, values))}]"


def number_text(value: float) -> str:
    """Return the shortest text of the single float that RAPID keeps of a value; raises OverflowError."""
    kept = single(value)
    texts = (f"{kept:.{digits}G}" for digits in _DIGITS)
    return next(text for text in texts if single(float(text)) == kept)


def single(value: float) -> float:
    """Return the single float that RAPID keeps of a value; raises OverflowError."""
    (kept,) = struct.unpack("<f", struct.pack("<f", value))
    return float(kept)


PORT: Final = 80
USER: Final = "Default User"
PASSWORD: Final = "robotics"  # that controllers leave the factory with
JOINTS: Final = 6
# Joint angles are texts of single floats: above 100 deg the seventh digit is a ten-thousandth.
RESOLUTION_DEG: Final = 1e-4
_FURTHEST_DEG: Final = 3600.0  # no joint is wound up further

IDENTITY: Final = "/ctrl/identity"
SYSTEM: Final = "/rw/system"
ROBOT_TYPE: Final = "/rw/system/robottype"
CONTROLLER_STATE: Final = "/rw/panel/ctrlstate"
OPERATION_MODE: Final = "/rw/panel/opmode"
SPEED_RATIO: Final = "/rw/panel/speedratio"
EXECUTION: Final = "/rw/rapid/execution"
TASKS: Final = "/rw/rapid/tasks"
SYMBOLS: Final = "/rw/rapid/symbols"
JOINT_TARGET: Final = "/rw/motionsystem/mechunits/ROB_1/jointtarget"
ROBOT_TARGET: Final = "/rw/motionsystem/mechunits/ROB_1/robtarget"
EVENT_LOG: Final = "/rw/elog/0/"
LOGOUT: Final = "/logout"
SYMBOL_DATA: Final = "/rw/rapid/symbol/data/RAPID/T_ROB1/"

State = Mapping[str, object]


def states(response: HttpResponse) -> list[State]:
    """Return the states in a response; raises RwsProtocolError."""
    found = _embedded(response).get("_state")
    if not isinstance(found, list) or not all(isinstance(state, dict) for state in found):
        raise RwsProtocolError(f"{response.body[:80]!r} contains no state: connect again")
    return found


def state(response: HttpResponse, kind: str) -> State:
    """Return the one state of a kind; raises RwsProtocolError."""
    told = next(iter(states(response)), {})
    if told.get("_type") != kind:
        raise RwsProtocolError(f"the robot reported {told.get('_type')!r}, not {kind!r}: connect again")
    return told


def text(told: State, name: str) -> str:
    """Return a text of a state; raises RwsProtocolError where it is missing."""
    value = told.get(name)
    if not isinstance(value, str):
        raise RwsProtocolError(f"the robot does not report {name!r}: connect again")
    return value


def state_text(response: HttpResponse, name: str) -> str:
    """Return a text of the first state, empty where it is missing; raises RwsProtocolError."""
    return str(next(iter(states(response)), {}).get(name) or "")[:100]


def error_sentence(response: HttpResponse) -> str:
    """Return what a response that is no success says, as far as it can be read."""
    try:
        status = _embedded(response).get("status")
    except RwsProtocolError:
        status = None
    said = status.get("msg") if isinstance(status, dict) else None
    return str(said)[:200] if said else f"HTTP status {response.status}"


def value_of(response: HttpResponse) -> str:
    """Return the value of a RAPID variable; raises RwsProtocolError."""
    return text(state(response, "rap-data"), "value")


def last_event(response: HttpResponse) -> str:
    """Return the newest entry of an event log as a sentence, empty where there is none."""
    entries = states(response)
    if not entries:
        return ""
    newest = max(entries, key=_event_number)
    return f"{text(newest, 'code')} {text(newest, 'title')}: {text(newest, 'desc')}"[:300]


def _event_number(entry: State) -> int:
    word = text(entry, "_title").rpartition("/")[2]
    return int(word) if word.isascii() and word.isdigit() else -1


def joint_angles_deg(response: HttpResponse) -> tuple[float, ...]:
    """Return where the joints are; raises RwsProtocolError."""
    told = state(response, "ms-jointtarget")
    angles = tuple(number(told.get(f"rax_{joint}")) for joint in range(1, JOINTS + 1))
    if any(abs(angle) > _FURTHEST_DEG for angle in angles):
        raise RwsProtocolError(f"{angles} deg: an angle is out of any robot's range: connect again")
    return angles


def encode_states(path: str, told: Sequence[State]) -> bytes:
    """Return the body of a response in JSON."""
    links = {"base": {"href": "http://localhost/"}, "self": {"href": path}}
    return json.dumps({"_links": links, "_embedded": {"_state": list(told)}}).encode()


def encode_error(code: int, sentence: str) -> bytes:
    """Return the body of a response that is no success."""
    return json.dumps({"_embedded": {"status": {"code": code, "msg": sentence}}}).encode()


def _embedded(response: HttpResponse) -> Mapping[str, object]:
    try:
        document = json.loads(response.body)
    except (ValueError, RecursionError) as error:
        raise RwsProtocolError(f"{response.body[:80]!r} is not JSON: connect again") from error
    embedded = document.get("_embedded") if isinstance(document, dict) else None
    if not isinstance(embedded, dict):
        raise RwsProtocolError(f"{response.body[:80]!r} is not a reply of Robot Web Services: connect again")
    return embedded


FULL_PERCENT: Final = 100.0

Known = TypeVar("Known", bound=StrEnum)


class ControllerState(StrEnum):
    """Motors and stops."""

    INIT = "init"
    MOTORS_ON = "motoron"
    MOTORS_OFF = "motoroff"
    GUARD_STOP = "guardstop"
    EMERGENCY_STOP = "emergencystop"
    EMERGENCY_STOP_RESET = "emergencystopreset"
    SYSTEM_FAILURE = "sysfail"


class OperationMode(StrEnum):
    """Position of the key switch."""

    INIT = "INIT"
    AUTO_CHANGE = "AUTO_CH"
    MANUAL_FULL_CHANGE = "MANF_CH"
    MANUAL_REDUCED = "MANR"
    MANUAL_FULL = "MANF"
    AUTO = "AUTO"
    UNDEFINED = "UNDEF"


class Execution(StrEnum):
    """Whether the RAPID program runs."""

    RUNNING = "running"
    STOPPED = "stopped"


@dataclass(frozen=True, slots=True)
class Panel:
    """All of it at one time."""

    state: ControllerState
    mode: OperationMode
    execution: Execution
    speed_percent: float

    @property
    def obstacle(self) -> str | None:
        """Why the arm may not be moved from here, with what to do; None where it may."""
        if self.halt is None and self.mode is not OperationMode.AUTO:
            return f"its key switch is at {self.mode.value}: switch it to AUTO and confirm on the pendant"
        return self.halt

    @property
    def halt(self) -> str | None:
        """Why nothing moves the arm now, with what to do; None where something may."""
        if self.state is not ControllerState.MOTORS_ON:
            return _WHY[self.state]
        return "its speed override is 0 %: raise it on the pendant" if self.speed_percent <= 0.0 else None


_WHY: Final = {
    ControllerState.INIT: "it is starting: wait until the pendant shows that it is ready",
    ControllerState.MOTORS_OFF: "its motors are off: check the cell, then switch them on at the controller",
    ControllerState.GUARD_STOP: "a guard stopped it: close the guard, then switch the motors on",
    ControllerState.EMERGENCY_STOP: "an emergency stop is active: check the cell, then release the stop",
    ControllerState.EMERGENCY_STOP_RESET: "an emergency stop was released: switch the motors on",
    ControllerState.SYSTEM_FAILURE: "it has failed: check the event log on the pendant",
}


def controller_state(response: HttpResponse) -> ControllerState:
    """Read the state of the motors; raises RwsProtocolError."""
    return _one_of(ControllerState, text(state(response, "pnl-ctrlstate"), "ctrlstate"))


def operation_mode(response: HttpResponse) -> OperationMode:
    """Read the key switch; raises RwsProtocolError."""
    return _one_of(OperationMode, text(state(response, "pnl-opmode"), "opmode"))


def execution(response: HttpResponse) -> Execution:
    """Read whether the program runs; raises RwsProtocolError."""
    return _one_of(Execution, text(state(response, "rap-execution"), "ctrlexecstate"))


def speed_percent(response: HttpResponse) -> float:
    """Read the speed override; raises RwsProtocolError."""
    percent = number(state(response, "pnl-speedratio").get("speedratio"))
    if not 0.0 <= percent <= FULL_PERCENT:
        raise RwsProtocolError(f"the robot reports a speed override of {percent:g} %: connect again")
    return percent


def _one_of(kind: type[Known], word: str) -> Known:
    try:
        return kind(word)
    except ValueError as error:
        raise RwsProtocolError(f"the robot reports {word[:40]!r}, which is no {kind.__name__}") from error


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
        raise RwsProtocolError(f"the robot's program reports {progress:g}, which is not a known state")
    return Report(Progress(int(progress)), tuple(order))


def beat_after(beat: float) -> float:
    """Return the beat that follows one."""
    return float(int(beat) % _COUNTED_TO + 1)
