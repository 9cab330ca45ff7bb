"""Judges lengths while no pre-calibration foresees them: by nominal arm, plan, and the readings so far.

What it says is a function of plan and situation alone. It keeps the accounts of the last few readings, so
that the next one costs some milliseconds; after a restart, or when something was reopened, they are made
anew.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np

from truepose.domain.ballbar import (
    BallbarStep,
    Leg,
    LengthTaken,
    PoseForecast,
    StepKind,
    Suspicion,
)
from truepose.domain.cell import BallbarKit
from truepose.planning.ballbar.length_forecast import SessionForecast
from truepose.sessions.ballbar import step_ids
from truepose.sessions.ballbar.situation import Situation
from truepose.sessions.ballbar.state import Answer
from truepose.validation.early_connection_check import Accounts, alike, begin, indistinct, judge_early

_KEPT: Final = 8  # accounts: of the present stop; each takes some megabytes


@dataclass(frozen=True, slots=True)
class _Stop:
    """A stop, or the triangle of the base."""

    group: str
    placement: int
    joints_rad: tuple[float, ...] | None  # None: the sides of the base triangle


@dataclass(frozen=True, slots=True)
class _Read:
    """One kept reading at the stop before it."""

    leg: Leg
    length_mm: float
    affirmed: bool


_Line: TypeAlias = _Stop | _Read


class EarlyJudge:
    """What the readings of one session make of the next, and of swaps that could not be seen in it."""

    def __init__(self, beforehand: SessionForecast, kit: BallbarKit) -> None:
        self._beforehand = beforehand
        self._kit = kit
        # A length costs one step of the filters where the accounts before it are kept, and all of them anew
        # where they are not: a person waits at the button meanwhile (decision 0025).
        self._path: list[tuple[tuple[_Line, ...], Accounts]] = []  # the last few, each with all lines so far
        self._alike: tuple[tuple[_Line, ...], tuple[tuple[Leg, Leg], ...]] | None = (
            None  # what was found last
        )

    def doubt(self, taken: LengthTaken, now: Situation, step: BallbarStep) -> Suspicion | None:
        """Return why a length does not go with the pair that a step asks for; None where it does."""
        if step.points is None:
            return None
        lines = (*_lines(now, step), _Read(step.points, taken.length_mm, affirmed=False))
        complete = step.kind is StepKind.CONNECT_LEG and len(now.earlier_legs()) + 1 >= now.legs_of_the_pose()
        return judge_early(self._after(lines), complete=complete)

    def alike(self, now: Situation) -> tuple[tuple[Leg, Leg], ...]:
        """Return the pairs of legs of the present pose whose exchange would not show; empty elsewhere."""
        step = now.step
        if step is None or step.kind is not StepKind.CONNECT_LEG:
            return ()
        if now.forecast is not None:
            return _alike_foreseen(now.forecast, step_ids.group_of(step.id), now, self._kit)
        begun = _lines(now, step)
        # Up to the arrival at this pose, without its readings: whether two legs can be told apart is asked of
        # the pose, and the answer must not change while they are read.
        last = max(place for place, line in enumerate(begun) if isinstance(line, _Stop))
        begun = begun[: last + 1]
        if self._alike is None or self._alike[0] != begun:
            self._alike = begun, alike(self._after(begun))
        return self._alike[1]

    def _after(self, lines: tuple[_Line, ...]) -> Accounts:
        """Return the accounts after these lines, from the longest part of them that is known."""
        # What was reopened is no part of any course any more.
        self._path = [step for step in self._path if _is_on_one_way(step[0], lines)]
        before = [step for step in self._path if len(step[0]) <= len(lines)]
        known, accounts = before[-1] if before else ((), begin(self._beforehand.kinds(), self._kit))
        for end in range(len(known) + 1, len(lines) + 1):
            accounts = self._next(accounts, lines[end - 1])
            self._path.append((lines[:end], accounts))
        self._path = sorted(self._path, key=lambda step: len(step[0]))[-_KEPT:]
        return accounts

    def _next(self, accounts: Accounts, line: _Line) -> Accounts:
        if isinstance(line, _Read):
            return accounts.read(line.leg, line.length_mm, affirmed=line.affirmed)
        if line.joints_rad is None:
            return accounts.at(self._beforehand.sides(line.placement))
        return accounts.at(self._beforehand.poses(line.placement, np.array([line.joints_rad]))[0])


def _is_on_one_way(one: tuple[_Line, ...], other: tuple[_Line, ...]) -> bool:
    """Whether one of two courses goes on where the other ends."""
    return one[: len(other)] == other[: len(one)]


def _alike_foreseen(
    forecast: PoseForecast, group: str, now: Situation, kit: BallbarKit
) -> tuple[tuple[Leg, Leg], ...]:
    legs = {
        step.points
        for step in now.steps
        if step.kind is StepKind.CONNECT_LEG and step_ids.group_of(step.id) == group
    }
    rows = [row for row, leg in enumerate(forecast.legs) if leg in legs]
    covariance = np.array(forecast.covariance_mm2)[np.ix_(rows, rows)]
    noise = kit.reading_u_mm**2 + kit.zero_u_mm**2
    close = indistinct(np.array(forecast.length_mm)[rows], covariance, noise)
    return tuple((forecast.legs[rows[a]], forecast.legs[rows[b]]) for a, b in close)


def _lines(now: Situation, step: BallbarStep) -> tuple[_Line, ...]:
    """Return stops and kept readings up to the group of a step, but for the step itself."""
    own = step_ids.group_of(step.id)
    groups: dict[str, list[BallbarStep]] = {}
    for listed in now.steps:
        is_side = listed.kind is StepKind.MEASURE_SIDE and listed.artefact == "base"
        if is_side or listed.kind is StepKind.CONNECT_LEG:
            groups.setdefault(step_ids.group_of(listed.id), []).append(listed)
    targets = {listed.id: listed.target_rad for listed in now.steps if listed.kind is StepKind.MOVE}
    found: list[_Line] = []
    for group, members in groups.items():
        kept = [*_kept(now, members, step)]
        if kept or group == own:
            found += [_Stop(group, members[0].placement or 0, targets.get(step_ids.move(group))), *kept]
        if group == own:
            break
    return tuple(found)


def _kept(now: Situation, members: list[BallbarStep], besides: BallbarStep) -> Iterator[_Read]:
    for member in members:
        outcome = now.outcomes[member.id]
        if member.id != besides.id and member.points is not None and outcome.length is not None:
            affirmed = outcome.text == Answer.RIGHT_PAIR
            yield _Read(member.points, outcome.length.length_mm, affirmed)
