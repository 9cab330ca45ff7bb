"""A cell as its owner describes it: robot, instruments, artefacts, certificates, keep-outs and limits."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from datetime import date, timedelta
from typing import Final, Literal, TypeAlias

from truepose.domain.robot import FixedNest, FramePlacement, JointRange, Nest, Robot
from truepose.messages.message import Message, Text, message

REFERENCE_C: Final = 20.0  # at which lengths are certified, ISO 1


def length_at(length_mm: float, expansion_per_k: float, celsius: float) -> float:
    """Return the length of an artefact at a temperature [mm]: l (1 + alpha (T - 20)), l that at 20 degC.

    Parameters
    ----------
    length_mm : float
        At 20 degC, as certified (ISO 1).
    expansion_per_k : float
    celsius : float
    """
    return length_mm * (1.0 + expansion_per_k * (celsius - REFERENCE_C))


@dataclass(frozen=True, slots=True)
class Artefact:
    """Paper of an artefact: what it is, and what says that its numbers hold."""

    name: str
    serial_number: str = ""
    certificate: str = ""
    certificate_expires: str = ""  # ISO date; empty where nobody said it


@dataclass(frozen=True, slots=True)
class Bars:
    """The ballbar made up with extension bars, and what the calibrator is certified to be for them."""

    nominal_mm: float
    calibrator_mm: float  # length of the calibrator at 20 degrees
    calibrator_u_mm: float
    bars_mm: tuple[float, ...]  # what the person screws on
    expansion_per_k: float | None = None  # of the calibrator; None: nobody said it


@dataclass(frozen=True, slots=True)
class BallbarKit:
    """A ballbar with its calibrator and fixtures, as the cell file describes them."""

    # Where a cell file does not say, the bars are those of the thesis' fixtures: tool sides of 150 mm, legs
    # of 300.
    tool_bars: Bars = field(default_factory=lambda: Bars(150.0, 150.0, 0.0005, (50.0,)))
    base_bars: Bars = field(default_factory=lambda: Bars(300.0, 300.0, 0.0005, (150.0, 50.0)))
    range_mm: float = 1.0  # either way of the nominal length
    reading_u_mm: float = 0.00051  # QC20-W: 2 um at 95 %, thesis section 3.2
    # Ten times a certified reading's: the scale of a ballbar without certificate is not known and cannot be
    # corrected, so that only its uncertainty can say so (docs/decisions/0020).
    uncertified_u_mm: float = 0.005  # of a ballbar whose certificate nobody has: nothing certain is known
    zero_u_mm: float = 0.0015  # of the zero by the snaps of the magnets since the last initialisation
    setup_u_mm: float = 0.01  # how well a clamped cup sits where the robot held the ball, per axis
    base_points: int = 3  # cups of the base fixture: 3, or 4
    instrument: Artefact = field(default_factory=lambda: Artefact("ballbar"))
    calibrator: Artefact = field(default_factory=lambda: Artefact("calibrator"))


Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Box:
    """A box along the axes of the world."""

    name: str
    lower_mm: Vector
    upper_mm: Vector


@dataclass(frozen=True, slots=True)
class Cylinder:
    """A round bar with flat ends."""

    name: str
    start_mm: Vector
    end_mm: Vector
    radius_mm: float


@dataclass(frozen=True, slots=True)
class HalfSpace:
    """All that lies behind a plane, such as a wall."""

    name: str
    point_mm: Vector  # of the plane
    outward: Vector  # towards the free side, of any length but none


KeepOut: TypeAlias = Box | Cylinder | HalfSpace


@dataclass(frozen=True, slots=True)
class KeepOuts:
    """All keep-out volumes of a cell; their names differ."""

    boxes: tuple[Box, ...] = ()
    cylinders: tuple[Cylinder, ...] = ()
    half_spaces: tuple[HalfSpace, ...] = ()

    def __iter__(self) -> Iterator[KeepOut]:
        """Iterate over all of them, boxes first."""
        yield from self.boxes
        yield from self.cylinders
        yield from self.half_spaces

    def __len__(self) -> int:
        return len(self.boxes) + len(self.cylinders) + len(self.half_spaces)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all of them."""
        return tuple(volume.name for volume in self)

    def without(self, name: str) -> "KeepOuts":
        """Return all but one, by its name; all where none has it."""
        return keep_outs_of([volume for volume in self if volume.name != name])

    def joined(self, others: "KeepOuts") -> "KeepOuts":
        """Return these and those of others that are not among them."""
        # Compared as values: a session that was planned with a volume already keeps it once.
        return keep_outs_of([*self, *(volume for volume in others if volume not in tuple(self))])


def keep_outs_of(volumes: list[KeepOut]) -> KeepOuts:
    """Return volumes of any kind together."""
    return KeepOuts(
        tuple(volume for volume in volumes if isinstance(volume, Box)),
        tuple(volume for volume in volumes if isinstance(volume, Cylinder)),
        tuple(volume for volume in volumes if isinstance(volume, HalfSpace)),
    )


# Of five kinds of arm the largest shift within the measured zone was 4.5 mm: beyond 5 mm a person is asked
# before an arm follows a handed-down model (docs/decisions/0074).
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
    artefact_rotation_u_rad: float  # of the artefact's definition in the flange frame
    upright: bool = False  # a laser tracker's frame: z is up, and x points to what lies below `looks_at_mm`


@dataclass(frozen=True, slots=True)
class CellLimits:
    """What must not be exceeded in this cell."""

    # Never wider than the robot's own: such a file is refused. What binds a session is the tighter of these
    # as they were stored and as they are now (docs/decisions/0019).
    joints: tuple[JointRange, ...] | None = None  # None: the robot's own
    calibration: tuple[JointRange, ...] | None = (
        None  # where configurations are chosen; None: the robot's own
    )
    floor_z_mm: float | None = None  # of floor or table, world; None: not stated (`Cell.floor_z_mm`)
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
    nests: tuple[Nest, ...] = ()  # tool nests, flange frame
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
    # Halting is for everybody, announced or not: nobody should have to spell a name in an emergency.
    people: tuple[str, ...] = ()  # who may confirm that the cell is clear; empty: whoever gives a name

    @property
    def floor_z_mm(self) -> float:
        """Floor or table [mm, world] as it is stated, else z = 0 or the robot's foot, whichever is lower."""
        stated = self.limits.floor_z_mm
        return min(0.0, self.base_nominal.z_mm) if stated is None else stated

    def keeping_out(self, keep_outs: KeepOuts) -> "Cell":
        """Return the cell with further keep-out volumes.

        Parameters
        ----------
        keep_outs : KeepOuts
            Volumes that the cell has already are not added again.
        """
        return replace(self, limits=replace(self.limits, keep_outs=self.limits.keep_outs.joined(keep_outs)))

    def expected_serial(self, kind: str, entry: DeviceEntry) -> str:
        """Return which serial number a device must answer with, empty where the cell names none.

        The number of the device's own entry comes first: a controller's or a cable's number may be another
        one than that of the robot or of the ballbar behind it.

        Parameters
        ----------
        kind : str
            "tracker", "robot", "ballbar" ..: what the device is used as.
        entry : DeviceEntry
        """
        if kind == "ballbar" and self.ballbar is not None:
            return entry.serial_number or self.ballbar.instrument.serial_number
        return entry.serial_number or (self.robot_serial_number if kind == "robot" else "")


Standing: TypeAlias = Literal["holds", "ends soon", "expired", "undated", "missing"]
ClosedAs: TypeAlias = Literal["calibrated", "not calibrated"]
WARNED: Final = timedelta(days=30)  # before the end of a certificate
_FAULTS: Final = {
    "expired": "certificate.expired",
    "undated": "certificate.undated",
    "missing": "certificate.missing",
}


@dataclass(frozen=True, slots=True)
class Paper:
    """What an instrument or artefact has to show."""

    of: str  # "laser tracker", or the name of an artefact
    serial_number: str = ""
    certificate: str = ""  # number, date, laboratory
    expires: str = ""  # ISO date; empty where nobody said it

    @property
    def called(self) -> Message:
        """What it is of, with its serial number where that is known."""
        if not self.serial_number:
            return message("certificate.named", what=self.of)
        return message("certificate.numbered", what=self.of, serial=self.serial_number)

    def standing(self, on: date) -> Standing:
        """Return whether the certificate holds on a day, its last one included.

        Parameters
        ----------
        on : date

        Returns
        -------
        Standing
            "ends soon" within 30 days of its end.

        Raises
        ------
        ValueError
            `expires` is no ISO date: who reads a cell file has refused it before.
        """
        # A date without a certificate proves nothing.
        if not self.certificate.strip():
            return "missing"
        if not self.expires:
            return "undated"
        last = date.fromisoformat(self.expires)
        if last < on:
            return "expired"
        return "ends soon" if last - on <= WARNED else "holds"


@dataclass(frozen=True, slots=True)
class JudgedPaper:
    """A certificate as it stood on the day that it was judged for."""

    paper: Paper
    standing: Standing

    @property
    def proves(self) -> bool:
        """Whether it held on that day."""
        return self.standing in {"holds", "ends soon"}

    @property
    def fault(self) -> Text:
        """What is wrong with it, "" where it held."""
        if self.proves:
            return ""
        paper = self.paper
        return message(
            _FAULTS[self.standing], what=paper.called, certificate=paper.certificate, day=paper.expires
        )


@dataclass(frozen=True, slots=True)
class Closing:
    """What a person closed a session as, on which certificates, and why where one did not hold."""

    session_id: int
    # A certificate that had expired, states no end or is missing stops nobody: it takes a named person and a
    # reason.
    closed_as: ClosedAs
    person: str
    reason: str
    certificates: tuple[JudgedPaper, ...]
    closed_at: str = ""  # when it was stored

    @property
    def overridden(self) -> tuple[JudgedPaper, ...]:
        """Return the certificates that did not hold and were passed over."""
        if self.closed_as != "calibrated":
            return ()
        return tuple(one for one in self.certificates if not one.proves)


def judged_papers(papers: Iterable[Paper], on: date) -> tuple[JudgedPaper, ...]:
    """Return certificates as they stand on a day, in their order.

    Parameters
    ----------
    papers : iterable of Paper
    on : date
    """
    return tuple(JudgedPaper(paper, paper.standing(on)) for paper in papers)
