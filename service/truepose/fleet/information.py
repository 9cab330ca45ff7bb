r"""What one campaign tells of its robot and its instrument, as information, without the priors of the robot.

At the campaign's own fit p0 the whitened readings are r = J (p - p0) + noise, so that all they say of p is

    A = J J^T        b = J r + A p0

What concerns the set-up alone (base, unknown nests, certificates of what stands on the table) is integrated
out with its priors (Schur complement); the parameters of the arm and the instrument's scale remain. That is
second order in p - p0: derivatives of an arm change by as little as its errors are small beside its lengths.

References
----------
D. A. Harville, J. American Statistical Association 72, 1977, 320-338.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray
from truepose.domain.definite import inverse
from truepose.domain.measurement.campaign import Campaign
from truepose.domain.robot import Robot
from truepose.effects.instruments.instrument_scale import NAME as SCALE
from truepose.effects.joints.joint_harmonics import NAME as WAVES
from truepose.effects.joints.joint_harmonics import wave_specs
from truepose.effects.links.thermal_growth import NAME as GROWTH
from truepose.effects.ports import ParameterSpec, Trait
from truepose.effects.registry import effects_with
from truepose.identification.fit.robust import RobustFit, robust_fit
from truepose.identification.problem.build import Problem, automatic_effects, build

# What ages: springs and gaps of gears, their waves; and the scale of what measures them.
AGEING: Final = ("backlash", WAVES, SCALE)
_BEYOND_TWO: Final = (3.0,)  # periods per turn, beside those that every robot may have


@dataclass(frozen=True, slots=True)
class Information:
    """What a campaign tells of P parameters, in their own units."""

    specs: tuple[ParameterSpec, ...]  # with what was believed before any reading
    owners: tuple[str, ...]  # effect of each
    normal: FloatArray  # (P, P) information
    right: FloatArray  # (P,) so that normal @ p = right where the campaign alone puts p
    motion_mm2: FloatArray  # (P, P) mean over the readings of products of motions per unit
    readings: int
    temperature_c: float | None = None  # mean of its stops; None: not of all of them is it known

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters."""
        return tuple(spec.name for spec in self.specs)


def fleet_effects(campaign: Campaign) -> tuple[str, ...]:
    """Return what a campaign of a fleet is identified with: the usual effects, and those that age.

    Growth of the links with the temperature is among them where that is known, so that lengths are those of
    20 degC in any season.
    """
    usual = automatic_effects(campaign)
    told = campaign.readings is not None and campaign.readings.stops.direction is not None
    ageing = tuple(name for name in AGEING if told or name != "backlash")
    warm = () if _temperature_c(campaign) is None else (GROWTH,)
    return (*usual, *(name for name in (*ageing, *warm) if name not in usual))


def effects_of_robot(campaign: Campaign) -> tuple[str, ...]:
    """Return those of `fleet_effects` that are the robot's: all but the instrument's scale."""
    return tuple(name for name in fleet_effects(campaign) if name != SCALE)


def _temperature_c(campaign: Campaign) -> float | None:
    readings = campaign.readings
    known = None if readings is None else readings.stops.temperature_c
    return None if known is None or not np.isfinite(known).all() else float(known.mean())


def information_of(campaign: Campaign, effects: tuple[str, ...] | None = None) -> Information:
    """Return what a campaign tells.

    Parameters
    ----------
    campaign : Campaign
    effects : tuple of str, optional
        By default those of `fleet_effects`; with waves among them, those of the gears too, where their ratios
        are known.

    Raises
    ------
    UnknownEffectError, ConfigurationError
        As `identify` does.
    """
    problem = with_gear_waves(build(campaign, effects or fleet_effects(campaign)), campaign.robot)
    fitted = robust_fit(problem.structure, problem.blocks, problem.start)
    told = _without_the_set_up(_of_fit(fitted, problem.structure.specs), _of_the_set_up(fitted))
    return replace(told, temperature_c=_temperature_c(campaign))


def with_gear_waves(problem: Problem, robot: Robot) -> Problem:
    """Return a problem with three waves per turn and the waves of the gears, where it has waves at all."""
    structure = problem.structure
    if WAVES not in structure.effects:
        return problem
    specs = tuple(
        spec
        for joint, ratio in enumerate(robot.gear_ratios or ())
        for order in (*_BEYOND_TWO, ratio, 2.0 * ratio)
        for spec in wave_specs(joint, order)
        if spec.name not in structure.names
    )
    extended = structure.extended(WAVES, specs)
    return replace(problem, structure=extended, start=np.append(problem.start, np.zeros(len(specs))))


def _of_fit(fitted: RobustFit, specs: tuple[ParameterSpec, ...]) -> Information:
    joint = fitted.solution.final
    motion = fitted.results[0].jacobian
    normal = joint.jacobian @ joint.jacobian.T
    return Information(
        specs,
        fitted.structure.owners,
        normal,
        joint.jacobian @ joint.residual + normal @ fitted.values,
        np.einsum("pnd,qnd->pq", motion, motion, optimize=True) / motion.shape[1],
        int(fitted.blocks[0].counts.sum()),
    )


def _of_the_set_up(fitted: RobustFit) -> BoolArray:
    """Return which parameters concern the set-up of this campaign only, shape (P,)."""
    own = {*effects_with(Trait.PLACING), *effects_with(Trait.NUISANCE)}
    return np.array([owner in own for owner in fitted.structure.owners])


def _without_the_set_up(told: Information, of_set_up: BoolArray) -> Information:
    """Integrate parameters out, with their priors."""
    keep, out = np.flatnonzero(~of_set_up), np.flatnonzero(of_set_up)
    means, widths = (np.array([told.specs[k][i] for k in out.tolist()], dtype=float) for i in (2, 3))
    lost = told.normal[np.ix_(out, out)] + np.diag(1.0 / widths**2)
    gain = (inverse(lost) @ told.normal[np.ix_(out, keep)]).T
    normal = told.normal[np.ix_(keep, keep)] - gain @ told.normal[np.ix_(out, keep)]
    return Information(
        tuple(told.specs[k] for k in keep.tolist()),
        tuple(told.owners[k] for k in keep.tolist()),
        0.5 * (normal + normal.T),
        told.right[keep] - gain @ (told.right[out] + means / widths**2),
        told.motion_mm2[np.ix_(keep, keep)],
        told.readings,
    )
