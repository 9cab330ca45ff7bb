"""Controllers whose words name a branch and count whole turns, neither of which is followed here.

FANUC (`N U T, 0, 0, 0`), Yaskawa (RCONF) and Staubli name the branch, which is stated by whoever has the
program corrected. Their numbers count whole turns from -180 to 180 degrees; of which joints FANUC's three
are differs between its manuals. As long as no joint passes 180 degrees they stay right, whatever they are
of: joints are therefore always taken within half a turn of the middle of their range, and what passes that
border does not arrive.

Source: FANUC Robotics, SYSTEM R-30iA and R-30iB Handling Tool, Setup and Operations Manual, "Configuration";
Yaskawa, DX200 and YRC1000 Operator's Manual, "Job data format", RCONF; Staubli, VAL3 reference manual,
"config".
"""

from collections.abc import Sequence
from typing import Final

from truepose.domain.arrays import FloatArray
from truepose.domain.robot import JointRange
from truepose.exchange.programs.controllers.rule import Known, within

_OF_RCONF: Final = 3  # wrist, elbow, side; behind them turns


class StatedBranch:
    """The rule of these controllers."""

    def posture(self, words: str) -> str:
        """Return what of the words is no number; of RCONF, which is numbers, the first three."""
        parts = [part.strip() for part in words.split(",")]
        named = [part for part in parts if not part.lstrip("-").isdigit()]
        return ", ".join(named or parts[:_OF_RCONF])

    def taken(
        self, answers: FloatArray, known: Known, limits: Sequence[JointRange] | None
    ) -> FloatArray | None:
        """Return the answer of the branch."""
        return within(answers[known.branch], limits)

    def turned(self, known: Known, own_rad: FloatArray, sent_rad: FloatArray) -> tuple[int, ...]:
        """Return the numbers as they are."""
        return known.turns

    def moves_external(self, external: Sequence[float]) -> bool:
        """Whether the target names external axes: only those that are there are written."""
        return bool(external)
