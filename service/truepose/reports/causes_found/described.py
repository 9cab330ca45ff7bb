"""What a model describes without a name: a sentence, and a table of the largest."""

from collections.abc import Iterator
from dataclasses import dataclass

from truepose.domain.results.diagnosis import Described, Remaining, Worth
from truepose.reports.wording.causes import worth_words
from truepose.reports.wording.rounding import MISSING, millimetres
from truepose.words.catalogue import IN_ENGLISH, Catalogue

_SAID = 3  # in the sentence
_LISTED = 8  # in the table


@dataclass(frozen=True, slots=True)
class DescribedRow:
    """One place and variable; lengths are text in mm."""

    place: str
    own: str  # missed without it, all other parameters fitted again
    worth: str


def described_sentence(remaining: Remaining, words: Catalogue = IN_ENGLISH) -> str:
    """Return what is described without a name, and how far that helps on unseen points."""
    listed, gain = tuple(_listed(remaining.described, words)), remaining.described_gain
    if gain is None:
        return words.say("described", places=listed)
    before, after = millimetres(gain.rms_before_mm), millimetres(gain.rms_after_mm)
    return words.say("described.gain", places=listed, before=before, after=after)


def _listed(described: tuple[Described, ...], words: Catalogue) -> Iterator[str]:
    for one in described[:_SAID]:
        yield f"{described_place(one, words)} ({words.units.quantity(own_text(one.worth), 'mm')})"
    if len(described) > _SAID:
        yield words.say("described.smaller", number=len(described) - _SAID)


def described_rows(
    described: tuple[Described, ...], words: Catalogue = IN_ENGLISH
) -> tuple[DescribedRow, ...]:
    """Return the largest ones for a table."""
    return tuple(
        DescribedRow(described_place(one, words), own_text(one.worth), worth_words(one.worth, words))
        for one in described[:_LISTED]
    )


def described_place(described: Described, words: Catalogue = IN_ENGLISH) -> str:
    """Return e.g. "joint 2 over angle of joint 1"; what depends on nothing is its place alone."""
    if described.over == "constant":
        return words.name(described.where)
    return words.say("described.place", where=described.where, over=described.over)


def own_text(worth: Worth) -> str:
    """Return what would be missed without it, all other parameters fitted again; without its unit."""
    return MISSING if worth.own_mm is None else millimetres(worth.own_mm)
