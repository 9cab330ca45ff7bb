"""The closed loops that can be recorded: what stands in the cell, what the tool carries, how well it reads.

Sizes are what such instruments state: touch probes 0.001 mm, spheres and bars certified to 0.001 mm, plates
flat within 0.002 mm, gauges 0.001 mm over 10 mm, encoders with wires 0.02 mm, sensors on a ball 0.01 mm
within 2 mm (A. Nubiola, thesis, ETS Montreal 2014, section 1.8, has 0.020 mm of ROSY).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Placed:
    """One thing in the cell, as drawings have it."""

    kind: str  # as the campaign format names it
    place_mm: Vector  # centre, or a point of the plane, world
    normal: Vector = (0.0, 0.0, 1.0)  # along which a plane's or gauge's readings grow
    zero_mm: float | None = None  # stated, as the papers have it


@dataclass(frozen=True, slots=True)
class Loop:
    """One way to close a loop."""

    placed: tuple[Placed, ...]
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
_BALL = Placed("ball", (430.0, 0.0, 260.0))
_GAUGES = tuple(
    Placed("gauge", (420.0, -60.0, 240.0), axis)
    for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
)
_SPHERES = (
    Placed("sphere", (330.0, -250.0, 140.0), zero_mm=_SPHERE_MM),
    Placed("sphere", (450.0, 230.0, 260.0), zero_mm=_SPHERE_MM),
)
_LEVEL = Placed("plane", (450.0, 0.0, 120.0))
_TILTED_AT = ((450.0, 0.0, 250.0), (-0.5, 0.3, 0.8))
_TILTED = Placed("plane", *_TILTED_AT)
_FACES = (
    Placed("plane", (450.0, 0.0, 300.0)),
    Placed("plane", (350.0, 0.0, 250.0), (-1.0, 0.0, 0.0)),
    Placed("plane", (450.0, 200.0, 250.0), (0.0, 1.0, 0.0)),
)


def _planes(placed: tuple[Placed, ...], patch_mm: tuple[float, float]) -> Loop:
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
        (Placed("face", *_TILTED_AT),),
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
            Placed("wire", place)
            for place in ((900.0, -700.0, 30.0), (900.0, 700.0, 30.0), (-100.0, 650.0, 900.0))
        ),
        (2,),
        0.02,
        together=True,
    ),
    "ball": Loop((_BALL,), (2,), 0.01, spread_mm=1.5, nests_known=False),
    "two-balls": Loop(
        (Placed("ball", (330.0, -250.0, 180.0)), Placed("ball", (450.0, 230.0, 300.0))),
        (2,),
        0.01,
        u_distance_mm=0.001,
        spread_mm=1.5,
        nests_known=False,
    ),
})
