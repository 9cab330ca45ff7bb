"""Certified tool nests as parameters: lengths are finer than certificates."""

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray, distinct_values
from truepose.domain.measurement.campaign import Campaign, FixtureLengths
from truepose.effects.tool.tool_certificate import NAME as TOOL_CERTIFICATE
from truepose.effects.tool.tool_certificate import certificate_specs
from truepose.identification.distributions import chi2_limit
from truepose.identification.model.parameters.structure import Structure
from truepose.identification.problem.setting import unknown_nests

_CONTRADICTION_LEVEL = 1e-3  # at which a measured triangle is found to contradict the nests' certificates


def with_certified_nests(
    structure: Structure, start: FloatArray, campaign: Campaign, nest: IntArray
) -> tuple[Structure, FloatArray]:
    """Let the certified ones among the nests (n,) of lengths move within their certificates."""
    known = sorted(set(distinct_values(nest).tolist()) - set(unknown_nests(campaign)))
    stated = {k: campaign.nests[k - 1].standard_uncertainty_mm for k in known}
    wider = _certificates_contradicted(campaign)
    specs = certificate_specs({k: wider * u for k, u in stated.items() if u})
    if not specs:
        return structure, start
    return structure.extended(TOOL_CERTIFICATE, specs), np.concatenate([start, np.zeros(len(specs))])


def _certificates_contradicted(campaign: Campaign) -> float:
    """Return how much wider than certified nests scatter, by the measured triangle of the tool; 1 or more."""
    fixture = campaign.fixture
    if fixture is None:
        return 1.0
    from truepose.identification.observations.fixture import TOOL_PLACEMENT  # few have one

    tool = np.flatnonzero(fixture.placement == TOOL_PLACEMENT).tolist()
    squares = [square for row in tool if (square := _against_certificate(campaign, fixture, row)) is not None]
    total = float(np.sum(squares))
    if not squares or total <= chi2_limit(_CONTRADICTION_LEVEL, len(squares)):
        return 1.0
    return float(np.sqrt(total / len(squares)))


def _against_certificate(campaign: Campaign, fixture: FixtureLengths, row: int) -> float | None:
    """Return the square of a side's deviation from its certificate over its variance, None without one."""
    ends = (int(fixture.point_a[row]), int(fixture.point_b[row]))
    if max(ends) > len(campaign.nests):
        return None
    first, second = (campaign.nests[end - 1] for end in ends)
    if first.centre_mm is None or second.centre_mm is None:
        return None
    off_mm = float(fixture.length_mm[row] - np.linalg.norm(np.subtract(first.centre_mm, second.centre_mm)))
    stated = (first.standard_uncertainty_mm or 0.0, second.standard_uncertainty_mm or 0.0)
    return off_mm**2 / (float(fixture.standard_uncertainty_mm[row]) ** 2 + stated[0] ** 2 + stated[1] ** 2)
