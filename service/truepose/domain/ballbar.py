"""The ballbar as a 6D instrument: what a session plans, keeps and expects of lengths and poses."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Final, Literal, TypeAlias

from truepose.domain.arrays import FloatArray
from truepose.domain.cell import Artefact as Artefact
from truepose.domain.cell import BallbarKit as BallbarKit
from truepose.domain.cell import Bars as Bars
from truepose.domain.identification import Model
from truepose.domain.robot import FramePlacement

Vector: TypeAlias = tuple[float, float, float]
Leg: TypeAlias = tuple[int, int]  # base point (1..3 or 4), tool point (1..3)
BallbarTest: TypeAlias = Literal["sphere"]  # one leg a pose, from cup 1: validates, identifies nothing
BarSet: TypeAlias = Literal["tool", "base"]  # bars for the tool triangle; for base triangle and legs


@dataclass(frozen=True, slots=True)
class PlannedSetup:
    """Where the robot holds the setting ball, in tool nest 1, while a base cup is clamped on it."""

    base_point: int
    joints_rad: tuple[float, ...]
    via_rad: tuple[tuple[float, ...], ...] = ()  # clear way to it from the stop before


@dataclass(frozen=True, slots=True)
class PlannedAway:
    """Where the arm waits off the cups while the ball is taken out and the base triangle is measured."""

    joints_rad: tuple[float, ...]
    via_rad: tuple[tuple[float, ...], ...] = ()  # clear way to it from the last set-up


@dataclass(frozen=True, slots=True)
class PlannedPose:
    """One configuration and the legs that are measured in it."""

    config: int  # number in the campaign, unique in the session
    placement: int  # of the base fixture, from 1
    joints_rad: tuple[float, ...]
    legs: tuple[Leg, ...]  # in the order in which the person connects them
    # All legs are nominally as long as each other; lengths that differ on purpose tell which pair was
    # connected.
    aimed_mm: tuple[float, ...] | None = None  # coded length of each leg; None: all at the nominal length
    via_rad: tuple[tuple[float, ...], ...] = ()  # clear way to it from the stop before
    assembly: str = ""  # which of the assemblies of the pose device, in words


@dataclass(frozen=True, slots=True)
class PlannedPlacement:
    """One place of the base fixture with everything that is measured from it."""

    number: int  # from 1
    frame: FramePlacement  # of the base triangle in the world: B1 its origin, B2 on x, B3 in the xy plane
    cups_mm: tuple[Vector, ...]  # nominal, in the world, base points 1, 2, 3 (4)
    setups: tuple[PlannedSetup, ...]
    poses: tuple[PlannedPose, ...]
    # Over a clamped cup the tool nest is where the end of the ballbar has to go, and the ball cannot come
    # out.
    away: PlannedAway | None = None  # None: planned before there was one; the arm stays at the last set-up


@dataclass(frozen=True, slots=True)
class BallbarPlan:
    """What a ballbar session will do; the steps follow from it and from what has been kept so far."""

    placements: tuple[PlannedPlacement, ...]
    # Poses after which a fit foresees lengths well enough to aim by: of fewer it claims 0.02 to 0.1 mm on a
    # robot with several error sources and misses by 0.2 to 0.9.
    precalibrate_after: int = 12  # measured poses after which targets are aimed by what was found
    test: BallbarTest | None = None  # None: six legs a pose, from which a model is identified
    model_id: int | None = None  # of a test: the stored model that commands the arm; None: the nominal one
    check_at_end: bool = False  # whether one more pre-calibration tests what was measured since the last
    settle_s: float = 2.0
    stable_s: float = 1.0  # so long a length must stand still before it is stored by itself
    stable_mm: float = 0.002  # spread that counts as standing still: four times the reading's scatter
    state_age_s: float = 2.0  # no motion on a robot state older than this
    # Half of what a tracker session moves at, where nobody is in the cell.
    tool_speed_mm_s: float = 250.0  # a person is near
    orientation_speed_rad_s: float = 0.349  # 20 deg/s, thesis section 2.4
    joint_tolerance_rad: float = 0.00035  # reported against commanded; the protocol rounds to 0.01 deg


@dataclass(frozen=True, slots=True)
class SpherePlanRequest:
    """What is wanted of a sphere test."""

    nests: tuple[int, ...] = (1, 2)  # one after the other
    # Not the 90 to 123 of the thesis: a stop takes twenty seconds of a person, and means are as uncertain as
    # the errors of the arm are varied, not as the bar reads (docs/decisions/0045).
    stops: int = 24  # of each nest
    model: Model | None = None  # that commands the arm; None: the nominal one
    model_id: int | None = None  # of the model


class StepKind(StrEnum):
    """Kind of a step."""

    INITIALISE = "initialise"  # person: ballbar on the calibrator; its zero is read
    MEASURE_SIDE = "measure_side"  # person: ballbar between two nests of one triangle; a length is read
    PLACE_BASE = "place_base"  # person: put the base fixture down, release its cups
    FIT_BALL = "fit_ball"  # person: setting ball into tool nest 1
    MOVE = "move"  # robot: moves, once a person has confirmed that the cell is clear
    CLAMP_CUP = "clamp_cup"  # person: let the cup snap on the ball and clamp it
    REMOVE_BALL = "remove_ball"  # person: take the setting ball out of the tool nest
    CONNECT_LEG = "connect_leg"  # person: ballbar between base cup and tool nest; a length is read
    DETACH = "detach"  # person: ballbar off and out of the arm's way
    PRECALIBRATE = "precalibrate"  # service: identify with what is there, aim the rest, test assignments


@dataclass(frozen=True, slots=True)
class BallbarStep:
    """One thing to do; listed beforehand, done at most once in effect."""

    id: str  # stable, e.g. "placement-1/pose-12/leg-2-3"
    kind: StepKind
    placement: int | None = None
    config: int | None = None  # pose; None for what is not of a pose
    artefact: BarSet | None = None  # initialise: which bars; measure_side: which triangle
    points: tuple[int, int] | None = None  # measure_side: two points; connect_leg: (base point, tool point)
    base_point: int | None = None  # clamp_cup, and the move towards it
    target_rad: tuple[float, ...] | None = None  # move
    via_rad: tuple[tuple[float, ...], ...] = ()  # move
    expected_mm: float | None = None  # nominal, coded or foreseen length
    attempt: int = 1  # of the pose: 2 when it is tried again after the targets were aimed anew


@dataclass(frozen=True, slots=True)
class LengthTaken:
    """A length as it was stored, with everything that it rests on."""

    length_mm: float  # calibrator + deviation - zero; of an initialisation: the calibrator's
    deviation_mm: float  # what the ballbar showed, mean over the window
    zero_mm: float  # what it showed on the calibrator
    standard_uncertainty_mm: float
    spread_mm: float
    samples: int
    initialisation: int  # number of the last one in the session, from 1
    by_hand: bool  # stored by the button, not by itself
    temperature_c: float
    # Zero and certificate are of one instrument: after an exchange lengths are told apart by it.
    instrument_serial: str
    certificate: str
    certificate_expires: str  # ISO date, empty where nobody said it
    time_s: float  # cell clock, end of the window


@dataclass(frozen=True, slots=True)
class ArrivalTaken:
    """Where the robot came to rest."""

    commanded_rad: tuple[float, ...]
    reported_rad: tuple[float, ...]
    direction: tuple[int, ...]  # sign of each joint's last motion, 0 where it never moved
    time_s: float


@dataclass(frozen=True, slots=True)
class PoseForecast:
    """Lengths foreseen at one configuration, of every pair of base cup and tool nest."""

    config: int
    legs: tuple[Leg, ...]
    length_mm: tuple[float, ...]
    # Of all pairs at once: the errors of one pose are shared, and an exchange of two legs is told by their
    # difference.
    covariance_mm2: tuple[tuple[float, ...], ...]  # of the errors of these forecasts, arm's scatter included


@dataclass(frozen=True, slots=True)
class PreCalibration:
    """What was found halfway: where to aim from now on, and which lengths to expect there."""

    # A pose that was skipped because its lengths were out of the bar's range may be in it once it is aimed
    # anew.
    poses: tuple[PlannedPose, ...]  # those not measured yet and those skipped, with coded targets
    forecasts: tuple[PoseForecast, ...]  # of all poses, measured ones included
    rms_mm: float  # of the legs it rests on
    configurations: int
    exchanged: tuple[int, ...] = ()  # measured configurations whose legs were confused: to be measured again


SuspicionKind: TypeAlias = Literal[
    "same_pair",
    "other_pair",
    "exchanged",
    "unlikely",
    "calibrator",  # the ballbar seems to be on the calibrator, where a pair was asked for
    "like_calibrator",  # a side of the calibrator's length: nobody can tell which of them was read
    # A bar that was put back on the calibrator would else store its length as that of a leg
    # (docs/decisions/0018).
    "same_connection",  # it was not let go since a length was taken that is not what is asked for
    "not_calibrator",  # a zero so far from the one before that one of them was not read on the calibrator
    "same_bars",  # the zero is that of the other bars
]


@dataclass(frozen=True, slots=True)
class Suspicion:
    """A reading that does not go with the pair that was asked for."""

    kind: SuspicionKind
    asked: Leg
    suspected: Leg | None  # the pair that the reading goes with; None where there is none
    length_mm: float
    expected_mm: float | None


TOLD_APART: Final = 3.0  # standard uncertainties by which two lengths must differ for a swap to be seen


@dataclass(frozen=True, slots=True, eq=False)
class StopLengths:
    """Lengths at one stop of the arm, or between cups: length = nominal + slope x + motion m."""

    pairs: tuple[Leg, ...]  # p of them; cup and nest, or cup and cup
    nominal_mm: FloatArray  # (p,) of the nominal arm with its cups where it holds the ball
    slope: FloatArray  # (p, S) per unit of what is unknown of the session
    motion: FloatArray  # (p, 6) per mm of a shift of the tool, and of a turn at a lever; 0 between cups


@dataclass(frozen=True, slots=True, eq=False)
class ArmKind:
    """How far off an arm may be: one of several suppositions, of which the readings tell the likeliest."""

    share: float  # of all arms
    mean: FloatArray  # (S,) of what is unknown, in the units of the slopes
    covariance: FloatArray  # (S, S)
    motion_mm: float  # by which the tool comes to rest elsewhere at each stop than a model says, per axis
