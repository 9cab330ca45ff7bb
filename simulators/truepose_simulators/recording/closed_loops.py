"""The closed loops that can be recorded, and where the arm stands in them.

Sizes are what such instruments state: touch probes 0.001 mm, spheres and bars certified to 0.001 mm, plates
flat within 0.002 mm, gauges 0.001 mm over 10 mm, encoders with wires 0.02 mm, sensors on a ball 0.01 mm
within 2 mm (A. Nubiola, thesis, ETS Montreal 2014, section 1.8, has 0.020 mm of ROSY).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from truepose_simulators.cell.robot import nominal_bodies, nominal_flange
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.physics.effects.ports import NestNumbers
from truepose_simulators.physics.rigid import FloatArray, apply, move
from truepose_simulators.recording.nominal_tables import papers_of_cell
from truepose_simulators.recording.plan import NoStopsError
from truepose_simulators.recording.rows import Rows

Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class PlacedObject:
    """One thing in the cell, as drawings have it."""

    kind: str  # as the campaign format names it
    place_mm: Vector  # centre, or a point of the plane, world
    normal: Vector = (0.0, 0.0, 1.0)  # along which a plane's or gauge's readings grow
    zero_mm: float | None = None  # stated, as the papers have it


@dataclass(frozen=True, slots=True)
class Loop:
    """One way to close a loop."""

    placed: tuple[PlacedObject, ...]
    nests: tuple[int, ...]  # of the tool that are used, by turns
    u_mm: float  # of a reading
    u_zero_mm: float = 0.0  # of the stated zeros
    form_mm: float = 0.0
    u_distance_mm: float | None = None  # of the certified distance of the first two; None: none is certified
    spread_mm: float = 0.0  # by which stops are off the place, any way
    patch_mm: tuple[float, float] = (0.0, 0.0)  # half the sides of the part of a plane that is used
    touches: bool = False  # the arm goes on until the probe triggers, which reads 0
    nests_known: bool = True  # the papers say where the nests are
    together: bool = False  # everything is read at each stop
    stand_off_mm: float = 0.0  # of a sensor from a plane
    lean_deg: float = 75.0  # by at most which the tool leans against the way in


_SPHERE_MM = 12.7 + 3.0  # a sphere of one inch and a probe's tip of 6 mm
_BALL = PlacedObject("ball", (430.0, 0.0, 260.0))
_GAUGES = tuple(
    PlacedObject("gauge", (420.0, -60.0, 240.0), axis)
    for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
)
_SPHERES = (
    PlacedObject("sphere", (330.0, -250.0, 140.0), zero_mm=_SPHERE_MM),
    PlacedObject("sphere", (450.0, 230.0, 260.0), zero_mm=_SPHERE_MM),
)
_LEVEL = PlacedObject("plane", (450.0, 0.0, 120.0))
_TILTED_AT = ((450.0, 0.0, 250.0), (-0.5, 0.3, 0.8))
_TILTED = PlacedObject("plane", *_TILTED_AT)
_FACES = (
    PlacedObject("plane", (450.0, 0.0, 300.0)),
    PlacedObject("plane", (350.0, 0.0, 250.0), (-1.0, 0.0, 0.0)),
    PlacedObject("plane", (450.0, 200.0, 250.0), (0.0, 1.0, 0.0)),
)


def _planes(placed: tuple[PlacedObject, ...], patch_mm: tuple[float, float]) -> Loop:
    return Loop(placed, (1, 2, 3), 0.001, form_mm=0.002, patch_mm=patch_mm, touches=True)


LOOPS: Mapping[str, Loop] = MappingProxyType({
    "sphere": Loop(_SPHERES[:1], (2,), 0.001, u_zero_mm=0.001, form_mm=0.0005, touches=True),
    "two-spheres": Loop(
        _SPHERES, (2,), 0.001, u_zero_mm=0.001, form_mm=0.0005, u_distance_mm=0.001, touches=True
    ),
    "plane": _planes((_LEVEL,), (150.0, 300.0)),
    "tilted-plane": _planes((_TILTED,), (150.0, 300.0)),
    "planes": _planes(_FACES, (80.0, 150.0)),
    "gauges": Loop(_GAUGES, (1, 2, 3), 0.001, spread_mm=3.0, together=True),
    "face": Loop(
        (PlacedObject("face", *_TILTED_AT),),
        (2,),
        0.005,
        form_mm=0.002,
        spread_mm=5.0,
        patch_mm=(150.0, 300.0),
        stand_off_mm=40.0,
        lean_deg=25.0,
    ),
    "wires": Loop(
        tuple(
            PlacedObject("wire", place)
            for place in ((900.0, -700.0, 30.0), (900.0, 700.0, 30.0), (-100.0, 650.0, 900.0))
        ),
        (2,),
        0.02,
        together=True,
    ),
    "ball": Loop((_BALL,), (2,), 0.01, spread_mm=1.5, nests_known=False),
    "two-balls": Loop(
        (PlacedObject("ball", (330.0, -250.0, 180.0)), PlacedObject("ball", (450.0, 230.0, 300.0))),
        (2,),
        0.01,
        u_distance_mm=0.001,
        spread_mm=1.5,
        nests_known=False,
    ),
})


_DRAWN = 40  # configurations for each that is wanted
_MOST_DRAWS = 30
_NEAR_MM = 250.0  # from which the arm is led to the place
_STEPS = 12
_ARRIVED_MM = 1e-6
_LOWEST_MM = 80.0  # no nest of a wire closer to the table


@dataclass(frozen=True, slots=True)
class LoopConfigurations(Rows):
    """m stops of a loop."""

    joints_deg: FloatArray  # (m, J) nominal, with the decimals of the file
    nest: NestNumbers  # (m,) 1-based
    placed: NestNumbers  # (m,) index of what is met; of loops that read everything at once 0


def plan_stands(cell: Cell, loop: Loop, count: int, rng: np.random.Generator) -> LoopConfigurations:
    """Draw stops of a loop, nests and places by turns; raises NoStopsError."""
    rows = np.arange(count)
    nest = np.array(loop.nests)[rows % len(loop.nests)]
    n_places = 1 if loop.together else len(loop.placed)
    placed = rows // len(loop.nests) % n_places
    joints = np.zeros((count, cell.plant.arm.n_joints))
    for number in np.unique(nest).tolist():
        for which in range(n_places):
            mine = np.flatnonzero((nest == number) & (placed == which))
            joints[mine] = _stops(cell, loop, loop.placed[which], number, len(mine), rng)
    return LoopConfigurations(joints, nest, placed)


def _stops(
    cell: Cell, loop: Loop, placed: PlacedObject, nest: int, count: int, rng: np.random.Generator
) -> FloatArray:
    """Return joints [deg] at which the nominal nest is where the loop wants it, shape (count, J)."""
    lower, upper = np.array(papers_of_cell(cell).calibration_deg).T
    nest_mm = np.array(cell.scenario.tool.nests_mm[nest - 1])
    found = np.zeros((0, len(lower)))
    for _ in range(_MOST_DRAWS):
        drawn = rng.uniform(lower, upper, (_DRAWN * count, len(lower)))
        found = np.concatenate([found, _led(cell, loop, placed, nest_mm, drawn, rng)])
        found = found[((found > lower) & (found < upper)).all(axis=1)]
        if len(found) >= count:
            kept: FloatArray = found[:count].round(5)
            return kept
    raise NoStopsError(f"the arm reaches the {placed.kind} at {len(found)} stops only; {count} are required")


def _led(
    cell: Cell,
    loop: Loop,
    placed: PlacedObject,
    nest_mm: FloatArray,
    joints_deg: FloatArray,
    rng: np.random.Generator,
) -> FloatArray:
    """Return configurations led to places of the loop near by: those that arrive and may stand there."""
    if placed.kind == "wire":
        places = move(nominal_flange(cell.plant.arm, np.radians(joints_deg)), nest_mm)
        return joints_deg[places[:, 2] > _LOWEST_MM]
    wanted, inward = _wanted(loop, placed, len(joints_deg), rng)
    flange = nominal_flange(cell.plant.arm, np.radians(joints_deg))
    near = np.linalg.norm(move(flange, nest_mm) - wanted, axis=1) < _NEAR_MM
    wanted, inward = wanted[near], inward[near]
    joints, arrived = _arrived(cell, nest_mm, np.radians(joints_deg[near]), wanted)
    pointing = nominal_flange(cell.plant.arm, joints)[:, :3, 2]
    stands = arrived & ((pointing * inward).sum(axis=1) > np.cos(np.radians(loop.lean_deg)))
    kept: FloatArray = np.degrees(joints[stands])
    return kept


def _wanted(
    loop: Loop, placed: PlacedObject, count: int, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Return places for the nest and the way in from where the tool comes, shape (count, 3) each."""
    place = np.broadcast_to(np.array(placed.place_mm), (count, 3))
    down = np.broadcast_to(np.array([0.0, 0.0, -1.0]), (count, 3))
    if placed.kind == "sphere":
        outward = rng.standard_normal((count, 3))
        outward[:, 2] = np.abs(outward[:, 2])
        outward /= np.linalg.norm(outward, axis=1, keepdims=True)
        return place + (placed.zero_mm or 0.0) * outward, -outward
    if placed.kind in ("plane", "face"):
        axes = axes_of(placed)
        on_it = rng.uniform(-1.0, 1.0, (count, 2)) * np.array(loop.patch_mm)
        high = loop.stand_off_mm + loop.spread_mm * rng.uniform(-1.0, 1.0, (count, 1))
        return place + np.hstack([on_it, high]) @ axes.T, np.broadcast_to(-axes[:, 2], (count, 3))
    off = rng.uniform(-loop.spread_mm, loop.spread_mm, (count, 3))
    way = down if placed.kind == "ball" else np.broadcast_to(-np.ones(3) / np.sqrt(3.0), (count, 3))
    return place + off, way


def axes_of(placed: PlacedObject) -> FloatArray:
    """Return the axes of a plane or gauge as drawn, in columns (3, 3): the second level, the third across."""
    normal = np.array(placed.normal) / np.linalg.norm(placed.normal)
    level = np.cross(normal, [1.0, 0.0, 0.0] if abs(normal[0]) < abs(normal[2]) else [0.0, 0.0, 1.0])
    level /= np.linalg.norm(level)
    axes: FloatArray = np.stack([np.cross(level, normal), level, normal], axis=1)
    return axes


def _arrived(
    cell: Cell, nest_mm: FloatArray, joints_rad: FloatArray, wanted_mm: FloatArray
) -> tuple[FloatArray, NestNumbers]:
    """Newton steps of least motion that bring the nest to its place, all stops at once."""
    arm = cell.plant.arm
    joints = joints_rad.copy()
    for _ in range(_STEPS):
        bodies = nominal_bodies(arm, joints)
        places = move(bodies.last_frame, nest_mm)
        levers = places[:, np.newaxis] - bodies.axis_points_mm
        slopes = np.swapaxes(np.cross(bodies.axis_directions, levers), 1, 2)
        steps = np.asarray(np.linalg.pinv(slopes), dtype=np.float64)
        joints = joints + apply(steps, wanted_mm - places)
    left = np.linalg.norm(move(nominal_flange(arm, joints), nest_mm) - wanted_mm, axis=1)
    return joints, left < _ARRIVED_MM
