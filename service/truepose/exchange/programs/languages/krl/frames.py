"""Tools and bases that a KRL file declares, and that its statements name.

A base is given by $BASE, by BAS(#BASE, n), or with every point of an inline form: the point XP1 has its
numbers of tool and base in FP1.
"""

from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

from truepose.domain.sentences import Sentence, said
from truepose.exchange.programs.draft import HOLDS_WORK
from truepose.exchange.programs.frames_in_use import InUse
from truepose.exchange.programs.languages.krl.values import entries, pose, whole
from truepose.exchange.programs.program import AT_THE_ORIGIN, Frame, Pose
from truepose.exchange.programs.source import Source
from truepose.exchange.programs.tokens import Tokens, shown

Which: TypeAlias = Literal["TOOL", "BASE"]
_NONE_AT_ALL: Final = Frame("$NULLFRAME", AT_THE_ORIGIN)
_MOVED: Final = frozenset({"EK", "EB", "EO"})  # functions that give the base of another kinematic system
NAMES: Final[dict[str, Which]] = {"$TOOL": "TOOL", "$BASE": "BASE"}


@dataclass(frozen=True, slots=True)
class PointData:
    """What an inline form says of a point: tool and base, or why it is left alone."""

    tool: Frame | None
    base: Frame | None
    reason: Sentence | None = None


class Frames:
    """The frames that a file declares, by name in capitals."""

    def __init__(self, source: Source) -> None:
        self._source = source
        self._poses: dict[str, Pose | None] = {}

    def declare(self, name: str, words: Tokens) -> None:
        """Take down TOOL_DATA[n], BASE_DATA[n] or a variable; given twice, it is only known by its name."""
        again = name in self._poses
        self._poses[name] = None if again else pose(self._source, words)

    def numbered(self, which: Which, number: int | None) -> Frame | None:
        """Return a tool or base by its number."""
        if number is None:
            return None
        return _NONE_AT_ALL if number == 0 else self.named(f"{which}_DATA[{number}]")

    def named(self, name: str) -> Frame:
        """Return a tool or base by its name."""
        return _NONE_AT_ALL if name == _NONE_AT_ALL.name else Frame(name, self._poses.get(name))

    def given(self, name: str, words: Tokens) -> InUse:
        """Return what $TOOL or $BASE becomes by an assignment, of the words behind its sign."""
        if not words:
            return None
        if words[0].upper in _MOVED:
            return said("left.base_moved")
        written = pose(self._source, words)
        if written is not None:
            line = self._source.line(words[0].start)
            spoken = said("left.frame_at", frame=name, place=self._source.place(line))
            return Frame(f"{name} of {self._source.said(line)}", written, spoken)
        return self.named(shown(self._source, words).upper().replace(" ", ""))

    def of_point(self, words: Tokens) -> PointData:
        """Return what a FDAT aggregate says."""
        held = entries(words) or {}
        tool = self.numbered("TOOL", whole(self._source, held.get("TOOL_NO", ())))
        base = self.numbered("BASE", whole(self._source, held.get("BASE_NO", ())))
        on_tool = "#TCP" in shown(self._source, held.get("IPO_FRAME", ())).upper()
        return PointData(tool, base, HOLDS_WORK if on_tool else None)
