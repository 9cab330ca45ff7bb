"""Whether the ballbar is where it is asked for: on the calibrator, off it, with other bars, let go at all.

These doubts need no model of the robot. They rest on what was connected when a length was last taken, and on
the zeros: those of the same bars differ by how far the magnets' snaps let them walk, those of others by how
much bars are off their nominal length.
"""

from typing import Final

from truepose.domain.cell.artefacts import BallbarKit
from truepose.domain.measurement.ballbar import (
    BallbarStep,
    Leg,
    LengthTaken,
    StepKind,
    Suspicion,
    SuspicionKind,
)
from truepose.sequencing.ballbar.measuring.lengths import bars_of
from truepose.sequencing.ballbar.plan import step_ids
from truepose.sequencing.ballbar.situation import Situation

NO_PAIR: Final[Leg] = (0, 0)  # of the calibrator
# The zero walks by 0.003 mm at most, twice its standard uncertainty (thesis, section 3.5); as much again for
# two readings, and for bars that grow by a degree.
_ZERO_WALK: Final = 4.0  # times the uncertainty of a zero


def calibrator_doubt(
    taken: LengthTaken, now: Situation, step: BallbarStep, kit: BallbarKit, held_for: str | None
) -> Suspicion | None:
    """Return why the ballbar seems to be on the calibrator, or off it, against what is asked for.

    `held_for` is the step whose length this connection gave before; None where it was let go since.
    """
    if step.kind is StepKind.INITIALISE:
        return _doubt_about_zero(taken, now, step, kit, held_for)
    zero = now.zero
    same_length = zero is not None and _agree(taken.deviation_mm, zero.zero_mm, kit)
    if same_length or (held_for and step_ids.kind_of(held_for) is StepKind.INITIALISE):
        return _suspicion("calibrator", step, taken.length_mm)
    return None


def contact_doubt(taken: LengthTaken, step: BallbarStep, held_for: str | None) -> Suspicion | None:
    """Return that the connection is one that is not asked for and was not let go; None where it is new."""
    if held_for is None or held_for == step.id or step.kind is StepKind.INITIALISE:
        return None
    is_leg = step_ids.kind_of(held_for) is StepKind.CONNECT_LEG
    suspected = step_ids.points_of(held_for) if is_leg and step.kind is StepKind.CONNECT_LEG else None
    return _suspicion("same_connection", step, taken.length_mm, suspected)


def _doubt_about_zero(
    taken: LengthTaken, now: Situation, step: BallbarStep, kit: BallbarKit, held_for: str | None
) -> Suspicion | None:
    calibrator_mm, before = bars_of(step, kit).calibrator_mm, now.zero_before
    if before is not None and not _agree(taken.zero_mm, before.zero_mm, kit):
        return _suspicion("not_calibrator", step, calibrator_mm + taken.zero_mm - before.zero_mm)
    if held_for is not None and step_ids.kind_of(held_for) is not StepKind.INITIALISE:
        return _suspicion("not_calibrator", step, calibrator_mm)
    if now.zeroed is not None and before is None and _agree(taken.zero_mm, now.zeroed[1].zero_mm, kit):
        return _suspicion("same_bars", step, calibrator_mm)
    return None


def _agree(one_mm: float, other_mm: float, kit: BallbarKit) -> bool:
    return abs(one_mm - other_mm) <= _ZERO_WALK * kit.zero_u_mm


def _suspicion(
    kind: SuspicionKind, step: BallbarStep, length_mm: float, suspected: Leg | None = None
) -> Suspicion:
    return Suspicion(kind, step.points or NO_PAIR, suspected, length_mm, step.expected_mm)
