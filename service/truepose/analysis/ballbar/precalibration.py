"""The pre-calibration of a ballbar session: identify with what is there, aim the rest, test what was read."""

from collections.abc import Collection, Sequence
from dataclasses import replace
from operator import itemgetter
from typing import Final

import numpy as np

from truepose.analysis.ballbar.assembly import Counting, assemble_ballbar_campaign
from truepose.analysis.ballbar.early_forecasts import EarlyForeseen
from truepose.analysis.ballbar.forecasts import Foreseen
from truepose.analysis.ballbar.next_poses import next_poses
from truepose.analysis.errors import NothingMeasuredError
from truepose.domain.cell.artefacts import BallbarKit
from truepose.domain.measurement.ballbar import BallbarPlan, PlannedPose, PoseForecast, PreCalibration
from truepose.domain.results.identification import Identification, Status
from truepose.identification import identify
from truepose.judgement.ball_pairs.judge import judge_pose
from truepose.planning.ballbar.lengths.beforehand import known_beforehand
from truepose.planning.ballbar.plan import ballbar_cell
from truepose.storage.records import SessionSetup
from truepose.words.catalogue import english

_FEWEST_LEGS: Final = 24  # from four poses on something is foreseen
_TIMES_UNKNOWNS: Final = 2
_ROUNDS: Final = 3  # of identifying without the poses whose legs turned out exchanged
_EFFECTS: Final = (None, ("geometry",), ("joint_offset",))  # None: what a whole campaign is given
_WELL_FORESEEN_MM: Final = 0.06  # a wrong pair can be named then; between that and the range, less is better
_USABLE: Final = frozenset({Status.CONVERGED, Status.NOT_CONVERGED})


def precalibrate(setup: SessionSetup, plan: BallbarPlan, counting: Counting) -> PreCalibration:
    """Return where to aim from now on, and which lengths to expect there.

    Parameters
    ----------
    setup : SessionSetup
    plan : BallbarPlan
    counting : Counting
        What counts of the session so far.

    Raises
    ------
    NothingMeasuredError
        The legs do not identify a model yet; the sentence says why.
    """
    kit = setup.cell.ballbar or BallbarKit()
    standing = counting.standing
    if standing is None:
        raise NothingMeasuredError("The arm has not moved yet; measure a few poses first.")
    early = _foreseen_early(setup, plan, kit, counting)
    refuted = set() if early is None else {k.config for k in counting.legs if k.stop in early.refuted()}
    foreseen: Foreseen | EarlyForeseen
    if early is not None and _are_few(counting, early):
        foreseen, rms_mm, exchanged = early, early.rms_mm(_without(counting, refuted)), refuted
    else:
        foreseen, rms_mm, exchanged = _fitted(setup, plan, kit, counting, refuted)
    poses = next_poses(ballbar_cell(setup.cell), plan, counting, standing, exchanged, foreseen)
    planned = {pose.config: pose for placement in plan.placements for pose in placement.poses}
    return PreCalibration(
        poses=poses,
        forecasts=foreseen.forecasts([*{**planned, **{pose.config: pose for pose in poses}}.values()]),
        rms_mm=rms_mm,
        configurations=len({kept.stop for kept in counting.legs if kept.config not in exchanged}),
        exchanged=tuple(sorted(exchanged)),
    )


def _foreseen_early(
    setup: SessionSetup, plan: BallbarPlan, kit: BallbarKit, counting: Counting
) -> EarlyForeseen | None:
    known = known_beforehand(setup.cell, plan, kit)
    return None if known is None else EarlyForeseen(known, kit, counting)


def _are_few(counting: Counting, early: EarlyForeseen) -> bool:
    """Whether a fit would hardly have more lengths than unknowns, and claim more than it knows."""
    return _FEWEST_LEGS <= len(counting.legs) < _TIMES_UNKNOWNS * early.fitted


def _fitted(
    setup: SessionSetup, plan: BallbarPlan, kit: BallbarKit, counting: Counting, refuted: Collection[int]
) -> tuple[Foreseen, float, set[int]]:
    """Return what a fit foresees, what it leaves of the legs, and the poses whose legs were exchanged.

    Poses that all readings together speak against are left out from the start: a fit bends to them.
    """
    exchanged = set(refuted)
    for _ in range(_ROUNDS):
        found, foreseen = _identified(setup, plan, kit, _without(counting, exchanged))
        more = _exchanged(counting, foreseen.forecasts(_measured_poses(counting)), kit)
        if more <= exchanged:
            break
        exchanged |= more
    return foreseen, found.calibration.identified.rms_mm if found.calibration else float("nan"), exchanged


def _identified(
    setup: SessionSetup, plan: BallbarPlan, kit: BallbarKit, counting: Counting
) -> tuple[Identification, Foreseen]:
    """Return the model that foresees the planned legs best, the richest one where it foresees them well.

    A handful of legs carries a rich model without a residual, and then its poses are aimed by what the priors
    leave open: by millimetres, where a poorer model says tenths.
    """
    campaign = assemble_ballbar_campaign("the session so far", setup, kit, counting)
    answers: list[tuple[float, Identification, Foreseen]] = []
    for effects in _EFFECTS:
        found = identify(campaign, effects)
        if found.model is None or found.status not in _USABLE:
            continue
        foreseen = Foreseen(found.model, plan, kit)
        answers.append((_typical_u_mm(foreseen, plan), found, foreseen))
        if answers[-1][0] <= _WELL_FORESEEN_MM:
            break
    if not answers:
        why = english(found.message)
        raise NothingMeasuredError(
            f"The legs so far do not identify the arm: {why} Measure more poses, then try again."
        )
    _, found, foreseen = min(answers, key=itemgetter(0))
    return found, foreseen


def _typical_u_mm(foreseen: Foreseen, plan: BallbarPlan) -> float:
    """Return the standard uncertainty that half of the planned pairs are foreseen within."""
    forecasts = foreseen.forecasts([pose for placement in plan.placements for pose in placement.poses])
    return float(np.median([np.sqrt(np.diag(forecast.covariance_mm2)) for forecast in forecasts]))


def _without(counting: Counting, exchanged: Collection[int]) -> Counting:
    return replace(counting, legs=tuple(kept for kept in counting.legs if kept.config not in exchanged))


def _measured_poses(counting: Counting) -> list[PlannedPose]:
    """Return the stops that were measured, under the numbers that they have in the campaign."""
    stops = {
        kept.stop: PlannedPose(kept.stop, kept.placement, kept.arrival.commanded_rad, ())
        for kept in counting.legs
    }
    return list(stops.values())


def _exchanged(counting: Counting, forecasts: Sequence[PoseForecast], kit: BallbarKit) -> set[int]:
    """Return the poses that hold a reading of another pair than the one that was asked for."""
    found = set()
    for forecast in forecasts:
        of_stop = [kept for kept in counting.legs if kept.stop == forecast.config]
        lengths = {kept.leg: kept.length.length_mm for kept in of_stop}
        suspicions = judge_pose(lengths, forecast, reading_u_mm=kit.reading_u_mm, zero_u_mm=kit.zero_u_mm)
        if any(suspicion.suspected is not None for suspicion in suspicions):
            found.add(of_stop[0].config)
    return found
