"""The one sentence that pages of a plant begin with: robots within their limits, or what is missing.

A validation judges the robot until a model is made after it. Of a plant cells are counted: each by the robot
that was measured there last, the worst of several; a cell in which no robot is known is not validated.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import Final

from truepose.domain.validation import Verdict
from truepose.messages.message import Message, Value, message
from truepose.plant.calibration_due import times_allowed, validation_of_newest_model
from truepose.storage.plant.overview import NewestTold, ResultFacts, RobotMeasured
from truepose.storage.plant.result_projections import ToldKind
from truepose.storage.results.items import FAILED, PASSED, UNDECIDED
from truepose.validation.outcome import (
    NO_LIMIT,
    NOT_VALIDATED,
    Quantity,
    before_and_after,
    held_against,
    largest_judged,
)


class Conformity(IntEnum):
    """How a robot stands against its limit, the worst first."""

    FAILED = 0
    UNDECIDED = 1
    NOT_VALIDATED = 2
    NO_LIMIT = 3
    WITHIN = 4


_JUDGED: Final[Mapping[str, tuple[Conformity, Verdict]]] = {
    PASSED: (Conformity.WITHIN, "conforms"),
    FAILED: (Conformity.FAILED, "does not conform"),
    UNDECIDED: (Conformity.UNDECIDED, "cannot be decided"),
}
_COUNTED: Final = {
    Conformity.UNDECIDED: "outcome.plant.undecided",
    Conformity.NO_LIMIT: "outcome.plant.no_limit",
    Conformity.NOT_VALIDATED: "outcome.plant.unvalidated",
}


def conformity(told: Mapping[ToldKind, ResultFacts]) -> Conformity:
    """Return how a robot stands by what its results tell."""
    found = validation_of_newest_model(told)
    if found is None:
        return Conformity.NOT_VALIDATED
    return _JUDGED[found.verdict][0] if found.verdict in _JUDGED else Conformity.NO_LIMIT


@dataclass(frozen=True, slots=True)
class _CellStanding:
    """A cell as its robot stands."""

    cell: str
    robot: str  # serial number; empty: none is known there
    how: Conformity
    validation: ResultFacts | None = None

    @property
    def rank(self) -> tuple[Conformity, float]:
        """What cells and their robots are ordered by, the worst first."""
        beyond = 0.0 if self.validation is None else times_allowed(self.validation)
        return self.how, -beyond


def plant_outcome(cells: Iterable[str], robots: Iterable[RobotMeasured], told: NewestTold) -> Message:
    """Return how many cells have a robot within its limit, which is worst, and what is missing for the rest.

    Parameters
    ----------
    cells : iterable of str
        All that belong to the plant.
    robots : iterable of RobotMeasured
        Those of other cells, and of none, are not counted.
    told : mapping
        What the newest results of each robot tell.
    """
    standing = {cell: _CellStanding(cell, "", Conformity.NOT_VALIDATED) for cell in cells}
    for robot in robots:
        results = told.get(robot.serial_number, {})
        found = validation_of_newest_model(results)
        one = _CellStanding(robot.cell, robot.serial_number, conformity(results), found)
        known = standing.get(robot.cell)
        if known is not None and (not known.robot or one.rank < known.rank):
            standing[robot.cell] = one
    if not standing:
        return message("outcome.plant.no_cells")
    return message("outcome.plant", counts=tuple(_counts(standing)), judged=_judged(standing))


def _counts(standing: Mapping[str, _CellStanding]) -> Iterator[Message]:
    counted = Counter(one.how for one in standing.values())
    yield message("outcome.plant.within", count=counted[Conformity.WITHIN], cells=len(standing))
    if counted[Conformity.FAILED]:
        yield _failed(counted[Conformity.FAILED], min(standing.values(), key=lambda one: one.rank))
    yield from (message(key, count=counted[how]) for how, key in _COUNTED.items() if counted[how])


def _failed(count: int, worst: _CellStanding) -> Message:
    of: dict[str, Value] = {"count": count, "robot": worst.robot, "cell": worst.cell}
    found = worst.validation
    if found is None or found.figure_mm is None or found.limit_mm is None:
        return message("outcome.plant.failed.endless", **of)
    return message("outcome.plant.failed", **of, largest_mm=found.figure_mm, limit_mm=found.limit_mm)


def _judged(standing: Mapping[str, _CellStanding]) -> Message:
    worst = min(one.how for one in standing.values())
    if worst is Conformity.FAILED:
        return message("outcome.fails")
    return message("outcome.passes" if worst is Conformity.WITHIN else "outcome.plant.missing")


def robot_outcome(told: Mapping[ToldKind, ResultFacts]) -> Message:
    """Return what a robot came to: by its validation where that stands, else by what was found last."""
    validation = validation_of_newest_model(told)
    if validation is not None:
        return _validated(validation)
    known = [told[kind] for kind in _FOUND if kind in told and told[kind].figure_mm is not None]
    if not known:
        return message("outcome.unmeasured")
    newest = max(known, key=lambda one: (one.measured_on, one.id))
    return _of(newest, newest.figure_mm, NOT_VALIDATED)


_FOUND: Final[tuple[ToldKind, ...]] = ("identification", "diagnosis")


def _validated(found: ResultFacts) -> Message:
    if found.verdict not in _JUDGED or found.limit_mm is None:
        return _of(found, found.document.get("after_mm", found.figure_mm), NO_LIMIT)
    judged = held_against(found.limit_mm, _JUDGED[found.verdict][1])
    if found.figure_mm is not None:
        judged = largest_judged(found.figure_mm, judged)
    after_mm = found.document.get("after_mm")
    # Of an error without a finite mean, and of what was collected before means were kept beside the largest.
    return message("outcome.judged", judged=judged) if after_mm is None else _of(found, after_mm, judged)


def _of(found: ResultFacts, after_mm: float | None, judged: Message) -> Message:
    if after_mm is None:
        return message("outcome.no_model")
    quantity: Quantity = "length" if found.document.get("quantity") == "length" else "position"
    return before_and_after(found.document.get("before_mm"), after_mm, judged, quantity)
