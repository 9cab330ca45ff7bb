"""A session: one run of a plan with fixed artefacts, tool and base placement."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from typing import Final, Literal, TypeAlias

from truepose.domain.arrays import FloatArray
from truepose.messages.message import Text

IdentityOf: TypeAlias = Literal["tracker", "robot", "ballbar"]
Finding: TypeAlias = Literal[
    "first",  # the session measures with this one; nobody had to be asked
    "same",  # it answers again, after it had said nothing or another one was there
    "silent",  # it told its serial number before and does not any more
    "foreign",  # not the one that is expected; nothing is measured before a person has accepted it
    # Never of a robot: limits, nominal model and readings are of one arm (docs/decisions/0020).
    "accepted",  # a person accepted it in place of the one that was expected
]


@dataclass(frozen=True, slots=True)
class IdentityTaken:
    """What a device answered when it was asked who it is, where that says anything new."""

    device: IdentityOf
    finding: Finding
    serial: str  # as it answered; empty: it does not say
    expected: str = ""  # of the cell file, or of the session so far; empty: nothing was
    person: str | None = None  # who accepted it


Vector = tuple[float, float, float]


class SessionState(StrEnum):
    """State of a session."""

    # `sessions.engine.states` holds the table of transitions.
    PLANNED = "planned"
    RUNNING = "running"
    # Some controllers cannot stop a motion: between the wish and its effect the arm still goes.
    PAUSING = "pausing"  # asked for; takes effect when the motion under way has ended
    PAUSED = "paused"
    # Entered at the start, after a lost link and after a restart: whoever pulled a cable may stand in the
    # cell.
    AWAITING_CONFIRMATION = "awaiting_confirmation"  # a person confirms before anything moves
    ABORTING = "aborting"  # asked for; takes effect when the motion under way has ended
    ABORTED = "aborted"
    FINISHED = "finished"
    FAILED = "failed"


Role = Literal["calibration", "validation"]  # of readings of points
Measured = Literal["points", "poses"]  # by a tracker, or by a camera, which tells orientations too
SessionRole = Literal["calibration", "validation", "ballbar", "contacts"]
PlaceOf = Literal["work", "approach", "stop"]  # what the arm is somewhere for


@dataclass(frozen=True, slots=True)
class Work:
    """Whole rounds of motions before a stop, by which the arm warms up; one that is late does without."""

    until_s: float  # cell time after the first reading of the session
    places_rad: tuple[tuple[float, ...], ...]


@dataclass(frozen=True, slots=True)
class PlannedStop:
    """One configuration to visit and the nest to measure there."""

    config: int  # number in the campaign, unique in the session
    joints_rad: tuple[float, ...]
    nest: int  # 1-based tool nest that faces the tracker
    repeat_of: int | None = None  # an earlier configuration with the same joints: pure error
    begin_rad: tuple[float, ...] | None = None  # of the last motion to it; None: as the plan has it
    group: int | None = None  # of the readings that belong together: one direction, or one hour of warm-up
    work: Work | None = None

    def approach_rad(self, offset_rad: float | None) -> tuple[float, ...] | None:
        """Return where the last motion begins; None where the arm comes from wherever it was.

        Parameters
        ----------
        offset_rad : float or None
            On all joints, where the stop itself does not say.

        Returns
        -------
        tuple of float, length J, or None
            [rad]
        """
        if self.begin_rad is not None or offset_rad is None:
            return self.begin_rad
        return tuple(joint + offset_rad for joint in self.joints_rad)

    def places(self, offset_rad: float | None) -> Iterator[tuple[PlaceOf, tuple[float, ...]]]:
        """Yield where the arm goes for this stop, in that order.

        Parameters
        ----------
        offset_rad : float or None
            As of `approach_rad`.

        Yields
        ------
        place : PlaceOf
            work, approach, then stop.
        joints_rad : tuple of float, length J
        """
        for place_rad in () if self.work is None else self.work.places_rad:
            yield "work", place_rad
        begin_rad = self.approach_rad(offset_rad)
        if begin_rad is not None:
            yield "approach", begin_rad
        yield "stop", self.joints_rad


@dataclass(frozen=True, slots=True)
class Turn:
    """Through which angles one joint is turned while all others stand.

    Source: thesis of A. Nubiola, 2014, section 2.4.1 (table 2.3: one joint at a time, in both directions).
    """

    joint: int  # 1-based
    lower_rad: float
    upper_rad: float
    step_rad: float


@dataclass(frozen=True, slots=True)
class SessionPlan:
    """What a tracker session will do, in order; can be listed and dry-run before anything moves."""

    role: Role
    stops: tuple[PlannedStop, ...]
    # From one side, so that backlash is an offset of the zeros: thesis section 2.4.
    approach_offset_rad: float | None = -0.0872664626  # -5 deg on all joints; None: mixed directions
    settle_s: float = 4.0  # thesis section 2.4
    measure_s: float = 1.0
    search_radius_mm: float = 10.0
    tool_speed_mm_s: float = 500.0
    orientation_speed_rad_s: float = 0.349
    # A tracker that drifts or was pushed moves all readings alike, and only the fixed nests tell it from the
    # base.
    reference_every: int = 10  # fixed nests are read before, after every so many configurations, and after
    reference_limit_mm: float = 0.1  # a fixed nest that moved further pauses the session
    registration_readings: int = 20  # of each fixed nest at the start
    two_face_check: bool = True
    two_face_limit_mm: float = 0.1  # half the difference of the faces; beyond it the session pauses
    joint_tolerance_rad: float = 0.00035  # reported against commanded; the protocol rounds to 0.01 deg
    rms_limit_mm: float = 0.1  # scatter within a reading; the table moves 0.01, the tracker scatters 0.03
    failures_in_a_row: int = 3  # so many configurations without a reading pause the session
    ends_when_settled: bool = False  # leaves out further groups once drift has become slow
    measures: Measured = "points"
    # By what readings say and not by the clock: half an hour is too much after a pause and too little in a
    # cold hall.
    warm_up: bool = False  # the fixed nests are read until the tracker drifts no more


@dataclass(frozen=True, slots=True)
class PointTaken:
    """A reading of a tool nest, with everything known of the stop; world frame where registered."""

    config: int
    nest: int
    commanded_rad: tuple[float, ...]
    reported_rad: tuple[float, ...]
    direction: tuple[int, ...]
    time_s: float
    temperature_c: float
    attachment: int
    # Both frames are kept: a registration may be given up later, and what was read stays.
    position_tracker_mm: Vector
    position_world_mm: Vector
    standard_uncertainty_mm: float
    rms_mm: float
    samples: int
    repeat_of: int | None = None
    # Of the reading, world frame; None where the instrument states a standard uncertainty only.
    covariance_mm2: tuple[Vector, Vector, Vector] | None = None
    # With each reading: an instrument can be exchanged behind a bridge without its link going down.
    instrument_serial: str = ""  # as the tracker says it; empty where it does not
    group: int | None = None  # as planned
    quaternion: tuple[float, float, float, float] | None = None  # w first, world frame; None: none is read
    rotation_uncertainty_rad: float | None = None  # of it, per axis


@dataclass(frozen=True, slots=True)
class FixedNestTaken:
    """A reading of a fixed nest; `phase` says in which part of the session."""

    phase: Literal["warm_up", "registration", "two_face", "reference"]
    fixed_nest: int
    face: Literal[1, 2]
    time_s: float
    position_tracker_mm: Vector
    position_world_mm: Vector | None  # None until the registration is known
    standard_uncertainty_mm: float
    instrument_serial: str = ""


@dataclass(frozen=True, slots=True)
class StopSkipped:
    """A configuration that was not measured, and why; never filled in."""

    config: int
    time_s: float
    reason: Text


@dataclass(frozen=True, slots=True)
class Registration:
    """The tracker's place in the world, from the fixed nests: x_world = R x_tracker + t.

    Attributes
    ----------
    rotation : ndarray, shape (3, 3)
    translation_mm : ndarray, shape (3,)
    covariance : ndarray, shape (6, 6)
        Of a small motion about the world origin: [mm, rad].
    rms_mm : float
        Of the fixed nests' residuals after the rigid motion.
    two_face_mm : float or None
        Half the difference between the faces.
    scale : float or None
        Certified over measured lengths; None: scale not verified.
    scale_standard_uncertainty : float or None
    instrument_serial : str
        Of the tracker that it is the place of.
    """

    rotation: FloatArray  # (3, 3)
    translation_mm: FloatArray  # (3,)
    covariance: FloatArray  # (6, 6) of a small motion about the world origin: [mm, rad]
    rms_mm: float  # of the fixed nests' residuals after the rigid motion
    two_face_mm: float | None  # half the difference between the faces
    scale: float | None = None  # certified over measured lengths; None: scale not verified
    scale_standard_uncertainty: float | None = None
    instrument_serial: str = ""  # of the tracker that it is the place of


@dataclass(frozen=True, slots=True)
class Progress:
    """How far a session is."""

    done: int
    skipped: int
    planned: int
    elapsed_s: float
    remaining_s: float | None
    doing: Text


_STOP: Final = "stop"
_STOP_ID: Final = re.compile(rf"{_STOP}-(0|[1-9][0-9]{{0,17}})")


def stop_id(config: int) -> str:
    """Return the name of the step that measures a configuration, e.g. `stop-12`."""
    return f"{_STOP}-{config}"


def config_of(step_id: str) -> int | None:
    """Return the configuration that a step measures; None where it measures none, or is no step at all.

    Parameters
    ----------
    step_id : str
        As of `stop_id`, of another step, or whatever somebody asks for.
    """
    found = _STOP_ID.fullmatch(step_id)
    return int(found[1]) if found else None
