"""Causes that are larger than before, beyond chance: what a service visit looks at first.

A cause grew where the test of its amplitudes says so (`history`). It appeared where the measurement before
looked for it, did not find it, and knew how large it could have been at most (95 %), while now it is certain
and larger than that with 95 % of what its uncertainty allows. What grew and fell back since is no alarm.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from truepose.diagnosis.history import CauseObservation, CauseOverTime, Change, DatedDiagnosis, Sighting
from truepose.domain.diagnosis import Confidence, Diagnosis

_BAND: Final = 1.96  # standard uncertainties of 95 %


@dataclass(frozen=True, slots=True)
class CauseGrowth:
    """A cause whose amplitude grew, and from when to when.

    Attributes
    ----------
    cause : CauseOverTime
    change : Change
        The significant one.
    """

    cause: CauseOverTime
    change: Change


@dataclass(frozen=True, slots=True)
class NewCause:
    """A cause that was not there before.

    Attributes
    ----------
    cause : CauseOverTime
    absent_on : str
        When it was looked for and not found.
    at_most_mm : float
        How large it could have been then, RMS at the tool, 95 % [mm].
    found_on : str
    worth_mm : float
        How large it is now, RMS at the tool [mm].
    """

    cause: CauseOverTime
    absent_on: str
    at_most_mm: float
    found_on: str
    worth_mm: float


Alarm = CauseGrowth | NewCause


def alarms(causes: Sequence[CauseOverTime], diagnoses: Sequence[DatedDiagnosis]) -> tuple[Alarm, ...]:
    """Return what is larger now than before.

    Parameters
    ----------
    causes : sequence of CauseOverTime
        As `compare` returns them.
    diagnoses : sequence of DatedDiagnosis
        Those that were compared.

    Returns
    -------
    tuple of CauseGrowth or NewCause
        At most one a cause, in the order of `causes`.
    """
    known = {entry.id: entry.diagnosis for entry in diagnoses}
    found = (_grown(cause) or _appeared(cause, known) for cause in causes)
    return tuple(alarm for alarm in found if alarm is not None)


def _grown(cause: CauseOverTime) -> CauseGrowth | None:
    """Return the significant growth that ends with the last amplitude: overall, else of the last step."""
    signs = {sign.diagnosis_id: abs(sign.amplitude or 0.0) for sign in cause.signs}
    last = cause.changes[-1].to_id if cause.changes else None
    # The whole span first: slow growth may be significant over years though no single step of it is.
    for change in filter(None, (cause.overall, *cause.changes[-1:])):
        if change.significant and change.to_id == last and signs[change.to_id] > signs[change.from_id]:
            return CauseGrowth(cause, change)
    return None


def _appeared(cause: CauseOverTime, known: Mapping[int, Diagnosis]) -> NewCause | None:
    """Return a cause that was certainly smaller at the measurement before; None where that cannot be said."""
    dated = [sign for sign in cause.signs if sign.measured_at is not None]
    if len(dated) < 2 or dated[-1].confidence is not Confidence.CERTAIN:
        return None
    before, now = dated[-2:]
    # The last two dated diagnoses alone: a cause that was absent longer ago was reported in between.
    limit = _limit_mm(cause, before, known[before.diagnosis_id])
    worth = _worth_mm(cause, known[now.diagnosis_id])
    if limit is None or worth is None or worth * _surely(now) <= limit:
        return None
    return NewCause(cause, before.measured_at or "", limit, now.measured_at or "", worth)


def _limit_mm(cause: CauseOverTime, sign: CauseObservation, diagnosis: Diagnosis) -> float | None:
    """Return how large a cause could have been at most where it was not found."""
    if sign.sighting is not Sighting.NOT_FOUND:
        return None
    said = [r for r in diagnosis.ruled_out if (r.effect, r.subject) == (cause.effect, cause.subject)]
    return said[0].upper_limit_mm if said else None


def _worth_mm(cause: CauseOverTime, diagnosis: Diagnosis) -> float | None:
    """Return how large a finding of this cause is, RMS at the tool [mm]; None where it is not known."""
    for found in diagnosis.all_findings:
        if (found.effect, found.subject) == (cause.effect, cause.subject) and found.worth is not None:
            return found.worth.own_mm
    return None


def _surely(sign: CauseObservation) -> float:
    """Return the share of an amplitude that its uncertainty leaves for sure."""
    if not sign.amplitude:
        return 0.0
    relative = (sign.standard_uncertainty or 0.0) / abs(sign.amplitude)
    return max(1.0 - _BAND * relative, 0.0)
