"""The resources of Robot Web Services that are spoken here, and their states in JSON.

Every state is an object of texts, its kind in `_type`; an error has a code and a sentence.
"""

import json
from collections.abc import Mapping, Sequence
from typing import Final

from truepose_drivers.abb_rws.protocol.errors import RwsProtocolError
from truepose_drivers.abb_rws.protocol.http import HttpResponse
from truepose_drivers.abb_rws.protocol.rapid import number

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
        raise RwsProtocolError(f"{response.body[:80]!r} tells no state: connect again")
    return found


def state(response: HttpResponse, kind: str) -> State:
    """Return the one state of a kind; raises RwsProtocolError."""
    told = next(iter(states(response)), {})
    if told.get("_type") != kind:
        raise RwsProtocolError(f"the robot tells of {told.get('_type')!r}, not of {kind!r}: connect again")
    return told


def text(told: State, name: str) -> str:
    """Return a text of a state; raises RwsProtocolError where it is missing."""
    value = told.get(name)
    if not isinstance(value, str):
        raise RwsProtocolError(f"the robot does not state {name!r}: connect again")
    return value


def stated(response: HttpResponse, name: str) -> str:
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
        raise RwsProtocolError(f"{response.body[:80]!r} is no JSON: connect again") from error
    embedded = document.get("_embedded") if isinstance(document, dict) else None
    if not isinstance(embedded, dict):
        raise RwsProtocolError(f"{response.body[:80]!r} is none of Robot Web Services: connect again")
    return embedded
