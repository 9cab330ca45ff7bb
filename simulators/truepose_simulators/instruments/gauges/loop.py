"""The gauges of a closed loop as devices: what each of them shows while the arm is where it is.

Whoever bolts a fixture puts it about where it was asked for; its own parts stand to each other as its paper
says, but for what that is uncertain by.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final, NamedTuple

import numpy as np

from truepose_simulators.errors import ScenarioError
from truepose_simulators.instruments.gauges.length_source import Sample
from truepose_simulators.physics.arm import Vector
from truepose_simulators.physics.contacts import (
    ball_on_gauge_mm,
    ball_position_mm,
    probe_on_plane_mm,
    probe_on_sphere_mm,
    wire_mm,
)
from truepose_simulators.physics.rigid import FloatArray, small_motion
from truepose_simulators.scenarios.table import require_at_least_0

_KINDS: Final = {
    "sphere": ("probe",), "plane": ("probe",), "gauge": ("gauges",), "wire": ("wires",), "ball": ("sensor",),
}  # fmt: skip
_SENSOR_AXES: Final = 3
_FACE_MM: Final = 15.0  # of a fixed gauge


@dataclass(frozen=True, slots=True)
class LoopSetup:
    """What reads against what, and how truly."""

    reader: str = "probe"  # or "gauges", "wires", "sensor"
    nest: int = 2  # tip of the probe at its zero, ball, end of the wires, origin of the sensor
    axis: Vector = (0.0, 0.0, 1.0)  # flange frame: where the probe points
    kinds: tuple[str, ...] = ("sphere",)
    places_mm: tuple[Vector, ...] = ((420.0, 0.0, 80.0),)  # as asked for, world
    normals: tuple[Vector, ...] = ()  # in which readings grow; none: upwards
    zeros_mm: tuple[float, ...] = ()  # sphere and tip together, or a wire's length at 0; none: 0
    placed_u_mm: float = 1.0  # by which somebody bolts a fixture elsewhere than asked for
    placed_u_rad: float = 0.003
    paper_u_mm: float = 0.002  # of distances between targets, per axis and target, and of `zeros_mm`
    travel_mm: float = 5.5  # either way of 0
    noise_mm: float = 0.0005  # of one reading
    resolution_mm: float = 0.0001

    def __post_init__(self) -> None:
        for kind in self.kinds:
            if self.reader not in _KINDS.get(kind, ()):
                raise ScenarioError(f'key "kinds": a {self.reader} does not read a {kind}')
        n = len(self.kinds)
        if n == 0 or not all(map(any, self.normals)):
            raise ScenarioError('key "kinds" must not be empty, and "normals" must not contain a zero vector')
        for name in ("places_mm", "normals", "zeros_mm"):
            if len(getattr(self, name)) not in {n, 0 if name != "places_mm" else n}:
                raise ScenarioError(f'key "{name}" must have {n} entries, one for each of "kinds"')
        require_at_least_0(self, "placed_u_mm", "placed_u_rad", "paper_u_mm", "noise_mm")
        if min(self.travel_mm, self.resolution_mm) <= 0.0 or not any(self.axis):
            raise ScenarioError('keys "travel_mm" and "resolution_mm" must be above 0, "axis" a direction')


class Tool(NamedTuple):
    """Where the tool is."""

    rotation: FloatArray  # (3, 3) of the flange frame, world
    nest_mm: FloatArray  # (3,) world


@dataclass(frozen=True, slots=True)
class TrueTarget:
    """A target where it truly stands."""

    kind: str
    place_mm: FloatArray
    normal: FloatArray
    zero_mm: float


def bolt_targets(setup: LoopSetup, rng: np.random.Generator) -> tuple[TrueTarget, ...]:
    """Draw where the targets truly stand: together elsewhere, and each a little off its paper."""
    n = len(setup.kinds)
    asked = np.array(setup.places_mm, dtype=np.float64)
    normals = np.array(setup.normals or ((0.0, 0.0, 1.0),) * n, dtype=np.float64)
    motion = np.concatenate([
        setup.placed_u_mm * rng.standard_normal(3),
        setup.placed_u_rad * rng.standard_normal(3),
    ])
    frame, middle = small_motion(motion), asked.mean(axis=0)
    places = (
        (asked - middle) @ frame[:3, :3].T
        + frame[:3, 3]
        + middle
        + setup.paper_u_mm * rng.standard_normal((n, 3))
    )
    turned = normals @ frame[:3, :3].T
    zeros = np.array(setup.zeros_mm or (0.0,) * n) + setup.paper_u_mm * rng.standard_normal(n)
    return tuple(
        TrueTarget(kind, place, normal / np.linalg.norm(normal), float(zero))
        for kind, place, normal, zero in zip(setup.kinds, places, turned, zeros, strict=True)
    )


@dataclass
class LoopGauge:
    """One gauge on the wire; a probe touches whichever target stops it first."""

    setup: LoopSetup
    targets: tuple[TrueTarget, ...]  # that it can read
    tool: Callable[[], Tool]
    rng: np.random.Generator | None  # None: without noise
    axis: int = 0  # of a sensor
    plugged: bool = True
    _sequence: int = field(default=0, init=False)

    def sample(self, time_s: float) -> Sample:
        """Read it now; `time_s` is now."""
        self._sequence += 1
        shown = max(self._travel_mm(target, self.tool()) for target in self.targets)
        if abs(shown) > self.setup.travel_mm:
            return Sample(math.copysign(self.setup.travel_mm, shown), "out_of_range", self._sequence)
        if self.rng is not None:
            shown += self.setup.noise_mm * float(self.rng.standard_normal())
        rounded = round(shown / self.setup.resolution_mm) * self.setup.resolution_mm
        return Sample(rounded, "good", self._sequence)

    def _travel_mm(self, target: TrueTarget, tool: Tool) -> float:
        axis = tool.rotation @ (np.array(self.setup.axis) / np.linalg.norm(self.setup.axis))
        match target.kind:
            case "sphere":
                return probe_on_sphere_mm(tool.nest_mm, axis, target.place_mm, target.zero_mm)
            case "plane":
                return probe_on_plane_mm(tool.nest_mm, axis, target.place_mm, target.normal, target.zero_mm)
            case "gauge":
                return ball_on_gauge_mm(tool.nest_mm, target.place_mm, target.normal, _FACE_MM)
            case "wire":
                return wire_mm(tool.nest_mm, target.place_mm, target.zero_mm)
        return ball_position_mm(tool.nest_mm, tool.rotation, target.place_mm, self.axis)


def loop_gauges(
    setup: LoopSetup, tool: Callable[[], Tool], rng: np.random.Generator, *, noise: bool
) -> tuple[LoopGauge, ...]:
    """Return the gauges of a cell, in the order in which a session reads them."""
    targets, of_noise = bolt_targets(setup, rng), rng if noise else None
    if setup.reader == "probe":
        return (LoopGauge(setup, targets, tool, of_noise),)
    if setup.reader == "sensor":
        return tuple(LoopGauge(setup, targets, tool, of_noise, axis) for axis in range(_SENSOR_AXES))
    return tuple(LoopGauge(setup, (target,), tool, of_noise) for target in targets)
