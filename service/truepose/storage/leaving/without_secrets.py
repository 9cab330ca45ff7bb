"""What is taken out of a record before it leaves a cell: whatever may open something.

Which options a device has its driver decides, which somebody else may have written. So they stay at home,
except numbers and what is known here to open nothing.
"""

import json
import re
from collections.abc import Mapping
from typing import Any, Final

HARMLESS: Final = frozenset({  # options whose text says where a device is, and how it counts
    "channels",
    "host",
    "joint_3_from",
    "joint_speeds_deg_s",
    "probe",
    "reflector",
    "reversed",
    "serial",
    "signs",
    "terminator",
    "tool_file",
    "tool_mm",
    "usb",
})
_SET_UP: Final = "setup"  # of a session: the cell with the options of its devices
_OPTIONS: Final = "options"
_TAKEN_OUT: Final = "taken out"
_OPENING: Final = re.compile(
    r"passw|passphrase|passcode|pincode|pwd|secret|token|credential|(api|access|private)key"
)
_OPENING_WORDS: Final = frozenset({"pass", "pin", "pw"})  # only as words: a spindle opens nothing
_USER_INFO: Final = re.compile(r"://\S*@")
_USER_INFO_OF_OPTION: Final = re.compile(r"^([\w+.-]+://)?.*@", re.DOTALL)


def without_secrets(row: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return a record as it may leave: itself, or with what may open something taken out of its set-up.

    The latter has no longer the hash of its link: it can be read, and not verified.
    """
    if not isinstance(row.get(_SET_UP), str):
        return row
    set_up = json.loads(row[_SET_UP])
    told = _told(set_up)
    return row if told == set_up else {**row, _SET_UP: json.dumps(told)}


def _told(document: Any) -> Any:
    match document:
        case dict():
            return {name: _told_under(name, value) for name, value in document.items()}
        case list():
            return [_told(value) for value in document]
        case str():
            return _USER_INFO.sub("://", document)
        case _:
            return document


def _told_under(name: str, value: Any) -> Any:
    if _opens(name):
        return _TAKEN_OUT
    if name == _OPTIONS and isinstance(value, dict):
        return {option: _told_option(option, one) for option, one in value.items()}
    return _told(value)


def _told_option(name: str, value: Any) -> Any:
    if _opens(name):
        return _TAKEN_OUT
    match value:
        case bool() | int() | float() | None:
            return value
        case str() if name in HARMLESS:
            return _USER_INFO_OF_OPTION.sub(r"\1", value)
        case _:
            return _TAKEN_OUT


def _opens(name: str) -> bool:
    """Whether what has such a name may open something, however somebody writes it."""
    words = re.split(r"[^a-z0-9]+", name.lower())
    return bool(_OPENING.search("".join(words))) or not _OPENING_WORDS.isdisjoint(words)
