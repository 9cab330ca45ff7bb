"""Jobs of Yaskawa controllers as text (.jbi).

Source: Yaskawa, DX200 and YRC1000 Operator's Manual and INFORM manual, "Job data format". Positions are
written in pulses of the encoders, in degrees, or as X Y Z Rx Ry Rz, which turn about fixed X, Y and Z.
Pulses are left alone: how many make a degree is a parameter of the controller, not of the job.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from truepose.exchange.programs.parsed_program import (
    ARC,
    CHOSEN,
    COMPUTED,
    DISPLACED,
    ELSEWHERE,
    RELATIVE,
    Draft,
)
from truepose.exchange.programs.pose_notation import degrees_of_joints, millimetres, turns_in_degrees
from truepose.exchange.programs.program import (
    AT_THE_ORIGIN,
    Configuration,
    Frame,
    Path,
    Pose,
    ProgramTarget,
    Written,
)
from truepose.exchange.programs.tokens import plain_digits
from truepose.messages.message import Message, message

_POSITION: Final = millimetres(3)
_ROTATION: Final = turns_in_degrees("fixed xyz", 2)  # two decimals on older controllers, four on newer ones
_JOINTS: Final = degrees_of_joints(4)
_HEAD: Final = re.compile(r"/{2,4}(?P<key>[A-Z0-9]+)[ \t]*(?P<value>[^\r\n]*)")
_ENTRY: Final = re.compile(r"(?P<name>L?P|C|BC|EC|BP|EX)(?P<number>[0-9]+)[ \t]*=(?P<values>[^\r\n]*)")
_NUMBER: Final = re.compile(r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)")
_MOTION: Final = re.compile(r"(?P<plus>\+?)(?P<kind>S?MOV[JLCS]|IMOV|REFP)\b(?P<rest>[^\r\n]*)")
_POINT: Final = re.compile(r"\b(L?P|C)\[?([0-9]+)\b")
_CHOSEN: Final = re.compile(r"\bL?P\[")
_GIVEN: Final = re.compile(r"\b(?:SET|ADD|SUB|SETE|CNVRT|GETPOS|MULMAT|MFRAME|GETS)[ \t]+(L?P)([0-9]+)\b")
_NEXT_ELSEWHERE: Final = re.compile(
    r"(?:\*|JUMP|CALL|IF|ELSE|ENDIF|WHILE|ENDWHILE|FOR|NEXT|SWITCH|CASE|RET|PSTART|TSYNC)"
)
_PATHS: Final[Mapping[str, Path]] = {"MOVJ": "joints", "MOVL": "line"}
_PULSES: Final = message("left.pulses")
_N_NUMBERS: Final = 6


@dataclass(slots=True)
class _Heads:
    """What the heads of the section //POS say of the positions behind them."""

    tool: Frame | None = None
    kind: str = ""
    user: str = ""
    branch: str = ""

    def take(self, key: str, value: str) -> None:
        """Follow a head."""
        if key == "TOOL":
            self.tool = Frame(f"TOOL {value.split(',')[0]}")
        elif key == "POSTYPE":
            self.kind = value
        elif key == "USER":
            self.user = value
        elif key == "RCONF":
            self.branch = value

    @property
    def work_object(self) -> Frame | None:
        """The frame of the positions behind."""
        if self.kind == "ROBOT":
            return Frame("ROBOT", AT_THE_ORIGIN)
        return Frame(f"USER {self.user}" if self.kind == "USER" else self.kind)


def read(draft: Draft) -> None:
    """Read a job."""
    if not draft.source.text.startswith("/JOB", draft.source.start):
        draft.source.fail("a job begins with /JOB", draft.source.start)
    _Job(draft).read()


class _Job:
    """The lines of a job."""

    def __init__(self, draft: Draft) -> None:
        self._draft = draft
        self._source = draft.source
        self._heads = _Heads()
        self._targets: dict[str, int] = {}
        self._shifted = False
        self._declared: set[str] = set()

    def read(self) -> None:
        """Read every line: positions up to //INST, then instructions."""
        instructions = False
        for line in range(1, self._source.n_lines + 1):
            start, stop = self._source.line_span(line)
            text = self._source.text[start:stop].strip()
            head = _HEAD.fullmatch(text)
            if head is not None:
                self._heads.take(head["key"], head["value"].strip())
                instructions |= head["key"] == "INST"
            elif instructions and text == "END":
                return
            elif instructions:
                self._instruction(line, text)
            elif (entry := _ENTRY.match(self._source.text, start, stop)) is not None:
                self._position(line, entry)
        self._source.fail("the job has no END; the file is cut off", len(self._source.text.rstrip()))

    def _position(self, line: int, entry: re.Match[str]) -> None:
        if entry["name"] not in ("C", "P", "LP"):
            return  # axes of the base and of stations
        key = _key(entry["name"], entry["number"])
        name = entry["name"] + entry["number"]
        self._declared.add(key)
        found = _PULSES if self._heads.kind == "PULSE" else self._target(line, name, entry)
        if isinstance(found, Message):
            self._draft.leave(line, name, found, moves=False)
        else:
            self._targets[key] = self._draft.add(found)

    def _target(self, line: int, name: str, entry: re.Match[str]) -> ProgramTarget | Message:
        start, stop = entry.span("values")
        spans = [found.span() for found in _NUMBER.finditer(self._source.text, start, stop)]
        if len(spans) < _N_NUMBERS:
            self._source.refuse(f"{name} has {_N_NUMBERS} numbers, {len(spans)} found", start)
        numbers = tuple(self._source.number(*span) for span in spans)
        kept = tuple(number.value for number in numbers[_N_NUMBERS:])
        held = numbers[:_N_NUMBERS]
        if self._heads.kind == "ANGLE":
            joints = Written(held, _JOINTS)
            return ProgramTarget(name, line, Configuration(joints.read()), (joints,), external=kept)
        # A seventh number is an axis of the arm that the six others do not determine.
        if kept:
            return message("left.seven_axes")
        position, rotation = Written(held[:3], _POSITION), Written(held[3:], _ROTATION)
        return ProgramTarget(
            name,
            line,
            Pose.written(position, rotation),
            (position, rotation),
            branch=self._heads.branch,
            tool=self._heads.tool,
            work_object=self._heads.work_object,
        )

    def _instruction(self, line: int, text: str) -> None:
        if text.startswith("'"):
            return
        motion, given = _MOTION.match(text), _GIVEN.match(text)
        if text.startswith(("SFTON", "SFTOF")):
            self._shifted = text.startswith("SFTON")
        elif motion is not None:
            self._move(line, text, motion)
        elif given is not None:
            self._draft.change(line, self._known(_key(given[1], given[2])))
        elif _NEXT_ELSEWHERE.match(text):
            self._draft.interrupt()
        elif self._points(text):
            self._draft.leave(line, self._shown(text), COMPUTED, self._points(text), moves=False)

    def _move(self, line: int, text: str, motion: re.Match[str]) -> None:
        point = _POINT.search(motion["rest"])
        key = _key(*point.groups()) if point else ""
        reason = self._reason(motion, key)
        if reason is None:
            self._draft.visit(line, self._known(key), _PATHS[motion["kind"]])
        elif key in self._declared and key not in self._targets:
            self._draft.interrupt()  # told where it stands
        else:
            self._draft.leave(line, self._shown(text), reason, self._points(motion["rest"]))

    def _reason(self, motion: re.Match[str], key: str) -> Message | None:
        """Say why a motion is left alone."""
        if motion["kind"] == "IMOV":
            return RELATIVE
        if motion["kind"] not in _PATHS:
            return message("left.another_robot") if motion["kind"].startswith("S") else ARC
        if motion["plus"]:
            return message("left.work_moves")
        if self._shifted:
            return DISPLACED
        if _CHOSEN.search(motion["rest"]):
            return CHOSEN
        return None if key in self._targets else ELSEWHERE

    def _points(self, text: str) -> tuple[int, ...]:
        return tuple(target for found in _POINT.findall(text) for target in self._known(_key(*found)))

    def _known(self, key: str) -> tuple[int, ...]:
        return (self._targets[key],) if key in self._targets else ()

    def _shown(self, text: str) -> str:
        return " ".join(text.split())


def _key(name: str, number: str) -> str:
    """Return the name of a position whose number may stand with more or fewer zeros."""
    return name + plain_digits(number)
