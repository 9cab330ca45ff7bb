"""The data that a RAPID module declares, and what its statements give to them."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Final

from truepose.domain.sentences import Sentence, said
from truepose.exchange.programs.draft import COMPUTED, ELSEWHERE, Chosen, Draft
from truepose.exchange.programs.languages.rapid.module import Routine, Statement, assignment_at
from truepose.exchange.programs.languages.rapid.values import (
    JOINTTARGET,
    ROBTARGET,
    elements,
    target,
    tool,
    work_object,
)
from truepose.exchange.programs.program import AT_THE_ORIGIN, Frame
from truepose.exchange.programs.tokens import Token, Tokens, closing, inside, number, outside, shown

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
    frame: Frame | Sentence | None = None

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
                found += self._among(datum, _bracket(words[at + 1 :]))
        return tuple(found)

    def chosen(self, routine: Routine, words: Tokens) -> Chosen | Sentence:
        """Return the targets that a name, with or without index, can be; or why that is not known."""
        name = words[0].upper
        if name in routine.arguments:
            return said("left.argument")
        datum = self.find(routine, name)
        if datum is None or datum.kind not in _TARGETS:
            return ELSEWHERE
        targets = self._among(datum, words[1:])
        return Chosen(targets, self._index(words[1:]) is not None) if targets else COMPUTED

    def frame(self, routine: Routine, words: Tokens) -> Frame | Sentence:
        """Return the tool or work object of that name, or why targets with it are left alone."""
        name = words[0].upper if words else ""
        datum = self.find(routine, name) if len(words) == 1 else None
        if datum is not None and datum.frame is not None:
            return datum.frame
        return _ALWAYS_THERE.get(name) or Frame(shown(self._source, words))

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
            again = datum.frame is not None
            datum.frame = Frame(name.text) if again else _FRAMES[kind](self._source, name.text, value)

    def _add_all(self, datum: Datum, name: str, dimensions: int, value: Tokens) -> None:
        for index, words in elements(self._source, value, dimensions):
            called = f"{name}{{{','.join(map(str, index))}}}" if index else name
            self._add(datum, index, called, words)

    def _add(self, datum: Datum, index: tuple[int, ...], name: str, words: Tokens) -> None:
        found = target(self._source, datum.kind, name, words)
        if isinstance(found, Sentence):
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
            datum.frame = said("left.frame_changed", frame=name.text, place=self._source.place(line))
            return
        index = self._index(index_words)
        if index is not None and not component and inside(words[at + 1 :], "[") is not None:
            self._add(datum, index, shown(self._source, [name, *index_words]), words[at + 1 :])
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
    return len(inside(_bracket(words), "{") or ())


def _assigned(words: Tokens) -> tuple[Token, Tokens, Tokens]:
    """Return name, index and component that an assignment goes to, of the words before its sign."""
    start = 0
    for index in outside(words):
        follows = index > 0 and words[index - 1].text == "."
        if words[index].kind == "word" and not follows:
            start = index
    behind = words[start + 1 :]
    bracket = _bracket(behind)
    return words[start], bracket, behind[len(bracket) :]


def _bracket(words: Tokens) -> Tokens:
    """Return the index that words begin with; no words where they begin with none."""
    return words[: closing(words, 0) + 1] if words and words[0].text == "{" else ()
