"""RAPID modules of ABB controllers (.mod, .sys, .prg): the data that they declare, and their motions.

Source: ABB, Technical reference manual, RAPID Instructions, Functions and Data types, section
"Instructions": which argument is the target, and which the tool.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Final

from truepose.exchange.programs.languages.rapid_data import (
    JOINTTARGET,
    ROBTARGET,
    Routine,
    Statement,
    assignment_at,
    elements,
    read_statements,
    target,
    tool,
    work_object,
)
from truepose.exchange.programs.parsed_program import (
    ARC,
    CHOSEN,
    COMPUTED,
    DISPLACED,
    ELSEWHERE,
    ArgumentTargets,
    Draft,
)
from truepose.exchange.programs.program import AT_THE_ORIGIN, Frame, Path
from truepose.exchange.programs.tokens import (
    Token,
    Tokens,
    bracket,
    closing,
    display_tokens,
    inside,
    number,
    outside,
    parts,
)
from truepose.messages.message import Message, message

_TARGETS: Final = frozenset({ROBTARGET, JOINTTARGET})
_FRAMES: Final = {"TOOLDATA": tool, "WOBJDATA": work_object}
_STORED_AS: Final = frozenset({"CONST", "PERS", "VAR"})
_ALWAYS_THERE: Final = {
    "TOOL0": Frame("tool0", AT_THE_ORIGIN),
    "WOBJ0": Frame("wobj0", AT_THE_ORIGIN),
}


@dataclass(slots=True)
class Datum:
    """A name of the module: targets by the index in an array, () where it is none; or a frame."""

    kind: str
    targets: dict[tuple[int, ...], list[int]] = field(default_factory=dict)
    frame: Frame | Message | None = None

    def all_targets(self) -> tuple[int, ...]:
        """Return every target that the name ever is."""
        return tuple(index for indices in self.targets.values() for index in indices)


class Data:
    """What the names of a module stand for."""

    def __init__(self, draft: Draft, statements: Iterable[Statement]) -> None:
        self._draft = draft
        self._source = draft.source
        self._names: dict[tuple[int, str], Datum] = {}
        assignments = []
        for statement in statements:
            self._declare(statement)
            if _is_assignment(statement.words):
                assignments.append(statement)
        for statement in assignments:  # also to what is declared further down
            self._give(statement)

    def find(self, routine: Routine, name: str) -> Datum | None:
        """Return what a name in capitals stands for; None for an argument and for what is elsewhere."""
        own = self._names.get((routine.number, name))
        if own is not None or name in routine.arguments:
            return own
        return self._names.get((0, name))

    def targets_in(self, routine: Routine, words: Tokens) -> tuple[int, ...]:
        """Return the targets whose names an expression has."""
        found: list[int] = []
        for at, word in enumerate(words):
            datum = self.find(routine, word.upper) if word.kind == "word" else None
            if datum is not None and datum.kind in _TARGETS:
                found += self._among(datum, bracket(words, "{", at + 1))
        return tuple(found)

    def chosen(self, routine: Routine, words: Tokens) -> ArgumentTargets | Message:
        """Return the targets that a name, with or without index, can be; or why that is not known."""
        name = words[0].upper
        if name in routine.arguments:
            return message("left.argument")
        datum = self.find(routine, name)
        if datum is None or datum.kind not in _TARGETS:
            return ELSEWHERE
        targets = self._among(datum, words[1:])
        return ArgumentTargets(targets, self._index(words[1:]) is not None) if targets else COMPUTED

    def frame(self, routine: Routine, words: Tokens) -> Frame | Message:
        """Return the tool or work object of that name, or why targets with it are left alone."""
        name = words[0].upper if words else ""
        datum = self.find(routine, name) if len(words) == 1 else None
        if datum is not None and datum.frame is not None:
            return datum.frame
        return _ALWAYS_THERE.get(name) or Frame(display_tokens(self._source, words))

    def _declare(self, statement: Statement) -> None:
        words = statement.words
        at = next((index for index in outside(words) if words[index].upper in _STORED_AS), None)
        if at is None or len(words) < at + 3:
            return
        kind, name, rest = words[at + 1].upper, words[at + 2], words[at + 3 :]
        if kind not in _TARGETS and kind not in _FRAMES:
            return
        datum = self._names.setdefault((statement.routine.number, name.upper), Datum(kind))
        value = _behind_assignment(rest)
        if value and kind in _TARGETS:
            self._add_all(datum, name.text, _dimensions(rest), value)
        elif value:
            # Declared twice under one name, perhaps with two values: of such a frame only the name is known.
            again = datum.frame is not None
            datum.frame = Frame(name.text) if again else _FRAMES[kind](self._source, name.text, value)

    def _add_all(self, datum: Datum, name: str, dimensions: int, value: Tokens) -> None:
        for index, words in elements(self._source, value, dimensions):
            called = f"{name}{{{','.join(map(str, index))}}}" if index else name
            self._add(datum, index, called, words)

    def _add(self, datum: Datum, index: tuple[int, ...], name: str, words: Tokens) -> None:
        found = target(self._source, datum.kind, name, words)
        if isinstance(found, Message):
            self._draft.leave(self._source.line(words[0].start), name, found)
        else:
            datum.targets.setdefault(index, []).append(self._draft.add(found))

    def _give(self, statement: Statement) -> None:
        """Follow an assignment: a literal is one more target, all else changes what was declared."""
        words, routine = statement.words, statement.routine
        at = assignment_at(words) or 0
        name, index_words, component = _assigned(words[:at])
        datum = self.find(routine, name.upper)
        if datum is None:
            return
        line = self._source.line(name.start)
        if datum.kind in _FRAMES:
            datum.frame = message("left.frame_changed", frame=name.text, place=self._source.place(line))
            return
        index = self._index(index_words)
        if index is not None and not component and inside(words[at + 1 :], "[") is not None:
            self._add(datum, index, display_tokens(self._source, [name, *index_words]), words[at + 1 :])
            return
        self._draft.change(line, self._among(datum, index_words))

    def _among(self, datum: Datum, index_words: Tokens) -> tuple[int, ...]:
        """Return the targets that an index chooses; all of an array where it is computed."""
        index = self._index(index_words)
        if index is None or not (index or () in datum.targets):
            return datum.all_targets()
        return tuple(datum.targets.get(index, ()))

    def _index(self, words: Tokens) -> tuple[int, ...] | None:
        """Return the index that stands behind a name; None where it is computed, () where none stands."""
        if not words:
            return ()
        read = [number(self._source, entry) for entry in inside(words, "{") or ()]
        index = tuple(int(entry.value) for entry in read if entry is not None)
        return index if index and len(index) == len(read) else None


def _is_assignment(words: Tokens) -> bool:
    """Whether words give something to what is declared elsewhere."""
    return bool(assignment_at(words)) and all(
        words[index].upper not in _STORED_AS for index in outside(words)
    )


def _behind_assignment(words: Tokens) -> Tokens:
    at = assignment_at(words)
    return () if at is None else words[at + 1 :]


def _dimensions(words: Tokens) -> int:
    return len(inside(bracket(words, "{"), "{") or ())


def _assigned(words: Tokens) -> tuple[Token, Tokens, Tokens]:
    """Return name, index and component that an assignment goes to, of the words before its sign."""
    start = 0
    for index in outside(words):
        follows = index > 0 and words[index - 1].text == "."
        if words[index].kind == "word" and not follows:
            start = index
    index_words = bracket(words, "{", start + 1)
    return words[start], index_words, words[start + 1 + len(index_words) :]


@dataclass(frozen=True, slots=True)
class _Move:
    """An instruction that moves to its first argument; `tool` is the place of the tool among the others."""

    path: Path
    tool: int = 3
    kind: str = ROBTARGET


_MOVES: Final = {
    **dict.fromkeys(("MOVEJ", "MOVEJDO", "MOVEJAO", "MOVEJGO", "MOVEJSYNC"), _Move("joints")),
    **dict.fromkeys(("MOVEL", "MOVELDO", "MOVELAO", "MOVELGO", "MOVELSYNC"), _Move("line")),
    "MOVEABSJ": _Move("joints", kind=JOINTTARGET),
    "TRIGGJ": _Move("joints", tool=4),
    "TRIGGL": _Move("line", tool=4),
    "TRIGGABSJ": _Move("joints", tool=4, kind=JOINTTARGET),
    "SPOTJ": _Move("joints", tool=-1),
    **dict.fromkeys(("SPOTL", "ARCL", "ARCLSTART", "ARCLEND", "DISPL"), _Move("line", tool=-1)),
}
_ARCS: Final = (
    "MOVEC", "MOVECDO", "MOVECAO", "MOVECGO", "MOVECSYNC", "TRIGGC", "ARCC", "ARCCSTART", "ARCCEND", "DISPC",
)  # fmt: skip
_LEFT: Final = {
    **dict.fromkeys(_ARCS, ARC),
    **dict.fromkeys(("SEARCHL", "SEARCHC"), message("left.search")),
    "SEARCHEXTJ": message("left.search"),
    "MOVEEXTJ": message("left.external_only"),
    **dict.fromkeys(("PDISPON", "PDISPSET"), message("left.displaces")),
    **dict.fromkeys(("EOFFSON", "EOFFSSET"), message("left.displaces_external")),
    **dict.fromkeys(("CORRCON", "CORRWRITE"), message("left.sensor")),
    **dict.fromkeys(("STARTMOVE", "STOREPATH", "RESTOPATH"), message("left.path_again")),
}
_DISPLACES: Final = {"PDISPON": True, "PDISPSET": True, "PDISPOFF": False}
_STANDS_STILL: Final = frozenset({
    "SETDO", "SETGO", "SETAO", "SET", "RESET", "PULSEDO", "INVERTDO", "WAITTIME", "WAITDI", "WAITDO",
    "WAITUNTIL", "WAITROB", "TPWRITE", "TPERASE", "ACCSET", "VELSET", "CONFJ", "CONFL", "SINGAREA",
    "GRIPLOAD", "INCR", "DECR", "ADD", "CLEAR", "CLKRESET", "CLKSTART", "CLKSTOP", "STOP", "PDISPOFF",
    "EOFFSOFF",
})  # fmt: skip


def read(draft: Draft) -> None:
    """Read a RAPID module."""
    data = Data(draft, read_statements(draft.source))
    displaced, routine = False, None
    for statement in read_statements(draft.source):  # read anew: its words weigh a hundred times the text
        displaced = displaced and statement.routine is routine
        routine = statement.routine
        if not statement.is_condition:
            _Follower(draft, data, statement, displaced).follow()
            displaced = _is_displaced_behind(statement, displaced)
        if statement.branches:
            draft.interrupt()


def _is_displaced_behind(statement: Statement, displaced: bool) -> bool:
    """Whether a displacement of the program holds behind a statement, by the text of its routine."""
    given = [_DISPLACES[word.upper] for word in statement.words if word.upper in _DISPLACES]
    return given[-1] if given else displaced


class _Follower:
    """Follows one statement; `displaced` if a displacement of the program holds."""

    def __init__(self, draft: Draft, data: Data, statement: Statement, displaced: bool) -> None:
        self._displaced = displaced
        self._draft = draft
        self._data = data
        self._words = statement.words
        self._routine = statement.routine

    def follow(self) -> None:
        """Say what the statement does with the robot and with targets."""
        words = self._words
        places = list(outside(words))
        if any(words[index].text == ":" for index in places):
            self._draft.interrupt()  # a label or a case
        for index in places:
            name = words[index].upper
            if name in _MOVES:
                self._move(_MOVES[name], index)
                return
            if name in _LEFT:
                self._leave(words[index:], _LEFT[name])
                return
        assignment = assignment_at(words)
        if assignment is not None:
            self._assignment(assignment)
        elif words and words[0].upper not in _STANDS_STILL:
            self._call()

    def _assignment(self, at: int) -> None:
        serving = self._data.targets_in(self._routine, self._words[at + 1 :])
        self._draft.compute_from(self._words, serving)

    def _call(self) -> None:
        # A routine that is not followed may move to what it is given, and leaves the robot where nobody
        # knows.
        self._draft.hand_over(self._words, self._data.targets_in(self._routine, self._words))
        self._draft.interrupt()

    def _move(self, move: _Move, index: int) -> None:
        words = self._words[index:]
        arguments = [given for part in parts(words[1:]) if (given := _without_options(part))]
        if not arguments:
            self._draft.source.refuse(f"{words[0].text} has no target", words[0].start)
        frames = self._frames(move, words, arguments)
        if isinstance(frames, Message):
            self._leave(words, frames)
            return
        chosen = self._chosen(move, arguments[0])
        if isinstance(chosen, Message):
            self._leave(words, chosen)
            return
        self._draft.visit(self._draft.line(words), chosen.targets, move.path, *frames)
        if not chosen.told:
            self._leave(words, CHOSEN)

    def _chosen(self, move: _Move, words: Tokens) -> ArgumentTargets | Message:
        """Return the targets that an argument can be, or why the motion is left alone."""
        if words[0].text == "*":
            return message("left.hidden")
        if words[0].text == "[":
            found = target(self._draft.source, move.kind, f"line {self._draft.line(words)}", words)
            return found if isinstance(found, Message) else ArgumentTargets((self._draft.add(found),))
        is_name = len(words) == 1 or (words[1].text == "{" and closing(words, 1) == len(words) - 1)
        return self._data.chosen(self._routine, words) if is_name else COMPUTED

    def _frames(
        self, move: _Move, words: Tokens, arguments: Sequence[Tokens]
    ) -> tuple[Frame | None, Frame | None] | Message:
        """Return tool and work object, or why the motion is left alone; joint angles need neither."""
        if move.kind == JOINTTARGET:
            return None, None
        # What PDispOn adds is computed while the program runs: the numbers of the target are not where the
        # robot goes.
        if self._displaced:
            return DISPLACED
        if not -len(arguments) <= move.tool < len(arguments):
            return message("left.no_tool")
        tool = self._data.frame(self._routine, arguments[move.tool])
        work_object = self._data.frame(self._routine, _work_object(words))
        if isinstance(tool, Message):
            return tool
        return work_object if isinstance(work_object, Message) else (tool, work_object)

    def _leave(self, words: Tokens, reason: Message) -> None:
        self._draft.leave_words(words, reason, self._data.targets_in(self._routine, words))


def _without_options(words: Tokens) -> Tokens:
    """Return an argument without the options behind it, which begin with a backslash."""
    option = next((index for index in outside(words) if words[index].text == "\\"), len(words))
    return words[:option]


def _work_object(words: Tokens) -> Sequence[Token]:
    """Return the words of the option WObj; those of wobj0 where it is not given."""
    for part in parts(words):
        for index in outside(part):
            if part[index].upper == "WOBJ" and index > 0 and part[index - 1].text == "\\":
                behind = part[index + 2 :]
                return _without_options(behind)
    return (Token("word", "wobj0", words[0].start, words[0].end),)
