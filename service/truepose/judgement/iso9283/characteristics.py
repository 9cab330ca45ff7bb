"""What a test answers: figures with uncertainty, and what is withheld."""

from dataclasses import dataclass
from typing import Literal

from truepose.domain.sentences import Sentence

Symbol = Literal["AP", "RP", "vAP", "AD", "RD", "dAP", "dRP"]
Component = Literal["p", "l", "x", "y", "z", "a", "b", "c"]

CLAUSES: dict[Symbol, str] = {
    "AP": "7.2.1",
    "RP": "7.2.2",
    "vAP": "7.2.3",
    "AD": "7.3",
    "RD": "7.3",
    "dAP": "7.6",
    "dRP": "7.6",
}


@dataclass(frozen=True, slots=True)
class Characteristic:
    """A figure of ISO 9283:1998.

    Accuracies of components have a sign; repeatabilities of angles and distances are half widths (+-).
    """

    symbol: Symbol
    component: Component  # p: position, l: radius about the barycentre, a b c: angles about x y z
    subject: str  # P1, or P2-P4
    value: float
    standard_uncertainty: float  # of the value, to first order
    unit: Literal["mm", "rad"]
    visits: int
    noise: float = 0.0  # what the instrument's stated scatter alone would show; 0 where it averages out

    @property
    def clause(self) -> str:
        """Where the standard defines it."""
        return CLAUSES[self.symbol]


@dataclass(frozen=True, slots=True)
class Withheld:
    """A figure that these visits do not give, and why."""

    symbol: Symbol
    subject: str
    reason: Sentence


@dataclass(frozen=True, slots=True)
class Performance:
    """All figures of a test."""

    characteristics: tuple[Characteristic, ...]
    withheld: tuple[Withheld, ...]

    def largest(self, symbol: Symbol, component: Component) -> Characteristic | None:
        """Return the figure of the worst pose, by size; None where every pose is withheld."""
        found = [c for c in self.characteristics if (c.symbol, c.component) == (symbol, component)]
        return max(found, key=lambda figure: abs(figure.value), default=None)

    def joined(self, other: "Performance") -> "Performance":
        """Return the figures of both."""
        return Performance(self.characteristics + other.characteristics, self.withheld + other.withheld)
