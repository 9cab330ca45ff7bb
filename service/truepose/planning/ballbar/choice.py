"""Which configurations of all placements are measured: by observability, the cups being unknown too."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.measurement.ballbar import PlannedSetup
from truepose.kinematics.pose_device import Assembly
from truepose.planning.ballbar.fixture import BaseFixture
from truepose.planning.ballbar.lengths.information import (
    ArmModel,
    Gathered,
    PoseRows,
    WorkSpaceSample,
    error_weight,
    gathered,
    of_poses,
    pose_rows,
    setting_information,
    with_placement,
)
from truepose.planning.ballbar.lengths.least_error import exchanged_for_error
from truepose.planning.ballbar.poses import Reached, reach
from truepose.planning.choice_by_exchange import choose_by_exchange


@dataclass(frozen=True, slots=True)
class Candidates:
    """What can be measured from one placement."""

    fixture: BaseFixture
    found: Reached
    rows: PoseRows
    setting: FloatArray  # (P + 3 K, P + 3 K) information of priors, set-ups and sides

    def __len__(self) -> int:
        return len(self.found)


def candidates(
    model: ArmModel,
    fixture: BaseFixture,
    setups: Sequence[PlannedSetup] | None = None,
    made: Sequence[Assembly] | None = None,
) -> Candidates:
    """Return all measurable configurations of a placement with what they say."""
    found = reach(model.cell, fixture, made)
    return _with_rows(model, fixture, found, setups)


def of_candidates(
    model: ArmModel, offer: Candidates, setups: Sequence[PlannedSetup] | None = None
) -> Candidates:
    """Return what the same configurations say by another model of the arm."""
    return _with_rows(model, offer.fixture, offer.found, setups)


def _with_rows(
    model: ArmModel, fixture: BaseFixture, found: Reached, setups: Sequence[PlannedSetup] | None
) -> Candidates:
    legs = [assembly.legs for assembly in found.assembly]
    joints = None if setups is None else np.array([setup.joints_rad for setup in setups])
    return Candidates(
        fixture,
        found,
        pose_rows(model, fixture.cups_mm, found.joints_rad, legs),
        setting_information(model, fixture.cups_mm, joints),
    )


def known_after(
    model: ArmModel, placements: Sequence[Candidates], chosen: Sequence[IntArray | None], n: int | None = None
) -> Gathered:
    """Return what a session will know.

    Parameters
    ----------
    model : ArmModel
    placements : sequence of Candidates
    chosen : sequence of ndarray or None
        Configurations of each placement; None: all of them, weighed as if there were its share of `n`.
    n : int, optional
        Configurations of the whole session, where some are not chosen yet.
    """
    known = gathered(model)
    for own, rows in zip(placements, chosen, strict=True):
        weight = 1.0 if rows is not None or n is None else n / len(placements) / max(1, len(own))
        information = own.setting + of_poses(own.rows, rows, weight)
        known = with_placement(known, information, own.fixture.cups_mm)
    return known


def choose(
    model: ArmModel,
    placements: Sequence[Candidates],
    n: int,
    rng: np.random.Generator,
    sample: WorkSpaceSample | None = None,
) -> tuple[IntArray, ...]:
    """Choose n configurations of all placements together, by observability, then by the error that is left.

    Parameters
    ----------
    model : ArmModel
    placements : sequence of Candidates
    n : int
    rng : numpy.random.Generator
        Draws the start.
    sample : WorkSpaceSample, optional
        Where errors count; without it the choice rests on O1 alone.

    Returns
    -------
    tuple of ndarray
        Indices into the candidates of each placement, ascending; all of them where there are no more than n.

    Raises
    ------
    ConfigurationError
        Fewer than one configuration was asked for.
    """
    counts = [len(own) for own in placements]
    if sum(counts) <= n:
        return tuple(np.arange(count, dtype=np.int64) for count in counts)
    prior = known_after(model, placements, [np.zeros(0, dtype=np.int64)] * len(placements))
    rows = stacked_rows(model, placements, len(prior.matrix))
    chosen = choose_by_exchange(rows, n, rng, prior_information=prior.matrix).indices
    if sample is not None:
        weight = error_weight(prior.cups_mm, sample)
        chosen = exchanged_for_error(rows, chosen, prior.matrix, weight)
    ends = np.cumsum(counts)
    return tuple(
        chosen[(chosen >= end - count) & (chosen < end)] - (end - count)
        for count, end in zip(counts, ends, strict=True)
    )


def stacked_rows(model: ArmModel, placements: Sequence[Candidates], columns: int) -> FloatArray:
    """Return the whitened derivatives of all candidates in arm and all cups, shape (N, L, columns)."""
    total, legs = sum(len(own) for own in placements), max(own.rows.arm.shape[1] for own in placements)
    stacked = np.zeros((total, legs, columns))
    row, column = 0, model.parameters
    for own in placements:
        n, lines, width = own.rows.cups.shape
        stacked[row : row + n, :lines, : model.parameters] = own.rows.arm
        stacked[row : row + n, :lines, column : column + width] = own.rows.cups
        row, column = row + n, column + width
    return stacked
