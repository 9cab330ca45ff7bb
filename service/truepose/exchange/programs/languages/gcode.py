"""Lists of points like those of milling machines (.nc, .gcode, .cnc, .tap): G0 and G1 with X Y Z A B C.

Only a block that gives all six words is a target: a word that a block leaves out keeps its value from a
block before, and cannot be corrected alone. What A, B and C turn about is not in the file.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final, get_args

from truepose.exchange.errors import MissingEntryError
from truepose.exchange.programs.parsed_program import ARC, COMPUTED, RELATIVE, Draft
from truepose.exchange.programs.pose_notation import INCHES, MILLIMETRES, Order, turns_in_degrees
from truepose.exchange.programs.program import Form, Frame, Number, Path, Pose, ProgramTarget, Written
from truepose.messages.message import Message, message

_WORD: Final = re.compile(
    r"\((?:[^)\r\n]*)\)|;[^\r\n]*|(?P<letter>[A-Za-z])[ \t]*"
    r"(?:(?P<number>[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+))|(?P<computed>[#\[=]))|(?P<open>\()"
)
_AXES: Final = ("X", "Y", "Z", "A", "B", "C")
_ORDERS: Final[Mapping[str, Order]] = {order: order for order in get_args(Order)}
_PATHS: Final[Mapping[float, Path]] = {0.0: "joints", 1.0: "line"}
_ARCS: Final = (2.0, 3.0)
_UNITS: Final = {20.0: INCHES, 21.0: MILLIMETRES}
_AWAY: Final = {28.0: message("left.place_of_machine"), 30.0: message("left.place_of_machine")}
_SHIFTED: Final = frozenset({10.0, 52.0, 68.0, 92.0, 92.1})
_NO_MOTIONS: Final = frozenset({4.0, *_SHIFTED})  # a dwell may be given by X
_OFFSETS: Final = frozenset({53.0, 54.0, 55.0, 56.0, 57.0, 58.0, 59.0})


@dataclass(slots=True)
class _State:
    """What holds from block to block."""

    motion: float = 0.0
    relative: bool = False
    shifted: bool = False
    unit: Form = field(default_factory=lambda: MILLIMETRES)
    work_object: Frame | None = None
    tool: Frame | None = None


def read(draft: Draft) -> None:
    """Read a list of points."""
    source = draft.source
    state = _State()
    for line in range(1, source.n_lines + 1):
        _Block(draft, state, line, *source.line_span(line)).follow()


class _Block:
    """The words of a line."""

    def __init__(self, draft: Draft, state: _State, line: int, start: int, stop: int) -> None:
        self._draft = draft
        self._state = state
        self._line = line
        self._shown = draft.source.shown(start, stop)
        self._codes: list[float] = []
        self._axes: dict[str, Number] = {}
        self._computed = False
        for found in _WORD.finditer(draft.source.text, max(start, draft.source.start), stop):
            self._take(found)

    def follow(self) -> None:
        """Say what the block does."""
        for code in self._codes:
            self._set(code)
        away = next((reason for code, reason in _AWAY.items() if code in self._codes), None)
        if away:
            self._draft.leave(self._line, self._shown, away)
        elif (self._axes or self._computed) and not _NO_MOTIONS & set(self._codes):
            self._move()

    def _take(self, found: re.Match[str]) -> None:
        letter = (found["letter"] or "").upper()
        if found["open"]:
            self._draft.source.fail("the remark that begins here is not closed", found.start())
        if found["computed"]:
            self._computed |= letter in _AXES
        elif letter == "G":
            self._codes.append(float(found["number"]))
        elif letter == "T":
            self._state.tool = Frame(f"T{found['number']}")
        elif letter in _AXES:
            if letter in self._axes:
                self._draft.source.refuse(f"{letter} appears twice in this block", found.start())
            self._axes[letter] = self._draft.source.number(*found.span("number"))

    def _set(self, code: float) -> None:
        state = self._state
        if code in _PATHS or code in _ARCS:
            state.motion = code
        elif code in (90.0, 91.0):
            state.relative = code == 91.0
        elif code in _UNITS:
            state.unit = _UNITS[code]
        # Where the zero of G54 and its like lies is kept in the machine: the file only names it.
        elif code in _OFFSETS:
            state.work_object = Frame(f"G{code:g}")
        elif code in _SHIFTED:
            state.shifted = True

    def _move(self) -> None:
        reason = self._reason()
        if reason is not None:
            self._draft.leave(self._line, self._shown, reason)
            return
        index = self._draft.add(self._target())
        state = self._state
        self._draft.visit(self._line, (index,), _PATHS[state.motion], state.tool, state.work_object)

    def _reason(self) -> Message | None:
        """Say why the block is left alone."""
        if self._computed:
            return COMPUTED
        if self._state.motion in _ARCS:
            return ARC
        if self._state.relative:
            return RELATIVE
        if self._state.shifted:
            return message("left.zero_shifted")
        # A word that a block leaves out keeps its value; to correct it the block would need words that it
        # does not have.
        absent = [axis for axis in _AXES if axis not in self._axes]
        return message("left.absent_kept", names=", ".join(absent)) if absent else None

    def _target(self) -> ProgramTarget:
        numbers = [self._axes[axis] for axis in _AXES]
        position = Written(tuple(numbers[:3]), self._state.unit)
        rotation = Written(tuple(numbers[3:]), turns_in_degrees(self._order()))
        return ProgramTarget(
            f"line {self._line}", self._line, Pose.written(position, rotation), (position, rotation)
        )

    def _order(self) -> Order:
        order = _ORDERS.get(self._draft.angles or "")
        if order is None:
            self._draft.source.fail(
                f"the file does not state the axes of A, B and C; specify them: {', '.join(_ORDERS)}",
                self._axes["A"].start,
                MissingEntryError,
            )
        return order
