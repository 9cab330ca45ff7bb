"""A ballbar campaign without any wire, as a folder with the truth beside it.

The session comes first: tool triangle, then per placement cups, base triangle and legs. The tracker, which
has registered itself on the fixed nests before, reads the cups as they are clamped, and its own campaign
after the session.
"""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from truepose_simulators.cell.environment import CellClock
from truepose_simulators.cell.robot import TargetOutOfRangeError, check_range
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.errors import ScenarioError
from truepose_simulators.physics.identified import IdentifiedModel
from truepose_simulators.physics.rigid import FloatArray
from truepose_simulators.recording.ballbars.plan import BallbarPlan, check_plan
from truepose_simulators.recording.ballbars.readings import BallbarSession, Cups, Legs, Sides
from truepose_simulators.recording.ballbars.tour import (
    BoolArray,
    PlannedLegs,
    Tour,
    aim_balls,
    aim_legs,
    plan_legs,
    plan_tour,
)
from truepose_simulators.recording.campaign import Recording, RegisteredTracker, record_in
from truepose_simulators.recording.files import (
    Columns,
    campaign_document,
    coordinates,
    decimals,
    direction_columns,
    joint_columns,
    points_table,
    reference_table,
    true_table,
    truth_document,
    whole,
    write_json,
    write_table,
    write_tables,
)
from truepose_simulators.recording.plan import RecordingRequest, check_approach
from truepose_simulators.scenarios.scenario import Scenario

_CUP_READINGS = 10  # of each cup: 0.016 mm of one reading become 0.005
_STREAM = 102  # 100 and 101 are the tracker campaign's
_PLACEMENTS_OFF_MM = 50.0  # no robot is off by that much: the plan is of another cell


@dataclass(frozen=True, slots=True)
class BallbarRecordingRequest:
    """What a recorded ballbar campaign should be."""

    aimed: bool = False  # joints corrected as after a pre-calibration; else poses as planned
    aim_error_mm: float = 0.05  # standard deviation by which a pre-calibrated model misses a length
    approach: str = "mixed"
    tracker: RecordingRequest = field(
        default_factory=lambda: RecordingRequest(configurations=50, validation=3000, attachments=1)
    )

    def __post_init__(self) -> None:
        if self.aim_error_mm < 0.0:
            raise ScenarioError(f'"aim_error_mm" must be 0 or more, not {self.aim_error_mm}')
        check_approach(self.approach)


@dataclass(frozen=True, slots=True)
class BallbarRecording:
    """One ballbar campaign, the tracker campaign beside it, and the truth."""

    cell: Cell
    legs: Legs
    out_of_range: Legs  # with the lengths that they would have had
    not_reached: tuple[int, ...]  # configs that the arm could not correct, aimed campaigns only
    sides: Sides
    cups: Cups
    tracker: Recording
    true_validation_mm: FloatArray  # (n, nests, 3) at the validation stops, without noise and scatter
    u_mm: float  # standard uncertainty of a length


def record_ballbar(
    scenario: Scenario,
    seed: int,
    plan: BallbarPlan,
    wishes: BallbarRecordingRequest,
    model: IdentifiedModel | None = None,
) -> BallbarRecording:
    """Record a ballbar campaign of the cell that scenario, seed and perhaps a model give.

    The tracker campaign beside it is that of `campaign.record` at later times, whatever the plan: plans can
    be compared on one robot.

    Raises
    ------
    SimulatorError
        The cell cannot be, the plan does not go with it, or its tracker sees too few configurations.
    """
    cell = Cell(scenario, seed, CellClock(0), model)
    check_plan(plan, cell)
    streams = np.random.SeedSequence(seed, spawn_key=(_STREAM,)).spawn(3)
    person_rng, arm_rng, instrument_rng = (np.random.default_rng(stream) for stream in streams)
    tour = plan_tour(plan, wishes.approach, person_rng)
    recording, tracker = record_in(cell, wishes.tracker, float(tour.end_s[-1]))
    tour = _set_up_anew(cell, plan, tour, wishes, arm_rng) if wishes.aimed else tour
    cups = _clamp_cups(cell, tour, tracker, arm_rng)
    _check_cups(plan, cups)
    legs = plan_legs(plan, tour, scenario.ballbar.nominal_mm)
    tour, reached = _aimed(cell, tour, legs, cups, wishes, arm_rng) if wishes.aimed else (tour, None)
    _check_reach(cell, tour)
    scatter = _drawn(cell, scenario.arm.scatter_mm, (len(tour), 3), arm_rng)
    sides, read = BallbarSession(cell, tour, legs, cups, scatter, instrument_rng).read()
    in_range = np.abs(read.length_mm - scenario.ballbar.nominal_mm) <= scenario.ballbar.range_mm
    kept = np.ones(len(read), dtype=bool) if reached is None else reached
    return BallbarRecording(
        cell=cell,
        legs=read.part(np.flatnonzero(in_range & kept)),
        out_of_range=read.part(np.flatnonzero(~in_range & kept)),
        not_reached=tuple(sorted({int(config) for config in read.config[~kept]})),
        sides=sides,
        cups=cups,
        tracker=recording,
        true_validation_mm=cell.true_positions(recording.validation.stops.conditions(cell)),
        u_mm=scenario.ballbar.stated_u_mm,
    )


def _drawn(cell: Cell, size: float, shape: tuple[int, ...], rng: np.random.Generator) -> FloatArray:
    return (size if cell.scenario.noise else 0.0) * rng.standard_normal(shape)


def _clamp_cups(cell: Cell, tour: Tour, tracker: RegisteredTracker, rng: np.random.Generator) -> Cups:
    """Clamp every cup where the true robot holds the ball in tool nest 1, and have the tracker read it."""
    stops = np.flatnonzero(tour.is_setup)
    times = tour.end_s[stops]
    held = cell.true_positions(tour.conditions(cell, stops, times))[:, 0]
    size_mm = float(np.hypot(cell.scenario.arm.scatter_mm, cell.scenario.ballbar.clamp_mm))
    true = held + _drawn(cell, size_mm, held.shape, rng)
    readings = tracker.read(np.repeat(true, _CUP_READINGS, axis=0), np.repeat(times, _CUP_READINGS))
    return Cups(
        placement=tour.placement[stops],
        base_point=tour.number[stops],
        joints_deg=tour.joints_deg[stops],
        clamped_s=times,
        true_mm=true,
        read_mm=readings.position_mm.reshape(-1, _CUP_READINGS, 3).mean(axis=1),
        u_mm=readings.u_mm[::_CUP_READINGS] / np.sqrt(_CUP_READINGS),
    )


def _check_cups(plan: BallbarPlan, cups: Cups) -> None:
    """Refuse a plan whose set-ups do not lead to the cups that it states."""
    for placement in plan.placements:
        for point, stated in enumerate(placement.cups_mm, start=1):
            mine = (cups.placement == placement.number) & (cups.base_point == point)
            off_mm = float(np.linalg.norm(cups.true_mm[mine] - np.array(stated), axis=1).max(initial=0.0))
            if off_mm > _PLACEMENTS_OFF_MM:
                raise ScenarioError(
                    f"placement {placement.number}: at the joints of set-up {point} the ball is"
                    f" {off_mm:.0f} mm from the planned cup; give joints in deg and cups in the world frame"
                )


def _aimed(
    cell: Cell,
    tour: Tour,
    legs: PlannedLegs,
    cups: Cups,
    wishes: BallbarRecordingRequest,
    rng: np.random.Generator,
) -> tuple[Tour, BoolArray]:
    wanted = legs.aimed_mm + wishes.aim_error_mm * rng.standard_normal(len(legs.aimed_mm))
    joints, reached = aim_legs(cell, tour, legs, cups.true_mm[cups.of_legs(legs, tour)], wanted)
    return tour.at_joints(joints, wishes.approach), reached


def _set_up_anew(
    cell: Cell, plan: BallbarPlan, tour: Tour, wishes: BallbarRecordingRequest, rng: np.random.Generator
) -> Tour:
    """Aim the set-ups of later placements: the legs of the first are what the model learnt from."""
    stated = {
        (placement.number, point): cup
        for placement in plan.placements[1:]
        for point, cup in enumerate(placement.cups_mm, start=1)
    }
    stops = np.array(
        [
            stop
            for stop in np.flatnonzero(tour.is_setup)
            if (int(tour.placement[stop]), int(tour.number[stop])) in stated
        ],
        dtype=int,
    )
    if not len(stops):
        return tour
    wanted = np.array([stated[int(tour.placement[stop]), int(tour.number[stop])] for stop in stops])
    wanted = wanted + wishes.aim_error_mm * rng.standard_normal(wanted.shape)
    return tour.at_joints(aim_balls(cell, tour, stops, wanted), wishes.approach)


def _check_reach(cell: Cell, tour: Tour) -> None:
    for stop in range(len(tour)):
        try:
            check_range(cell.plant.arm, np.radians(tour.joints_deg[stop]))
        except TargetOutOfRangeError as error:
            what = "set-up" if tour.is_setup[stop] else "config"
            raise ScenarioError(
                f"placement {tour.placement[stop]}, {what} {tour.number[stop]}: {error}"
            ) from error


def write_ballbar_campaign(recording: BallbarRecording, folder: Path) -> None:
    """Write the folder, which may exist.

    `campaign.json` describes the legs; `calibration.csv`, the tracker campaign of the same robot, is a
    campaign of its own with `tracker.json` as its description.
    """
    tracker = recording.tracker
    tables = {
        "legs": _legs_table(recording.legs, recording.u_mm),
        "setup": _setup_table(recording.cups),
        "fixture": _fixture_table(recording.sides, recording.u_mm),
        "cups": _cups_table(recording.cups),
        "calibration": points_table(tracker.calibration),
        "validation": points_table(tracker.validation),
        "reference": reference_table(tracker.references),
    }
    files = write_tables(folder, tables)
    write_table(folder / "true_validation.csv", true_table(recording.true_validation_mm))
    write_json(folder / "campaign.json", _ballbar_document(recording, files))
    write_json(folder / "tracker.json", campaign_document(recording.cell, _files_of(_OF_POINTS, files)))
    write_json(folder / "truth.json", _truth(recording))


_OF_LEGS = frozenset({"legs", "setup", "fixture", "cups", "validation"})
_OF_POINTS = frozenset({"calibration", "validation", "reference"})


def _files_of(names: frozenset[str], files: dict[str, str]) -> dict[str, str]:
    return {name: file for name, file in files.items() if name in names}


def _ballbar_document(recording: BallbarRecording, files: dict[str, str]) -> dict[str, Any]:
    setup = recording.cell.scenario.ballbar
    return {
        **campaign_document(recording.cell, _files_of(_OF_LEGS, files)),
        "kind": "ballbar",
        "ballbar_nominal_mm": setup.nominal_mm,
        "ballbar_range_mm": setup.range_mm,
        "setup_u_mm": setup.clamp_mm,
    }


def _truth(recording: BallbarRecording) -> dict[str, Any]:
    cups, missed = recording.cups, recording.out_of_range
    return {
        **truth_document(recording.tracker),
        "cups": [
            {"placement": int(placement), "base_point": int(point), "position_mm": place.tolist()}
            for placement, point, place in zip(cups.placement, cups.base_point, cups.true_mm, strict=True)
        ],
        "true_legs_mm": recording.legs.true_mm.tolist(),
        "out_of_range": [
            {"config": int(config), "leg": [int(base), int(tool)], "length_mm": float(length)}
            for config, base, tool, length in zip(
                missed.config, missed.base_point, missed.tool_point, missed.length_mm, strict=True
            )
        ],
        "not_reached": list(recording.not_reached),
    }


def _legs_table(legs: Legs, u_mm: float) -> Columns:
    return {
        "placement": whole(legs.placement),
        "config": whole(legs.config),
        **joint_columns(legs.joints_deg, 5),
        **direction_columns(legs.direction),
        "time_s": decimals(legs.time_s, 1),
        "temperature_C": decimals(legs.temperature_c, 2),
        "attachment": whole(legs.attachment),
        "init": whole(legs.init),
        "base_point": whole(legs.base_point),
        "tool_point": whole(legs.tool_point),
        "length_mm": decimals(legs.length_mm, 4),
        "u_mm": decimals(np.full(len(legs), u_mm), 5),
    }


def _setup_table(cups: Cups) -> Columns:
    return {
        "placement": whole(cups.placement),
        "base_point": whole(cups.base_point),
        **joint_columns(cups.joints_deg, 5),
    }


def _fixture_table(sides: Sides, u_mm: float) -> Columns:
    return {
        "placement": whole(sides.placement),
        "kind": ["base" if placement else "tool" for placement in sides.placement],
        "point_a": whole(sides.point_a),
        "point_b": whole(sides.point_b),
        "length_mm": decimals(sides.length_mm, 4),
        "u_mm": decimals(np.full(len(sides.length_mm), u_mm), 5),
    }


def _cups_table(cups: Cups) -> Columns:
    return {
        "placement": whole(cups.placement),
        "base_point": whole(cups.base_point),
        **coordinates(cups.read_mm),
        "u_mm": decimals(cups.u_mm, 4),
    }
