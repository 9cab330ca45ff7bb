"""The campaigns of robots of one type, as arrays over the same parameters in units of their stated widths."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.errors import ConfigurationError
from truepose.effects.links.thermal_growth import NAME as GROWTH
from truepose.effects.ports import ParameterSpec
from truepose.fleet.information import Information

_SCALE: Final = "scale"  # of a tracker's lengths: the one parameter that is the instrument's
_SEASON_K: Final = 2.0  # between campaigns; a metre of aluminium grows by 0.05 mm in it
_FEWEST_ROBOTS: Final = 2


@dataclass(frozen=True, slots=True)
class Measured:
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
        """Return the fleet with the information of each robot over a ratio of its own, (R,)."""
        own = ratios[self.robot]
        return replace(self, normal=self.normal / own[:, None, None], right=self.right / own[:, None])

    def of_campaigns(self, kept: IntArray) -> "Fleet":
        """Return the fleet as some of its campaigns show it."""
        each = {name: getattr(self, name)[kept] for name in ("robot", "instrument", "day", "normal", "right")}
        return replace(self, **each)


def fleet_of(campaigns: Sequence[Measured]) -> Fleet:
    """Bring campaigns to the same parameters; one that lacks a parameter tells nothing of it.

    Raises
    ------
    ConfigurationError
        There are fewer than two robots.
    """
    robots = tuple(sorted({one.robot for one in campaigns}))
    if len(robots) < _FEWEST_ROBOTS:
        raise ConfigurationError(
            f"A fleet has at least two robots of one type, and these campaigns are of {len(robots)}: "
            "give those of another one too."
        )
    instruments = tuple(sorted({one.instrument for one in campaigns}))
    specs = _all_specs(campaigns)
    if not _tells_of_growth(campaigns):
        specs = {name: (spec, owner) for name, (spec, owner) in specs.items() if owner != GROWTH}
    own = {name: spec for name, (spec, _) in specs.items() if name != _SCALE}
    each = {name: spec for name, (spec, _) in specs.items()}
    arrays = [_over(one.told, each, (*own, _SCALE)) for one in campaigns]
    return Fleet(
        robots=robots,
        instruments=instruments,
        specs=tuple(own.values()),
        owners=tuple(specs[name][1] for name in own),
        robot=np.array([robots.index(one.robot) for one in campaigns], dtype=np.int64),
        instrument=np.array([instruments.index(one.instrument) for one in campaigns], dtype=np.int64),
        day=np.array([one.day for one in campaigns]),
        normal=np.array([normal for normal, _, _ in arrays]),
        right=np.array([right for _, right, _ in arrays]),
        motion_mm2=np.mean([motion for _, _, motion in arrays], axis=0),
    )


def _tells_of_growth(campaigns: Sequence[Measured]) -> bool:
    """Return whether temperatures are known and differ; else all lengths are those of one temperature."""
    known = [one.told.temperature_c for one in campaigns if one.told.temperature_c is not None]
    return len(known) == len(campaigns) and max(known) - min(known) > _SEASON_K


def _all_specs(campaigns: Sequence[Measured]) -> dict[str, tuple[ParameterSpec, str]]:
    found: dict[str, tuple[ParameterSpec, str]] = {}
    for one in campaigns:
        for spec, owner in zip(one.told.specs, one.told.owners, strict=True):
            found.setdefault(spec.name, (spec, owner))
    return found


def _over(
    told: Information, specs: Mapping[str, ParameterSpec], names: tuple[str, ...]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return normal matrix, right side and motions over `names`, in the widths of `specs` from their means.

    In those of the fleet: a campaign may have stated others, and what it tells does not depend on them. A
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
