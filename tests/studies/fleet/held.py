"""What an account of a fleet names, held against what was planted."""

from dataclasses import dataclass, field
from typing import Final

import numpy as np

from tests.studies.fleet.simulated import DAYS_A_MONTH, MONTHS, SCALE_DRIFT, Ageing, FleetTruth
from truepose.fleet.changes import Account, RealChange
from truepose.fleet.trend import passing

LIMIT_MM: Final = 0.1
_PHASE_RAD: Final = np.radians(40.0)  # of waves that grow


@dataclass(frozen=True, slots=True)
class Held:
    """One fleet."""

    seed: int
    planted: int  # changes: robots and a tracker
    right: int  # named with robot or tracker, cause, joint and order, as even growth since the first month
    alone: int  # of those, with no rival but itself
    missed: int
    false: int
    birge_ratio: float
    covered: list[bool] = field(
        default_factory=list
    )  # the true day of passing lies in the 90 % that was stated
    named: list[str] = field(default_factory=list)


def held(truth: FleetTruth, account: Account) -> Held:
    """Compare."""
    planted = len(truth.ageing) + (truth.drifting is not None)
    right = [one for one in account.named if _is_right(truth, one)]
    return Held(
        seed=truth.seed,
        planted=planted,
        right=len(right),
        alone=sum(not one.rivals for one in right),
        missed=planted - len(right),
        false=len(account.named) - len(right),
        birge_ratio=account.birge_ratio,
        covered=[_covered(truth, account, one) for one in right],
        named=[_said(one) for one in account.named],
    )


def _is_right(truth: FleetTruth, named: RealChange) -> bool:
    change, cause = named.change, named.change.cause
    if change.kind != "linear" or change.since != 0.0:
        return False
    if change.scope == "instrument":
        return change.of == truth.drifting
    worn = truth.ageing.get(change.of) if change.scope == "robot" else None
    return worn is not None and (cause.effect, cause.subject, cause.order) == (
        worn.effect,
        worn.subject,
        worn.order,
    )


def _covered(truth: FleetTruth, account: Account, named: RealChange) -> bool:
    found = passing(account.fleet, named, LIMIT_MM)
    if found is None:
        return False
    size = _true_size_mm(truth, account, named)
    true = LIMIT_MM * MONTHS * DAYS_A_MONTH / size
    return found.earliest <= true <= found.latest


def _true_size_mm(truth: FleetTruth, account: Account, named: RealChange) -> float:
    fleet, directions = account.fleet, named.change.cause.directions
    if named.change.scope == "instrument":
        amount = np.array([SCALE_DRIFT / 1e-4])
    else:
        place = [int(np.argmax(column)) for column in directions.T]
        amount = _parts(truth.ageing[named.change.of]) / fleet.widths[place]
    moved = directions @ amount
    return float(np.sqrt(moved @ fleet.motion_mm2 @ moved))


def _parts(worn: Ageing) -> np.ndarray:
    if worn.effect == "compliance":
        return np.array([worn.amplitude])
    angle = np.radians(worn.amplitude)
    return angle * np.array([np.cos(_PHASE_RAD), np.sin(_PHASE_RAD)]) if worn.order else np.array([angle])


def _said(named: RealChange) -> str:
    change, cause = named.change, named.change.cause
    rivals = [f"{one.change.of} {one.change.cause.subject} {one.change.kind}" for one in named.rivals[:3]]
    since = f"{change.kind} since day {change.since:g}"
    size = f"{1e3 * named.size_mm:.0f} +- {1e3 * named.size_u_mm:.0f} um, ratio {named.trial.ratio:.0f}"
    where = f"{change.scope} {change.of}: {cause.effect} {cause.subject} {cause.order:g}"
    return ", ".join([where, since, size, *(f"or {rival}" for rival in rivals)])
