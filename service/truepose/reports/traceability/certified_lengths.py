"""Certified lengths at the temperature of the day, beside that at 20 °C, as a report states them."""

from dataclasses import dataclass

from truepose.domain.cell.artefacts import length_at
from truepose.domain.sentences import Sentence, Text, said
from truepose.reports.wording.rounding import millimetres, rounded, uncertainty_mm


@dataclass(frozen=True, slots=True)
class LengthOfDay:
    """A certified length, and the temperatures that were measured while it was used."""

    of: Text
    length_mm: float  # at 20 °C
    standard_uncertainty_mm: float
    expansion_per_k: float | None = None  # None: nobody said it
    temperature_c: tuple[float, float] | None = None  # lowest, highest; None: nothing was read


def length_sentence(length: LengthOfDay) -> Sentence:
    """Return the length at 20 °C and, where that is known, what it was then."""
    u = length.standard_uncertainty_mm
    at_20 = said("lengths.at_20", length=rounded(length.length_mm, u, "mm"), u=uncertainty_mm(u))
    if length.temperature_c is None:
        return said("lengths.no_temperature", at_20=at_20)
    low, high = length.temperature_c
    if length.expansion_per_k is None:
        return said("lengths.no_expansion", at_20=at_20, low_c=low, high_c=high)
    ends = [length_at(length.length_mm, length.expansion_per_k, celsius) for celsius in (low, high)]
    farthest = max((end - length.length_mm for end in ends), key=abs)
    return said(
        "lengths.then",
        at_20=at_20,
        low_c=low,
        high_c=high,
        shortest=rounded(min(ends), u, "mm"),
        longest=rounded(max(ends), u, "mm"),
        change=millimetres(farthest),
    )
