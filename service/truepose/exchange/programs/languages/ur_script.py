"""Programs of Universal Robots in URScript (.script), written by hand or by PolyScope.

Source: Universal Robots, The URScript Programming Language, "Types" and "Module motion". Lengths are in m,
angles in rad, a rotation is a vector; a list of six numbers is a configuration, p[...] a pose in the base.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Final

from truepose.domain.correction import place
from truepose.exchange.programs.parsed_program import (
    ARC,
    CHOSEN,
    COMPUTED,
    ELSEWHERE,
    ArgumentTargets,
    Draft,
    FramesInUse,
    Held,
    Step,
    among,
    sets_within,
)
from truepose.exchange.programs.pose_notation import JOINT_RADIANS, METRES, ROTATION_VECTOR
from truepose.exchange.programs.program import (
    AT_THE_ORIGIN,
    Configuration,
    Frame,
    Path,
    Pose,
    ProgramTarget,
    Source,
    Written,
)
from truepose.exchange.programs.tokens import (
    Language,
    Token,
    Tokens,
    inside,
    number,
    numbers,
    outside,
    statements,
    tokens,
)
from truepose.messages.message import Message, message

_LANGUAGE: Final = Language(
    skipped=r"[ \t\f\v]+|#[^\r\n]*|\$[ \t][^\r\n]*",  # `$` begins the lines that PolyScope counts
    string=r'"[^"\r\n]*"|\'[^\'\r\n]*\'',
    lines=True,
    sign=r"==|<=|>=|!=|.",
)
_PATHS: Final[Mapping[str, Path]] = {"movej": "joints", "movel": "line", "movep": "line"}
_STEERED: Final = message("left.steered")
_LEFT: Final = {
    "movec": ARC,
    **dict.fromkeys(("servoj", "servol", "servoc", "speedj", "speedl", "freedrive_mode"), _STEERED),
}
_BRANCHES: Final = {"if": 1, "while": 1, "for": 1, "elif": 0, "else": 0}
_ROUTINES: Final = frozenset({"def", "thread", "sec"})
_INVERSE: Final = "get_inverse_kin"
_STANDS_STILL: Final = (
    "set_", "get_", "write_", "read_", "socket_", "rtde_", "textmsg", "popup", "sleep", "sync",
)  # fmt: skip
_BASE: Final = Frame("base", AT_THE_ORIGIN)
_TOOL: Final = "tool"
_SET_TOOL: Final = "set_tcp"
_LOOPS: Final = frozenset({"while", "for"})
_N_NUMBERS: Final = 6


def read(draft: Draft) -> None:
    """Read a URScript program."""
    found = statements(draft.source, tokens(draft.source, _LANGUAGE), _ends_line, continued=True)
    lines = [line for statement in found if (line := [t for t in statement if not _ends_line(t)])]
    _require_ends(draft.source, lines)
    names = _Names(draft, lines)
    reader = _Reader(draft, names)
    sets = sets_within(map(_step, lines))
    for at, line in enumerate(lines):
        reader.follow(line, sets[at] if line[0].text in _LOOPS else set())


def _step(words: Tokens) -> Step:
    first = words[0].text
    opens = _BRANCHES.get(first, 0) or _begins_routine(words)
    return Step(-1 if first == "end" else int(opens), frozenset({_TOOL} if first == _SET_TOOL else ()))


def _ends_line(token: Token) -> bool:
    return token.kind == "end"


def _require_ends(source: Source, lines: Sequence[Tokens]) -> None:
    opened: list[Token] = []
    for line in lines:
        first = line[0]
        if _BRANCHES.get(first.text) == 1 or _begins_routine(line):
            opened.append(first)
        elif first.text == "end":
            if not opened:
                source.fail("this end has no matching beginning", first.start)
            opened.pop()
    if opened:
        begin = opened[-1]
        source.fail(f"the {begin.text} that begins here has no end; the file is cut off", begin.start)


def _begins_routine(words: Tokens) -> bool:
    """Whether a line is the head of a routine, and no assignment to what is called like that."""
    return words[0].text in _ROUTINES and len(words) > 1 and words[1].kind == "word"


def _target(source: Source, name: str, words: Tokens) -> ProgramTarget | None:
    """Return the pose or the configuration that a literal is, or None."""
    is_pose = bool(words) and words[0].text == "p"
    held = numbers(source, inside(words[is_pose:], "["), _N_NUMBERS)
    if held is None:
        return None
    line = source.line(words[0].start)
    if not is_pose:
        joints = Written(held, JOINT_RADIANS)
        return ProgramTarget(name, line, Configuration(joints.read()), (joints,))
    position, rotation = Written(held[:3], METRES), Written(held[3:], ROTATION_VECTOR)
    return ProgramTarget(name, line, Pose.written(position, rotation), (position, rotation))


class _Names:
    """The variables that hold poses and configurations, and lists of them."""

    def __init__(self, draft: Draft, lines: Sequence[Tokens]) -> None:
        self._draft = draft
        self._source = draft.source
        self._held: dict[str, Held] = {}  # by name
        for line in lines:
            self._take(line)

    def chosen(self, words: Tokens) -> ArgumentTargets | Message:
        """Return the targets that an argument can be, or why the motion is left alone."""
        if not words:
            return message("left.no_target")
        if words[0].text == _INVERSE:
            return self._inverse(words)
        if words[0].text in ("p", "[") and inside(words[words[0].text == "p" :], "[") is not None:
            found = _target(self._source, f"line {self._source.line(words[0].start)}", words)
            return COMPUTED if found is None else ArgumentTargets((self._draft.add(found),))
        if words[0].text not in self._held:
            return ELSEWHERE if len(words) == 1 else COMPUTED
        index = self._index(words[1:])
        targets = self._among(words[0].text, index)
        is_name = len(words) == 1 or inside(words[1:], "[") is not None
        return ArgumentTargets(targets, index is not None) if targets and is_name else COMPUTED

    def targets_in(self, words: Tokens) -> tuple[int, ...]:
        """Return the targets whose names an expression has."""
        names = {word.text for word in words if word.kind == "word"} & set(self._held)
        return tuple(target for name in sorted(names) for target in self._among(name, None))

    def pose(self, words: Tokens) -> Pose | None:
        """Return the pose that a literal is, or a variable that only ever is one."""
        literal = _target(self._source, "", words)
        targets = self._among(words[0].text, "") if len(words) == 1 and words[0].text in self._held else ()
        value = literal.value if literal else self._draft.value(targets[0]) if len(targets) == 1 else None
        return value if isinstance(value, Pose) else None

    def _inverse(self, words: Tokens) -> ArgumentTargets | Message:
        arguments = [_unnamed(part) for part in inside(words[1:], "(") or ()]
        if not arguments or not arguments[0] or arguments[0][0].text == _INVERSE:
            return COMPUTED
        chosen = self.chosen(arguments[0])
        near = self.chosen(arguments[1]) if len(arguments) > 1 and len(arguments[1]) == 1 else COMPUTED
        if isinstance(chosen, Message) or isinstance(near, Message):
            return chosen
        value = self._draft.value(near.targets[0])
        return replace(chosen, near_rad=value.joints_rad) if isinstance(value, Configuration) else chosen

    def _take(self, line: Tokens) -> None:
        words = line[1:] if line[0].text in ("global", "local") else line
        at = next((place for place in outside(words) if words[place].text == "="), None)
        if at is None or words[0].kind != "word":
            return
        name, value = words[0].text, words[at + 1 :]
        found = list(self._literals(name, value)) if at == 1 else []
        held = self._held.setdefault(name, {}) if found else self._held.get(name)
        if held is None:
            return
        if not found:
            self._draft.change(self._source.line(words[0].start), self._among(name, None))
        for index, target in found:
            held.setdefault(index, []).append(self._draft.add(target, if_used=True))

    def _literals(self, name: str, words: Tokens) -> Iterator[tuple[str, ProgramTarget]]:
        """Yield the target that a value is, or those that a list has, with their index."""
        whole = _target(self._source, name, words)
        if whole is not None:
            yield "", whole
            return
        for count, part in enumerate(inside(words, "[") or ()):
            entry = _target(self._source, f"{name}[{count}]", part)
            if entry is not None:
                yield str(count), entry

    def _index(self, words: Tokens) -> str | None:
        """Return an index as text; None where it is computed, empty where none stands."""
        match inside(words, "["):
            case [only]:
                found = number(self._source, only)
                return None if found is None else f"{found.value:g}"
        return None if words else ""

    def _among(self, name: str, index: str | None) -> tuple[int, ...]:
        return among(self._held.get(name, {}), index)


class _Reader:
    """Follows the lines."""

    def __init__(self, draft: Draft, names: _Names) -> None:
        self._draft = draft
        self._names = names
        self._frames = FramesInUse()
        self._opened: list[bool] = []  # whether what is open is a routine

    def follow(self, words: Tokens, set_in_loop: set[str]) -> None:
        """Say what a line does with the robot and with targets; a loop that it begins may set frames."""
        first = words[0].text
        if first in _PATHS:
            self._move(_PATHS[first], words)
        elif first in _LEFT:
            self._leave(words, _LEFT[first])
        elif first in _BRANCHES or _begins_routine(words) or first == "end":
            self._branch(first, set_in_loop)
        elif first == _SET_TOOL:
            self._set_tool(words)
        elif any(words[place].text == "=" for place in outside(words)):
            self._assignment(words)
        else:
            self._call(words)

    def _branch(self, first: str, set_in_loop: set[str]) -> None:
        self._draft.interrupt()
        routine = self._opened.pop() if first == "end" else first in _ROUTINES
        if routine:
            self._frames.begin_routine()
        elif set_in_loop:
            self._frames.begin_loop(set_in_loop)
        else:
            self._frames.branch(-1 if first == "end" else _BRANCHES[first])
        if first in _ROUTINES or _BRANCHES.get(first) == 1:
            self._opened.append(routine)

    def _set_tool(self, words: Tokens) -> None:
        given = [_unnamed(part) for part in inside(words[1:], "(") or ()]
        if given:
            line = self._draft.line(words)
            spoken = message("left.frame_at", frame="set_tcp", place=place(line))
            frame = Frame(f"set_tcp of line {line}", self._names.pose(given[0]), spoken)
            self._frames.put(_TOOL, frame)

    def _assignment(self, words: Tokens) -> None:
        at = next(place for place in outside(words) if words[place].text == "=")
        self._draft.compute_from(words, self._names.targets_in(words[at + 1 :]))

    def _call(self, words: Tokens) -> None:
        if words[0].text.startswith(_STANDS_STILL):
            return
        self._draft.hand_over(words, self._names.targets_in(words))
        self._draft.interrupt()

    def _move(self, path: Path, words: Tokens) -> None:
        arguments = [_unnamed(part) for part in inside(words[1:], "(") or ()]
        chosen = self._names.chosen(arguments[0] if arguments else ())
        if isinstance(chosen, Message):
            self._leave(words, chosen)
            return
        tool = self._frames.of(_TOOL)
        frame = tool if isinstance(tool, Frame) else None
        self._draft.visit(self._draft.line(words), chosen.targets, path, frame, _BASE, chosen.near_rad)
        if not chosen.told:
            self._leave(words, CHOSEN)

    def _leave(self, words: Tokens, reason: Message) -> None:
        self._draft.leave_words(words, reason, self._names.targets_in(words))


def _unnamed(words: Tokens) -> Tokens:
    """Return an argument without the name that may stand in front of it."""
    return words[2:] if len(words) > 2 and words[1].text == "=" else words
