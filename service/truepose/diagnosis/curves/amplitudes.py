"""The amplitudes that a diagnosis found, one by one: waves by their order, shared causes by their joint."""

import re
from dataclasses import dataclass, replace
from typing import Final

from truepose.domain.results.causes import Detail
from truepose.domain.results.diagnosis import Confidence, Diagnosis, Finding

SHARED: Final = {"joint": "joints", "link": "links"}  # subjects when more than two share a cause

# Details that say which of several ways a cause acts in, and the detail after it with that way's amplitude.
_VARIANTS: Final = {"order": "amplitude", "source joint": "coupling"}
_ALIKE: Final = 1  # decimals: an order between whole ones is not found alike to more
_MEMBER: Final = re.compile(r".+ of ((?:joint|link) \d+)")


@dataclass(frozen=True, slots=True)
class Variant:
    """Which of several ways a cause acts in: the `order` of a wave, the `source joint` of a coupling."""

    name: str
    value: float


@dataclass(frozen=True, slots=True)
class Key:
    """By what a cause is recognised in another diagnosis."""

    effect: str
    subject: str
    variant: Variant | None
    unit: str


@dataclass(frozen=True, slots=True)
class Amplitude:
    """How large a cause is, in the unit of its key."""

    value: float
    standard_uncertainty: float
    confidence: Confidence


def amplitudes_of(diagnosis: Diagnosis) -> dict[Key, Amplitude]:
    """Return every amplitude that the findings state, the small ones too."""
    amplitudes: dict[Key, Amplitude] = {}
    for finding in diagnosis.all_findings:
        whole = (_key(finding), _amplitude(finding))
        for key, amplitude in _variants(finding) or _members(finding) or [whole]:
            amplitudes.setdefault(key, amplitude)  # of two of one name, the more important one
    return amplitudes


def _variants(finding: Finding) -> list[tuple[Key, Amplitude]]:
    """Return a finding way by way; a detail with its own amplitude follows where there are several."""
    found: list[tuple[Key, Amplitude]] = []
    own = ""
    for detail in finding.details:
        if detail.name in _VARIANTS:
            own = _VARIANTS[detail.name]
            variant = Variant(detail.name, round(detail.value, _ALIKE))
            found.append((replace(_key(finding), variant=variant), _amplitude(finding)))
        elif found and detail.name == own:
            found[-1] = (found[-1][0], _amplitude_of(detail, finding))
    return found


def _members(finding: Finding) -> list[tuple[Key, Amplitude]]:
    """Return a finding on several joints or links one by one, where the details have their amplitudes."""
    if finding.subject not in SHARED.values():
        return []
    named = [(_MEMBER.fullmatch(detail.name), detail) for detail in finding.details]
    return [
        (replace(_key(finding), subject=match[1]), _amplitude_of(detail, finding))
        for match, detail in named
        if match is not None and detail.unit == finding.unit
    ]


def _key(finding: Finding) -> Key:
    return Key(finding.effect, finding.subject, None, finding.unit)


def _amplitude_of(detail: Detail, finding: Finding) -> Amplitude:
    return Amplitude(detail.value, detail.standard_uncertainty, finding.confidence)


def _amplitude(finding: Finding) -> Amplitude:
    return Amplitude(finding.amplitude, finding.amplitude_standard_uncertainty, finding.confidence)
