"""A campaign: one robot measured with one set-up, as tables of equal-length arrays.

Readings are positions, lengths or contacts, and each kind answers the same few questions (`observed_mm`,
`ends`, `seen_from`), so that nobody else asks which kind it is.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import date
from typing import Any, ClassVar, Final, Literal, TypeAlias

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray, Table, distinct_values
from truepose.domain.contacts import Target
from truepose.domain.robot import FixedNest, FramePlacement, Nest, Robot, WorldRegistration
from truepose.messages.message import Message, Text, message

Quantity = Literal["position", "length"]  # what the readings of a campaign are of
NO_AXIS = -1  # of a reading that is along no axis of a sensor


@dataclass(frozen=True, slots=True)
class Stops(Table):
    """What is known of the arm at each row, whatever was measured there; n rows, J joints.

    A missing optional column is None; a missing entry is NaN (0 in `direction`).
    """

    config: IntArray  # (n,) number of the configuration
    # The controller's nominal model turns the commanded ones into the pose that the identified model must
    # correct.
    joints_rad: FloatArray  # (n, J) commanded where the robot was commanded, else reported
    direction: IntArray | None = None  # (n, J) sign of each joint's last motion, 0 unknown
    time_s: FloatArray | None = None  # (n,)
    temperature_c: FloatArray | None = None  # (n,)
    attachment: IntArray | None = None  # (n,) how often the tool has been mounted
    torque_n_mm: FloatArray | None = None  # (n, J) measured joint torques
    group: IntArray | None = None  # (n,) rows measured in one go
    repeat_of: IntArray | None = None  # (n,) an earlier configuration with the same joints, -1 for none
    move_rad: FloatArray | None = None  # (n, J) how far each joint came from the stop before

    def __len__(self) -> int:
        return int(self.config.size)


@dataclass(frozen=True, slots=True)
class PointReadings(Table):
    """Positions of tool nests in the world frame; n rows."""

    quantity: ClassVar[Quantity] = "position"
    frozen_if_equal: ClassVar[bool] = True

    stops: Stops
    nest: IntArray  # (n,) 1-based
    position_mm: FloatArray  # (n, 3)
    standard_uncertainty_mm: FloatArray  # (n,) per axis
    covariance_mm2: FloatArray | None = None  # (n, 3, 3) where the file gives more than u_mm
    quaternion: FloatArray | None = None  # (n, 4) w first, orientation of the tool
    rotation_uncertainty_rad: FloatArray | None = None  # (n,) NaN: estimate from the residuals

    def __len__(self) -> int:
        return len(self.stops)

    @property
    def observed_mm(self) -> FloatArray:
        """What was read, shape (n, 3)."""
        return self.position_mm

    @property
    def ends(self) -> IntArray:
        """What tells the readings of one stop apart, shape (n, 1)."""
        return self.nest[:, None]

    @property
    def seen_from(self) -> IntArray:
        """Number of the place that each was read from, shape (n,): one instrument stands in one place."""
        return np.zeros(len(self), dtype=np.int64)


@dataclass(frozen=True, slots=True)
class LegReadings(Table):
    """Lengths between a base nest and a tool nest; n rows."""

    quantity: ClassVar[Quantity] = "length"
    frozen_if_equal: ClassVar[bool] = True

    stops: Stops
    placement: IntArray  # (n,) of the base fixture, from 1
    base_point: IntArray  # (n,)
    nest: IntArray  # (n,) tool point
    length_mm: FloatArray  # (n,)
    standard_uncertainty_mm: FloatArray  # (n,)
    initialisation: IntArray | None = None  # (n,) number of the last one on the calibrator

    def __len__(self) -> int:
        return len(self.stops)

    @property
    def observed_mm(self) -> FloatArray:
        """What was read, shape (n, 1)."""
        return self.length_mm[:, None]

    @property
    def ends(self) -> IntArray:
        """What tells the readings of one stop apart, shape (n, 2)."""
        return np.column_stack([self.nest, self.base_point])

    @property
    def cups(self) -> list[tuple[int, int]]:
        """Placement and base point of each leg."""
        return list(zip(self.placement.tolist(), self.base_point.tolist(), strict=True))

    @property
    def seen_from(self) -> IntArray:
        """Number of the cup that each was read from, shape (n,)."""
        cups = np.column_stack([self.placement, self.base_point])
        return np.unique(cups, axis=0, return_inverse=True)[1].reshape(-1)


@dataclass(frozen=True, slots=True)
class ContactReadings(Table):
    """What probes, gauges, wires and sensors read against targets; n rows."""

    quantity: ClassVar[Quantity] = "length"
    frozen_if_equal: ClassVar[bool] = False  # an arm that stops where its probe touches reads nothing but 0

    stops: Stops
    target: IntArray  # (n,) its number
    nest: IntArray  # (n,) of the tool, 1-based
    reading_mm: FloatArray  # (n,)
    standard_uncertainty_mm: FloatArray  # (n,)
    axis: IntArray | None = None  # (n,) 0 to 2 of the sensor in the tool, NO_AXIS where it has none

    def __len__(self) -> int:
        return len(self.stops)

    @property
    def observed_mm(self) -> FloatArray:
        """What was read, shape (n, 1)."""
        return self.reading_mm[:, None]

    @property
    def axes(self) -> IntArray:
        """Axis of the sensor of each reading, shape (n,)."""
        return np.full(len(self), NO_AXIS) if self.axis is None else self.axis

    @property
    def ends(self) -> IntArray:
        """What tells the readings of one stop apart, shape (n, 3)."""
        return np.column_stack([self.nest, self.target, self.axes])

    @property
    def seen_from(self) -> IntArray:
        """Number of the target that each was read against, shape (n,)."""
        return self.target


Readings: TypeAlias = PointReadings | LegReadings | ContactReadings
IdentifyingTable: TypeAlias = Literal["calibration", "legs", "contacts"]
# Of each, the table that judges a model of it; in the order in which they count.
_JUDGES: Final[Mapping[IdentifyingTable, str]] = {
    "calibration": "validation",
    "legs": "validation_legs",
    "contacts": "validation_contacts",
}


@dataclass(frozen=True, slots=True)
class FixedNestReadings:
    """The tracker's looks at fixed nests; n rows, world frame."""

    time_s: FloatArray
    fixed_nest: IntArray  # 1-based
    position_mm: FloatArray  # (n, 3)
    standard_uncertainty_mm: FloatArray

    def __len__(self) -> int:
        return int(self.fixed_nest.size)


@dataclass(frozen=True, slots=True)
class FixtureLengths:
    """Sides of the triangles, measured with the ballbar; n rows. Placement 0 is the tool."""

    placement: IntArray
    point_a: IntArray
    point_b: IntArray
    length_mm: FloatArray
    standard_uncertainty_mm: FloatArray


@dataclass(frozen=True, slots=True)
class CupSetups:
    """Joint angles at which the robot held the ball in tool nest 1 while a cup was clamped on it; n rows."""

    placement: IntArray
    base_point: IntArray
    joints_rad: FloatArray  # (n, J)


@dataclass(frozen=True, slots=True)
class CupReadings:
    """Tracker readings of base cups in the world frame of the validation: a judge, never used to identify."""

    placement: IntArray
    base_point: IntArray
    position_mm: FloatArray  # (n, 3)
    standard_uncertainty_mm: FloatArray


@dataclass(frozen=True, slots=True)
class TargetDistances:
    """Certified distances between the centres of two targets; n rows."""

    target_a: IntArray
    target_b: IntArray
    distance_mm: FloatArray
    standard_uncertainty_mm: FloatArray


@dataclass(frozen=True, slots=True)
class ReadingName:
    """What tells a reading from the others of its campaign."""

    config: int
    nest: int  # of the tool, 1-based
    base_point: int | None = None  # of a length; None: from whichever
    target: int | None = None  # of a contact; None: against whichever


@dataclass(frozen=True, slots=True)
class ReadingsSetAside:
    """Readings without which a person wants a campaign to be analysed, and why."""

    readings: tuple[ReadingName, ...]
    reason: str  # of all of them; several are joined
    person: str
    rows: tuple[int, ...] = ()  # of their table, ascending; a sensor has one for each of its axes
    reasons: tuple[str, ...] = ()  # of each reading, in their order; empty: `reason` is that of all

    @property
    def reason_of_each(self) -> tuple[str, ...]:
        """Why each of the readings is set aside, in their order."""
        return self.reasons or (self.reason,) * len(self.readings)

    @property
    def sentence(self) -> Message:
        """What whoever reads a result made without them has to know."""
        # On one line, and closed by the catalogue, whose languages have full stops of their own.
        whys = self.reason_of_each or (self.reason,)
        reasons = tuple(dict.fromkeys(" ".join(one.split()).rstrip(".。") for one in whys))
        told: Text = reasons[0]
        if len(reasons) > 1:
            each = tuple(message("set_aside.reason", reason=reason) for reason in reasons)
            told = message("set_aside.listed", readings=each)
        return message("set_aside", n=len(self.rows), person=self.person, reason=told)

    def row_in_table(self, row: int) -> int:
        """Return where a reading stands in its table, by its row among those that are left."""
        for aside in self.rows:
            row += aside <= row
        return row


@dataclass(frozen=True, slots=True)
class Campaign:
    """One robot, one set-up, its readings and what is known beforehand."""

    robot: Robot
    base_nominal: FramePlacement | None  # None: found from the data
    nests: tuple[Nest, ...]
    gravity_m_s2: tuple[float, float, float] = (0.0, 0.0, -9.81)  # world frame
    calibration: PointReadings | None = None
    validation: PointReadings | None = None
    reference: FixedNestReadings | None = None
    # As lengths, never as poses: the errors of the cups are shared by all poses of a placement, and a
    # covariance that says so would have to be carried along (docs/decisions/0017).
    legs: LegReadings | None = None
    validation_legs: LegReadings | None = None
    fixture: FixtureLengths | None = None
    setup: CupSetups | None = None
    cups: CupReadings | None = None
    contacts: ContactReadings | None = None
    validation_contacts: ContactReadings | None = None
    targets: tuple[Target, ...] = ()  # of the contacts
    target_distances: TargetDistances | None = None
    repeatability_in_uncertainty: bool = False  # u_mm already contains the robot's repeatability
    tracker_position_mm: tuple[float, float, float] | None = None
    # Of the measured orientations' frame in the last one, per axis: it is that frame to this; None: it is
    # whatever the readings show.
    tool_rotation_uncertainty_rad: float | None = None
    fixed_nests: tuple[FixedNest, ...] = ()
    registration: WorldRegistration | None = None
    ballbar_nominal_mm: float | None = None
    ballbar_range_mm: float | None = None
    setup_uncertainty_mm: float | None = None
    simulated: bool | None = None  # no robot and no instrument took part; None: nobody said
    # The day on which a file came says nothing of when it was measured: without this it has no place in time.
    measured_on: date | None = None  # None: nobody said
    robot_serial_number: str = ""  # empty: nobody said
    instrument_serial_number: str = ""  # of the one that read all of it; empty: nobody said, or several did
    notes: tuple[str, ...] = ()
    # Told, not dropped: a misspelt column would else count as one that was never measured.
    ignored: tuple[Text, ...] = ()  # columns and keys kept but not understood, one sentence each
    set_aside: ReadingsSetAside | None = None  # by a person, of the readings that identify; in no table

    @property
    def identified_from(self) -> IdentifyingTable | None:
        """The table that the robot is identified from; one without rows does not count, None where none does.

        Positions first: they alone see where the arm stands in the world.
        """
        return next((table for table in _JUDGES if getattr(self, table)), None)

    @property
    def readings(self) -> Readings | None:
        """What the robot is identified from: positions where there are any, else legs, else contacts."""
        table = self.identified_from
        found: Readings | None = None if table is None else getattr(self, table)
        return found

    @property
    def held_out(self) -> Readings | None:
        """What judges a model of these readings: others of the same kind; None where there are none."""
        table = self.identified_from
        found: Readings | None = None if table is None else getattr(self, _JUDGES[table])
        return found or None

    @property
    def scatter_mm(self) -> float:
        """Scatter of the arm per axis beside the stated uncertainties; 0 where they contain it."""
        return 0.0 if self.repeatability_in_uncertainty else self.robot.repeatability_mm

    def of_rows(self, rows: IntArray) -> "Campaign":
        """Return the campaign with some of the readings that identify.

        Parameters
        ----------
        rows : ndarray of int, shape (m,)
            Of `readings`.
        """
        table, readings = self.identified_from, self.readings
        if table is None or readings is None:
            return self
        some: dict[str, Any] = {table: readings.taken(rows)}
        return replace(self, **some)


Values: TypeAlias = tuple[float | None, ...]  # of one reading, a column each; None: it was not read


@dataclass(frozen=True, slots=True)
class Series:
    """What a program delivers: its columns are named as in the table that it would otherwise write."""

    name: str
    columns: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Delivery:
    """Some readings of a series, in one piece; `first` is the number of the first of them."""

    first: int
    readings: tuple[Values, ...]

    @property
    def next_number(self) -> int:
        """The number of the reading that follows."""
        return self.first + len(self.readings)


def each_nest(stops: Stops, nests: IntArray) -> tuple[Stops, IntArray]:
    """Return every stop once per nest.

    Parameters
    ----------
    stops : Stops
        n rows.
    nests : ndarray of int, shape (k,)

    Returns
    -------
    stops : Stops
        n k rows, stops in their order.
    nest : ndarray of int, shape (n k,)
    """
    rows = np.repeat(np.arange(len(stops)), len(nests))
    return stops.taken(rows), np.tile(nests, len(stops))


def sites(stops: Stops) -> IntArray:
    """Return the configuration of each row, a revisit counting as the one it revisits.

    Revisits of revisits lead back to the first; names that go round in a circle count as one site.

    Parameters
    ----------
    stops : Stops
        n rows.

    Returns
    -------
    ndarray of int, shape (n,)
    """
    if stops.repeat_of is None:
        return stops.config
    named = stops.repeat_of >= 0
    earlier = dict(zip(stops.config[named].tolist(), stops.repeat_of[named].tolist(), strict=True))
    first = {config: _first(config, earlier) for config in distinct_values(stops.config).tolist()}
    return np.array([first[config] for config in stops.config.tolist()], dtype=np.int64)


def _first(config: int, earlier: Mapping[int, int]) -> int:
    """Return the configuration that a row of revisits leads back to; of a circle its least number."""
    seen: list[int] = []
    while config in earlier and config not in seen:
        seen.append(config)
        config = earlier[config]
    return min(seen[seen.index(config) :]) if config in seen else config
