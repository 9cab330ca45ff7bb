"""Judges lengths while no pre-calibration foresees them: by nominal arm, plan, and the readings so far.

What it says is a function of plan and situation alone. It keeps the accounts of the last few readings, so
that the next one costs some milliseconds; after a restart, or when something was reopened, they are made
anew.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np

from service.domain.artefacts import BallbarKit
from service.domain.ballbar import BallbarStep, Leg, LengthTaken, StepKind, Suspicion
from service.planning.ballbar.beforehand import Beforehand
from service.sequencing.ballbar import step_ids
from service.sequencing.ballbar.acts import Answer
from service.sequencing.ballbar.situation import Situation
from service.validation.connections_accounts import Accounts, begin
from service.validation.connections_early import alike, judge_early

_KEPT: Final = 16  # accounts: of the present stop, and the one before


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

    def __init__(self, beforehand: Beforehand, kit: BallbarKit) -> None:
        self._beforehand = beforehand
        self._kit = kit
        self._path: list[tuple[tuple[_Line, ...], Accounts]] = []  # the last few, each with all lines so far

    def doubt(self, taken: LengthTaken, now: Situation, step: BallbarStep) -> Suspicion | None:
        """Return why a length does not go with the pair that a step asks for; None where it does."""
        if step.points is None:
            return None
        lines = (*_lines(now, step), _Read(step.points, taken.length_mm, affirmed=False))
        complete = step.kind is StepKind.CONNECT_LEG and len(now.earlier_legs()) + 1 >= now.legs_of_the_pose()
        return judge_early(self._after(lines), taken.length_mm, complete=complete)

    def alike(self, now: Situation) -> tuple[tuple[Leg, Leg], ...]:
        """Return the pairs of legs of the present pose whose exchange would not show; empty elsewhere."""
        step = now.step
        if step is None or step.kind is not StepKind.CONNECT_LEG or now.forecast is not None:
            return ()
        begun = _lines(now, step)
        last = max(place for place, line in enumerate(begun) if isinstance(line, _Stop))
        return alike(self._after(begun[: last + 1]))

    def _after(self, lines: tuple[_Line, ...]) -> Accounts:
        """Return the accounts after these lines, from the longest part of them that is known."""
        self._path = [(known, accounts) for known, accounts in self._path if known == lines[: len(known)]]
        known, accounts = self._path[-1] if self._path else ((), begin(self._beforehand.kinds(), self._kit))
        for end in range(len(known) + 1, len(lines) + 1):
            accounts = self._next(accounts, lines[end - 1])
            self._path.append((lines[:end], accounts))
        self._path = self._path[-_KEPT:]
        return accounts

    def _next(self, accounts: Accounts, line: _Line) -> Accounts:
        if isinstance(line, _Read):
            return accounts.read(line.leg, line.length_mm, affirmed=line.affirmed)
        if line.joints_rad is None:
            return accounts.at(self._beforehand.sides(line.placement))
        return accounts.at(self._beforehand.poses(line.placement, np.array([line.joints_rad]))[0])


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
