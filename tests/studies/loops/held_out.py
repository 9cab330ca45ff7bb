"""How far a calibrated arm truly is off, all over its work volume, and how far its covariance says it may be.

Neither knows where the base stands: positions are compared after the rigid motion that brings them closest.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from tests.studies.report_command import informing
from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.campaign import Campaign, Stops
from truepose.domain.identification import Identification
from truepose.identification import identify
from truepose.identification.model.derivatives import place_jacobian
from truepose.identification.model.estimates import Estimate, identified_estimate, nominal_estimate
from truepose.identification.model.evaluation import State, Targets, evaluate
from truepose.kinematics.frames import rigid_alignment
from truepose.reports.table_report import Row

_DRAWN = 200  # parameters from their covariance: the mean error is known to 3 % then


@dataclass(frozen=True, slots=True)
class HeldOut:
    """Errors of one arm at places that had no part in its calibration."""

    nominal_mm: float  # mean
    mean_mm: float
    worst_mm: float
    promised_mm: float  # mean
    answer: Identification


def errors_of(arms: Sequence[HeldOut]) -> Iterator[Row]:
    """Yield the errors of many arms as rows of a table."""
    yield informing("nominal arm, mean error", f"{np.mean([arm.nominal_mm for arm in arms]):.3f} mm")
    yield informing("calibrated, mean error", f"{np.mean([arm.mean_mm for arm in arms]):.4f} mm")
    yield informing("calibrated, worst of all arms", f"{max(arm.worst_mm for arm in arms):.3f} mm")
    yield informing("promised, mean error", f"{np.mean([arm.promised_mm for arm in arms]):.4f} mm")


def promise_ratio(arms: Sequence[HeldOut]) -> float:
    """Return the mean error of many arms over what they promise."""
    mean, promised = (np.mean([getattr(arm, name) for arm in arms]) for name in ("mean_mm", "promised_mm"))
    return float(mean / promised)


@dataclass(frozen=True, slots=True)
class Truth:
    """Where the tool truly was at n rows."""

    stops: Stops
    nest: IntArray  # (n,)
    true_mm: FloatArray  # (n, 3)

    def of_nests(self, nests: IntArray) -> "Truth":
        """Return the rows of some nests."""
        rows = np.flatnonzero(np.isin(self.nest, nests))
        return Truth(self.stops.taken(rows), self.nest[rows], self.true_mm[rows])


def held_out(campaign: Campaign, truth: Truth, nests: tuple[int, ...] = ()) -> HeldOut:
    """Calibrate, and hold the model and the nominal arm against the truth, on some nests or those read."""
    answer, readings = identify(campaign), campaign.readings
    if answer.model is None or readings is None:
        raise SystemExit(f"nothing was identified: {answer.status}")
    truth = truth.of_nests(np.array(nests) if nests else np.unique(readings.nest))
    model = identified_estimate(answer.model)
    states = [_state(one, truth) for one in (nominal_estimate(answer.model), model)]
    before, after = (_errors_mm(state.position_mm, truth.true_mm) for state in states)
    promised = float(promised_mm(states[1], model.covariance))
    return HeldOut(float(before.mean()), float(after.mean()), float(after.max()), promised, answer)


def _state(estimate: Estimate, truth: Truth) -> State:
    return evaluate(estimate.structure, estimate.values, Targets(truth.stops, truth.nest))


def _errors_mm(places_mm: FloatArray, true_mm: FloatArray) -> FloatArray:
    rotation, translation = rigid_alignment(places_mm, true_mm)
    return np.asarray(np.linalg.norm(places_mm @ rotation.T + translation - true_mm, axis=1))


def promised_mm(state: State, covariance: FloatArray) -> float:
    """Return the mean error that parameters of this covariance let expect, rigid motions taken out."""
    jacobian = place_jacobian(state)
    flat = jacobian.reshape(len(jacobian), -1)
    rigid = np.linalg.qr(_rigid_motions(state.position_mm))[0]
    bent = flat - (flat @ rigid) @ rigid.T
    widths = np.sqrt(np.maximum(np.diag(covariance), np.finfo(float).tiny))
    variances, directions = np.linalg.eigh(covariance / np.outer(widths, widths))
    sizes = np.sqrt(np.maximum(variances, 0.0))
    drawn = np.random.default_rng(0).standard_normal((_DRAWN, len(widths))) * sizes
    errors = ((drawn @ directions.T) * widths) @ bent
    return float(np.linalg.norm(errors.reshape(_DRAWN, -1, 3), axis=2).mean())


def _rigid_motions(places_mm: FloatArray) -> FloatArray:
    """Return how places move with three shifts and three turns, shape (3 n, 6)."""
    arms = places_mm - places_mm.mean(axis=0)
    shifts = [np.broadcast_to(axis, arms.shape) for axis in np.eye(3)]
    turns = [np.cross(axis, arms) for axis in np.eye(3)]
    return np.stack([motion.ravel() for motion in (*shifts, *turns)], axis=1)
