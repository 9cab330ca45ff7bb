"""What the ballbar endpoints ask of the cell: the same bar, whatever protocol speaks for it."""

from typing import Literal, Protocol


class Sample(Protocol):
    """What the bar's transducer shows at one moment."""

    @property
    def deviation_mm(self) -> float:
        """Longer than the bar's own zero is positive; NaN without a signal."""
        ...

    @property
    def signal(self) -> Literal["good", "out_of_range", "none"]:
        """Whether the transducer moves freely, stands at a stop, or says nothing."""
        ...

    @property
    def temperature_c(self) -> float:
        """Temperature of the bar."""
        ...

    @property
    def sequence(self) -> int:
        """Grows with every sample."""
        ...


class LengthSource(Protocol):
    """The bar in the simulated person's hands."""

    @property
    def plugged(self) -> bool:
        """Whether its cable is in."""
        ...

    def sample(self, time_s: float) -> Sample:
        """Read the transducer at a cell time."""
        ...


class CellTime(Protocol):
    """The cell's clock, as far as an instrument needs it."""

    @property
    def now_s(self) -> float:
        """Present cell time [s]."""
        ...
