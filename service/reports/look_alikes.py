"""Could it be something else? Which causes act alike, and what became of them."""

from collections.abc import Iterator
from dataclasses import dataclass

from service.domain.diagnosis import Cause, Diagnosis, Finding, NextMeasurement, RuledOut
from service.reports.causes import cause_words

# Effects that leave similar residuals: where one is found, a sceptic asks for the others.
_OF_ONE_JOINT = frozenset({
    "joint_gain",
    "joint_harmonics",
    "joint_coupling",
    "backlash",
    "compliance",
    "compliance_nonlinear",
})
_UNNAMED = "unnamed"
_OF_A_BALLBAR = frozenset({"ballbar_zero", "fixture_shift"})
_KIN = (
    # of loads: everything that follows the torques
    frozenset({
        "compliance",
        "compliance_nonlinear",
        "link_bending",
        "payload",
        "link_mass",
        "base_compliance",
        "axis_parallelism",
    }),
    # of time
    frozenset({
        "thermal_growth",
        "base_drift",
        "base_shift",
        "instrument_drift",
        "tool_reseating",
        "fixture_shift",
        "ballbar_zero",
    }),
    # of the places of nests
    frozenset({"nest_offset", "tool_reseating", "label_swap", "fixture_shift"}),
    # of lengths
    frozenset({"instrument_scale", "thermal_growth", "ballbar_zero"}),
    # of single readings
    frozenset({"outliers", "label_swap"}),
)


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


def alternatives(finding: Finding, diagnosis: Diagnosis) -> Alternatives:
    """Return what else it could be, and what it is not."""
    alike = [
        entry
        for entry in diagnosis.ruled_out
        if acts_alike(finding, entry) and not _impossible(entry, diagnosis)
    ]
    named = set(finding.confusable_with)
    rest = [entry for entry in alike if Cause(entry.effect, entry.subject) not in named]
    return Alternatives(
        rivals=tuple(_rivals(finding, diagnosis.next_measurements)),
        excluded=tuple(entry for entry in rest if entry.visible),
        not_excluded=tuple(entry for entry in rest if not entry.visible),
    )


def acts_alike(finding: Finding, entry: RuledOut) -> bool:
    """Whether the two leave similar residuals: the same effect elsewhere, the same joint, or kin."""
    if entry.effect == _UNNAMED:
        return finding.subject != entry.subject and _share_a_cell(finding, entry)
    if finding.effect == entry.effect:
        return finding.subject != entry.subject
    if finding.effect == _UNNAMED:
        return entry.subject == finding.where
    if {finding.effect, entry.effect} <= _OF_ONE_JOINT:
        return _may_be_same(finding.subject, entry.subject)
    return any({finding.effect, entry.effect} <= kin for kin in _KIN)


def _share_a_cell(finding: Finding, entry: RuledOut) -> bool:
    """Whether a cause without a name, whose subject is its cell, acts at the same place or over the same."""
    where, over, _ = entry.subject.split(", ")
    return where == finding.where or over == finding.over


def _impossible(entry: RuledOut, diagnosis: Diagnosis) -> bool:
    # What is not there cannot be what was found: a campaign of positions has no ballbar.
    return diagnosis.quantity == "position" and entry.effect in _OF_A_BALLBAR


def _may_be_same(subject: str, other: str) -> bool:
    # "" and "joints" stand for all of them.
    return subject == other or bool({"", "joints"} & {subject, other})


def _rivals(finding: Finding, proposals: tuple[NextMeasurement, ...]) -> Iterator[Rival]:
    own = Cause(finding.effect, finding.subject)
    for cause in finding.confusable_with:
        wanted = (proposal for proposal in proposals if cause in proposal.separates)
        both = sorted(wanted, key=lambda proposal: own not in proposal.separates)
        yield Rival(cause_words(cause), both[0].sentence if both else "")
