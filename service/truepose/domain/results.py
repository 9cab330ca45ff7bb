"""What identifications and validations answer."""

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Literal

from truepose.domain.arrays import FloatArray
from truepose.domain.robot import FramePlacement, JointRange, Robot
from truepose.domain.sentences import Text
from truepose.domain.targets import Target

Unit = Literal[
    "mm",
    "rad",
    "rad/(N*mm)",
    "rad*s2/m",
    "1",
    "1/K",
    "mm/h",
    "rad/h",
    "rad/K",
    "kg",
    "kg*mm",
    "1/(N*mm2)",
    "mm/N",
]

_HISTOGRAM_DECIMALS = 9  # widths are whole powers of ten, which binary fractions only nearly are
DecisionRule = Literal["guard band", "simple"]
Verdict = Literal["conforms", "does not conform", "cannot be decided"]


@dataclass(frozen=True, slots=True)
class Statistics:
    """Norms of errors of n observations [mm]; `noise_mm` is the mean norm that stated noise alone gives."""

    n: int
    mean_mm: float
    rms_mm: float
    sd_mm: float
    max_mm: float
    noise_mm: float


@dataclass(frozen=True, slots=True)
class TurnStatistics:
    """Angles [rad] between n measured orientations and a model's; `noise_rad`: mean of stated noise alone."""

    n: int
    mean_rad: float
    rms_rad: float
    sd_rad: float
    max_rad: float
    noise_rad: float  # NaN where the readings state nothing


@dataclass(frozen=True, slots=True)
class TurnPair:
    """The same for the nominal model and the identified one."""

    nominal: TurnStatistics
    identified: TurnStatistics


@dataclass(frozen=True, slots=True)
class Parameter:
    """An identified parameter, in internal units (angles in rad)."""

    name: str
    effect: str
    value: float
    unit: Unit
    standard_uncertainty: float
    prior_width: float


class Status(StrEnum):
    """How an identification ended."""

    CONVERGED = "converged"
    NOT_CONVERGED = "not_converged"
    TOO_FEW_DATA = "too_few_data"
    WRONG_NOMINAL_MODEL = "wrong_nominal_model"
    OUTLIERS_DOMINATE = "outliers_dominate"


@dataclass(frozen=True, slots=True)
class NotIdentifiable:
    """Parameters that the data see only together, or not at all, and why."""

    parameters: tuple[str, ...]
    reason: Text  # without a full stop: it stands in the midst of what is told


@dataclass(frozen=True, slots=True)
class Outlier:
    """A reading that was given no weight, and why; it stays in the data."""

    row: int  # 0-based row of its table
    config: int
    nest: int
    residual_mm: float
    reason: Text  # without a full stop, as above


@dataclass(frozen=True, slots=True)
class NestCentre:
    """A tool nest as the model holds it [mm, last frame]."""

    nest: int
    centre_mm: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Anchor:
    """A base nest whose place the legs gave [mm, world frame]."""

    placement: int
    base_point: int
    centre_mm: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class MeasuredZone:
    """Where the arm was when it was measured: outside of it a model extrapolates."""

    joint_ranges: tuple[JointRange, ...]
    extents_mm: tuple[float, ...]  # of the last frame's origin in the robot's base, along `zone.DIRECTIONS`


@dataclass(frozen=True, slots=True)
class Shortfall:
    """What a model of P parameters lacks, as far as its readings show it: c functions of single joints."""

    functions: tuple[Parameter, ...]  # (c,) values and widths as the readings ask for
    covariance: FloatArray  # (c, c)
    absorbed: FloatArray  # (P, c) what the parameters have taken over of each
    rest_mm: float  # per axis: what none of them expresses


@dataclass(frozen=True, slots=True)
class Model:
    """An identified model: the nominal robot, its effects and their parameters; predicts any configuration.

    `covariance` is that of `parameters` in their order and internal units; it contains what certified
    nests and the registration of the world frame add.
    """

    robot: Robot
    base: FramePlacement  # start value of the base; the parameters base_* are added to it
    nests: tuple[NestCentre, ...]  # start values; parameters nest_* are added to them
    tool_rotation_rad: tuple[float, float, float]  # start value of the tool's orientation: RotX RotY RotZ
    effects: tuple[str, ...]
    parameters: tuple[Parameter, ...]
    covariance: FloatArray
    gravity_m_s2: tuple[float, float, float]
    discrepancy_mm: float  # per axis: what held-out residuals show beyond noise, scatter and parameters
    repeatability_mm: float
    nominal_base: FramePlacement  # nominal model with only base and unknown nests fitted
    nominal_nests: tuple[NestCentre, ...]
    nominal_tool_rotation_rad: tuple[float, float, float] = (0.0, 0.0, 0.0)
    instrument_mm: tuple[float, float, float] | None = None  # place of the instrument in the world
    torques_measured: bool = False  # compliance was identified from measured joint torques
    origin_s: float = 0.0  # time from which drifts and warm-ups count
    nominal_leg_offset_mm: float = 0.0
    nominal_anchors: tuple[Anchor, ...] = ()
    targets: tuple[Target, ...] = ()  # of contacts; the parameters target_* start from their places
    nominal_targets: tuple[float, ...] = ()  # what these parameters are around the nominal robot
    zone: MeasuredZone | None = None  # None: nobody said
    shortfall: Shortfall | None = None  # None: the discrepancy stands for it, the same everywhere
    identified_from: dict[str, str | int | float] = field(default_factory=dict)
    program_version: str = ""


@dataclass(frozen=True, slots=True)
class Counts:
    """How many of what took part."""

    configurations: int
    observations: int
    parameters: int
    outliers: int


@dataclass(frozen=True, slots=True)
class NominalAndIdentified:
    """The same statistics for the nominal model (base and unknown nests fitted) and the identified one."""

    nominal: Statistics
    identified: Statistics


@dataclass(frozen=True, slots=True)
class Histogram:
    """Counts in bins of one width; bin k, counted from 0, begins at (first + k) * width_mm."""

    width_mm: float
    first: int
    counts: tuple[int, ...]

    @property
    def from_mm(self) -> float:
        """Where the first bin begins."""
        return round(self.first * self.width_mm, _HISTOGRAM_DECIMALS)


@dataclass(frozen=True, slots=True)
class SignedErrors:
    """What the signs of errors tell, seen minus predicted: a scale is wrong where most have one sign."""

    mean_mm: float
    positive_share: float
    histogram: Histogram


@dataclass(frozen=True, slots=True)
class DistanceErrors:
    """Errors of the distances between all pairs of points."""

    nominal: SignedErrors
    identified: SignedErrors


@dataclass(frozen=True, slots=True)
class Shell:
    """Errors of the readings at some distance from something."""

    from_mm: float
    to_mm: float
    errors: NominalAndIdentified


@dataclass(frozen=True, slots=True)
class BranchErrors:
    """Errors of the readings in one posture of the arm."""

    branch: str  # "front/up/no flip"
    errors: NominalAndIdentified


@dataclass(frozen=True, slots=True)
class ErrorsByPlace:
    """Where errors are large; shells and branches without a reading are left out."""

    zone_centre_mm: tuple[float, float, float]  # world: of the last frame's places
    zone_radius_mm: float  # no place of the zone is farther from its middle
    zone_stated: bool  # by the model; else it is that of the readings that judge
    from_zone: tuple[Shell, ...]  # distance of the last frame from the middle of the zone
    from_axis: tuple[Shell, ...]  # distance of the last frame from the line of axis 1
    branches: tuple[BranchErrors, ...]


@dataclass(frozen=True, slots=True)
class Decision:
    """Whether the largest error stays within a limit, and the reading that decides it."""

    rule: DecisionRule
    limit_mm: float
    error_mm: float
    guard_mm: float  # by which the error must stay away from the limit for anything to be proved
    verdict: Verdict


@dataclass(frozen=True, slots=True)
class PositionsJudged:
    """A model of lengths against held-out positions, whose frame lengths leave open."""

    tied: NominalAndIdentified | None  # by the base cups, as measured in the frame of the positions
    aligned: NominalAndIdentified  # after the best rigid alignment


@dataclass(frozen=True, slots=True)
class PureError:
    """What revisited configurations say: repeatability, and whether the model lacks something beyond it."""

    revisits: int
    degrees_of_freedom: int
    repeatability_mm: float  # standard deviation per axis of one reading, from revisits alone
    lack_of_fit_ratio: float  # F statistic of lack of fit over pure error
    p_value: float


@dataclass(frozen=True, slots=True)
class Identification:
    """The answer of an identification, whatever its status."""

    status: Status
    message: Text
    effects: tuple[str, ...]
    counts: Counts
    parameters: tuple[Parameter, ...]
    not_identifiable: tuple[NotIdentifiable, ...]
    outliers: tuple[Outlier, ...]
    quantity: Literal["position", "length"]
    calibration: NominalAndIdentified | None
    validation: NominalAndIdentified | None
    cross_validation: NominalAndIdentified | None
    calibration_without_outliers: NominalAndIdentified | None
    chi2_per_dof: float
    pure_error: PureError | None
    model: Model | None  # None where nothing could be fitted
    positions: PositionsJudged | None = None  # of a model of lengths
    relative: NominalAndIdentified | None = None  # held-out positions after the best rigid alignment
    calibration_turns: TurnPair | None = None  # None: no orientations were used
    validation_turns: TurnPair | None = None


@dataclass(frozen=True, slots=True)
class FigureUncertainty:
    """Standard uncertainties of statistics, each of the figure of that name [mm]."""

    mean_mm: float
    rms_mm: float
    sd_mm: float
    max_mm: float
    signed_mean_mm: float | None = None  # of the mean with sign; None where no signs are told


@dataclass(frozen=True, slots=True)
class UncertaintyPair:
    """Uncertainties of the same figures for the nominal model and the identified one."""

    nominal: FigureUncertainty
    identified: FigureUncertainty


@dataclass(frozen=True, slots=True)
class ValidationUncertainty:
    """How well the figures of a validation are known."""

    position: UncertaintyPair | None = None
    relative: UncertaintyPair | None = None
    distance: UncertaintyPair | None = None


@dataclass(frozen=True, slots=True)
class Validation:
    """A model against points it was not made from."""

    quantity: Literal["position", "length"]
    position: NominalAndIdentified
    distance: NominalAndIdentified | None
    limit_mm: float | None
    passed: bool
    claimed_mm: float = float(
        "nan"
    )  # mean error that the model's own uncertainty and the readings' let expect
    distance_errors: DistanceErrors | None = None  # with sign; None where `distance` is
    places: ErrorsByPlace | None = None  # None: of a program that did not tell it yet
    decision: Decision | None = None  # None without a limit
    relative: NominalAndIdentified | None = None  # after the best rigid alignment; None of lengths
    uncertainty: ValidationUncertainty | None = None  # None: of a program that did not tell it yet
    turns: TurnPair | None = None  # None: no orientations were read, or the model knows none
