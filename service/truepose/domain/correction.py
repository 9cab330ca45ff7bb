"""What a file of corrected targets came to."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from truepose.domain.arrays import FloatArray, IntArray
from truepose.messages.message import Message, message

# Unknown limits correct nothing away: a target that nobody checked is sent, and a sentence says what was not
# looked at.
CORRECTED: Final = ("ok", "limits_unknown")  # statuses of targets that have joints to be sent


@dataclass(frozen=True, slots=True)
class UncorrectedTarget:
    """What moves the robot, or would be a target, and cannot be corrected by changing numbers.

    `file` is that of the line, if it is another one than the program.
    """

    line: int
    what: str
    reason: Message
    file: str | None = None

    @property
    def place(self) -> Message:
        """Where it stands."""
        return place(self.line, self.file)


def place(line: int, file: str | None = None) -> Message:
    """Return how a sentence names a line of the program, or of another file."""
    if file is None:
        return message("left.line", line=line)
    return message("left.line_of_file", line=line, file=file)


@dataclass(frozen=True, slots=True)
class CorrectionTotals:
    """Counts and extremes of corrected targets."""

    statuses: Mapping[str, int]  # targets by what became of them: `ok`, else why not
    failed: tuple[tuple[str, str], ...]  # name and status of the first that were not corrected
    largest_error_mm: float  # between a target and where the model says that the tool goes
    mean_uncertainty_mm: float  # standard, per axis
    largest_uncertainty_mm: float
    far_moved: int  # corrected ones at which a joint turns far from the controller's own answer
    largest_move_rad: float
    outside: int  # corrected ones outside the measured zone
    farthest_outside_mm: float  # of the flange frame
    farthest_outside_rad: float  # of a joint
    zone_known: bool

    @property
    def targets(self) -> int:
        """How many targets there were."""
        return sum(self.statuses.values())

    @property
    def solved(self) -> int:
        """How many were corrected."""
        return sum(self.statuses.get(status, 0) for status in CORRECTED)


@dataclass(frozen=True, slots=True)
class CorrectedTargets:
    """The targets of a file, n of them, in its order.

    Attributes
    ----------
    names, statuses : tuple of str, length n
    lines : ndarray of int, shape (n,)
        Where they stand, from 1.
    place_mm : ndarray, shape (n, 3)
        Meant for the origin of the flange frame, in the robot's base.
    shift_mm : ndarray, shape (n, 3)
        From there to where the controller believes to go; NaN: not corrected.
    uncertainty_mm : ndarray, shape (n,)
        Standard, per axis, of where the tool really goes.
    outside_mm : ndarray, shape (n,)
        How far outside the measured zone; NaN: nobody said.
    moved_rad : ndarray, shape (n,)
        Largest change of a joint from the controller's own answer.
    """

    names: tuple[str, ...]  # (n,)
    statuses: tuple[str, ...]  # (n,)
    lines: IntArray  # (n,) where they stand, from 1
    place_mm: FloatArray  # (n, 3) meant for the origin of the flange frame, in the robot's base
    shift_mm: FloatArray  # (n, 3) from there to where the controller believes to go; NaN: not corrected
    uncertainty_mm: FloatArray  # (n,) standard, per axis, of where the tool really goes
    outside_mm: FloatArray  # (n,) how far outside the measured zone; NaN: nobody said
    moved_rad: FloatArray  # (n,) largest change of a joint from the controller's own answer


@dataclass(frozen=True, slots=True)
class FileCorrection:
    """What a file came to, beside its targets and its corrected text."""

    totals: CorrectionTotals
    largest_shift_mm: float  # NaN where nothing was corrected
    left_alone: tuple[UncorrectedTarget, ...]  # the first of them
    left_alone_count: int
    cautions: tuple[Message, ...]  # what the predictions do not contain, and what was not understood
