"""What the makers' papers say of the arms, as a campaign folder states it: DH-Modified rows and masses.

Only written into files, for whoever identifies; the truth is computed from `physics.robots` alone.
Sources: A. Nubiola, thesis, ETS Montreal 2014, sections 2.3, 2.4 and 4.3 (tables, masses, ranges).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from simulators.physics.arm import Vector

Row = tuple[float, float, float, float]
Range = tuple[float, float]


@dataclass(frozen=True, slots=True)
class NominalTable:
    """The papers of one arm."""

    name: str
    rows: tuple[Row, ...]  # alpha [deg], a [mm], theta offset [deg], d [mm] of DH-Modified (Craig)
    masses: tuple[tuple[int, float, Vector], ...]  # frame, mass [kg], centre of gravity in it [mm]; no tool
    calibration_deg: tuple[Range, ...]  # where configurations are chosen


NOMINAL_TABLES: Mapping[str, NominalTable] = MappingProxyType({
    "irb120": NominalTable(
        name="ABB IRB 120",
        rows=(
            (0.0, 0.0, 0.0, 290.0),
            (-90.0, 0.0, -90.0, 0.0),
            (0.0, 270.0, 0.0, 0.0),
            (-90.0, 70.0, 0.0, 302.0),
            (90.0, 0.0, 0.0, 0.0),
            (-90.0, 0.0, 180.0, 72.0),
        ),
        masses=((2, 4.2, (140.0, 0.0, 0.0)), (4, 5.0, (0.0, 0.0, -193.6))),
        calibration_deg=((-90, 90), (0, 90), (-80, 50), (-150, 150), (-90, 90), (-180, 180)),
    ),
    "lrmate200ic": NominalTable(
        name="Fanuc LR Mate 200iC",
        rows=(
            (0.0, 0.0, 0.0, 330.0),
            (-90.0, 75.0, -90.0, 0.0),
            (0.0, 300.0, 0.0, 0.0),
            (-90.0, 75.0, 0.0, 320.0),
            (90.0, 0.0, 0.0, 0.0),
            (-90.0, 0.0, 0.0, 80.0),
        ),
        masses=((2, 10.0, (150.0, 0.0, 0.0)), (4, 10.0, (0.0, 0.0, -160.0))),
        calibration_deg=((-150, 150), (-50, 110), (-80, 120), (-180, 180), (-115, 115), (-180, 180)),
    ),
})
