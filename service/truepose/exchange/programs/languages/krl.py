"""KUKA programs and data lists (.src, .dat) by statements: what is declared, and where the robot moves.

Source: KUKA System Software, Operating and Programming Instructions for System Integrators, chapter
"Introduction to KRL syntax". A statement is a line.
"""

from collections.abc import Sequence
from typing import Final

from truepose.exchange.programs.languages.krl_data import NAMES, Data, Which, target, whole
from truepose.exchange.programs.parsed_program import (
    ARC,
    CHOSEN,
    COMPUTED,
    HOLDS_WORK,
    RELATIVE,
    ArgumentTargets,
    Draft,
    FramesInUse,
    InUse,
    Step,
    sets_within,
)
from truepose.exchange.programs.program import Frame, Path, Source
from truepose.exchange.programs.tokens import (
    Language,
    Token,
    Tokens,
    bracket,
    display_tokens,
    inside,
    outside,
    parts,
    statements,
    tokens,
)
from truepose.messages.message import Message, message

_LANGUAGE: Final = Language(
    skipped=r"[ \t\f\v]+|;[^\r\n]*|(?<![^\r\n])&[^\r\n]*",  # `&` begins the lines of the header
    string=r'"[^"\r\n]*"|\'[^\'\r\n]*\'',
    lines=True,
    sign=r"==|<=|>=|<>|.",
)
_PATHS: Final[dict[str, Path]] = {"PTP": "joints", "SPTP": "joints", "LIN": "line", "SLIN": "line"}
_LEFT: Final = {
    **dict.fromkeys(("CIRC", "SCIRC", "CIRC_REL", "SCIRC_REL"), ARC),
    **dict.fromkeys(("SPL", "SPL_REL"), message("left.spline")),
    **dict.fromkeys(("PTP_REL", "SPTP_REL", "LIN_REL", "SLIN_REL"), RELATIVE),
}
_CLOSED_BY: Final = {"DEF": "END", "DEFFCT": "ENDFCT", "DEFDAT": "ENDDAT"}
_BRANCHES: Final = {
    **dict.fromkeys(("IF", "FOR", "WHILE", "REPEAT", "LOOP", "SWITCH"), 1),
    **dict.fromkeys(("ENDIF", "ENDFOR", "ENDWHILE", "UNTIL", "ENDLOOP", "ENDSWITCH"), -1),
    **dict.fromkeys(("ELSE", "CASE", "DEFAULT", "GOTO", "RETURN", "HALT"), 0),
}
_LOOPS: Final = frozenset({"FOR", "WHILE", "REPEAT", "LOOP"})
_SETS: Final = {**{name: (which,) for name, which in NAMES.items()}, "FDAT_ACT": tuple(NAMES.values())}
_STANDS_STILL: Final = frozenset({
    "BAS", "WAIT", "PULSE", "TRIGGER", "CONTINUE", "EXT", "INTERRUPT", "SIGNAL", "ENUM",
})  # fmt: skip


def read(draft: Draft) -> None:
    """Read a KRL program or data list."""
    found = [line[:-1] if line[-1].kind == "end" else line for line in _lines(draft.source)]
    lines = [line for line in found if line]
    _require_ends(draft.source, lines)
    reader = _Reader(draft, Data(draft, lines))
    sets = sets_within(_step(draft.source, line) for line in lines)
    for at, line in enumerate(lines):
        if line[0].upper in _LOOPS:
            reader.enter_loop(sets[at])
        else:
            reader.follow(line)


def _step(source: Source, words: Tokens) -> Step:
    first = words[0].upper
    given = frozenset(_SETS.get(first, ()))
    if first == "BAS":
        text = display_tokens(source, words).upper()
        given = frozenset(which for name, which in NAMES.items() if name.replace("$", "#") in text)
    return Step(_BRANCHES.get(first, 0), given)


def _lines(source: Source) -> list[list[Token]]:
    return list(statements(source, tokens(source, _LANGUAGE), lambda token: token.kind == "end"))


def _require_ends(source: Source, lines: Sequence[Tokens]) -> None:
    opened: Token | None = None
    for line in lines:
        first = line[1] if line[0].upper == "GLOBAL" and len(line) > 1 else line[0]
        if first.upper in _CLOSED_BY:
            # A routine that begins within another one: the first was never ended.
            if opened is not None:
                break
            opened = first
        elif opened is not None and first.upper == _CLOSED_BY[opened.upper]:
            opened = None
    if opened is not None:
        end = _CLOSED_BY[opened.upper]
        source.fail(f"the {opened.text} that begins here has no {end}; the file is cut off", opened.start)


class _Reader:
    """Follows the lines."""

    def __init__(self, draft: Draft, data: Data) -> None:
        self._draft = draft
        self._data = data
        self._frames = FramesInUse()
        self._on_tool = False  # the robot holds the work

    def enter_loop(self, sets: set[str]) -> None:
        """Say that a loop begins, in which these frames are set."""
        self._frames.begin_loop(sets)
        self._draft.interrupt()

    def follow(self, words: Tokens) -> None:
        """Say what a line does with the robot and with targets."""
        first = words[0].upper
        if first in _PATHS:
            self._move(_PATHS[first], words)
        elif first in _LEFT:
            self._leave(words, _LEFT[first])
        elif first in _BRANCHES:
            self._frames.branch(_BRANCHES[first])
            self._draft.interrupt()
        elif first in _CLOSED_BY or first in _CLOSED_BY.values():
            self._frames.begin_routine()
            self._draft.interrupt()
        else:
            self._other(words)

    def _other(self, words: Tokens) -> None:
        at = next((index for index in outside(words) if words[index].text == "="), None)
        if at is not None:
            self._assignment(words, at)
        elif words[0].upper == "BAS":
            self._bas(words)
        elif any(token.text == "(" for token in words[1:2]):
            self._call(words)
        elif words[0].upper not in _STANDS_STILL:
            self._draft.interrupt()  # a label, or what is not known

    def _assignment(self, words: Tokens, at: int) -> None:
        name, value = words[0].upper, words[at + 1 :]
        if name in NAMES:
            self._frames.put(NAMES[name], self._data.frames.given(name, value))
        elif name == "$IPO_MODE":
            self._on_tool = "#TCP" in self._draft.shown(value).upper()
        elif name == "FDAT_ACT":
            data = self._data.point_data(value[0].upper) if value else None
            self._frames.put("TOOL", data.tool if data else None)
            self._frames.put("BASE", data.base if data else None)
        self._draft.compute_from(words, self._data.targets_in(value))

    def _bas(self, words: Tokens) -> None:
        match inside(words[1:], "("):
            case [command, given]:
                for name, which in NAMES.items():
                    if self._draft.shown(command).upper() == name.replace("$", "#"):
                        frame = self._data.frames.numbered(which, whole(self._draft.source, given))
                        self._frames.put(which, frame)

    def _call(self, words: Tokens) -> None:
        self._draft.hand_over(words, self._data.targets_in(words))
        if words[0].upper not in _STANDS_STILL:
            self._draft.interrupt()

    def _move(self, path: Path, words: Tokens) -> None:
        given = self._with(words)
        tool, base = (given.get(which, self._frames.of(which)) for which in NAMES.values())
        reason = HOLDS_WORK if self._on_tool else tool if isinstance(tool, Message) else base
        if isinstance(reason, Message):
            self._leave(words, reason)
            return
        chosen = self._chosen(words, _aim(words[1:]))
        if isinstance(chosen, Message):
            self._leave(words, chosen)
            return
        line = self._draft.line(words)
        self._draft.visit(line, chosen.targets, path, _framed(tool), _framed(base))
        if not chosen.told:
            self._leave(words, CHOSEN)

    def _with(self, words: Tokens) -> dict[Which, InUse]:
        """Return the frames that hold for this motion only: those behind WITH."""
        at = next((place for place in outside(words) if words[place].upper == "WITH"), len(words))
        return {
            NAMES[part[0].upper]: self._data.frames.given(part[0].upper, part[2:])
            for part in parts(words[at + 1 :])
            if part and part[0].upper in NAMES
        }

    def _chosen(self, words: Tokens, aim: Tokens) -> ArgumentTargets | Message:
        if not aim:
            self._draft.source.refuse(f"{words[0].text} has no target", words[0].start)
        if inside(aim, "{") is not None:
            name = f"line {self._draft.line(words)}"
            found = target(self._draft.source, name, aim)
            return found if isinstance(found, Message) else ArgumentTargets((self._draft.add(found),))
        is_name = aim[0].kind == "word" and len(bracket(aim, "[", 1)) == len(aim) - 1
        return self._data.chosen(aim) if is_name else COMPUTED

    def _leave(self, words: Tokens, reason: Message) -> None:
        self._draft.leave_words(words, reason, self._data.targets_in(words))


def _framed(frame: InUse) -> Frame | None:
    return frame if isinstance(frame, Frame) else None


def _aim(words: Tokens) -> Tokens:
    """Return the target of a motion, without what is said of its speed and its rounding."""
    for place in outside(words):
        text = words[place].upper
        if text in ("WITH", ",") or (text.startswith("C_") and place > 0):
            return words[:place]
    return words
