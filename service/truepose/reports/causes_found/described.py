"""What a model describes without a name: a sentence, and a table of the largest."""

from collections.abc import Iterator
from dataclasses import dataclass

from truepose.domain.diagnosis import Described, Gain, Remaining, Worth
from truepose.reports.causes import worth_words
from truepose.reports.rounding import MISSING, millimetres

_SAID = 3  # in the sentence
_LISTED = 8  # in the table


@dataclass(frozen=True, slots=True)
class DescribedRow:
    """One place and variable; lengths are text in mm."""

    place: str
    own: str  # missed without it, all other parameters fitted again
    worth: str


def described_sentence(remaining: Remaining) -> str:
    """Return what is described without a name, and how far that helps on unseen points."""
    listed = ", ".join(_listed(remaining.described))
    return (
        "Described without a name, as functions as large as the data ask for: "
        f"{listed}{_gained(remaining.described_gain)}."
    )


def _listed(described: tuple[Described, ...]) -> Iterator[str]:
    for one in described[:_SAID]:
        yield f"{described_place(one)} ({own_text(one.worth)} mm)"
    if len(described) > _SAID:
        yield f"{len(described) - _SAID} smaller"


def _gained(gain: Gain | None) -> str:
    if gain is None:
        return ""
    before, after = millimetres(gain.rms_before_mm), millimetres(gain.rms_after_mm)
    return f"; with this the RMS of the errors on unseen points goes from {before} to {after} mm"


def described_rows(described: tuple[Described, ...]) -> tuple[DescribedRow, ...]:
    """Return the largest ones for a table."""
    return tuple(
        DescribedRow(described_place(one), own_text(one.worth), worth_words(one.worth))
        for one in described[:_LISTED]
    )


def described_place(described: Described) -> str:
    """Return e.g. "joint 2 over angle of joint 1"; what depends on nothing is its place alone."""
    return described.where if described.over == "constant" else f"{described.where} over {described.over}"


def own_text(worth: Worth) -> str:
    """Return what would be missed without it, all other parameters fitted again; without its unit."""
    return MISSING if worth.own_mm is None else millimetres(worth.own_mm)
