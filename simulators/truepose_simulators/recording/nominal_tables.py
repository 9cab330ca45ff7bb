"""What papers say of an arm, as a campaign folder states it: DH-Modified rows and masses.

Only written into files, for whoever identifies; the truth of drawn arms is computed from `physics.robots`.
Sources: A. Nubiola, thesis, ETS Montreal 2014, sections 2.3, 2.4 and 4.3 (tables, masses, ranges); of the
UR10 its maker's "DH parameters for calculations of kinematics and dynamics", of the KR 6 the axes of
ros-industrial/kuka_experimental, kr6r900sixx_macro.xacro, brought to this form by hand.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import degrees
from types import MappingProxyType

from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.errors import ModelError
from truepose_simulators.physics.arm import Vector
from truepose_simulators.physics.table_arm import ArmTable

Row = tuple[float, float, float, float]
Range = tuple[float, float]


@dataclass(frozen=True, slots=True)
class NominalTable:
    """The papers of one arm."""

    name: str
    rows: tuple[Row, ...]  # alpha [deg], a [mm], theta offset [deg], d [mm] of DH-Modified (Craig)
    masses: tuple[tuple[int, float, Vector], ...]  # frame, mass [kg], centre of gravity in it [mm]; no tool
    calibration_deg: tuple[Range, ...]  # where configurations are chosen
    signs: tuple[int, ...] = ()  # sense in which each joint counts; none: all about z


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
    "ur10": NominalTable(
        name="Universal Robots UR10",
        rows=(
            (0.0, 0.0, 0.0, 127.3),
            (90.0, 0.0, 0.0, 0.0),
            (0.0, -612.0, 0.0, 0.0),
            (0.0, -572.3, 0.0, 163.941),
            (90.0, 0.0, 0.0, 115.7),
            (-90.0, 0.0, 0.0, 92.2),
        ),
        masses=(
            (1, 7.1, (21.0, -27.0, 0.0)),
            (2, 12.7, (-232.0, 0.0, 158.0)),
            (3, 4.27, (-332.3, 0.0, 68.0)),
            (4, 2.0, (0.0, -18.0, 7.0)),
            (5, 2.0, (0.0, 18.0, -7.0)),
            (6, 0.365, (0.0, 0.0, -26.0)),
        ),
        # the maker states full turns only: elbow above the table, tool in front
        calibration_deg=((-90, 90), (-120, -60), (-120, -20), (-180, 0), (-120, 120), (-180, 180)),
    ),
    # Masses of its links are not public: these are estimates, and the simulated arm has others. 50
    # configurations leave 0.03 mm of that.
    "kr6r900": NominalTable(
        name="KUKA KR 6 R900 sixx",
        rows=(
            (0.0, 0.0, 0.0, 400.0),
            (-90.0, 25.0, 0.0, 0.0),
            (0.0, 455.0, -90.0, 0.0),
            (-90.0, 35.0, 0.0, 420.0),
            (90.0, 0.0, 0.0, 0.0),
            (-90.0, 0.0, 180.0, 80.0),
        ),
        masses=((2, 9.0, (227.5, 0.0, 0.0)), (4, 8.0, (0.0, 0.0, -210.0))),  # estimates: there are no others
        calibration_deg=((-90, 90), (-130, -40), (30, 140), (-150, 150), (-100, 100), (-180, 180)),
        signs=(-1, 1, 1, -1, 1, -1),
    ),
})


def papers_of_cell(cell: Cell) -> NominalTable:
    """Return the papers of the arm in a cell; raises ModelError."""
    of_scenario = NOMINAL_TABLES[cell.scenario.robot]
    return of_scenario if cell.model is None else _papers_of(cell.model.table, of_scenario)


def _papers_of(table: ArmTable, of_scenario: NominalTable) -> NominalTable:
    return NominalTable(
        name=table.name,
        rows=tuple(
            (degrees(row.alpha_rad), row.a_mm, degrees(row.offset_rad), row.d_mm) for row in table.rows
        ),
        masses=tuple((mass.joint, mass.mass_kg, mass.centre_of_gravity_mm) for mass in table.masses),
        calibration_deg=_ranges_deg(table, of_scenario),
        signs=tuple(row.sign for row in table.rows),
    )


def _ranges_deg(table: ArmTable, of_scenario: NominalTable) -> tuple[Range, ...]:
    """Return where a model's arm may stand: its own ranges, else those of the scenario's robot."""
    ranges = table.calibration_rad or table.limits_rad
    if ranges is not None:
        return tuple((degrees(lower), degrees(upper)) for lower, upper in ranges)
    if len(of_scenario.rows) != len(table.rows):
        raise ModelError(
            f"the model of {table.name} states neither calibration ranges nor joint limits, and the"
            f" scenario's robot has {len(of_scenario.rows)} joints instead of {len(table.rows)}; replay a"
            " campaign instead of recording a new one"
        )
    return of_scenario.calibration_deg
