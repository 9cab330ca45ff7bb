"""What a validation answers: errors by pair and place, how well they are known, and the decision.

Errors are seen minus predicted [mm]; of distances, over all pairs of points, with their sign.
"""

from dataclasses import dataclass
from typing import Literal

from truepose.domain.identification import NominalAndIdentified, TurnPair

_HISTOGRAM_DECIMALS = 9  # widths are whole powers of ten, which binary fractions only nearly are
DecisionRule = Literal["guard band", "simple"]
Verdict = Literal["conforms", "does not conform", "cannot be decided"]


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
    # Of noise alone it is a half. In the thesis' validation of the ballbar 60 and 86 % of the distances had
    # one sign: a scale of lengths, or a base that is off.
    positive_share: float
    histogram: Histogram


@dataclass(frozen=True, slots=True)
class DistanceErrors:
    """Errors of the distances between all pairs of points."""

    nominal: SignedErrors
    identified: SignedErrors


@dataclass(frozen=True, slots=True)
class DistanceBin:
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

    zone_centre_mm: tuple[float, float, float]  # world: of the flange frame's places
    zone_radius_mm: float  # no place of the zone is farther from its middle
    zone_stated: bool  # by the model; else it is that of the readings that judge
    from_zone: tuple[DistanceBin, ...]  # distance of the flange frame from the middle of the zone
    from_axis: tuple[DistanceBin, ...]  # distance of the flange frame from the line of axis 1
    branches: tuple[BranchErrors, ...]


@dataclass(frozen=True, slots=True)
class Decision:
    """Whether the largest error stays within a limit, and the reading that decides it.

    With the guard band g, conforms is error + g <= limit, does not conform error - g > limit; between the two
    nothing is proved. By the simple rule g is 0.

    Source: ISO 14253-1:2017.
    """

    rule: DecisionRule
    limit_mm: float
    error_mm: float
    guard_mm: float  # by which the error must stay away from the limit for anything to be proved
    verdict: Verdict


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
    # Beside the absolute errors, as these contain where the robot stands: who moved it spoilt nothing else.
    relative: NominalAndIdentified | None = None  # after the best rigid alignment; None of lengths
    uncertainty: ValidationUncertainty | None = None  # None: of a program that did not tell it yet
    turns: TurnPair | None = None  # None: no orientations were read, or the model knows none
