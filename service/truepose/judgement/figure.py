"""A figure of a test: a value, and how well it is known."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Figure:
    """A value with its standard uncertainty."""

    value: float
    standard_uncertainty: float

    @property
    def is_seen(self) -> bool:
        """Whether it is more than readings scatter by: 3 standard uncertainties."""
        return abs(self.value) > 3.0 * self.standard_uncertainty
