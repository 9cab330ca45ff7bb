"""Diagnoses of one robot over time: which cause has grown, which has gone, which was never looked for.

The amplitude of each cause is compared between consecutive diagnoses that found it, and between the first
and the last. Two campaigns are independent measurements, so the difference d = a2 - a1 has the uncertainty
u = sqrt(u1^2 + u2^2), and d / u is standard normal where nothing changed. What both campaigns share, such as
certified nests, makes u too large, never too small. All tests of one comparison share one level (S. Holm,
Scand. J. Statist. 6, 1979, 65-70): who looks at twenty causes over ten years finds no change by chance alone.

A cause that was not found is not a cause of amplitude zero. Where a diagnosis does not name it, the reason
is kept and nothing is subtracted. Nor is it where nobody said when readings were taken: what has no place
in time stands last, in the order of its numbers.
"""

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from itertools import pairwise
from typing import Final

from truepose.domain.diagnosis import Confidence, Detail, Diagnosis, Finding
from truepose.effects.readings.label_swap import NAME as LABEL_SWAP
from truepose.effects.signatures import named_signature
from truepose.identification.distributions import holm

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


LEVEL: Final = 0.05  # of a false "significant" anywhere in one comparison

_DAY: Final = len("2026-03-03")
_MINUTE: Final = len("2026-03-03T10:15")


@dataclass(frozen=True, slots=True)
class DatedDiagnosis:
    """A diagnosis and when its readings were taken: a day, or UTC in ISO 8601; None: nobody said."""

    id: int
    measured_at: str | None
    diagnosis: Diagnosis


class Sighting(StrEnum):
    """What a diagnosis says of a cause."""

    FOUND = "found"
    WITH_OTHERS = "with_others"  # found on several joints or links together
    NOT_FOUND = "not_found"
    NOT_VISIBLE = "not_visible"  # the readings could not show it
    PART_OF_START = "part_of_start"  # the model had it already, so it could be no finding
    NOT_MENTIONED = "not_mentioned"


@dataclass(frozen=True, slots=True)
class CauseObservation:
    """What one diagnosis says of one cause; the numbers are None where it was not found."""

    diagnosis_id: int
    measured_at: str | None
    sighting: Sighting
    amplitude: float | None = None
    standard_uncertainty: float | None = None
    confidence: Confidence | None = None


@dataclass(frozen=True, slots=True)
class Change:
    """A difference of amplitudes, in the unit of the cause, later less earlier.

    `p_value` is corrected for all tests of the comparison; None where an uncertainty is not known.
    """

    from_id: int
    to_id: int
    difference: float
    standard_uncertainty: float
    p_value: float | None
    significant: bool
    sentence: str


@dataclass(frozen=True, slots=True)
class CauseOverTime:
    """One cause in all diagnoses, oldest first, and last those of which nobody said when."""

    effect: str
    subject: str
    variant: Variant | None
    unit: str
    signs: tuple[CauseObservation, ...]
    changes: tuple[Change, ...]  # between consecutive diagnoses that found it
    overall: Change | None  # between the first and the last, where there are more than two


def compare(diagnoses: Sequence[DatedDiagnosis]) -> tuple[CauseOverTime, ...]:
    """Return every cause that any of the diagnoses found, in the order of its first sighting.

    Parameters
    ----------
    diagnoses : sequence of DatedDiagnosis
        Of one robot, each of other readings; in any order.
    """
    dated = sorted(diagnoses, key=lambda entry: place_in_time(entry.measured_at, entry.id))
    seen = [amplitudes_of(entry.diagnosis) for entry in dated]
    keys = dict.fromkeys(key for amplitudes in seen for key in amplitudes)
    causes = [_over_time(key, dated, [amplitudes.get(key) for amplitudes in seen]) for key in keys]
    return _corrected(causes)


def place_in_time(measured_at: str | None, number: int) -> tuple[bool, str, int]:
    """Return what diagnoses are sorted by: what nobody dated comes last."""
    return measured_at is None, measured_at or "", number


def _over_time(
    key: Key, dated: Sequence[DatedDiagnosis], amplitudes: Sequence[Amplitude | None]
) -> CauseOverTime:
    signs = tuple(_sign(key, entry, found) for entry, found in zip(dated, amplitudes, strict=True))
    found = [] if _is_event(key) else [sign for sign in signs if _has_amplitude_and_day(sign)]
    changes = tuple(_change(earlier, later) for earlier, later in pairwise(found))
    overall = _change(found[0], found[-1]) if len(found) > 2 else None
    return CauseOverTime(key.effect, key.subject, key.variant, key.unit, signs, changes, overall)


def _is_event(key: Key) -> bool:
    """Whether it happened once, in one campaign: two of them are not the same thing at two times."""
    return key.effect == LABEL_SWAP or named_signature(key.effect, key.subject).shape == "jump"


def _has_amplitude_and_day(sign: CauseObservation) -> bool:
    return sign.sighting is Sighting.FOUND and sign.measured_at is not None


def _sign(key: Key, entry: DatedDiagnosis, found: Amplitude | None) -> CauseObservation:
    if found is None:
        return CauseObservation(entry.id, entry.measured_at, _why_absent(key, entry.diagnosis))
    return CauseObservation(
        entry.id,
        entry.measured_at,
        Sighting.FOUND,
        found.value,
        found.standard_uncertainty,
        found.confidence,
    )


def _why_absent(key: Key, diagnosis: Diagnosis) -> Sighting:
    if key.effect in diagnosis.start_effects:
        return Sighting.PART_OF_START
    shared = SHARED.get(key.subject.split(" ")[0])
    if any(f.effect == key.effect and f.subject == shared for f in diagnosis.all_findings):
        return Sighting.WITH_OTHERS
    said = [r for r in diagnosis.ruled_out if r.effect == key.effect and r.subject in {"", key.subject}]
    if not said:
        return Sighting.NOT_MENTIONED
    return Sighting.NOT_FOUND if all(entry.visible for entry in said) else Sighting.NOT_VISIBLE


def _change(earlier: CauseObservation, later: CauseObservation) -> Change:
    """Return the difference of two signs that were found, its p value not yet corrected."""
    difference = (later.amplitude or 0.0) - (earlier.amplitude or 0.0)
    uncertainty = math.hypot(earlier.standard_uncertainty or 0.0, later.standard_uncertainty or 0.0)
    known = math.isfinite(difference) and math.isfinite(uncertainty) and uncertainty > 0.0
    p_value = math.erfc(abs(difference) / uncertainty / math.sqrt(2.0)) if known else None
    return Change(earlier.diagnosis_id, later.diagnosis_id, difference, uncertainty, p_value, False, "")


def _corrected(causes: Sequence[CauseOverTime]) -> tuple[CauseOverTime, ...]:
    """Return the causes with corrected p values, what is significant, and the sentences that say it."""
    tests = [change.p_value for cause in causes for change in _changes(cause)]
    corrected = iter(holm(tests))
    return tuple(
        replace(
            cause,
            changes=tuple(_judged(cause, change, next(corrected)) for change in cause.changes),
            overall=None if cause.overall is None else _judged(cause, cause.overall, next(corrected)),
        )
        for cause in causes
    )


def _changes(cause: CauseOverTime) -> Iterator[Change]:
    yield from cause.changes
    if cause.overall is not None:
        yield cause.overall


def _judged(cause: CauseOverTime, change: Change, p_value: float | None) -> Change:
    significant = p_value is not None and p_value < LEVEL
    judged = replace(change, p_value=p_value, significant=significant)
    return replace(judged, sentence=_sentence(cause, judged))


def _sentence(cause: CauseOverTime, change: Change) -> str:
    earlier = next(sign for sign in cause.signs if sign.diagnosis_id == change.from_id)
    later = next(sign for sign in cause.signs if sign.diagnosis_id == change.to_id)
    what = _words(cause)
    unit = "" if cause.unit == "1" else f" {cause.unit}"
    size = f"{_number(abs(change.difference), change.standard_uncertainty)}{unit}"
    return (
        f"{what[0].upper()}{what[1:]} {_verb(earlier, later)} by {size} between "
        f"{' and '.join(_moments(earlier, later))}: {_verdict(change)}."
    )


def _words(cause: CauseOverTime) -> str:
    name = cause.effect.replace("_", " ")
    match cause.variant:
        case Variant("order", order):
            name += f" of order {order:g}"
        case Variant("source joint", joint):
            name += f" from joint {joint:g}"
    return f"{name} of {cause.subject}"


def _verb(earlier: CauseObservation, later: CauseObservation) -> str:
    before, after = earlier.amplitude or 0.0, later.amplitude or 0.0
    if before * after < 0.0:
        return "turned round"
    return "grew" if abs(after) >= abs(before) else "fell"


def _verdict(change: Change) -> str:
    if change.p_value is None:
        return "not tested, since an uncertainty is not known"
    p = "p < 0.0001" if change.p_value < 1e-4 else f"p = {change.p_value:.2g}"
    return f"significant ({p})" if change.significant else f"within what noise explains ({p})"


def _moments(earlier: CauseObservation, later: CauseObservation) -> tuple[str, str]:
    first, last = earlier.measured_at or "", later.measured_at or ""
    length = _MINUTE if first[:_DAY] == last[:_DAY] else _DAY
    return first[:length].replace("T", " "), last[:length].replace("T", " ")


def _number(value: float, u: float) -> str:
    """Return value and uncertainty to two digits of the uncertainty."""
    if not (math.isfinite(u) and u > 0.0):
        return f"{value:.3g}"
    # Rounded first: 0.0996 is 0.10 to two digits, one place fewer than its exponent says.
    decimals = 1 - math.floor(math.log10(float(f"{u:.1e}")))
    if 0 <= decimals <= 5:
        return f"{value:.{decimals}f} ± {u:.{decimals}f}"
    exponent = math.floor(math.log10(max(value, u)))
    scale, digits = 10.0**exponent, max(0, decimals + exponent)
    return f"({value / scale:.{digits}f} ± {u / scale:.{digits}f})e{exponent}"
