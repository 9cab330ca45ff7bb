"""Could it be something else? Which causes act alike, and what became of them."""

from collections.abc import Iterator
from dataclasses import dataclass

from truepose.domain.results.causes import Cause
from truepose.domain.results.diagnosis import Diagnosis, Finding, NextMeasurement, RuledOut
from truepose.effects.cells import alike, named_cell, of_legs
from truepose.effects.unnamed.cause import NAME as UNNAMED
from truepose.reports.wording.causes import cause_words
from truepose.words.catalogue import IN_ENGLISH, Catalogue


@dataclass(frozen=True, slots=True)
class Rival:
    """A cause that these data cannot tell from the finding, and what would."""

    name: str
    separated_by: str  # sentence of the measurement; "" where none is proposed


@dataclass(frozen=True, slots=True)
class Alternatives:
    """The answer to "could it be something else?" for one finding."""

    rivals: tuple[Rival, ...]
    excluded: tuple[RuledOut, ...]  # act alike, were tried and not found
    not_excluded: tuple[RuledOut, ...]  # act alike, and these data cannot show them


def alternatives(finding: Finding, diagnosis: Diagnosis, words: Catalogue = IN_ENGLISH) -> Alternatives:
    """Return what else it could be, and what it is not."""
    alike = [
        entry
        for entry in diagnosis.ruled_out
        if acts_alike(finding, entry) and not _impossible(entry, diagnosis)
    ]
    named = set(finding.confusable_with)
    rest = [entry for entry in alike if Cause(entry.effect, entry.subject) not in named]
    return Alternatives(
        rivals=tuple(_rivals(finding, diagnosis.next_measurements, words)),
        excluded=tuple(entry for entry in rest if entry.visible),
        not_excluded=tuple(entry for entry in rest if not entry.visible),
    )


def acts_alike(finding: Finding, entry: RuledOut) -> bool:
    """Whether the two leave similar residuals: the same effect elsewhere, or cells that are alike."""
    if finding.effect == entry.effect and (entry.effect != UNNAMED or finding.subject == entry.subject):
        return finding.subject != entry.subject
    return alike(named_cell(finding.effect, finding.subject), named_cell(entry.effect, entry.subject))


def _impossible(entry: RuledOut, diagnosis: Diagnosis) -> bool:
    # What is not there cannot be what was found: a campaign of positions has no ballbar.
    return diagnosis.quantity == "position" and of_legs(named_cell(entry.effect, entry.subject))


def _rivals(finding: Finding, proposals: tuple[NextMeasurement, ...], words: Catalogue) -> Iterator[Rival]:
    own = Cause(finding.effect, finding.subject)
    for cause in finding.confusable_with:
        wanted = (proposal for proposal in proposals if cause in proposal.separates)
        both = sorted(wanted, key=lambda proposal: own not in proposal.separates)
        yield Rival(cause_words(cause, words), words.spoken(both[0].sentence) if both else "")
