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
    """Which of several ways a cause acts in.

    Attributes
    ----------
    name : str
        "order" of a wave, or "source joint" of a coupling.
    value : float
        Rounded to one decimal, so that it is found again.
    """

    name: str
    value: float


@dataclass(frozen=True, slots=True)
class Key:
    """By what a cause is recognised in another diagnosis.

    Attributes
    ----------
    effect, subject : str
    variant : Variant or None
        None where the cause has no variants.
    unit : str
        Amplitudes in different units are never subtracted.
    """

    effect: str
    subject: str
    variant: Variant | None
    unit: str


@dataclass(frozen=True, slots=True)
class Amplitude:
    """How large a cause is, in the unit of its key.

    Attributes
    ----------
    value : float
    standard_uncertainty : float
        0 or not finite where it is not known.
    confidence : Confidence
        Of the finding that it is part of.
    """

    value: float
    standard_uncertainty: float
    confidence: Confidence


def amplitudes_of(diagnosis: Diagnosis) -> dict[Key, Amplitude]:
    """Return every amplitude that the findings state, the small ones too.

    Parameters
    ----------
    diagnosis : Diagnosis

    Returns
    -------
    dict of Key to Amplitude
        Waves by their order, couplings by their source, shared causes by their joint or link.
    """
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
    """Return the key of a finding as a whole."""
    return Key(finding.effect, finding.subject, None, finding.unit)


def _amplitude_of(detail: Detail, finding: Finding) -> Amplitude:
    """Return the amplitude that a detail states."""
    return Amplitude(detail.value, detail.standard_uncertainty, finding.confidence)


def _amplitude(finding: Finding) -> Amplitude:
    """Return the amplitude of a finding as a whole."""
    return Amplitude(finding.amplitude, finding.amplitude_standard_uncertainty, finding.confidence)


LEVEL: Final = 0.05  # of a false "significant" anywhere in one comparison


@dataclass(frozen=True, slots=True)
class DatedDiagnosis:
    """A diagnosis and when its readings were taken.

    Attributes
    ----------
    id : int
        By which replies refer to it.
    measured_at : str or None
        A day, or UTC in ISO 8601; None where it is not known.
    diagnosis : Diagnosis
    """

    id: int
    measured_at: str | None
    diagnosis: Diagnosis


class Sighting(StrEnum):
    """Result of a diagnosis for one cause."""

    FOUND = "found"
    WITH_OTHERS = "with_others"  # found on several joints or links together
    NOT_FOUND = "not_found"
    NOT_VISIBLE = "not_visible"  # the readings could not show it
    PART_OF_START = "part_of_start"  # the model had it already, so it could be no finding
    NOT_MENTIONED = "not_mentioned"


@dataclass(frozen=True, slots=True)
class CauseObservation:
    """What one diagnosis says of one cause; the numbers are None where it was not found.

    Attributes
    ----------
    diagnosis_id : int
    measured_at : str or None
    sighting : Sighting
    amplitude, standard_uncertainty : float or None
        In the unit of the cause.
    confidence : Confidence or None
    """

    diagnosis_id: int
    measured_at: str | None
    sighting: Sighting
    amplitude: float | None = None
    standard_uncertainty: float | None = None
    confidence: Confidence | None = None


@dataclass(frozen=True, slots=True)
class Change:
    """A difference of amplitudes, in the unit of the cause, later less earlier.

    Attributes
    ----------
    from_id, to_id : int
        Diagnoses.
    difference, standard_uncertainty : float
    p_value : float or None
        Corrected for all tests of the comparison; None where an uncertainty is not known.
    significant : bool
    """

    from_id: int
    to_id: int
    difference: float
    standard_uncertainty: float
    p_value: float | None
    significant: bool


@dataclass(frozen=True, slots=True)
class CauseOverTime:
    """One cause in all diagnoses, oldest first; undated ones last.

    Attributes
    ----------
    effect, subject : str
    variant : Variant or None
    unit : str
    signs : tuple of CauseObservation
        One a diagnosis.
    changes : tuple of Change
        Between consecutive diagnoses that found it.
    overall : Change or None
        Between the first and the last, where there are more than two.
    """

    effect: str
    subject: str
    variant: Variant | None
    unit: str
    signs: tuple[CauseObservation, ...]
    changes: tuple[Change, ...]
    overall: Change | None


def compare(diagnoses: Sequence[DatedDiagnosis]) -> tuple[CauseOverTime, ...]:
    """Return every cause that any of the diagnoses found, in the order of its first sighting.

    Parameters
    ----------
    diagnoses : sequence of DatedDiagnosis
        Of one robot, each of other readings; in any order. Of several of the same readings the caller gives
        one: they share their noise.

    Returns
    -------
    tuple of CauseOverTime
    """
    dated = sorted(diagnoses, key=lambda entry: place_in_time(entry.measured_at, entry.id))
    seen = [amplitudes_of(entry.diagnosis) for entry in dated]
    keys = dict.fromkeys(key for amplitudes in seen for key in amplitudes)
    causes = [_over_time(key, dated, [amplitudes.get(key) for amplitudes in seen]) for key in keys]
    return _corrected(causes)


def place_in_time(measured_at: str | None, number: int) -> tuple[bool, str, int]:
    """Return the key by which diagnoses are sorted; undated ones come last.

    Parameters
    ----------
    measured_at : str or None
    number : int
        Decides among those of one moment.

    Returns
    -------
    tuple
        To be compared with others of its kind alone.
    """
    return measured_at is None, measured_at or "", number


def _over_time(
    key: Key, dated: Sequence[DatedDiagnosis], amplitudes: Sequence[Amplitude | None]
) -> CauseOverTime:
    """Return one cause in all diagnoses, nothing tested yet."""
    signs = tuple(_sign(key, entry, found) for entry, found in zip(dated, amplitudes, strict=True))
    found = [] if _is_event(key) else [sign for sign in signs if _has_amplitude_and_day(sign)]
    changes = tuple(_change(earlier, later) for earlier, later in pairwise(found))
    overall = _change(found[0], found[-1]) if len(found) > 2 else None
    return CauseOverTime(key.effect, key.subject, key.variant, key.unit, signs, changes, overall)


def _is_event(key: Key) -> bool:
    """Whether it happened once, in one campaign: two of them are not the same thing at two times."""
    return key.effect == LABEL_SWAP or named_signature(key.effect, key.subject).shape == "jump"


def _has_amplitude_and_day(sign: CauseObservation) -> bool:
    """Whether a sign has something to subtract, and a place in time."""
    return sign.sighting is Sighting.FOUND and sign.measured_at is not None


def _sign(key: Key, entry: DatedDiagnosis, found: Amplitude | None) -> CauseObservation:
    """Return what a diagnosis says of a cause that it found, or did not."""
    # Not found is not zero: the limit of what could have been seen depends on what else the model held.
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
    """Return why a diagnosis does not name a cause."""
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
    return Change(
        earlier.diagnosis_id, later.diagnosis_id, difference, uncertainty, p_value, significant=False
    )


def _corrected(causes: Sequence[CauseOverTime]) -> tuple[CauseOverTime, ...]:
    """Return the causes with corrected p values, and what is significant."""
    tests = [change.p_value for cause in causes for change in _changes(cause)]
    # P values carry no names: the changes are gone through below in the very order in which they were tested.
    corrected = iter(holm(tests))
    return tuple(
        replace(
            cause,
            changes=tuple(_judged(change, next(corrected)) for change in cause.changes),
            overall=None if cause.overall is None else _judged(cause.overall, next(corrected)),
        )
        for cause in causes
    )


def _changes(cause: CauseOverTime) -> Iterator[Change]:
    """Yield all changes of a cause, in the order in which their p values are corrected."""
    yield from cause.changes
    if cause.overall is not None:
        yield cause.overall


def _judged(change: Change, p_value: float | None) -> Change:
    """Return a change with its corrected p value."""
    return replace(change, p_value=p_value, significant=p_value is not None and p_value < LEVEL)
