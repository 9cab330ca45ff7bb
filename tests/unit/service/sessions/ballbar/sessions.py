"""Small plans, and ledgers written by hand, for the tests of the ballbar session."""

import math
from dataclasses import replace

from truepose.domain.ballbar import (
    ArrivalTaken,
    BallbarPlan,
    LengthTaken,
    PlannedAway,
    PlannedPlacement,
    PlannedPose,
    PlannedSetup,
    PoseForecast,
    PreCalibration,
    StepKind,
    Suspicion,
)
from truepose.domain.cell import Artefact, BallbarKit
from truepose.domain.ledger import EntryKind, LedgerEntry
from truepose.domain.robot import FramePlacement
from truepose.domain.session import SessionState
from truepose.sessions.ballbar import step_ids
from truepose.sessions.ballbar.situation import Situation, situation
from truepose.sessions.ballbar.state import READINGS

LEGS = ((1, 1), (1, 2), (2, 1), (2, 2), (2, 3), (3, 1))
SIDE = 300.0
CUPS = ((0.0, 0.0, 0.0), (SIDE, 0.0, 0.0), (SIDE / 2, SIDE * math.sqrt(0.75), 0.0))
FOURTH = (SIDE / 2, SIDE * math.sqrt(0.75) / 3, SIDE * math.sqrt(2 / 3))
KIT = BallbarKit(
    instrument=Artefact("ballbar", "B-7", "C-1", "2027-03-01"), calibrator=Artefact("calibrator", "K-2")
)
KIT_OF_FOUR = replace(KIT, base_points=4)
CUP = "placement-1/cup-1/move"
POSE = "placement-1/pose-1/move"  # with a stop on its way
LEG, NEXT_LEG = "placement-1/pose-1/leg-1-2", "placement-1/pose-1/leg-2-1"


def joints(number: float) -> tuple[float, ...]:
    """Joint angles that tell by their first angle which stop they belong to."""
    return (number / 100.0, 0.2, 0.3, 0.4, 0.5, 0.6)


def make_pose(config: int, placement: int = 1, **changes) -> PlannedPose:
    via = (joints(config + 0.5),)
    return replace(PlannedPose(config, placement, joints(config), LEGS, via_rad=via), **changes)


def make_placement(number: int, configs: tuple[int, ...], n_cups: int = 3) -> PlannedPlacement:
    return PlannedPlacement(
        number,
        FramePlacement(),
        (*CUPS, FOURTH)[:n_cups],
        tuple(PlannedSetup(k, joints(-10 * number - k)) for k in range(1, n_cups + 1)),
        tuple(make_pose(config, number) for config in configs),
        PlannedAway(joints(-10 * number - 5), (joints(-10 * number - 4.5),)),
    )


def make_plan(*configs: tuple[int, ...], n_cups: int = 3, **changes) -> BallbarPlan:
    """One placement for each tuple of configurations."""
    placements = tuple(make_placement(p, c, n_cups) for p, c in enumerate(configs, start=1))
    return replace(BallbarPlan(placements), **changes)


PLAN = make_plan((1, 2), precalibrate_after=1, stable_s=0.2, settle_s=0.1)


def make_sphere_plan(stops: int, **changes) -> BallbarPlan:
    """A sphere test at nest 2."""
    place = make_placement(1, ())
    poses = tuple(make_pose(config, legs=((1, 2),)) for config in range(1, stops + 1))
    placed = replace(place, setups=place.setups[:1], poses=poses)
    return replace(BallbarPlan((placed,), test="sphere"), **changes)


def without_away(plan: BallbarPlan) -> BallbarPlan:
    """The plan as it was stored before the arm backed off the cups."""
    return replace(plan, placements=tuple(replace(place, away=None) for place in plan.placements))


def found(*poses: PlannedPose, exchanged: tuple[int, ...] = (), forecasts: tuple[PoseForecast, ...] = ()):
    return PreCalibration(poses, forecasts, 0.05, 12, exchanged)


def length(length_mm: float = 300.1, initialisation: int = 1) -> LengthTaken:
    return LengthTaken(
        length_mm, 0.1, 0.0, 0.0016, 0.0004, 20, initialisation, False, 22.5, "B-7", "C-1", "2027-03-01", 1.0
    )


class Story:
    """A ledger that a test writes: what a session would have kept."""

    def __init__(self, plan: BallbarPlan, kit: BallbarKit = KIT) -> None:
        self.plan = plan
        self.kit = kit
        self.entries: list[LedgerEntry] = []
        self.control(SessionState.RUNNING)

    @property
    def now(self) -> Situation:
        return situation(self.plan, self.kit, self.entries)

    def add(self, step_id: str, kind: EntryKind, **changes) -> None:
        entry = LedgerEntry(step_id, kind, 10.0 * len(self.entries), "Eva", "one")
        self.entries.append(replace(entry, **changes))

    def control(self, state: SessionState) -> None:
        self.add("", EntryKind.CONTROL, entered=state, text="it was asked for.")

    def show(self) -> str:
        """Show the present step; returns its name."""
        step = self.now.step
        assert step is not None
        self.add(step.id, EntryKind.SHOWN)
        return step.id

    def do(self, pre_calibration: PreCalibration | None = None) -> str:
        """Do the present step as it should be done; returns its name."""
        step_id = self.show()
        kind = step_ids.kind_of(step_id)
        if kind is StepKind.INITIALISE:
            number = self.now.initialisations + 1
            self.add(step_id, EntryKind.MEASURED, length=length(300.0, number))
        elif kind in READINGS:
            self.add(step_id, EntryKind.MEASURED, length=length())
        elif kind is StepKind.PRECALIBRATE:
            self.add(step_id, EntryKind.COMPUTED, precalibration=pre_calibration or found())
        else:
            self.add(step_id, EntryKind.CONFIRMED)
            if kind is StepKind.MOVE:
                self.arrive(step_id)
        return step_id

    def arrive(self, step_id: str) -> None:
        arrival = ArrivalTaken(joints(1), joints(1), (1,) * 6, 1.0)
        self.add(step_id, EntryKind.MOVED, arrival=arrival)

    def until(self, step_id: str) -> "Story":
        """Do everything before this step."""
        while self.now.step is None or self.now.step.id != step_id:
            assert self.now.step is not None, f"{step_id} never comes"
            self.do()
        return self

    def skip(self) -> str:
        step_id = self.show()
        self.add(step_id, EntryKind.SKIPPED, text="out of range")
        return step_id

    def back(self) -> str:
        """Go back; returns the step that was reopened."""
        step_id = self.now.back_to
        assert step_id is not None
        self.add(step_id, EntryKind.REOPENED)
        return step_id

    def suspect(self, suspicion: Suspicion) -> None:
        self.add(self.show(), EntryKind.SUSPECTED, suspicion=suspicion, length=length())

    @property
    def present(self) -> str | None:
        step = self.now.step
        return None if step is None else step.id
