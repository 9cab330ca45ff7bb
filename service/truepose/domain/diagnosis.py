"""What a diagnosis answers: causes and findings, residual structure, what to measure next."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Literal, TypeAlias

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.campaign import ReadingsSetAside
from truepose.domain.identification import Model, Statistics
from truepose.messages.message import Text

Shape = Literal["line", "wave", "curve", "jump", "drift", "settling", "sign", "group"]


@dataclass(frozen=True, slots=True)
class Cause:
    """A physical cause by its name, e.g. `joint_gain` of `joint 2`."""

    effect: str
    subject: str


@dataclass(frozen=True, slots=True)
class Detail:
    """One more number of a finding: an order, a time, a rotation; in the unit it states."""

    name: str
    value: float
    unit: str
    standard_uncertainty: float


@dataclass(frozen=True, slots=True)
class Spectrum:
    """Waves of one joint by their order, k of them."""

    order: FloatArray  # (k,) ascending, periods per turn
    amplitude_deg: FloatArray  # (k,) less what noise adds; 0 where that explains all of it
    standard_uncertainty_deg: FloatArray  # (k,)


HeldOut = Literal["validation", "cross_validation"]


class Verdict(StrEnum):
    """Verdict on the present model."""

    CONSISTENT = "consistent"
    EXPLAINED = "explained"
    PARTLY_EXPLAINED = "partly_explained"
    UNEXPLAINED = "unexplained"


class Confidence(StrEnum):
    """Confidence in a finding."""

    CERTAIN = "certain"
    LIKELY = "likely"


@dataclass(frozen=True, slots=True)
class Gain:
    """RMS of the held-out errors with all findings but one, and with that one too [mm].

    `interval_95_mm` holds the difference of the two (before less after); resampled by configuration.
    """

    rms_before_mm: float
    rms_after_mm: float
    # By configuration: readings of one stop share what the model lacks there, and are no witnesses of each
    # other.
    interval_95_mm: tuple[float, float]


@dataclass(frozen=True, slots=True)
class CurvePoints:
    """Further readings of a curve, k of them, as its own are."""

    x: FloatArray  # (k,)
    residual: FloatArray  # (k,)
    standard_uncertainty: FloatArray  # (k,)


@dataclass(frozen=True, slots=True)
class Curve:
    """Residuals along one variable with what was fitted to them: what a page draws.

    The points are the calibration readings; `residual` is what the model without this finding leaves,
    projected on the way in which the cause acts (e.g. an angle of one joint). For remaining structure the
    line is a smooth curve with its band.
    """

    variable: str  # "angle of joint 4", "time", "torque of joint 2"
    variable_unit: str  # "deg", "h", "N*m", "degC", "" for a number of an attachment or nest
    quantity: str  # "error of joint 4", "shift of the base along x"
    quantity_unit: str  # "deg", "mm"
    x: FloatArray  # (n,)
    residual: FloatArray  # (n,)
    standard_uncertainty: FloatArray  # (n,) of each residual
    line_x: FloatArray  # (m,) ascending
    line: FloatArray  # (m,)
    line_band: FloatArray  # (m,) half width of the 95 % band
    unseen: CurvePoints | None = None  # validation readings, which were never fitted


@dataclass(frozen=True, slots=True)
class EffectSize:
    """How far a cause moves the tool over the calibration readings [mm]; of legs, how much a length.

    `own_mm` is the RMS by which they would be missed without it, all other parameters fitted again: a joint
    that errs by a nearly constant angle moves the tool far, and an offset of that joint does the same.
    """

    mean_mm: float
    max_mm: float
    own_mm: float | None = None  # None in what was stored before it was told


@dataclass(frozen=True, slots=True)
class Finding:
    """One cause that the data show."""

    effect: str
    subject: str
    amplitude: float
    unit: str
    amplitude_standard_uncertainty: float
    p_value: float  # corrected for everything that was tried
    confidence: Confidence
    details: tuple[Detail, ...]
    sentence: Text
    # The name is given with its rivals: a wrong confident name is worse than none (docs/decisions/0015).
    confusable_with: tuple[Cause, ...]
    gain: Gain | None  # None where nothing held out can show it
    parameters: tuple[str, ...]  # their names in the extended model; none for bad readings
    share: float  # of the structure explained, 0..1
    curve: Curve | None = None
    where: str = ""  # "joint 3", "base"; nothing in what was stored before findings said so
    over: str = ""  # what it depends on: "angle of joint 3", "time"
    shape: Shape | None = None
    worth: EffectSize | None = None  # None for bad readings
    spectrum: Spectrum | None = None  # of several waves of a joint


@dataclass(frozen=True, slots=True)
class Dependence:
    """Something that what is left depends on."""

    variable: str
    p_value: float  # corrected for everything that was tried
    curve: Curve | None = None


@dataclass(frozen=True, slots=True)
class WorstPoint:
    """The held-out point at which the extended model is farthest off."""

    config: int
    before_mm: float  # norm of its error with the initial model
    after_mm: float


@dataclass(frozen=True, slots=True)
class Described:
    """A place and a variable without a name, where the model holds a function as large as data ask for."""

    where: str  # "joint 2"
    over: str  # "angle of joint 1"
    worth: EffectSize


@dataclass(frozen=True, slots=True)
class Remaining:
    """What the findings leave, and what of it the extended model describes without a name."""

    structure: bool
    depends_on: tuple[Dependence, ...]
    sentence: Text
    # An extended model once made the mean better and the worst point six times worse: the mean alone hides
    # it.
    worse_at: WorstPoint | None = None  # a held-out point that is far worse than any was before
    described: tuple[Described, ...] = ()  # largest first
    described_gain: Gain | None = None  # of all that is described, beside the findings


@dataclass(frozen=True, slots=True)
class NextMeasurement:
    """An action or configurations that would tell causes apart."""

    sentence: Text
    configurations_deg: tuple[tuple[float, ...], ...]
    separates: tuple[Cause, ...] = ()


@dataclass(frozen=True, slots=True)
class RuledOut:
    """A cause that was looked at and not found, and why."""

    effect: str
    subject: str  # "" for the effect as a whole
    reason: Text
    p_value: float | None = None  # corrected; None where the data cannot show the cause at all
    visible: bool = True  # False: these data cannot show it
    # What was not found is not zero: how large it may be is said instead (docs/decisions/0013).
    upper_limit_mm: float | None = None  # 95 %: how large it could still be, RMS at the tool; None: unseen


ScatterVariable: TypeAlias = Literal[
    "reach", "range", "angle", "time", "temperature", "nest", "mounting", "placement"
]


@dataclass(frozen=True, slots=True)
class Scatter:
    """Noise that is larger at some readings than at others.

    Attributes
    ----------
    variable : ScatterVariable
        Reach [mm] from the base, range [mm] from the instrument, angle [deg] of a joint, time [s] after
        the first reading, temperature [deg C], or the number of a nest, mounting of the tool or placement.
    subject : str
        The joint of an angle, as "joint 3"; else "".
    at_low, at_high : float
        Where it is smallest and largest, in the unit of the variable, all but a twentieth at either end.
    low_mm, high_mm : float
        Standard deviation per axis there.
    p_value : float
        Corrected for all variables that were tried.
    """

    variable: ScatterVariable
    subject: str
    at_low: float
    low_mm: float
    at_high: float
    high_mm: float
    p_value: float

    @property
    def unit(self) -> str:
        """Of the variable; "" of what is numbered."""
        return _SCATTER_UNITS.get(self.variable, "")


_SCATTER_UNITS: Mapping[str, str] = {
    "reach": "mm",
    "range": "mm",
    "angle": "deg",
    "time": "s",
    "temperature": "degC",
}


@dataclass(frozen=True, slots=True)
class Noise:
    """What the readings say of their own noise."""

    scale: float  # residual that is left over the stated uncertainty
    tail_degrees_of_freedom: float | None  # Student's t where the tails are heavy, None for normal ones
    sentence: Text
    scatter: Scatter | None = None  # None where it is alike everywhere, and in what was stored before


@dataclass(frozen=True, slots=True)
class HeldOutErrors:
    """Errors on points that neither the choice of the model nor its parameters saw; n points.

    Attributes
    ----------
    config : ndarray of int, shape (n,)
    position_mm : ndarray, shape (n, 3)
        As measured; of legs the predicted point.
    before_mm, after_mm : ndarray, shape (n, d)
        With the initial model and the extended one; d = 3, or 1 for legs.
    """

    config: IntArray  # (n,)
    position_mm: FloatArray  # (n, 3) as measured; of legs the predicted point
    before_mm: FloatArray  # (n, d) d = 3, or 1 for legs
    after_mm: FloatArray  # (n, d)

    @property
    def worst(self) -> WorstPoint:
        """The point that is farthest off in the end."""
        before, after = (np.linalg.norm(errors, axis=1) for errors in (self.before_mm, self.after_mm))
        at = int(np.argmax(after))
        return WorstPoint(int(self.config[at]), float(before[at]), float(after[at]))


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """What the model gets wrong, why, and how much better the extended one is."""

    robot: str
    verdict: Verdict
    message: Text  # the first line: one plain sentence
    start_effects: tuple[str, ...]
    findings: tuple[Finding, ...]  # most important first
    quantity: Literal["position", "length"]
    before: Statistics | None  # None where nothing could be fitted
    after: Statistics | None
    held_out: HeldOut
    remaining: Remaining
    next_measurements: tuple[NextMeasurement, ...]
    ruled_out: tuple[RuledOut, ...]
    withdrawn: tuple[Text, ...]  # extensions that did not help on held-out points, one sentence each
    noise: Noise | None
    errors: HeldOutErrors | None
    model: Model | None  # extended; the start's where nothing was found
    # In the model and followed from diagnosis to diagnosis, but no causes that the first sentence would
    # count.
    small: tuple[Finding, ...] = ()  # they take less than 2 % off the held-out error; in the model as well
    # Of the robot as its maker describes it, on the same readings as `before` and `after`: those start from a
    # model that is fitted already, and a calibration that halved every error read as one that did nothing.
    nominal: Statistics | None = None  # None in what was stored before it was told
    set_aside: ReadingsSetAside | None = None  # by a person; None: all readings took part
    # Of the squared held-out error beyond the noise; None where nothing is named, or none is beyond.
    named_share: float | None = None

    @property
    def all_findings(self) -> tuple[Finding, ...]:
        """Everything that has a name, the small ones last."""
        return (*self.findings, *self.small)
