"""Controllers whose words name a branch and count whole turns, neither of which is followed here.

FANUC (`N U T, 0, 0, 0`), Yaskawa (RCONF) and Staubli name the branch, which is stated by whoever has the
program corrected. Their numbers count whole turns from -180 to 180 degrees; of which joints FANUC's three
are differs between its manuals, and RCONF does not say to which side. As long as all of them are 0 and no
joint passes 180 degrees they stay right, whatever they are of: joints are therefore always taken within
half a turn of the middle of their range, what passes that border does not arrive, and other numbers than 0
are not followed.

Source: FANUC Robotics, SYSTEM R-30iA and R-30iB Handling Tool, Setup and Operations Manual, "Configuration";
Yaskawa, DX200 and YRC1000 Operator's Manual, "Job data format", RCONF; Staubli, VAL3 reference manual,
"config".
"""

import re
from collections.abc import Sequence
from typing import Final

from truepose.domain.arrays import FloatArray
from truepose.domain.robot import JointRange
from truepose.exchange.programs.controllers.rule import Known, within

_WHOLE: Final = re.compile(r"[-+]?[0-9]+")
_OF_RCONF: Final = 3  # wrist, elbow, side; behind them turns


class StatedBranch:
    """The rule of these controllers."""

    def posture(self, words: str) -> str:
        """Return what of the words is no number; of RCONF, which is numbers, the first three."""
        named, numbers = _parts(words)
        return ", ".join(named or numbers[:_OF_RCONF])

    def taken(
        self, answers: FloatArray, known: Known, limits: Sequence[JointRange] | None
    ) -> FloatArray | None:
        """Return the answer of the branch."""
        return within(answers[known.branch], limits)

    def turned(self, known: Known, own_rad: FloatArray, sent_rad: FloatArray) -> tuple[int, ...]:
        """Return the numbers as they are."""
        return known.turns

    def counts_turns(self, words: str) -> bool:
        """Whether a number that counts turns is not 0."""
        named, numbers = _parts(words)
        return any(int(number) for number in (numbers if named else numbers[_OF_RCONF:]))

    def moves_external(self, external: Sequence[float]) -> bool:
        """Whether the target names external axes: only those that are there are written."""
        return bool(external)


def _parts(words: str) -> tuple[list[str], list[str]]:
    """Return what of the words is no number, and the numbers."""
    parts = [part.strip() for part in words.split(",")]
    named = [part for part in parts if not _WHOLE.fullmatch(part)]
    return named, [part for part in parts if _WHOLE.fullmatch(part)]
