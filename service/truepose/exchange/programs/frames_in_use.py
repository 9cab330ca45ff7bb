"""Which tool and which work object hold where, in a language that sets them by statements.

What is set in a branch holds only there; what is set in a loop may also hold when it begins again.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

from truepose.domain.sentences import Sentence
from truepose.exchange.programs.program import Frame

InUse: TypeAlias = Frame | Sentence | None  # a reason where nothing in it can be corrected, None if not known


@dataclass(frozen=True, slots=True)
class Step:
    """What a line does to frames: enters (1) or leaves (-1) a branch, and sets which of them."""

    deeper: int
    sets: frozenset[str] = frozenset()


def set_within(steps: Sequence[Step], at: int) -> set[str]:
    """Return what is set between the line that enters a branch and the one that leaves it."""
    depth, found = 0, set[str]()
    for step in steps[at:]:
        depth += step.deeper
        found |= step.sets
        if depth == 0:
            break
    return found


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
