"""Spectra: a joint's waves by their order, where a finding has several."""

from truepose.diagnosis.evidence.sensitivities import values_of
from truepose.diagnosis.screening.groups import names_of
from truepose.diagnosis.screening.selection import Selected
from truepose.domain.results.causes import Spectrum
from truepose.effects.causes import Candidate, Fitted
from truepose.effects.joints.joint_harmonics import NAME as HARMONICS
from truepose.effects.joints.joint_harmonics import spectrum


def finding_spectrum(selected: Selected, group: tuple[Candidate, ...]) -> Spectrum | None:
    """Return the amplitudes of a finding's waves; None where it is no sum of several."""
    if group[0].effect != HARMONICS:
        return None
    names = names_of(group)
    found = spectrum(Fitted(names, *values_of(selected, names)))
    return found if len(found.order) > 1 else None
