"""The motions of a RAPID module.

Source: ABB, Technical reference manual, RAPID Instructions, Functions and Data types, section
"Instructions": which argument is the target, and which the tool.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from truepose.domain.sentences import Sentence, said
from truepose.exchange.programs.draft import ARC, CHOSEN, COMPUTED, DISPLACED, Chosen, Draft
from truepose.exchange.programs.languages.rapid.data import Data
from truepose.exchange.programs.languages.rapid.module import Statement, assignment_at, read_statements
from truepose.exchange.programs.languages.rapid.values import JOINTTARGET, ROBTARGET, target
from truepose.exchange.programs.program import Frame, Path
from truepose.exchange.programs.tokens import Token, Tokens, closing, outside, parts


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
    **dict.fromkeys(("SEARCHL", "SEARCHC"), said("left.search")),
    "SEARCHEXTJ": said("left.search"),
    "MOVEEXTJ": said("left.external_only"),
    **dict.fromkeys(("PDISPON", "PDISPSET"), said("left.displaces")),
    **dict.fromkeys(("EOFFSON", "EOFFSSET"), said("left.displaces_external")),
    **dict.fromkeys(("CORRCON", "CORRWRITE"), said("left.sensor")),
    **dict.fromkeys(("STARTMOVE", "STOREPATH", "RESTOPATH"), said("left.path_again")),
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
        if serving:
            self._draft.leave(
                self._draft.line(self._words), self._draft.shown(self._words), COMPUTED, serving, moves=False
            )

    def _call(self) -> None:
        handed = self._data.targets_in(self._routine, self._words)
        if handed:
            self._draft.hand_over(self._draft.line(self._words), self._draft.shown(self._words), handed)
        self._draft.interrupt()

    def _move(self, move: _Move, index: int) -> None:
        words = self._words[index:]
        arguments = [given for part in parts(words[1:]) if (given := _without_options(part))]
        if not arguments:
            self._draft.source.refuse(f"{words[0].text} has no target", words[0].start)
        frames = self._frames(move, words, arguments)
        if isinstance(frames, Sentence):
            self._leave(words, frames)
            return
        chosen = self._chosen(move, arguments[0])
        if isinstance(chosen, Sentence):
            self._leave(words, chosen)
            return
        self._draft.visit(self._draft.line(words), chosen.targets, move.path, *frames)
        if not chosen.told:
            self._leave(words, CHOSEN)

    def _chosen(self, move: _Move, words: Tokens) -> Chosen | Sentence:
        """Return the targets that an argument can be, or why the motion is left alone."""
        if words[0].text == "*":
            return said("left.hidden")
        if words[0].text == "[":
            found = target(self._draft.source, move.kind, f"line {self._draft.line(words)}", words)
            return found if isinstance(found, Sentence) else Chosen((self._draft.add(found),))
        is_name = len(words) == 1 or (words[1].text == "{" and closing(words, 1) == len(words) - 1)
        return self._data.chosen(self._routine, words) if is_name else COMPUTED

    def _frames(
        self, move: _Move, words: Tokens, arguments: Sequence[Tokens]
    ) -> tuple[Frame | None, Frame | None] | Sentence:
        """Return tool and work object, or why the motion is left alone; joint angles need neither."""
        if move.kind == JOINTTARGET:
            return None, None
        if self._displaced:
            return DISPLACED
        if not -len(arguments) <= move.tool < len(arguments):
            return said("left.no_tool")
        tool = self._data.frame(self._routine, arguments[move.tool])
        work_object = self._data.frame(self._routine, _work_object(words))
        if isinstance(tool, Sentence):
            return tool
        return work_object if isinstance(work_object, Sentence) else (tool, work_object)

    def _leave(self, words: Tokens, reason: Sentence) -> None:
        serving = self._data.targets_in(self._routine, words)
        self._draft.leave(self._draft.line(words), self._draft.shown(words), reason, serving)


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
