"""The clear way of the arm to its next stop, also where stops were left out or are visited again.

Every motion is planned from some other stop: the one listed before it; after a pre-calibration the one
where the arm stood by then; at a new placement the one planned last at the placement before. So the stops
are a tree, and from anywhere the arm follows its branches, forwards or backwards: each of them was found
clear, a shortcut was not.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

from truepose.domain.measurement.ballbar import BallbarPlan, BallbarStep, StepKind

Joints = tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Ways:
    """All planned ways of a session: the motions by name, and where each was planned from."""

    moves: Mapping[str, BallbarStep]
    planned_from: Mapping[str, str | None]

    def between(self, last_stop: str | None, to: str) -> tuple[Joints, ...]:
        """Return the joints [rad] on the way from the stop of one motion to that of another, both left out.

        From a place that no planned way leads to, it is the planned way alone.
        """
        back, forth = self._to_the_root(last_stop), self._to_the_root(to)
        common = next((stop for stop in back if stop in forth), None)
        if common is None:
            return self.moves[to].via_rad
        passed: list[Joints] = []
        for stop, before in pairwise(back[: back.index(common) + 1]):
            passed += [*reversed(self.moves[stop].via_rad), *self._rests_at(before)]
        for stop in reversed(forth[: forth.index(common)]):
            passed += [*self.moves[stop].via_rad, *self._rests_at(stop)]
        return tuple(passed[:-1])

    def _to_the_root(self, stop: str | None) -> list[str]:
        found: list[str] = []
        while stop is not None and stop in self.moves and stop not in found:
            found.append(stop)
            stop = self.planned_from[stop]
        return found

    def _rests_at(self, stop: str) -> tuple[Joints, ...]:
        target_rad = self.moves[stop].target_rad
        return () if target_rad is None else (target_rad,)


def ways(plan: BallbarPlan, agenda: Sequence[BallbarStep], stood_at: Mapping[str, str | None]) -> Ways:
    """Return the ways of a session; `stood_at` says where the arm was at each pre-calibration."""
    moves: dict[str, BallbarStep] = {}
    planned_from: dict[str, str | None] = {}
    here: str | None = None
    for step in agenda:
        if step.kind is StepKind.PRECALIBRATE:
            here = stood_at.get(step.id, here)
        elif step.kind is StepKind.PLACE_BASE:
            here = _last_planned(plan, moves, step.placement)
        elif step.kind is StepKind.MOVE:
            moves[step.id], planned_from[step.id] = step, here
            here = step.id
    return Ways(moves, planned_from)


def _last_planned(plan: BallbarPlan, moves: dict[str, BallbarStep], placement: int | None) -> str | None:
    """Return the last motion to the pose that was planned last before this placement."""
    before = [place for place in plan.placements if placement is not None and place.number < placement]
    config = next((place.poses[-1].config for place in reversed(before) if place.poses), None)
    if config is None:
        return next(reversed(moves), None)
    return next((name for name in reversed(moves) if moves[name].config == config), None)
