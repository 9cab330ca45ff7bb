"""The plan of a ballbar session, and its pre-calibration: identify, aim the rest, test what was read.

Poses of the present placement come in a new order, on clear ways from where the arm stands; one to which no
clear way leads is left out. The last planned one stays the last: the arm is out of the way there while the
fixture is put elsewhere. Later placements keep their order and ways; aiming turns their joints by tenths of a
degree at most.
"""

from collections.abc import Collection, Sequence
from dataclasses import replace
from operator import itemgetter
from typing import Final

import numpy as np

from truepose.analysis.ballbar_forecasts import EarlyForecast, LengthForecast
from truepose.analysis.campaigns.ballbar import RestPose, ValidReadings, assemble_ballbar_campaign
from truepose.analysis.errors import NothingMeasuredError
from truepose.domain.ballbar import (
    BallbarPlan,
    PlannedPlacement,
    PlannedPose,
    PoseForecast,
    PreCalibration,
    SpherePlanRequest,
)
from truepose.domain.cell import BallbarKit, Cell
from truepose.domain.identification import Identification, Status
from truepose.domain.robot import FramePlacement
from truepose.identification import identify
from truepose.messages.message import message
from truepose.planning.ballbar.bodies import BallbarCell, BaseFixture, base_fixture
from truepose.planning.ballbar.length_forecast import forecast_lengths
from truepose.planning.ballbar.length_targets import aimed_again, coded_or_kept
from truepose.planning.ballbar.plan import ballbar_cell, ballbar_plan, plan_at
from truepose.planning.ballbar.sphere import plan_sphere
from truepose.storage.records import SessionSetup
from truepose.validation.connection_check import judge_pose


def plan_ballbar_session(
    cell: Cell,
    frames: Sequence[FramePlacement],
    *,
    placements: int,
    poses: int,
    seed: int,
    sphere: SpherePlanRequest | None,
) -> BallbarPlan:
    """Return the plan that is asked for; raises as `truepose.planning.ballbar.plan.ballbar_plan`.

    Without `frames` the base fixture is placed here; a test by a `sphere` has exactly one.
    """
    kit = cell.ballbar or BallbarKit()
    side_mm = kit.base_bars.nominal_mm
    if sphere is not None:
        (place,) = frames
        ball = base_fixture(1, place, kit.base_points, side_mm)
        return plan_sphere(ballbar_cell(cell), ball, sphere, seed=seed)
    if not frames:
        return ballbar_plan(cell, placements=placements, base_points=kit.base_points, poses=poses, seed=seed)
    numbered = enumerate(frames, 1)
    fixtures = [base_fixture(number, frame, kit.base_points, side_mm) for number, frame in numbered]
    return plan_at(ballbar_cell(cell), fixtures, poses, seed=seed)


def next_poses(
    arm: BallbarCell,
    plan: BallbarPlan,
    counting: ValidReadings,
    standing: RestPose,
    exchanged: Collection[int],
    foreseen: LengthForecast | EarlyForecast,
) -> tuple[PlannedPose, ...]:
    """Return what is to be measured from now on, in order.

    Parameters
    ----------
    arm : BallbarCell
    plan : BallbarPlan
    counting : ValidReadings
    standing : RestPose
        Where the arm is, and at which placement.
    exchanged : collection of int
        Poses whose legs were confused: to be measured again.
    foreseen : LengthForecast or EarlyForecast
        What the poses are aimed by.
    """
    found: list[PlannedPose] = []
    for placement in plan.placements:
        left = [pose for pose in placement.poses if _is_left(pose, counting, exchanged)]
        if placement.number == standing.placement:
            after = next((one for one in plan.placements if one.number > placement.number), None)
            found += _here(arm, placement, after, left, standing, foreseen)
        elif placement.number > standing.placement:
            # Later placements keep their order and their ways, which were planned with the fixture that is
            # not there yet; only joints are turned.
            found += [coded_or_kept(arm, pose, foreseen.lengths_of(pose))[0] for pose in left]
    return tuple(found)


def _is_left(pose: PlannedPose, counting: ValidReadings, exchanged: Collection[int]) -> bool:
    """Whether a pose is to be measured, all of it: its fixture must not move between its legs."""
    kept = {leg.leg for leg in counting.legs if leg.config == pose.config}
    return pose.config in exchanged or not set(pose.legs) <= kept


def _here(
    arm: BallbarCell,
    placement: PlannedPlacement,
    after: PlannedPlacement | None,
    left: list[PlannedPose],
    standing: RestPose,
    foreseen: LengthForecast | EarlyForecast,
) -> tuple[PlannedPose, ...]:
    if not left:
        return ()
    return aimed_again(
        arm,
        _fixture(placement),
        left,
        foreseen.lengths_of,
        standing.joints_rad,
        last=placement.poses[-1].config,
        after=None if after is None else _fixture(after),
    ).poses


def _fixture(placement: PlannedPlacement) -> BaseFixture:
    return BaseFixture(placement.number, placement.frame, np.array(placement.cups_mm))


_FEWEST_LEGS: Final = 24  # from four poses on something is foreseen
_TIMES_UNKNOWNS: Final = 2
_ROUNDS: Final = 3  # of identifying without the poses whose legs turned out exchanged
_EFFECTS: Final = (None, ("geometry",), ("joint_offset",))  # None: what a whole campaign is given
_WELL_FORESEEN_MM: Final = 0.06  # a wrong pair can be named then; between that and the range, less is better
_USABLE: Final = frozenset({Status.CONVERGED, Status.NOT_CONVERGED})


def precalibrate(setup: SessionSetup, plan: BallbarPlan, counting: ValidReadings) -> PreCalibration:
    """Return where to aim from now on, and which lengths to expect there.

    Parameters
    ----------
    setup : SessionSetup
    plan : BallbarPlan
    counting : ValidReadings
        What counts of the session so far.

    Raises
    ------
    NothingMeasuredError
        The legs do not identify a model yet; the sentence says why.
    """
    kit = setup.cell.ballbar or BallbarKit()
    standing = counting.standing
    if standing is None:
        raise NothingMeasuredError(message("refused.arm_not_moved"))
    early = _foreseen_early(setup, plan, kit, counting)
    # Poses that the accounts of all readings speak against are out before any fit: one wrong pair bends a fit
    # of few legs until all of them look right.
    refuted = set() if early is None else {k.config for k in counting.legs if k.stop in early.refuted()}
    foreseen: LengthForecast | EarlyForecast
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
    setup: SessionSetup, plan: BallbarPlan, kit: BallbarKit, counting: ValidReadings
) -> EarlyForecast | None:
    known = forecast_lengths(setup.cell, plan, kit)
    return None if known is None else EarlyForecast(known, kit, counting)


def _are_few(counting: ValidReadings, early: EarlyForecast) -> bool:
    """Whether a fit would hardly have more lengths than unknowns, and claim more than it knows."""
    return _FEWEST_LEGS <= len(counting.legs) < _TIMES_UNKNOWNS * early.fitted


def _fitted(
    setup: SessionSetup, plan: BallbarPlan, kit: BallbarKit, counting: ValidReadings, refuted: Collection[int]
) -> tuple[LengthForecast, float, set[int]]:
    """Return what a fit foresees, what it leaves of the legs, and the poses whose legs were exchanged.

    Poses that all readings together speak against are left out from the start: a fit bends to them.
    """
    exchanged = set(refuted)
    found, foreseen = _identified(setup, plan, kit, _without(counting, exchanged))
    for _ in range(_ROUNDS):
        more = _exchanged(counting, foreseen.forecasts(_measured_poses(counting)), kit)
        # What a fit without them foresees can find further ones; where it finds no more, the next round would
        # be the same.
        if more <= exchanged:
            break
        exchanged |= more
        found, foreseen = _identified(setup, plan, kit, _without(counting, exchanged))
    return foreseen, found.calibration.identified.rms_mm if found.calibration else float("nan"), exchanged


def _identified(
    setup: SessionSetup, plan: BallbarPlan, kit: BallbarKit, counting: ValidReadings
) -> tuple[Identification, LengthForecast]:
    """Return the model that foresees the planned legs best, the richest one where it foresees them well.

    A handful of legs carries a rich model without a residual, and then its poses are aimed by what the priors
    leave open: by millimetres, where a poorer model says tenths.
    """
    campaign = assemble_ballbar_campaign("the session so far", setup, kit, counting)
    answers: list[tuple[float, Identification, LengthForecast]] = []
    for effects in _EFFECTS:
        found = identify(campaign, effects)
        if found.model is None or found.status not in _USABLE:
            continue
        foreseen = LengthForecast(found.model, plan, kit)
        answers.append((_typical_u_mm(foreseen, plan), found, foreseen))
        # The richest comes first; where it foresees well enough to name a wrong pair, no poorer one is
        # needed.
        if answers[-1][0] <= _WELL_FORESEEN_MM:
            break
    if not answers:
        raise NothingMeasuredError(message("refused.lengths_do_not_identify", why=found.message))
    _, found, foreseen = min(answers, key=itemgetter(0))
    return found, foreseen


def _typical_u_mm(foreseen: LengthForecast, plan: BallbarPlan) -> float:
    """Return the standard uncertainty that half of the planned pairs are foreseen within."""
    forecasts = foreseen.forecasts([pose for placement in plan.placements for pose in placement.poses])
    return float(np.median([np.sqrt(np.diag(forecast.covariance_mm2)) for forecast in forecasts]))


def _without(counting: ValidReadings, exchanged: Collection[int]) -> ValidReadings:
    return replace(counting, legs=tuple(kept for kept in counting.legs if kept.config not in exchanged))


def _measured_poses(counting: ValidReadings) -> list[PlannedPose]:
    """Return the stops that were measured, under the numbers that they have in the campaign."""
    stops = {
        kept.stop: PlannedPose(kept.stop, kept.placement, kept.arrival.commanded_rad, ())
        for kept in counting.legs
    }
    return list(stops.values())


def _exchanged(counting: ValidReadings, forecasts: Sequence[PoseForecast], kit: BallbarKit) -> set[int]:
    """Return the poses that hold a reading of another pair than the one that was asked for."""
    found = set()
    for forecast in forecasts:
        of_stop = [kept for kept in counting.legs if kept.stop == forecast.config]
        lengths = {kept.leg: kept.length.length_mm for kept in of_stop}
        suspicions = judge_pose(
            lengths,
            forecast,
            reading_u_mm=kit.reading_u_mm,
            zero_u_mm=kit.zero_u_mm,
            range_mm=kit.range_mm,
        )
        if any(suspicion.suspected is not None for suspicion in suspicions):
            found.add(of_stop[0].config)
    return found
