"""A program while it is read: what its targets are, what is done with each, which frames hold where.

A target is corrected if the program moves to it, or if nothing in the file says what is done with it. It
is left alone if the program changes it, if it only serves to compute other places or an arc, or if it is
used with several tools or work objects, because one set of numbers cannot be right for all of them.

What is set in a branch holds only there; what is set in a loop may also hold when it begins again.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Final, TypeAlias

from truepose.domain.correction import UncorrectedTarget
from truepose.exchange.programs.program import (
    Configuration,
    Frame,
    LeftAlone,
    Motion,
    Path,
    Pose,
    Program,
    ProgramTarget,
    Source,
    Value,
)
from truepose.exchange.programs.tokens import Tokens, display_tokens
from truepose.messages.message import Message, Text, message

COMPUTED: Final = message("left.computed")
ELSEWHERE: Final = message("left.elsewhere")
CHOSEN: Final = message("left.chosen")
HOLDS_WORK: Final = message("left.holds_work")
DISPLACED: Final = message("left.displaced")
RELATIVE: Final = message("left.relative")
ARC: Final = message("left.arc")
_MOST_MEANT: Final = 1_000_000  # targets of names that mean several, each as often as it is meant


@dataclass(frozen=True, slots=True)
class Use:
    """A motion to one of these targets: of one name, at different moments."""

    line: int
    targets: tuple[int, ...]
    path: Path
    tool: Frame | None
    work_object: Frame | None
    near_rad: tuple[float, ...] | None
    follows: bool  # whether the motion before it in the text is the one before it when the program runs


@dataclass(frozen=True, slots=True)
class ArgumentTargets:
    """The targets that an argument can be; `told` if the text says which element of an array it is."""

    targets: tuple[int, ...]
    told: bool = True
    near_rad: tuple[float, ...] | None = None  # a configuration that chooses the branch


Held: TypeAlias = dict[str, list[int]]  # targets of a name by their index, as it stands


def among(held: Held, index: str | None) -> tuple[int, ...]:
    """Return the targets that an index chooses; all of them where it is computed (None)."""
    if index is None:
        return tuple(target for targets in held.values() for target in targets)
    return tuple(held.get(index, ()))


@dataclass(slots=True)
class _Fate:
    """What the program does with a target."""

    uses: list[Use] = field(default_factory=list)
    changed_line: int | None = None
    serves: bool = False  # to compute other places, or an arc


class Draft:
    """Collects what a reader finds.

    Parameters
    ----------
    source : Source
    angles : str, optional
        What the caller says of the order of three angles, where the format does not.
    """

    def __init__(self, source: Source, angles: str | None = None) -> None:
        self.source = source
        self.angles = angles
        self._targets: list[ProgramTarget] = []
        self._fates: list[_Fate] = []
        self._uses: list[Use] = []
        self._left: list[tuple[UncorrectedTarget, tuple[int, ...]]] = []
        self._follows = False
        self._meant = 0

    def line(self, words: Tokens) -> int:
        """Return the line that words of the text begin on."""
        return self.source.line(words[0].start)

    def shown(self, words: Tokens) -> str:
        """Return words of the text as a person reads them, cut where they are long."""
        return display_tokens(self.source, words)

    def add(self, target: ProgramTarget, *, if_used: bool = False) -> int:
        """Add a target and return its index.

        With `if_used` it is one only if the program moves to it: its type has other uses.
        """
        self._targets.append(target)
        self._fates.append(_Fate(serves=if_used))
        return len(self._targets) - 1

    def value(self, target: int) -> Value:
        """Return the configuration or the pose of a target."""
        return self._targets[target].value

    def visit(
        self,
        line: int,
        targets: Sequence[int],
        path: Path,
        tool: Frame | None = None,
        work_object: Frame | None = None,
        near_rad: tuple[float, ...] | None = None,
    ) -> None:
        """Say that the program moves to a target; to one of several where a name has several values."""
        self._count(line, targets)
        use = Use(line, tuple(targets), path, tool, work_object, near_rad, self._follows)
        self._uses.append(use)
        self._follows = True
        for target in targets:
            self._fates[target].uses.append(use)

    def leave(
        self, line: int, what: str, reason: Message, serving: Sequence[int] = (), *, moves: bool = True
    ) -> None:
        """Leave something alone, for which the targets `serving` are used; `moves` the robot or not."""
        self._count(line, serving)
        self._left.append((UncorrectedTarget(line, what, reason), tuple(serving)))
        for target in serving:
            self._fates[target].serves = True
        if moves:
            self.interrupt()

    def leave_words(self, words: Tokens, reason: Message, serving: Sequence[int]) -> None:
        """Leave a motion alone that words of the text tell, as `leave` does."""
        self.leave(self.line(words), self.shown(words), reason, serving)

    def compute_from(self, words: Tokens, serving: Sequence[int]) -> None:
        """Say that words of the text compute something from targets, if there are any; nothing moves."""
        if serving:
            self.leave(self.line(words), self.shown(words), COMPUTED, serving, moves=False)

    def hand_over(self, words: Tokens, targets: Sequence[int]) -> None:
        """Say that targets, if there are any, are handed to something that is not seen, or not followed."""
        if targets:
            line, reason = self.line(words), message("left.not_seen")
            self._count(line, targets)
            self._left.append((UncorrectedTarget(line, self.shown(words), reason), tuple(targets)))
            self.interrupt()

    def change(self, line: int, targets: Sequence[int]) -> None:
        """Say that the program gives targets other values than those that stand in the file."""
        self._count(line, targets)
        for target in targets:
            self._fates[target].changed_line = line

    def _count(self, line: int, targets: Sequence[int]) -> None:
        """Refuse a program of a few lines of which each may mean thousands of targets."""
        self._meant += max(len(targets) - 1, 0)
        if self._meant > _MOST_MEANT:
            sentence = "computed indices select among too many targets; split the program"
            self.source.fail(sentence, self.source.line_span(line)[0])

    def interrupt(self) -> None:
        """Say that it is not known where the robot stands when the next motion begins."""
        self._follows = False

    def program(self, name_of_format: str) -> Program:
        """Return what was read."""
        # Files beside tell how targets of this one are used; they are not written, so their own are no
        # targets here (decision 0040).
        own = [target for target, found in enumerate(self._targets) if self.source.is_own(found.line)]
        kept = [target for target in own if self._reason_against(target) is None]
        index_of = {target: index for index, target in enumerate(kept)}
        return Program(
            name=self.source.name,
            format=name_of_format,
            data=self.source.data,
            targets=tuple(map(self._with_frames, kept)),
            motions=tuple(self._motions(index_of)),
            set_aside=tuple(self._all_left_alone(own, index_of)),
        )

    def _reason_against(self, target: int) -> Text | None:
        """Say why a target is left alone; None where it is corrected, empty where its uses say why."""
        fate = self._fates[target]
        if fate.changed_line is not None:
            return message("left.changed", place=self.source.place(fate.changed_line))
        if fate.serves and not fate.uses:
            return ""
        return None if isinstance(self._targets[target].value, Configuration) else self._two_frames(fate)

    def _two_frames(self, fate: _Fate) -> Message | None:
        for use in fate.uses[1:]:
            first = fate.uses[0]
            if _names(use) != _names(first):
                return message("left.two_frames", first=self._used(first), second=self._used(use))
        return None

    def _used(self, use: Use) -> Message:
        return message("left.used_with", frames=_frames(use), place=self.source.place(use.line))

    def _with_frames(self, target: int) -> ProgramTarget:
        found = self._targets[target]
        uses = self._fates[target].uses
        if not uses or not isinstance(found.value, Pose):
            return found
        tool, work_object = uses[0].tool or found.tool, uses[0].work_object or found.work_object
        near_rad = uses[0].near_rad or found.near_rad
        return replace(found, tool=tool, work_object=work_object, near_rad=near_rad)

    def _motions(self, index_of: dict[int, int]) -> Iterator[Motion]:
        before: int | None = None
        for use in self._uses:
            index = index_of.get(use.targets[0]) if len(use.targets) == 1 else None
            if index is not None:
                file, line = self._place(use.line)
                yield Motion(line, index, use.path, before if use.follows else None, file)
            before = index

    def _all_left_alone(self, own: Sequence[int], index_of: dict[int, int]) -> Iterator[LeftAlone]:
        """Yield what is left alone, by line; of the files beside only what uses targets of this one."""
        entries = [
            (UncorrectedTarget(self._targets[target].line, self._targets[target].name, reason), ())
            for target in own
            if isinstance(reason := self._reason_against(target), Message)
        ]
        for entry, serving in sorted([*entries, *self._left], key=lambda pair: pair[0].line):
            used = tuple(index_of[target] for target in serving if target in index_of)
            if used or self.source.is_own(entry.line):
                file, line = self._place(entry.line)
                yield LeftAlone(UncorrectedTarget(line, entry.what, entry.reason, file), used)

    def _place(self, line: int) -> tuple[str | None, int]:
        file, number = self.source.file_and_line(line)
        return None if self.source.is_own(line) else file, number


def _names(use: Use) -> tuple[str, ...]:
    return tuple(frame.name.casefold() for frame in (use.tool, use.work_object) if frame is not None)


def _frames(use: Use) -> Message:
    match [frame.shown for frame in (use.tool, use.work_object) if frame is not None]:
        case [tool, frame]:
            return message("left.frame_in_frame", tool=tool, frame=frame)
        case [frame]:
            return message("left.frame_named", frame=frame)
    return message("left.frames_unknown")


InUse: TypeAlias = Frame | Message | None  # a reason where nothing in it can be corrected, None if not known


@dataclass(frozen=True, slots=True)
class Step:
    """What a line does to frames: enters (1) or leaves (-1) a branch, and sets which of them."""

    deeper: int
    sets: frozenset[str] = frozenset()


def sets_within(steps: Iterable[Step]) -> list[set[str]]:
    """Return for each line what is set up to the one that leaves the branch that it enters."""
    found: list[set[str]] = []
    opened: list[set[str]] = []
    for step in steps:
        found.append(set(step.sets))
        if step.deeper > 0:
            opened.append(found[-1])
        elif opened:
            opened[-1] |= step.sets
            if step.deeper < 0:
                _close(opened)
    while opened:  # by the end of the text
        _close(opened)
    return found


def _close(opened: list[set[str]]) -> None:
    """Leave the innermost branch: what is set in it is set in the one around it."""
    inner = opened.pop()
    if opened:
        opened[-1] |= inner


class FramesInUse:
    """Which tool and base hold at a place in the text."""

    def __init__(self) -> None:
        self._held: dict[str, tuple[InUse, int]] = {}  # and the depth of branches at which it was set
        self._depth = 0

    def of(self, which: str) -> InUse:
        """Return the tool or the base that holds now; None where it is not known."""
        return self._held.get(which, (None, 0))[0]

    def put(self, which: str, frame: InUse) -> None:
        """Say that a tool or base holds from here."""
        self._held[which] = (frame, self._depth)

    def begin_loop(self, sets: set[str]) -> None:
        """Enter a loop in which frames are set: as it begins they may hold already, or not yet."""
        self.branch(1)
        for which in sets:
            self.put(which, None)

    def begin_routine(self) -> None:
        """Forget all: who calls a routine may have set anything."""
        self._held.clear()
        self._depth = 0

    def branch(self, deeper: int) -> None:
        """Enter (1), leave (-1) or change (0) a branch; behind it nobody knows what was set in it."""
        floor = self._depth + min(deeper, 0)
        left = self._depth if deeper < 1 else self._depth + 1
        for which, (_, depth) in list(self._held.items()):
            if depth >= left and depth > 0:
                self._held[which] = (None, floor)
        self._depth = max(self._depth + deeper, 0)
