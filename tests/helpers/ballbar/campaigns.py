"""Ballbar campaigns whose truth is the nominal robot: cups anywhere, six legs of any length at each stop."""

from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.synthetic import NESTS, configurations
from truepose.domain.campaign import (
    Campaign,
    CupReadings,
    CupSetups,
    FixtureLengths,
    LegReadings,
    PointReadings,
    Stops,
)
from truepose.domain.robot import FramePlacement, Nest
from truepose.kinematics.chain import forward, nominal_values

PATTERN = ((1, 1), (1, 2), (2, 1), (2, 2), (2, 3), (3, 1))
LENGTH_U_MM = 0.001
SETUP_U_MM = 0.01
REPEATABILITY_MM = 0.003
_TABLE = 500  # numbers of validation stops begin here


@dataclass(frozen=True)
class TrueCell:
    """Where things are."""

    cups_mm: dict[int, np.ndarray]  # placement -> (K, 3)
    nests_mm: np.ndarray


def places(joints_rad, nests_mm):
    """Nests of the nominal robot, shape (n, K, 3)."""
    chain = forward(nominal_values(IRB_120, joints_rad), np.eye(3), np.zeros(3))
    n = len(joints_rad)
    return np.stack([chain.points(np.broadcast_to(nest, (n, 3))) for nest in nests_mm], axis=1)


def ballbar_campaign(
    stops=30, placements=1, cups=3, seed=0, nests_off_mm=None, noise_mm=0.0, pattern=PATTERN
):
    """A campaign and where its things truly are; readings without noise unless asked for."""
    rng = np.random.default_rng(seed)
    nests = np.array(NESTS) + (0.0 if nests_off_mm is None else nests_off_mm)
    setups = configurations(cups * placements, seed + 50).reshape(placements, cups, 6)
    true = TrueCell({p + 1: places(setups[p], nests)[:, 0] for p in range(placements)}, nests)
    campaign = Campaign(
        robot=replace(IRB_120, repeatability_mm=REPEATABILITY_MM),
        base_nominal=FramePlacement(),
        nests=tuple(Nest(centre, 0.002) for centre in NESTS),
        legs=_legs(
            true, stops, seed, noise_mm * rng.standard_normal((stops, placements, len(pattern))), pattern
        ),
        fixture=_sides(true),
        setup=_setups(setups),
        cups=_cups(true),
        validation=_points(true, seed),
        ballbar_nominal_mm=300.0,
        ballbar_range_mm=1.0,
        setup_uncertainty_mm=SETUP_U_MM,
    )
    return campaign, true


def _legs(true, stops, seed, noise_mm, pattern):
    rows = []
    for placement, cups in true.cups_mm.items():
        joints = configurations(stops, seed + placement)
        nests = places(joints, true.nests_mm)
        for stop in range(stops):
            for k, (base, tool) in enumerate(pattern):
                length = np.linalg.norm(nests[stop, tool - 1] - cups[base - 1])
                config = 100 * placement + stop
                rows.append((
                    config,
                    joints[stop],
                    placement,
                    base,
                    tool,
                    length + noise_mm[stop, placement - 1, k],
                ))
    config, joints, placement, base, tool, length = (list(column) for column in zip(*rows, strict=True))
    return LegReadings(
        Stops(np.array(config), np.array(joints)),
        np.array(placement),
        np.array(base),
        np.array(tool),
        np.array(length),
        np.full(len(rows), LENGTH_U_MM),
    )


def _sides(true):
    rows = [
        (0, a, b, np.linalg.norm(true.nests_mm[b - 1] - true.nests_mm[a - 1]))
        for a, b in combinations((1, 2, 3), 2)
    ]
    for placement, cups in true.cups_mm.items():
        pairs = combinations(range(1, len(cups) + 1), 2)
        rows += [(placement, a, b, np.linalg.norm(cups[b - 1] - cups[a - 1])) for a, b in pairs]
    placement, a, b, length = (np.array(column) for column in zip(*rows, strict=True))
    return FixtureLengths(placement, a, b, length, np.full(len(rows), LENGTH_U_MM))


def _setups(setups):
    placements, cups, joints = setups.shape
    return CupSetups(
        np.repeat(np.arange(1, placements + 1), cups),
        np.tile(np.arange(1, cups + 1), placements),
        setups.reshape(-1, joints),
    )


def _cups(true):
    rows = [(p, k, cup) for p, cups in true.cups_mm.items() for k, cup in enumerate(cups, start=1)]
    placement, point, place = (np.array(column) for column in zip(*rows, strict=True))
    return CupReadings(placement, point, place, np.full(len(rows), 0.005))


def _points(true, seed):
    joints = configurations(60, seed + 900)
    nest = 1 + np.arange(60) % 3
    place = places(joints, true.nests_mm)[np.arange(60), nest - 1]
    return PointReadings(Stops(_TABLE + np.arange(60), joints), nest, place, np.full(60, 0.015))
