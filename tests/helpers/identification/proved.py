"""A robot at the pairs of a proof move: as it is without a correction, and with it."""

from dataclasses import replace

import numpy as np

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.models import model_of, plain_parameters
from tests.helpers.identification.synthetic import configurations
from truepose.correction.proof import pairs_of
from truepose.domain.campaign import PointReadings, Stops
from truepose.identification.model.estimates import structure_of, values_of
from truepose.identification.model.evaluation import Targets, evaluate

N, NOISE_MM, SCATTER_MM = 40, 0.012, 0.004


def model(seed=1):
    plain = model_of(IRB_120, *plain_parameters(IRB_120, seed), repeatability_mm=SCATTER_MM)
    return replace(plain, nominal_base=plain.base)


def visited(robot, believed=None, *, n=N, noise_mm=NOISE_MM, seed=0):
    """Readings of a robot that is `robot`, at the pairs that `believed` plans."""
    believed = believed or robot
    joints = configurations(n, 100 + seed)
    nest = 1 + np.arange(n) % 2
    pairs = pairs_of(believed, Stops(np.arange(n), joints), nest)
    kept = np.flatnonzero(pairs.solved)  # as a plan leaves out what cannot be corrected
    pairs, nest, n = pairs.taken(kept), nest[kept], len(kept)
    both = np.stack([pairs.uncorrected_rad, pairs.corrected_rad], axis=1).reshape(-1, 6)
    stops = Stops(np.arange(1, 2 * n + 1), both)
    nests = np.repeat(nest, 2)
    places = evaluate(structure_of(robot), values_of(robot), Targets(stops, nests)).unscaled_mm
    scatter = np.hypot(noise_mm, SCATTER_MM)
    read = places + scatter * np.random.default_rng(seed).standard_normal(places.shape)
    return PointReadings(stops, nests, read, np.full(len(both), noise_mm))
