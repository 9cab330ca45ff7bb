"""What only a simulator knows: true errors and true parameters beside the identified ones."""

import math
from dataclasses import dataclass

from truepose.domain.results.identification import Statistics
from truepose.domain.sentences import Text
from truepose.reports.wording.rounding import MISSING, rounded, uncertainty
from truepose.words.catalogue import IN_ENGLISH, Catalogue

_K_95 = 1.96  # two-sided 95 % of the normal distribution
_FAR = 3.0  # standard uncertainties at which a deviation catches the eye


@dataclass(frozen=True, slots=True)
class TrueParameter:
    """A parameter as identified and as it truly is, in the unit that documents use (angles in deg)."""

    name: str
    identified: float
    true: float
    standard_uncertainty: float
    unit: str

    @property
    def deviation(self) -> float:
        """Identified minus true."""
        return self.identified - self.true

    @property
    def normalised(self) -> float:
        """Deviation over its standard uncertainty; NaN where none is stated."""
        return self.deviation / self.standard_uncertainty if self.standard_uncertainty > 0.0 else math.nan


@dataclass(frozen=True, slots=True)
class Truth:
    """True parameters and true errors: distances between predicted and true positions [mm]."""

    parameters: tuple[TrueParameter, ...] = ()
    errors: tuple[tuple[Text, Statistics], ...] = ()  # label such as "absolute" or "after rigid alignment"

    @property
    def covered_95(self) -> int:
        """How many parameters lie within their stated 95 % interval."""
        return sum(abs(parameter.normalised) <= _K_95 for parameter in self.parameters)


@dataclass(frozen=True, slots=True)
class TruthRow:
    """A true parameter as text, for page and terminal."""

    name: str
    identified: str
    true: str
    u: str
    unit: str
    ratio: str
    far: bool


def truth_row(parameter: TrueParameter, words: Catalogue = IN_ENGLISH) -> TruthRow:
    """Return a parameter as text, both values to the place of its uncertainty."""
    u, ratio = parameter.standard_uncertainty, parameter.normalised
    return TruthRow(
        name=parameter.name,
        identified=rounded(parameter.identified, u, parameter.unit),
        true=rounded(parameter.true, u, parameter.unit),
        u=uncertainty(u, parameter.unit),
        unit=words.units.conversion(parameter.unit).symbol,
        ratio=f"{ratio:+.1f}" if math.isfinite(ratio) else MISSING,
        far=abs(ratio) > _FAR,
    )
