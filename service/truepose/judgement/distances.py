"""Errors of the distances between all pairs of points: what no frame can hide."""

from dataclasses import dataclass

import numpy as np

from truepose.domain.results.identification import NominalAndIdentified, Statistics
from truepose.domain.results.validation import DistanceErrors, SignedErrors
from truepose.identification.verdict.judge import Judged
from truepose.judgement.pairs import PairErrors, pair_errors


@dataclass(frozen=True, slots=True)
class Distances:
    """Sizes of the errors of all distances, and what only their signs tell."""

    sizes: NominalAndIdentified
    errors: DistanceErrors


def distances(judged: Judged) -> Distances | None:
    """Return the statistics over all pairs of places; None of readings that are none, or of a single one."""
    places = judged.block.place_mm
    if places is None or len(places) < 2:
        return None
    noise = _noise_mm(judged)
    nominal, identified = pair_errors(places, (judged.nominal.state.position_mm, judged.position_mm))
    return Distances(
        NominalAndIdentified(_statistics(nominal, noise), _statistics(identified, noise)),
        DistanceErrors(_signed(nominal), _signed(identified)),
    )


def _noise_mm(judged: Judged) -> float:
    """Return the mean size that noise gives: a distance sees one component of that of each of its ends."""
    block = judged.block
    covariance = block.covariance() + block.scatter_mm**2 * np.eye(block.components)
    variance = float(np.trace(covariance, axis1=1, axis2=2).mean()) / block.components
    return float(np.sqrt(2.0 / np.pi) * np.sqrt(2.0 * variance))


def _statistics(found: PairErrors, noise_mm: float) -> Statistics:
    return Statistics(
        found.n, found.mean_absolute_mm, found.rms_mm, found.sd_absolute_mm, found.largest_mm, noise_mm
    )


def _signed(found: PairErrors) -> SignedErrors:
    return SignedErrors(found.mean_mm, found.positive_share, found.histogram)
