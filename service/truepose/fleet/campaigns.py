r"""The campaigns of robots of one type, and what each tells of its robot and its instrument.

A campaign is its information, without the priors of the robot. At its own fit p0 the whitened readings are r
= J (p - p0) + noise, so that all they say of p is

    A = J J^T        b = J r + A p0

What concerns the set-up alone (base, unknown nests, certificates of what stands on the table) is integrated
out with its priors (Schur complement); the parameters of the arm and the instrument's scale remain. That is
second order in p - p0: derivatives of an arm change by as little as its errors are small beside its lengths.

Campaigns are brought to the same parameters, counted from their stated means m in their stated widths w:

    A' = diag(w) A diag(w)        b' = diag(w) (b - A m)

References
----------
D. A. Harville, J. American Statistical Association 72, 1977, 320-338.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.domain.campaign import Campaign
from truepose.domain.errors import ConfigurationError
from truepose.domain.robot import Robot
from truepose.domain.singular_covariance import inverse
from truepose.effects.ports import ParameterSpec, Trait
from truepose.effects.registry import effect_named, effects_with
from truepose.effects.waves import wave_specs
from truepose.identification.fit.robust import RobustFit, robust_fit
from truepose.identification.problem.build import Problem, automatic_effects, build

(SCALE,), (GROWTH,), (WAVES,) = map(effects_with, (Trait.SCALE, Trait.OF_MATERIAL, Trait.WAVES))
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

    Parameters
    ----------
    campaign : Campaign

    Returns
    -------
    tuple of str
        Names of effects, the usual ones first.
    """
    usual = automatic_effects(campaign)
    told = campaign.readings is not None and campaign.readings.stops.direction is not None
    # A gap shows only where it is known from which side each joint came.
    ageing = (
        name for name in effects_with(Trait.AGEING) if told or "direction" not in effect_named(name).needs
    )
    warm = () if _temperature_c(campaign) is None else (GROWTH,)
    return (*usual, *(name for name in (*ageing, *warm) if name not in usual))


def effects_of_robot(campaign: Campaign) -> tuple[str, ...]:
    """Return those of `fleet_effects` that are the robot's: all but the instrument's scale.

    Parameters
    ----------
    campaign : Campaign

    Returns
    -------
    tuple of str
    """
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

    Returns
    -------
    Information
        Without the priors of the robot, and without what concerns the set-up alone.

    Raises
    ------
    UnknownEffectError, ConfigurationError
        As `identify` does.
    """
    problem = with_gear_waves(build(campaign, effects or fleet_effects(campaign)), campaign.robot)
    fitted = robust_fit(problem.structure, problem.blocks, problem.start)
    # Specs as stated: the fit may have widened its priors, and a fleet counts in widths that all
    # campaigns share.
    told = _without_the_set_up(_of_fit(fitted, problem.structure.specs), _of_the_set_up(fitted))
    return replace(told, temperature_c=_temperature_c(campaign))


def with_gear_waves(problem: Problem, robot: Robot) -> Problem:
    """Return a problem with three waves per turn and the waves of the gears, where it has waves at all.

    Parameters
    ----------
    problem : Problem
    robot : Robot
        Its gear ratios; none: three waves per turn for no joint either.

    Returns
    -------
    Problem
        With those waves that it lacked, starting at 0.
    """
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
    """Return A = J J', b = J r + A p0 and the mean motions of a fit.

    With whitened derivatives J (P, m) and residuals r (m,) at the parameters p0 (P,) that it found. Motions
    are those of the first block, which all figures are of.
    """
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
    """Integrate parameters out, with their priors.

    With k kept and o out, of prior N(m, diag(w^2)): G = A_ko (A_oo + diag(w^-2))^-1,

        A = A_kk - G A_ok        b = b_k - G (b_o + m / w^2)
    """
    keep, out = np.flatnonzero(~of_set_up), np.flatnonzero(of_set_up)
    means, widths = (np.array([told.specs[k][i] for k in out.tolist()], dtype=float) for i in (2, 3))
    lost = told.normal[np.ix_(out, out)] + np.diag(1.0 / widths**2)
    gain = (inverse(lost) @ told.normal[np.ix_(out, keep)]).T
    normal = told.normal[np.ix_(keep, keep)] - gain @ told.normal[np.ix_(out, keep)]
    return Information(
        tuple(told.specs[k] for k in keep.tolist()),
        tuple(told.owners[k] for k in keep.tolist()),
        # Symmetric to the last digit: eigenvalues are asked of it.
        0.5 * (normal + normal.T),
        told.right[keep] - gain @ (told.right[out] + means / widths**2),
        told.motion_mm2[np.ix_(keep, keep)],
        told.readings,
    )


_SCALE: Final = "scale"  # of a tracker's lengths: the one parameter that is the instrument's
_SEASON_K: Final = 2.0  # between campaigns; a metre of aluminium grows by 0.05 mm in it
_FEWEST_ROBOTS: Final = 2


@dataclass(frozen=True, slots=True)
class FleetCampaign:
    """One campaign: which robot, by which instrument, on which day (any origin), and what it told."""

    robot: str
    instrument: str
    day: float
    told: Information


@dataclass(frozen=True)
class Fleet:
    """C campaigns of R robots over P parameters of the robots and, last of each array, the scale.

    Parameters are counted from their stated means in their stated widths, so that a variance of 1 is what
    was believed beforehand.
    """

    robots: tuple[str, ...]
    instruments: tuple[str, ...]
    specs: tuple[ParameterSpec, ...]  # (P,)
    owners: tuple[str, ...]  # (P,)
    scale_width: float  # stated, of the instruments; 0 where no campaign has a scale
    robot: IntArray  # (C,) index of each campaign's robot
    instrument: IntArray  # (C,)
    day: FloatArray  # (C,)
    normal: FloatArray  # (C, P + 1, P + 1)
    right: FloatArray  # (C, P + 1)
    motion_mm2: FloatArray  # (P + 1, P + 1) mean over all campaigns

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the robots' parameters."""
        return tuple(spec.name for spec in self.specs)

    @cached_property
    def means(self) -> FloatArray:
        """Stated means in the parameters' own units, shape (P,)."""
        return np.array([spec.prior_mean for spec in self.specs])

    @cached_property
    def widths(self) -> FloatArray:
        """Stated widths in the parameters' own units, shape (P,)."""
        return np.array([spec.prior_width for spec in self.specs])

    @cached_property
    def visits(self) -> tuple[tuple[int, float], ...]:
        """Instruments and days on which they measured, in order."""
        return tuple(sorted(set(zip(self.instrument.tolist(), self.day.tolist(), strict=True))))

    @cached_property
    def visit(self) -> IntArray:
        """Index of each campaign's visit, shape (C,)."""
        place = {visit: k for k, visit in enumerate(self.visits)}
        each = zip(self.instrument.tolist(), self.day.tolist(), strict=True)
        return np.array([place[visit] for visit in each], dtype=np.int64)

    def divided(self, ratios: FloatArray) -> "Fleet":
        """Return the fleet with the information of each robot over a ratio of its own.

        Parameters
        ----------
        ratios : ndarray, shape (R,)
            Of variances, 1 or more.

        Returns
        -------
        Fleet
        """
        own = ratios[self.robot]
        return replace(self, normal=self.normal / own[:, None, None], right=self.right / own[:, None])

    def of_campaigns(self, kept: IntArray) -> "Fleet":
        """Return the fleet as some of its campaigns show it.

        Parameters
        ----------
        kept : ndarray, shape (k,)
            Indices of campaigns.

        Returns
        -------
        Fleet
            With all robots and instruments, also those of which no campaign is kept.
        """
        each = {name: getattr(self, name)[kept] for name in ("robot", "instrument", "day", "normal", "right")}
        return replace(self, **each)


def fleet_of(campaigns: Sequence[FleetCampaign]) -> Fleet:
    """Bring campaigns to the same parameters; one that lacks a parameter tells nothing of it.

    Parameters
    ----------
    campaigns : sequence of FleetCampaign

    Returns
    -------
    Fleet
        Campaigns in the order given, robots and instruments in that of their names.

    Raises
    ------
    ConfigurationError
        There are fewer than two robots.
    """
    robots = tuple(sorted({one.robot for one in campaigns}))
    if len(robots) < _FEWEST_ROBOTS:
        raise ConfigurationError(
            f"A fleet needs at least two robots of one type; these campaigns are of {len(robots)}. Add "
            "campaigns of another robot."
        )
    instruments = tuple(sorted({one.instrument for one in campaigns}))
    specs = _all_specs(campaigns)
    if not _tells_of_growth(campaigns):
        # At one temperature growth is the same as longer links: both would be free, and neither
        # known.
        specs = {name: (spec, owner) for name, (spec, owner) in specs.items() if owner != GROWTH}
    own = {name: spec for name, (spec, _) in specs.items() if name != _SCALE}
    each = {name: spec for name, (spec, _) in specs.items()}
    arrays = [_over(one.told, each, (*own, _SCALE)) for one in campaigns]
    return Fleet(
        robots=robots,
        instruments=instruments,
        specs=tuple(own.values()),
        owners=tuple(specs[name][1] for name in own),
        scale_width=each[_SCALE].prior_width if _SCALE in each else 0.0,
        robot=np.array([robots.index(one.robot) for one in campaigns], dtype=np.int64),
        instrument=np.array([instruments.index(one.instrument) for one in campaigns], dtype=np.int64),
        day=np.array([one.day for one in campaigns]),
        normal=np.array([normal for normal, _, _ in arrays]),
        right=np.array([right for _, right, _ in arrays]),
        motion_mm2=np.mean([motion for _, _, motion in arrays], axis=0),
    )


def _tells_of_growth(campaigns: Sequence[FleetCampaign]) -> bool:
    """Return whether temperatures are known and differ; else all lengths are those of one temperature."""
    known = [one.told.temperature_c for one in campaigns if one.told.temperature_c is not None]
    return len(known) == len(campaigns) and max(known) - min(known) > _SEASON_K


def _all_specs(campaigns: Sequence[FleetCampaign]) -> dict[str, tuple[ParameterSpec, str]]:
    found: dict[str, tuple[ParameterSpec, str]] = {}
    for one in campaigns:
        for spec, owner in zip(one.told.specs, one.told.owners, strict=True):
            # The first campaign that has a parameter says in which widths all count: what they
            # tell does not depend on it.
            found.setdefault(spec.name, (spec, owner))
    return found


def _over(
    told: Information, specs: Mapping[str, ParameterSpec], names: tuple[str, ...]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return normal matrix, right side and motions over `names`, in the widths of `specs` from their means.

    W A W, W (b - A m) and W M W with W = diag(widths) and m the means, zeros for what the campaign lacks. In
    those of the fleet: a campaign may have stated others, and what it tells does not depend on them. A
    parameter that is not among `names` is nothing.
    """
    place = {name: k for k, name in enumerate(names)}
    here = [k for k, name in enumerate(told.names) if name in place]
    common = [told.names[k] for k in here]
    to = np.array([place[name] for name in common], dtype=np.int64)
    widths = np.array([specs[name].prior_width for name in common])
    means = np.array([specs[name].prior_mean for name in common])
    information, moved = (matrix[np.ix_(here, here)] for matrix in (told.normal, told.motion_mm2))
    normal, motion = np.zeros((2, len(names), len(names)))
    right = np.zeros(len(names))
    normal[np.ix_(to, to)] = information * np.outer(widths, widths)
    motion[np.ix_(to, to)] = moved * np.outer(widths, widths)
    right[to] = widths * (told.right[here] - information @ means)
    return normal, right, motion
