"""What a KRL file declares: targets by name and index, and tool and base of the points of inline forms."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final, TypeAlias

from truepose.domain.sentences import Sentence
from truepose.exchange.programs.draft import COMPUTED, ELSEWHERE, Chosen, Draft
from truepose.exchange.programs.languages.krl.frames import NAMES, Frames, PointData
from truepose.exchange.programs.languages.krl.values import entries, target
from truepose.exchange.programs.tokens import Token, Tokens, closing, inside, number, outside, parts, shown

_TARGETS: Final = frozenset({"E6POS", "POS", "E6AXIS", "AXIS"})
_FRAME: Final = "FRAME"  # of a target, of an offset or of a base
_POINT_DATA: Final = "FDAT"
_IN_FRONT: Final = frozenset({"GLOBAL", "DECL", "CONST", "PUBLIC"})
_Held: TypeAlias = dict[str, list[int]]  # targets by index as it stands


@dataclass(frozen=True, slots=True)
class _Given:
    """A name, and what a line gives to it; without a value it is only declared."""

    kind: str  # its type, empty where the line does not say it
    name: Token
    index: Tokens
    component: bool  # whether only a part of it
    value: Tokens


class Data:
    """The names of a file."""

    def __init__(self, draft: Draft, lines: Sequence[Tokens]) -> None:
        self._draft = draft
        self._source = draft.source
        self._points: dict[str, PointData] = {}
        self._targets: dict[str, _Held] = {}
        self._certain: set[str] = set()  # names of targets, whether or not this file moves to them
        self.frames = Frames(self._source)
        given = [entry for line in lines for entry in _given(line)]
        for entry in given:
            self._take_frame(entry)
        for entry in given:
            if entry.kind == _POINT_DATA:
                self._points[entry.name.upper] = self.frames.of_point(entry.value)
        for entry in given:
            self._take(entry)

    def point_data(self, name: str) -> PointData | None:
        """Return what FDAT says under a name in capitals."""
        return self._points.get(name)

    def chosen(self, words: Tokens) -> Chosen | Sentence:
        """Return the targets that a name, with or without index, can be; or why that is not known."""
        name, index = words[0].upper, self._index(words[1:])
        held = self._targets.get(name)
        if held is None:
            return COMPUTED if name.startswith("$") else ELSEWHERE
        targets = _among(held, index)
        return Chosen(targets, index is not None) if targets else COMPUTED

    def targets_in(self, words: Tokens) -> tuple[int, ...]:
        """Return the targets whose names an expression has."""
        found: list[int] = []
        for at, word in enumerate(words):
            if word.upper in self._targets:
                found += _among(self._targets[word.upper], self._index(bracket(words[at + 1 :])))
        return tuple(found)

    def _take_frame(self, given: _Given) -> None:
        """Take down what may be a tool or a base: an aggregate of the type FRAME, or without a type."""
        may_be = given.kind in ("", _FRAME) and not given.component and given.name.upper not in NAMES
        if may_be and entries(given.value) is not None:
            self.frames.declare(f"{given.name.upper}{shown(self._source, given.index)}", given.value)

    def _take(self, given: _Given) -> None:
        name = given.name.upper
        if name.startswith("$") or name.endswith("_DATA"):
            return
        if given.kind in _TARGETS:
            self._certain.add(name)
        if given.kind in _TARGETS or given.kind == _FRAME or _is_place(given):
            self._targets.setdefault(name, {})
        if name in self._targets and given.value:
            self._give(self._targets[name], given)

    def _give(self, held: _Held, given: _Given) -> None:
        """Follow what is given to a target: an aggregate is one, all else changes it."""
        index = self._index(given.index)
        if given.component or index is None or entries(given.value) is None:
            self._draft.change(self._source.line(given.name.start), _among(held, index))
            return
        name = shown(self._source, [given.name, *given.index])
        if_used = given.name.upper not in self._certain
        data = self._points.get(f"F{name.upper()[1:]}") or PointData(None, None)
        found = data.reason or target(self._source, name, given.value)
        if not isinstance(found, Sentence):
            framed = replace(found, tool=data.tool, work_object=data.base)
            held.setdefault(index, []).append(self._draft.add(framed, if_used=if_used))
        elif not if_used:
            self._draft.leave(self._source.line(given.name.start), name, found, moves=False)

    def _index(self, words: Tokens) -> str | None:
        """Return an index as text; None where it is computed, empty where none stands."""
        if not words:
            return ""
        read = [number(self._source, entry) for entry in inside(words, "[") or ()]
        known = [f"{entry.value:g}" for entry in read if entry is not None]
        return ",".join(known) if known and len(known) == len(read) else None


def bracket(words: Tokens) -> Tokens:
    """Return the index that words begin with; no words where they begin with none."""
    return words[: closing(words, 0) + 1] if words and words[0].text == "[" else ()


def _among(held: _Held, index: str | None) -> tuple[int, ...]:
    if index is None:
        return tuple(target for targets in held.values() for target in targets)
    return tuple(held.get(index, ()))


def _is_place(given: _Given) -> bool:
    """Whether a value without a type is that of a target, which another file declares."""
    return not given.kind and not {"X", "A1"}.isdisjoint(entries(given.value) or ())


def _given(line: Tokens) -> Iterator[_Given]:
    """Yield what a line gives, or every name that it declares."""
    words = line
    while words and words[0].upper in _IN_FRONT:
        words = words[1:]
    kind = ""
    if len(words) > 1 and words[0].kind == words[1].kind == "word":
        kind, words = words[0].upper, words[1:]
    for entry in parts(words) if kind else [words]:
        if entry and entry[0].kind == "word":
            index = bracket(entry[1:])
            behind = entry[1 + len(index) :]
            given = bool(behind) and behind[0].text in ("=", ".")
            signs = (place for place in outside(behind) if behind[place].text == "=")
            at = next(signs, None) if given else None
            yield _Given(kind, entry[0], index, bool(at), () if at is None else behind[at + 1 :])
