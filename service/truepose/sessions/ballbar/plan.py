"""What a ballbar session does, in order: a pure generator of steps, thesis section 3.5.

The order follows from the plan and from how the poses before ended: nothing else. With nothing known yet
every pose is taken to succeed, which is the listing beforehand.

- Once `precalibrate_after` poses are measured the service identifies with what is there. From then on
  lengths are foreseen and targets aimed: the poses left come in its order, those that had to be skipped
  and those whose legs were exchanged among them, as a further attempt.
- A fixture that is taken up cannot be measured again. So the end of a placement asks for a
  pre-calibration too where poses were skipped, or measured while no length could be foreseen. Poses skipped
  once more get a further one where others were measured meanwhile: it aims better than the last.
- A short plan has its first one early, on few lengths; so it ends with one that tests all of them.

Every motion is planned from some other stop: the one listed before it; after a pre-calibration the one
where the arm stood by then; at a new placement the one planned last at the placement before. So the stops
are a tree, and from anywhere the arm follows its branches, forwards or backwards: each of them was found
clear, a shortcut was not.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise
from typing import Final

from truepose.domain.ballbar import (
    BallbarPlan,
    BallbarStep,
    BarSet,
    PlannedPlacement,
    PlannedPose,
    PoseForecast,
    PreCalibration,
    StepKind,
)
from truepose.domain.cell import BallbarKit
from truepose.sessions.ballbar import step_ids

STOPS_PER_ZERO: Final = 10  # of a sphere test: the zero walks by 0.003 mm at most, the arm errs by far more
MAX_ATTEMPTS: Final = 3  # at one pose: planned, aimed anew, and once more with what was learnt meanwhile


@dataclass(frozen=True, slots=True)
class Course:
    """What of the past shapes what follows; the default is a session that has not begun."""

    skipped: AbstractSet[str] = frozenset()  # groups of the attempts that ended with a skip
    found: Mapping[str, PreCalibration | None] = field(default_factory=dict)  # by step; None: left out


@dataclass(slots=True)
class _Progress:
    """What is counted across placements while the steps are listed."""

    course: Course
    measured: int = 0
    asked: bool = False  # a pre-calibration was due before
    foreseen: bool = False  # there are forecasts by now, or will be by then
    found: PreCalibration | None = None  # the last one


@dataclass(frozen=True, slots=True)
class _Attempt:
    pose: PlannedPose
    number: int


def steps(plan: BallbarPlan, kit: BallbarKit, course: Course | None = None) -> Iterator[BallbarStep]:
    """Yield all steps of a session, those that are done included."""
    if plan.test == "sphere":
        yield from _sphere(plan, kit)
        return
    progress = _Progress(course or Course())
    # The tool's triangle can be measured anywhere, so it comes before anything moves; that of the base stands
    # once its cups are clamped.
    yield from _triangle(step_ids.TOOL, kit, "tool", None)
    for placement in plan.placements:
        yield from _opening(placement)
        yield from _triangle(step_ids.placement(placement.number), kit, "base", placement.number)
        yield from _Poses(plan, kit, placement, progress).steps()


def _sphere(plan: BallbarPlan, kit: BallbarKit) -> Iterator[BallbarStep]:
    """Yield the steps of a sphere test: nothing but cup 1 is known of its fixture, nor need it be."""
    for placement in plan.placements:
        yield from _opening(placement)
        for number, pose in enumerate(placement.poses):
            group = step_ids.pose(step_ids.placement(placement.number), pose.config, 1)
            for step in pose_steps(group, 1, pose, kit, None):
                if step.kind is not StepKind.INITIALISE or number % STOPS_PER_ZERO == 0:
                    yield step


def sides(n_points: int) -> tuple[tuple[int, int], ...]:
    """Return the pairs between which a fixture of three or four points is measured, in order."""
    triangle = ((1, 2), (2, 3), (1, 3))
    return triangle if n_points == 3 else (*triangle, (1, 4), (2, 4), (3, 4))


def _triangle(group: str, kit: BallbarKit, artefact: BarSet, place: int | None) -> Iterator[BallbarStep]:
    bars, n_points = (kit.tool_bars, 3) if artefact == "tool" else (kit.base_bars, kit.base_points)
    reading = partial(BallbarStep, placement=place, artefact=artefact)
    yield reading(step_ids.initialise(group), StepKind.INITIALISE, expected_mm=bars.calibrator_mm)
    for points in sides(n_points):
        side = step_ids.side(group, points)
        yield reading(side, StepKind.MEASURE_SIDE, points=points, expected_mm=bars.nominal_mm)
    yield BallbarStep(step_ids.detach(group), StepKind.DETACH, place)


def _opening(placement: PlannedPlacement) -> Iterator[BallbarStep]:
    number = placement.number
    place = step_ids.placement(number)
    step = partial(BallbarStep, placement=number)
    yield step(f"{place}/place", StepKind.PLACE_BASE)
    yield step(step_ids.ball(place), StepKind.FIT_BALL)
    for setup in placement.setups:
        group = step_ids.cup(place, setup.base_point)
        of_cup = partial(step, base_point=setup.base_point)
        yield of_cup(step_ids.move(group), StepKind.MOVE, target_rad=setup.joints_rad, via_rad=setup.via_rad)
        yield of_cup(f"{group}/clamp", StepKind.CLAMP_CUP)
    # Plans that were stored before there was such a motion have none (decision 0016).
    if placement.away is not None:
        move, away = step_ids.move(step_ids.away(place)), placement.away
        yield step(move, StepKind.MOVE, target_rad=away.joints_rad, via_rad=away.via_rad)
    yield step(f"{place}/ball-out", StepKind.REMOVE_BALL)


class _Poses:
    """Lists the poses of one placement with the pre-calibrations between them."""

    def __init__(
        self, plan: BallbarPlan, kit: BallbarKit, placement: PlannedPlacement, progress: _Progress
    ) -> None:
        self._plan = plan
        self._kit = kit
        self._place = step_ids.placement(placement.number)
        self._number = placement.number
        self._progress = progress
        self._planned = {pose.config: pose for pose in placement.poses}
        # A pre-calibration at an earlier placement aims these poses already.
        self._due = self._aimed([_Attempt(pose, 1) for pose in placement.poses])
        self._skipped: list[_Attempt] = []
        self._attempts: dict[int, int] = {}  # configuration -> number of its last attempt
        self._untested = False  # something was measured here of which no length had been foreseen
        self._learnt = False  # a pose was measured since the last pre-calibration
        self._precalibrations = 0

    def steps(self) -> Iterator[BallbarStep]:
        while True:
            while self._due and not self._threshold_reached():
                yield from self._attempt(self._due.pop(0))
            if not self._precalibration_is_worth_it():
                return
            yield from self._precalibrate()

    def _threshold_reached(self) -> bool:
        progress = self._progress
        return not progress.asked and progress.measured >= self._plan.precalibrate_after

    def _precalibration_is_worth_it(self) -> bool:
        if self._threshold_reached():
            return True
        # Nothing to identify with.
        if self._progress.measured == 0:
            return False
        if self._learnt and self._plan.check_at_end and self._number == self._plan.placements[-1].number:
            return True
        # A pose that was skipped with its planned target may succeed with an aimed one. Aimed once, it is
        # worth another try only where something was learnt since.
        never_aimed = any(attempt.number == 1 for attempt in self._skipped)
        return self._untested or never_aimed or (bool(self._skipped) and self._learnt)

    def _attempt(self, attempt: _Attempt) -> Iterator[BallbarStep]:
        pose, progress = attempt.pose, self._progress
        group = step_ids.pose(self._place, pose.config, attempt.number)
        self._attempts[pose.config] = attempt.number
        yield from pose_steps(group, attempt.number, pose, self._kit, progress.found)
        if group not in progress.course.skipped:
            progress.measured += 1
            self._untested |= not progress.foreseen
            self._learnt = True
        elif attempt.number < MAX_ATTEMPTS:
            self._skipped.append(attempt)

    def _precalibrate(self) -> Iterator[BallbarStep]:
        progress = self._progress
        self._precalibrations += 1
        progress.asked = True
        step_id = f"{self._place}/precalibrate-{self._precalibrations}"
        yield BallbarStep(step_id, StepKind.PRECALIBRATE, self._number)
        found = progress.course.found.get(step_id)
        # One that has not taken place yet is taken to succeed: the listing beforehand assumes that of every
        # step.
        progress.foreseen |= found is not None or step_id not in progress.course.found
        self._untested = self._learnt = False
        if found is not None:
            progress.found = found
            self._due = self._aimed([*self._due, *self._again(found)])
        self._skipped = []

    def _again(self, found: PreCalibration) -> Iterable[_Attempt]:
        """Return further attempts at skipped and at exchanged poses, as often as allowed."""
        for attempt in self._skipped:
            yield _Attempt(attempt.pose, attempt.number + 1)
        skipped = {attempt.pose.config for attempt in self._skipped}
        for config in found.exchanged:
            # A pose of an earlier placement has no attempt here, and gets none: its fixture was taken up.
            number = self._attempts.get(config, MAX_ATTEMPTS) + 1
            if config not in skipped and number <= MAX_ATTEMPTS:
                yield _Attempt(self._planned[config], number)

    def _aimed(self, attempts: list[_Attempt]) -> list[_Attempt]:
        """Return the attempts in the order, and with the targets, of the last pre-calibration."""
        found = self._progress.found
        if found is None:
            return attempts
        poses = {pose.config: (order, pose) for order, pose in enumerate(found.poses)}
        last = len(poses)
        ranked = sorted(attempts, key=lambda a: poses.get(a.pose.config, (last, a.pose))[0])
        return [_Attempt(poses.get(a.pose.config, (last, a.pose))[1], a.number) for a in ranked]


def pose_steps(
    group: str, attempt: int, pose: PlannedPose, kit: BallbarKit, found: PreCalibration | None
) -> Iterator[BallbarStep]:
    """Yield the steps of one attempt at one pose."""
    step = partial(BallbarStep, placement=pose.placement, config=pose.config, attempt=attempt)
    yield step(step_ids.move(group), StepKind.MOVE, target_rad=pose.joints_rad, via_rad=pose.via_rad)
    calibrator_mm = kit.base_bars.calibrator_mm
    yield step(step_ids.initialise(group), StepKind.INITIALISE, artefact="base", expected_mm=calibrator_mm)
    for leg, expected_mm in zip(pose.legs, _expected(pose, kit, found), strict=True):
        yield step(step_ids.leg(group, leg), StepKind.CONNECT_LEG, points=leg, expected_mm=expected_mm)
    yield step(step_ids.detach(group), StepKind.DETACH)


def _expected(pose: PlannedPose, kit: BallbarKit, found: PreCalibration | None) -> list[float]:
    """Return the length of each leg [mm]: foreseen, else as it was coded, else nominal."""
    forecast = forecast_of(found, pose.config)
    foreseen = dict(zip(forecast.legs, forecast.length_mm, strict=True)) if forecast else {}
    coded = pose.aimed_mm or (kit.base_bars.nominal_mm,) * len(pose.legs)
    return [foreseen.get(leg, length) for leg, length in zip(pose.legs, coded, strict=True)]


def forecast_of(found: PreCalibration | None, config: int | None) -> PoseForecast | None:
    """Return what a pre-calibration foresees of a configuration; None where there is none."""
    forecasts = found.forecasts if found else ()
    return next((forecast for forecast in forecasts if forecast.config == config), None)


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
        # The two branches meet where one of them comes to a place of the other.
        common = next((stop for stop in back if stop in forth), None)
        if common is None:
            return self.moves[to].via_rad
        passed: list[Joints] = []
        for stop, before in pairwise(back[: back.index(common) + 1]):
            passed += [*reversed(self.moves[stop].via_rad), *self._rests_at(before)]
        for stop in reversed(forth[: forth.index(common)]):
            passed += [*self.moves[stop].via_rad, *self._rests_at(stop)]
        # Without the end itself, which is the target of the step.
        return tuple(passed[:-1])

    def course(self, last_stop: str | None, to: str) -> tuple[Joints, ...]:
        """Return the joints [rad] on the way from the stop of one motion to that of another, with both ends.

        Without its begin where no planned way leads from there.
        """
        way = (*self.between(last_stop, to), *self._rests_at(to))
        is_planned = not set(self._to_the_root(last_stop)).isdisjoint(self._to_the_root(to))
        return (*self._rests_at(last_stop), *way) if last_stop is not None and is_planned else way

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
        # The way to the next pose was planned from where the arm stood then, not from the pose that is listed
        # before it.
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
