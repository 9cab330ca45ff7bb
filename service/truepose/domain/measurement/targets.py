"""Targets of closed loops: what probes, gauges, wires and sensors read against. Nobody knows their places."""

from dataclasses import dataclass
from enum import StrEnum

Vector = tuple[float, float, float]


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
