"""What identifications and validations answer.

Internal units: mm, rad, N mm, kg, s; statistics are of norms of errors e_k, k = 1..n,

    mean |e|,    rms = sqrt(mean |e|^2),    sd = sqrt(sum (|e| - mean)^2 / (n - 1)),    max |e|
"""

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Literal

from truepose.domain.arrays import FloatArray
from truepose.domain.campaign import ReadingsSetAside
from truepose.domain.contacts import Target
from truepose.domain.robot import FramePlacement, JointRange, Robot
from truepose.messages.message import Text

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
    """An identified parameter, in internal units (angles in rad).

    `prior_width` is kept with it: what is undetermined is defined by it (docs/decisions/0004), and whoever
    reads a model has to know what was believed.
    """

    name: str
    effect: str
    value: float
    unit: Unit
    standard_uncertainty: float
    prior_width: float


class Status(StrEnum):
    """Outcome of an identification."""

    # Also where something is undetermined: predictions near the data are good then, and the covariance says
    # where they are not (docs/decisions/0004).
    CONVERGED = "converged"
    NOT_CONVERGED = "not_converged"
    TOO_FEW_DATA = "too_few_data"
    WRONG_NOMINAL_MODEL = "wrong_nominal_model"
    OUTLIERS_DOMINATE = "outliers_dominate"


@dataclass(frozen=True, slots=True)
class NotIdentifiable:
    """Parameters that the data see only together, or not at all, and why.

    A direction is undetermined where its standard uncertainty exceeds half of its prior width
    (docs/decisions/0004); what is so by construction is listed as well.
    """

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
    """A tool nest as the model holds it [mm, flange frame]."""

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
    """Where the arm was when it was measured: outside of it a model extrapolates.

    Attributes
    ----------
    joint_ranges : tuple of JointRange
    extents_mm : tuple of float
        Of the flange frame's origin in the robot's base, along `zone.DIRECTIONS`: 26 faces, of a size that is
        the same for every model, where a hull would need all points (docs/decisions/0039).
    """

    joint_ranges: tuple[JointRange, ...]
    extents_mm: tuple[float, ...]  # of the flange frame's origin in the robot's base, along `zone.DIRECTIONS`


@dataclass(frozen=True, slots=True)
class ModelInadequacy:
    """What a model of P parameters lacks, as far as its readings show it: c functions of single joints.

    They are considered and not estimated: the model is used without them, and what is left of them at a
    target counts in its uncertainty (docs/decisions/0044).

    Attributes
    ----------
    functions : tuple of Parameter, length c
        Values and widths as the readings ask for.
    covariance : ndarray, shape (c, c)
    absorbed : ndarray, shape (P, c)
        What the parameters have taken over of each.
    rest_mm : float
        Per axis: what none of them expresses.
    """

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
    # So that before and after differ by the errors of the arm, and not by where somebody thought that it
    # stands.
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
    shortfall: ModelInadequacy | None = None  # None: the discrepancy stands for it, the same everywhere
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
class PositionsJudged:
    """A model of lengths against held-out positions, whose frame lengths leave open."""

    # Neither of the two takes part in the identification: they are judges (docs/decisions/0017).
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
    set_aside: ReadingsSetAside | None = None  # by a person; None: all readings took part

    @property
    def judging(self) -> NominalAndIdentified | None:
        """The figures that judge the model: validation, else cross-validation, else calibration."""
        return self.validation or self.cross_validation or self.calibration
