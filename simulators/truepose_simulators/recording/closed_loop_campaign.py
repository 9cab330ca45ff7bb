"""A closed loop without any wire: what a probe, gauges, wires or a sensor read, and the truth beside it."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from truepose_simulators.cell.environment import CellClock
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.errors import ScenarioError
from truepose_simulators.instruments.truth_endpoint import plant_document
from truepose_simulators.physics.contacts import BallAtSensor, Contact, Plane, PlaneAtSensor, Sphere
from truepose_simulators.physics.effects import Conditions
from truepose_simulators.physics.effects.ports import NestNumbers
from truepose_simulators.physics.rigid import FloatArray, motion, rotation
from truepose_simulators.recording.campaign import Points, record_in
from truepose_simulators.recording.closed_loops import (
    LOOPS,
    Loop,
    LoopConfigurations,
    PlacedObject,
    axes_of,
    plan_stands,
)
from truepose_simulators.recording.files import (
    Columns,
    campaign_document,
    decimals,
    direction_columns,
    joint_columns,
    points_table,
    true_table,
    whole,
    write_json,
    write_table,
    write_tables,
)
from truepose_simulators.recording.plan import RecordingRequest, check_approach, directions
from truepose_simulators.recording.rows import Rows
from truepose_simulators.scenarios.scenario import Scenario

_STREAM = 103  # 100 to 102 are the tracker's and the ballbar's campaigns
_STOP_S = 20.0
_OFF_MM, _OFF_RAD = 3.0, 5e-3  # by which things stand off their drawing
_SENSOR_RAD = 0.02  # by which a sensor sits askew in its tool
_TOUCH_STEPS = 10
_TOUCH_RAD = 1e-5  # of the numerical derivative


@dataclass(frozen=True, slots=True)
class LoopRecordingRequest:
    """What a recorded closed loop should be."""

    kind: str = "two-spheres"
    configurations: int = 80
    validation: int = 40  # further stops whose contacts judge
    approach: str = "from_below"
    tracker: RecordingRequest = field(
        default_factory=lambda: RecordingRequest(
            configurations=1, validation=300, attachments=1, reference_every=0
        )
    )

    def __post_init__(self) -> None:
        if self.kind not in LOOPS:
            raise ScenarioError(f'unknown closed loop "{self.kind}"; known: {", ".join(LOOPS)}')
        check_approach(self.approach)


@dataclass(frozen=True, slots=True)
class Contacts(Rows):
    """n readings, one axis each."""

    config: NestNumbers  # (n,)
    joints_deg: FloatArray  # (n, J)
    direction: FloatArray  # (n, J)
    time_s: FloatArray  # (n,)
    temperature_c: FloatArray  # (n,)
    target: NestNumbers  # (n,) 1-based
    nest: NestNumbers  # (n,) 1-based
    axis: NestNumbers  # (n,) 0 to 2 of a sensor, -1
    reading_mm: FloatArray  # (n,)


@dataclass(frozen=True, slots=True)
class LoopRecording:
    """One closed loop, and points of the same arm that a tracker read afterwards."""

    cell: Cell
    loop: Loop
    calibration: Contacts
    validation: Contacts
    distance_mm: float | None  # certified, of the first two
    points: Points
    true_points_mm: FloatArray  # (n, nests, 3) at the points, without noise and scatter


def record_loop(
    scenario: Scenario, seed: int, wishes: LoopRecordingRequest, planned: LoopConfigurations | None = None
) -> LoopRecording:
    """Record a closed loop in the cell that scenario and seed give.

    Where stops are planned they come before those that judge, instead of drawn ones.

    Raises
    ------
    SimulatorError
        The cell cannot be, or its arm does not reach what it should meet.
    """
    cell, loop = Cell(scenario, seed, CellClock(0)), LOOPS[wishes.kind]
    streams = np.random.SeedSequence(seed, spawn_key=(_STREAM,)).spawn(3)
    plan_rng, setup_rng, noise_rng = (np.random.default_rng(stream) for stream in streams)
    met = _set_up(cell, loop, setup_rng)
    n = wishes.configurations if planned is None else len(planned.nest)
    stands = plan_stands(cell, loop, n + wishes.validation, plan_rng)
    if planned is not None:
        judging = stands.part(slice(len(stands) - wishes.validation, None))
        stands = LoopConfigurations.joined([planned, judging])
    contacts = _read(cell, loop, met, stands, wishes.approach, noise_rng)
    first = contacts.config <= n
    points = record_in(cell, wishes.tracker, float(contacts.time_s[-1]))[0].validation
    return LoopRecording(
        cell=cell,
        loop=loop,
        calibration=contacts.part(np.flatnonzero(first)),
        validation=contacts.part(np.flatnonzero(~first)),
        distance_mm=_certified_mm(cell, loop, met, noise_rng),
        points=points,
        true_points_mm=cell.true_positions(points.stops.conditions(cell)),
    )


def _drawn(cell: Cell, shape: int | tuple[int, ...], rng: np.random.Generator) -> FloatArray:
    return (1.0 if cell.scenario.noise else 0.0) * rng.standard_normal(shape)


def _set_up(cell: Cell, loop: Loop, rng: np.random.Generator) -> list[Contact]:
    """Put everything where it truly stands."""
    sensor = rotation(_SENSOR_RAD * rng.standard_normal(3))
    return [_standing(placed, loop, sensor, cell, rng) for placed in loop.placed]


def _standing(
    placed: PlacedObject, loop: Loop, sensor: FloatArray, cell: Cell, rng: np.random.Generator
) -> Contact:
    place = np.array(placed.place_mm) + _OFF_MM * rng.uniform(-1.0, 1.0, 3)
    askew = rotation(_OFF_RAD * rng.uniform(-1.0, 1.0, 3))
    zero_mm = (placed.zero_mm or float(rng.uniform(0.0, 50.0))) + loop.u_zero_mm * float(
        _drawn(cell, 1, rng)[0]
    )
    if placed.kind == "ball":
        return BallAtSensor(place, sensor)
    if placed.kind in ("sphere", "wire"):
        return Sphere(place, zero_mm)
    frame = motion(place, askew @ axes_of(placed))
    return PlaneAtSensor(frame, sensor) if placed.kind == "face" else Plane(frame)


def _read(
    cell: Cell,
    loop: Loop,
    met: list[Contact],
    stands: LoopConfigurations,
    approach: str,
    rng: np.random.Generator,
) -> Contacts:
    """Visit the stops, one after the other, and read."""
    n = len(stands.nest)
    time_s = np.cumsum(_STOP_S * rng.uniform(0.8, 1.2, n)).round(1)
    direction = directions(stands.joints_deg, approach)
    scatter = cell.scenario.arm.scatter_mm * _drawn(cell, (n, 3), rng)
    stops = _Stops(cell, loop, met, stands, direction, time_s)
    noise = np.hypot(loop.u_mm, loop.form_mm) * _drawn(cell, (n, 3, 3), rng)
    if loop.touches:
        # What the arm and the probe are off by then shows in where the probe triggers.
        wanted = -stops.seen_scatter(stands.joints_deg, scatter) - noise[:, 0, :1]
        joints = stops.touched(wanted)
        return stops.contacts(joints, np.zeros((n, 1, 1)))
    true = stops.read(stands.joints_deg, scatter)
    return stops.contacts(stands.joints_deg, true + noise[:, : true.shape[1], : true.shape[2]])


@dataclass(frozen=True, slots=True)
class _Stops:
    """n stops at which k things are met (1, or all), each reading c components."""

    cell: Cell
    loop: Loop
    met: list[Contact]
    stands: LoopConfigurations
    direction: FloatArray
    time_s: FloatArray

    def conditions(self, joints_deg: FloatArray) -> Conditions:
        """Return the circumstances of the stops at these joints."""
        return self.cell.conditions(
            np.radians(joints_deg), self.direction, self.time_s, np.ones(len(self.time_s))
        )

    def read(self, joints_deg: FloatArray, shift_mm: FloatArray | float = 0.0) -> FloatArray:
        """Return true readings, shape (n, k, c), the tool shifted in the world by the arm's scatter."""
        conditions = self.conditions(joints_deg)
        frame = self.cell.rest(conditions).bodies.last_frame.copy()
        frame[:, :3, 3] += shift_mm
        rows = np.arange(len(frame))
        nests = np.broadcast_to(
            self.cell.true_nests_mm(conditions), (len(frame), len(self.cell.tool_nests_mm), 3)
        )[rows, self.stands.nest - 1]
        every = np.stack([one.read_mm(frame, nests) for one in self.met], axis=1)
        return every if self.loop.together else every[rows, self.stands.placed][:, np.newaxis]

    def seen_scatter(self, joints_deg: FloatArray, scatter_mm: FloatArray) -> FloatArray:
        """Return by how much the scatter of the arm changes the one reading of each stop, shape (n, 1)."""
        seen: FloatArray = (self.read(joints_deg, scatter_mm) - self.read(joints_deg))[:, 0]
        return seen

    def touched(self, wanted_mm: FloatArray) -> FloatArray:
        """Return the joints [deg] at which true readings are `wanted_mm`, reached by least motion."""
        joints = self.stands.joints_deg.copy()
        step = np.degrees(_TOUCH_RAD)
        for _ in range(_TOUCH_STEPS):
            here = self.read(joints)[:, 0, 0]
            # A stop has one reading h and slopes g of it by the joints: the least motion that changes h by m
            # is m g / (g . g). Repeated, since h is curved.
            slopes = np.stack(
                [(self.read(joints + step * one)[:, 0, 0] - here) / step for one in np.eye(joints.shape[1])],
                axis=1,
            )
            missing = (wanted_mm[:, 0] - here) / (slopes**2).sum(axis=1)
            joints = joints + missing[:, np.newaxis] * slopes
        return joints

    def contacts(self, joints_deg: FloatArray, reading_mm: FloatArray) -> Contacts:
        """Return readings (n, k, c) one by one."""
        n, k, c = reading_mm.shape
        stop, number, axis = (a.ravel() for a in np.indices((n, k, c)))
        air = self.conditions(joints_deg).temperature_c
        return Contacts(
            config=stop + 1,
            joints_deg=joints_deg[stop],
            direction=self.direction[stop],
            time_s=self.time_s[stop],
            temperature_c=air[stop],
            target=1 + (number if self.loop.together else self.stands.placed[stop]),
            nest=self.stands.nest[stop],
            axis=axis if c > 1 else np.full(len(stop), 2 if isinstance(self.met[0], PlaneAtSensor) else -1),
            reading_mm=reading_mm.ravel(),
        )


def _certified_mm(cell: Cell, loop: Loop, met: list[Contact], rng: np.random.Generator) -> float | None:
    """Return the distance of the first two centres as a certificate states it."""
    if loop.u_distance_mm is None:
        return None
    first, second = (one.centre_mm for one in met[:2] if isinstance(one, Sphere | BallAtSensor))
    true_mm = float(np.linalg.norm(second - first))
    return true_mm + loop.u_distance_mm * float(_drawn(cell, 1, rng)[0])


def write_loop(recording: LoopRecording, folder: Path) -> None:
    """Write the folder, which may exist."""
    tables = {
        "contacts": _contacts_table(recording.calibration, recording.loop.u_mm),
        "validation_contacts": _contacts_table(recording.validation, recording.loop.u_mm),
        "targets": _targets_table(recording),
        "target_distances": _distances_table(recording),
        "validation": points_table(recording.points),
    }
    files = write_tables(folder, tables)
    write_table(folder / "true_validation.csv", true_table(recording.true_points_mm))
    write_json(folder / "campaign.json", _document(recording, files))
    write_json(folder / "truth.json", plant_document(recording.cell))


def _document(recording: LoopRecording, files: dict[str, str]) -> dict[str, Any]:
    document = campaign_document(recording.cell, files)
    document["kind"] = "contacts"
    if not recording.loop.nests_known:
        stated = enumerate(document["tool_nests_mm"], start=1)
        document["tool_nests_mm"] = [
            None if number in recording.loop.nests else centre for number, centre in stated
        ]
    return document


def _contacts_table(contacts: Contacts, u_mm: float) -> Columns:
    columns = {
        "config": whole(contacts.config),
        # A probe stops the arm anywhere: its joints are read with all that encoders have.
        **joint_columns(contacts.joints_deg, 6),
        **direction_columns(contacts.direction),
        "time_s": decimals(contacts.time_s, 1),
        "temperature_C": decimals(contacts.temperature_c, 2),
        "target": whole(contacts.target),
        "nest": whole(contacts.nest),
        "reading_mm": decimals(contacts.reading_mm, 4),
        "u_mm": decimals(np.full(len(contacts), u_mm), 5),
    }
    if (contacts.axis >= 0).any():
        columns["axis"] = ["xyz"[axis] for axis in contacts.axis]
    return columns


def _targets_table(recording: LoopRecording) -> Columns:
    loop = recording.loop
    return {
        "target": whole(np.arange(1, len(loop.placed) + 1)),
        "kind": [placed.kind for placed in loop.placed],
        "zero_mm": ["" if placed.zero_mm is None else f"{placed.zero_mm:.4f}" for placed in loop.placed],
        "u_zero_mm": ["" if placed.zero_mm is None else f"{loop.u_zero_mm:.5f}" for placed in loop.placed],
        "form_mm": decimals(np.full(len(loop.placed), loop.form_mm), 5),
    }


def _distances_table(recording: LoopRecording) -> Columns:
    if recording.distance_mm is None or recording.loop.u_distance_mm is None:
        return {}
    return {
        "target_a": ["1"],
        "target_b": ["2"],
        "distance_mm": [f"{recording.distance_mm:.5f}"],
        "u_mm": [f"{recording.loop.u_distance_mm:.5f}"],
    }
