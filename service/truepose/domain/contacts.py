"""Sessions of closed loops: a probe, gauges, wires or sensors read against targets that stand still.

A contact is one number read at a stop against one target, whose shape is known and whose place is found from
the readings (docs/decisions/0048).
"""

from dataclasses import dataclass
from enum import StrEnum
from typing import Literal, TypeAlias

from truepose.domain.session import Role, Vector


class TargetKind(StrEnum):
    """What a reading against a target is of; P is the tool nest that takes part."""

    SPHERE = "sphere"  # distance of P, the probe's centre, from the centre of the sphere
    WIRE = "wire"  # distance of P, the wire's end, from the point where the wire leaves its drum
    PLANE = "plane"  # distance of P, the probe's centre, from the plane
    GAUGE = "gauge"  # travel of a fixed gauge with a flat face that P's ball pushes: along one direction
    BALL = "ball"  # from P, the sensor in the tool, to a fixed ball, along one axis of the sensor
    FACE = "face"  # from P, the sensor or gauge in the tool, to a fixed plane, along one axis of the sensor


CENTRES = frozenset({TargetKind.SPHERE, TargetKind.WIRE, TargetKind.BALL})
SEEN_ALONG_AXES = frozenset({TargetKind.BALL, TargetKind.FACE})  # from the tool, along axes of a sensor there


@dataclass(frozen=True, slots=True)
class Target:
    """What readings are taken against; it stands still, and its place is found from them."""

    number: int
    kind: TargetKind
    zero_mm: float | None = None  # distance at which a sphere or wire reads 0; None: found from the readings
    zero_uncertainty_mm: float = 0.0  # 0: exact
    form_mm: float = 0.0  # standard deviation of its form: flatness, roundness
    place_mm: Vector | None = None  # about where it is, world frame
    normal: Vector | None = None  # of what is flat, about the direction in which readings grow


Joints: TypeAlias = tuple[float, ...]
# What reads. probe: a gauge in the tool whose tip touches spheres and planes. gauges: fixed ones that a ball
# of the tool pushes. wires: their ends hang on the tool. sensor: in the tool, sees a fixed ball.
Loop: TypeAlias = Literal["probe", "gauges", "wires", "sensor"]
SENSOR_AXES = 3
# Of a way, at which nothing is touched: the place from which all ways begin, off the target, and before it.
FREE_PLACES = 3


@dataclass(frozen=True, slots=True)
class TargetDistance:
    """A certified distance of the centres of two targets."""

    targets: tuple[int, int]
    distance_mm: float
    standard_uncertainty_mm: float


@dataclass(frozen=True, slots=True)
class ContactStop:
    """One configuration in which gauges are read, and the way there and back."""

    config: int  # number in the campaign, unique in the session
    targets: tuple[int, ...]  # that the gauges read there, in their order; of a sensor the one ball
    # The arm leaves by the way it came: nobody has looked whether another one is clear of what it touches.
    way_rad: tuple[Joints, ...]  # from where all ways begin to the stop, which is the last
    push: Vector | None = None  # world: where the tool goes to push its probe in

    @property
    def joints_rad(self) -> Joints:
        """Where the gauges are read."""
        return self.way_rad[-1]


@dataclass(frozen=True, slots=True)
class ContactPlan:
    """What a session of closed loops will do, in order."""

    loop: Loop
    role: Role
    nest: int  # 1-based: tip of the probe at its zero, ball, end of the wires, origin of the sensor
    targets: tuple[Target, ...]
    stops: tuple[ContactStop, ...]
    distances: tuple[TargetDistance, ...] = ()
    found_zeros: tuple[int, ...] = ()  # targets whose zero is rough, and found from the readings
    stroke_mm: float = 5.0  # of each gauge, either way of its zero
    margin_mm: float = 1.0  # of it that stays unused
    null_mm: float | None = None  # so near its zero a probe is brought before it is read; None: it is not
    reading_u_mm: float = 0.001  # standard uncertainty of a reading
    samples: int = 5
    settle_s: float = 2.0
    tool_speed_mm_s: float = 250.0
    orientation_speed_rad_s: float = 0.349
    touch_speed_mm_s: float = 10.0  # while something touches, or is about to
    joint_tolerance_rad: float = 0.00035  # reported against commanded; protocols round to 0.01 deg
    failures_in_a_row: int = 3  # so many stops without a reading pause the session

    @property
    def touches(self) -> bool:
        """Whether the tool comes near its targets: then it creeps, and leaves by the way it came."""
        return self.loop != "wires"

    @property
    def channels(self) -> int:
        """How many gauges are read at each stop; of a plan with one stop at least."""
        return SENSOR_AXES if self.loop == "sensor" else len(self.stops[0].targets)


@dataclass(frozen=True, slots=True)
class ContactTaken:
    """What the gauges read at a stop."""

    config: int
    nest: int
    commanded_rad: Joints
    reported_rad: Joints
    direction: tuple[int, ...]
    time_s: float
    attachment: int
    targets: tuple[int, ...]  # of each reading
    axes: tuple[int, ...]  # of each reading: of the sensor, 0 to 2; none for what is no sensor
    reading_mm: tuple[float, ...]
    standard_uncertainty_mm: float
