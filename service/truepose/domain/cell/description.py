"""A cell as its owner describes it: robot, instruments, artefacts, conditions and limits."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Final

from truepose.domain.cell.artefacts import Artefact as Artefact
from truepose.domain.cell.artefacts import BallbarKit
from truepose.domain.cell.keep_outs import KeepOuts
from truepose.domain.robot import FixedNest, FramePlacement, JointRange, Nest, Robot

Vector = tuple[float, float, float]
MODEL_SHIFT_MM: Final = 5.0  # measured arms: up to 4.5 mm within the zone in which they were measured
Detail = str | float | tuple[float, ...]


@dataclass(frozen=True, slots=True)
class DeviceEntry:
    """An instrument or controller: which driver opens it, and with which options."""

    name: str  # unique in the cell: "tracker", "robot"
    driver: str  # configuration name of the driver
    options: Mapping[str, str | int | float | bool]  # host, port, serial, usb ...; the driver checks them
    serial_number: str = ""
    certificate: str = ""  # calibration certificate: number, date, laboratory
    certificate_expires: str = ""  # ISO date; empty where nobody said it
    use: str = ""  # kind of device that it is used as; empty: what its driver says first


@dataclass(frozen=True, slots=True)
class PlantedEffect:
    """A change that a simulated cell undergoes on purpose, from a moment of cell time on."""

    name: str
    subject: str
    amplitude: float  # in the unit of that effect
    from_s: float = 0.0
    details: Mapping[str, Detail] = field(default_factory=dict)  # order, phase ...; the cell checks them


@dataclass(frozen=True, slots=True)
class SimulatedCell:
    """Which simulated cell stands in for a real one."""

    scenario: str  # shipped name or file
    seed: int
    effects: tuple[PlantedEffect, ...] = ()
    pace: int | None = None  # wall time per cell time, 1 or 0; None: as the service is started


@dataclass(frozen=True, slots=True)
class Conditions:
    """What a report states beside its figures, in the owner's words."""

    load: str = ""
    warm_up: str = ""
    notes: tuple[str, ...] = ()
    part_temperature_c: float | None = None  # of arm and artefact, where somebody measured it


@dataclass(frozen=True, slots=True)
class CertifiedLength:
    """Distance between two fixed nests, certified apart from their coordinates: it verifies the scale."""

    fixed_nests: tuple[int, int]  # 1-based
    length_mm: float
    standard_uncertainty_mm: float
    expansion_per_k: float | None = None  # of what holds the nests; None: nobody said it


@dataclass(frozen=True, slots=True)
class Camera:
    """A tracker of poses in the tracker's place, and how exactly it reads its artefact.

    No fixed nest places it: the world of its readings is its own frame, put where it is said to stand.
    """

    position_mm: Vector  # in the world, nominal
    looks_at_mm: Vector  # along its negative z axis; its x axis is level
    nest: int  # 1-based: the artefact's centre, where poses are told
    position_u_mm: float  # of a reading, per axis
    rotation_u_rad: float
    artefact_rotation_u_rad: float  # of the artefact's definition in the last frame
    upright: bool = False  # a laser tracker's frame: z is up, and x points to what lies below `looks_at_mm`


@dataclass(frozen=True, slots=True)
class CellLimits:
    """What must not be exceeded in this cell."""

    joints: tuple[JointRange, ...] | None = None  # None: the robot's own
    calibration: tuple[JointRange, ...] | None = (
        None  # where configurations are chosen; None: the robot's own
    )
    floor_z_mm: float | None = None  # of floor or table, world; None: the world's z = 0, or the robot's foot
    keep_outs: KeepOuts = field(default_factory=KeepOuts)  # that nothing of the arm enters
    seen_within_rad: float | None = None  # of where a nest faces; None: as a corner cube is, 29 deg
    reference_mm: float = 0.1  # a fixed nest that moved further pauses the session
    tool_speed_mm_s: float = 500.0  # thesis section 2.4
    orientation_speed_rad_s: float = 0.349  # 20 deg/s, thesis section 2.4
    model_shift_mm: float = MODEL_SHIFT_MM  # of the tool; beyond it a handed-down model is asked about


@dataclass(frozen=True, slots=True)
class Cell:
    """One cell; exactly one of `devices` (real) and `simulated` is given."""

    name: str
    robot_key: str  # name of the shipped robot, or the robot file
    robot: Robot
    robot_serial_number: str = ""
    base_nominal: FramePlacement = field(default_factory=FramePlacement)  # in the world
    nests: tuple[Nest, ...] = ()  # tool nests, last frame
    tool: Artefact | None = None
    fixed_nests: tuple[FixedNest, ...] = ()  # world frame
    fixed_nests_seen_mm: tuple[Vector, ...] | None = (
        None  # in the tracker's frame, where somebody aimed at them
    )
    world: Artefact | None = None  # what certifies the fixed nests
    certified_lengths: tuple[CertifiedLength, ...] = ()
    tracker_position_mm: Vector | None = None  # nominal, in the world
    limits: CellLimits = field(default_factory=CellLimits)
    conditions: Conditions = field(default_factory=Conditions)
    devices: tuple[DeviceEntry, ...] = ()
    simulated: SimulatedCell | None = None
    ballbar: BallbarKit | None = None  # None: the cell has none
    camera: Camera | None = None  # measures poses in the tracker's place; None: the tracker measures points
    people: tuple[str, ...] = ()  # who may confirm that the cell is clear; empty: whoever gives a name

    def keeping_out(self, keep_outs: KeepOuts) -> "Cell":
        """Return the cell with further keep-out volumes."""
        return replace(self, limits=replace(self.limits, keep_outs=self.limits.keep_outs.joined(keep_outs)))

    def expected_serial(self, kind: str, entry: DeviceEntry) -> str:
        """Return which serial number a device must answer with, empty where the cell names none.

        The number of the device's own entry comes first: a controller's or a cable's number may be another
        one than that of the robot or of the ballbar behind it.
        """
        if kind == "ballbar" and self.ballbar is not None:
            return entry.serial_number or self.ballbar.instrument.serial_number
        return entry.serial_number or (self.robot_serial_number if kind == "robot" else "")
