"""Why a controller refuses: the numbers of the Remote Motion Interface in words, and what a person can do.

Source: the table of FANUC's own public driver; 7004 and 7015 as seen on a controller by its users.
"""

from collections.abc import Mapping
from typing import Final

_FIRST: Final = 2_556_928  # RMIT-000
_MOTION_FACILITY: Final = 15  # of the errors of motions, MOTN-nnn: 15,000 and what follows

IN_HOLD: Final = _FIRST + 24
ALREADY_CONNECTED: Final = _FIRST + 26
INVALID_STATE: Final = _FIRST + 15
NOT_RUNNING: Final = _FIRST + 9
WRONG_SEQUENCE: Final = _FIRST + 29
BAD_SPEED_TYPE: Final = _FIRST + 30
BAD_SPEED: Final = _FIRST + 31
BAD_TERM_TYPE: Final = _FIRST + 32
BAD_TERM_VALUE: Final = _FIRST + 33
BAD_POSITION_REGISTER: Final = _FIRST + 4
BAD_REPRESENTATION: Final = _FIRST + 44
BAD_POSITION_DATA: Final = _FIRST + 23
BAD_DESTINATION: Final = _FIRST + 36
BAD_OVERRIDE: Final = _FIRST + 5
BAD_TOOL: Final = _FIRST + 2
BAD_FRAME: Final = _FIRST + 3
BAD_VALUE: Final = _FIRST + 21
UNKNOWN_COMMAND: Final = _FIRST + 13
UNKNOWN_INSTRUCTION: Final = _FIRST + 20
PROGRAM_EXISTS: Final = 7015

_WORDS: Final[Mapping[int, str]] = {
    _FIRST + 1: "an error inside the controller",
    BAD_OVERRIDE: "no such speed override",
    _FIRST + 6: "its program cannot be run",
    _FIRST + 7: "the servos are off",
    _FIRST + 8: "the pendant is switched on, or its program cannot be run",
    NOT_RUNNING: "the interface was not initialised",
    _FIRST + 12: "its faults cannot be reset",
    UNKNOWN_COMMAND: "it does not know the command",
    _FIRST + 14: "the command failed",
    INVALID_STATE: "it is not ready",
    _FIRST + 16: "it must be switched off and on",
    UNKNOWN_INSTRUCTION: "it does not know the instruction",
    BAD_POSITION_DATA: "no such position",
    IN_HOLD: "it holds after an error",
    ALREADY_CONNECTED: "another program is connected to it",
    WRONG_SEQUENCE: "the instruction is out of turn",
    BAD_SPEED_TYPE: "no such kind of speed",
    BAD_SPEED: "no such speed",
    BAD_DESTINATION: "the target cannot be reached",
    _FIRST + 43: "the pendant is set to single steps",
    7004: "its program RMI_MOVE is in use",
    PROGRAM_EXISTS: "its program RMI_MOVE was left by a session that died: delete it on the pendant",
}


def in_words(error: int) -> str:
    """Return why a request was refused."""
    return f"{_WORDS.get(error, 'it does not say why')} (error {error})"


def is_of_target(error: int) -> bool:
    """Whether a motion was refused for where it leads."""
    return error in {BAD_POSITION_DATA, BAD_DESTINATION} or error // 1000 == _MOTION_FACILITY
