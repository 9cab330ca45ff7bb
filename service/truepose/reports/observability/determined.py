"""Which parameters a measurement determines: how much better each is known after it than before."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from truepose.domain.results.identification import NotIdentifiable, Parameter
from truepose.domain.sentences import Text, said, together
from truepose.identification.verdict.identifiability import UNDETERMINED
from truepose.reports.wording.rounding import uncertainty

HARDLY: Final = 1.0 / UNDETERMINED  # times better known; below, what was assumed before holds the parameter


@dataclass(frozen=True, slots=True)
class Determined:
    """A parameter, and how many times better it is known than was assumed before the measurement."""

    name: str
    times: float

    @property
    def is_hardly(self) -> bool:
        """Whether what was assumed before holds it."""
        return self.times < HARDLY


def determined(parameters: Sequence[Parameter]) -> tuple[Determined, ...]:
    """Return the parameters of which an assumption was stated, the worst known first."""
    known = (
        Determined(one.name, one.prior_width / one.standard_uncertainty)
        for one in parameters
        if one.standard_uncertainty > 0.0 and one.prior_width > 0.0
    )
    return tuple(sorted(known, key=lambda one: one.times))


def observability_sentence(found: Sequence[Determined], left_out: Sequence[NotIdentifiable] = ()) -> Text:
    """Return how many parameters the readings determine, which is known worst, and how many were left out."""
    if not found:
        return said("seen.observability.none")
    worst, weak = found[0], sum(one.is_hardly for one in found)
    key = "seen.observability.weak" if weak else "seen.observability.all"
    told = said(
        key,
        weak=weak,
        number=len(found),
        name=worst.name,
        times=uncertainty(worst.times),
        percent=100.0 / worst.times,
    )
    groups = len(left_out)
    return together(told, said("seen.observability.open", number=groups) if groups else "")
