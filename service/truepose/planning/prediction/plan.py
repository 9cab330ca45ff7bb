"""A plan with the accuracy it predicts, the work volume that it holds for, and what keep-outs cost.

The volume is a sample of configurations, drawn uniformly in joint ranges, with the tool nests of each that
lie in a box: mean errors over it are those of positions as the arm reaches them, not evenly over space.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.domain.ballbar import Leg
from truepose.domain.cell import KeepOuts
from truepose.domain.errors import ConfigurationError, UnderdeterminedError
from truepose.domain.identification import NotIdentifiable
from truepose.domain.robot import JointRange
from truepose.messages.message import message
from truepose.planning import observability
from truepose.planning.ballbar.bodies import BaseFixture
from truepose.planning.errors import WorkSpaceError
from truepose.planning.prediction.errors import CurvePoint, Discrepancy
from truepose.planning.workspace.candidates import has_room
from truepose.planning.workspace.capsules import look_at
from truepose.planning.workspace.space import (
    WorkSpace,
    nest_places,
    nominal_chain,
    require_consistent,
)

_INDICES: Final = ("O1", "O2", "O3", "O4", "O5")


@dataclass(frozen=True, slots=True)
class Assumptions:
    """What a promise takes for granted; standard deviations per axis [mm]."""

    reading_mm: float  # of a reading, RMS over the plan; of a length where lengths are read
    repeatability_mm: float  # of the arm
    discrepancy: Discrepancy
    kept_out: tuple[str, ...] = ()  # names of the keep-out volumes that arm, tool and bars stay outside


@dataclass(frozen=True, slots=True)
class BallbarPoses:
    """What is measured with the ballbar in each of n configurations, and from where."""

    legs: tuple[tuple[Leg, ...], ...]  # n
    placement: IntArray  # (n,) of the base fixture, from 1
    fixtures: tuple[BaseFixture, ...]  # in the order of their placements


@dataclass(frozen=True, slots=True)
class PromisedPlan:
    """Configurations to measure, in the order of their visits, and what they promise."""

    joints_rad: FloatArray  # (n, J)
    nest: IntArray | None  # (n,) 1-based; None: all nests, by their legs
    poses: BallbarPoses | None  # None: positions are read
    curve: tuple[CurvePoint, ...]  # numbers of configurations, those measured before included
    advised: int  # the knee of the curve
    measured: int  # configurations that were measured before
    left_open: tuple[NotIdentifiable, ...]  # what readings at all of them would not determine
    observability: Mapping[str, float]  # O1 to O5 of all of them, by name
    assumptions: Assumptions
    targets: tuple[tuple[int, ...], ...] | None = None  # n, read at each stop of a closed loop; None: none

    @property
    def total(self) -> int:
        """Configurations that the promise rests on."""
        return self.measured + len(self.joints_rad)

    @property
    def promised(self) -> CurvePoint:
        """The promise of this plan: the point of the curve at `total`, which is always one of it."""
        return next(point for point in self.curve if point.n == self.total)


def require_some(n: int | None) -> None:
    """Refuse a plan of nothing.

    Parameters
    ----------
    n : int or None
        Configurations that were asked for; None: not said, which is fine.

    Raises
    ------
    ConfigurationError
        n is below 1.
    """
    if n is not None and n < 1:
        raise ConfigurationError(f"The number of configurations must be at least 1 (got {n}).")


def indices(rows: FloatArray, configurations: int) -> dict[str, float]:
    """Return the observability indices O1 to O5 of whitened rows.

    Parameters
    ----------
    rows : ndarray, shape (n, d, P)
        Derivatives of n readings of d coordinates or lengths, in standard uncertainties of a reading per
        prior width of each parameter.
    configurations : int
        Different ones among them: of one that is read again O1 grows, as it is known better.

    Returns
    -------
    dict of str to float
        By name [1]; 0 where there are fewer readings than parameters.

    Raises
    ------
    ConfigurationError
        A derivative is not finite.
    """
    flat = rows.reshape(-1, rows.shape[2])
    try:
        first = observability.observability_o1(flat, configurations)
    # No refusal: with priors such a plan is one, and the indices say what its readings alone do.
    except UnderdeterminedError:
        return dict.fromkeys(_INDICES, 0.0)
    others = (
        observability.observability_o2,
        observability.observability_o3,
        observability.observability_o4,
        observability.observability_o5,
    )
    return dict(zip(_INDICES, (first, *(index(flat) for index in others)), strict=True))


VOLUME_CONFIGURATIONS: Final = 400  # the mean over them is that over the volume to about 1 %
_BATCH: Final = 2048
_MOST_BATCHES: Final = 100


@dataclass(frozen=True, slots=True)
class WorkVolume:
    """Where accuracy counts.

    Attributes
    ----------
    ranges : tuple of JointRange or None
        None: those in which configurations are chosen.
    box_mm : tuple of pairs of float or None
        From and to along x, y, z of the world; None: wherever the nests are.
    """

    ranges: tuple[JointRange, ...] | None = None
    box_mm: tuple[tuple[float, float], ...] | None = None


@dataclass(frozen=True, slots=True)
class VolumeSample:
    """Configurations all over a volume and the nests that are in it, m rows."""

    joints_rad: FloatArray  # (m, J)
    nest: IntArray  # (m,) 1-based

    def __len__(self) -> int:
        return len(self.nest)


def sample(space: WorkSpace, volume: WorkVolume, n: int, rng: np.random.Generator) -> VolumeSample:
    """Draw n configurations uniformly in the joint ranges, every nest of each that lies in the volume.

    They are within the joint limits, clear of table, column and keep-out volumes; whether a tracker would see
    them does not matter to whoever works there.

    Parameters
    ----------
    space : WorkSpace
    volume : WorkVolume
    n : int
        Fewer where 200,000 draws do not give as many.
    rng : numpy.random.Generator

    Returns
    -------
    VolumeSample
        A row for each nest: m >= n where a configuration has several in the volume.

    Raises
    ------
    WorkSpaceError
        The arm has no place in the volume, or what is said of the cell contradicts itself.
    """
    space = replace(space, ranges=volume.ranges or space.ranges)
    require_consistent(space)
    joints, nests, found = [], [], 0
    for _ in range(_MOST_BATCHES):
        drawn, nest = _inside(space, volume, rng)
        joints.append(drawn)
        nests.append(nest)
        found += len(drawn)
        if found >= n:
            break
    if not found:
        raise WorkSpaceError(
            f"None of {_BATCH * _MOST_BATCHES} random configurations has a tool nest in the work volume. "
            "Check its box, its joint ranges and the table height."
            f"{look_at(space.keep_outs)}"
        )
    # n configurations, not n places: a configuration counts with every nest that it brings into the
    # volume.
    inside = np.concatenate(nests)[:n]
    row, column = np.nonzero(inside)
    return VolumeSample(np.concatenate(joints)[:n][row], column.astype(np.int64) + 1)


def _inside(space: WorkSpace, volume: WorkVolume, rng: np.random.Generator) -> tuple[FloatArray, BoolArray]:
    """Return configurations (n, J) that have a nest in the volume, and which nests have, (n, K)."""
    low = np.array([limit.lower_rad for limit in space.ranges])
    high = np.array([limit.upper_rad for limit in space.ranges])
    drawn = low + (high - low) * rng.random((_BATCH, len(low)))
    chain = nominal_chain(space, drawn)
    nests = np.ones((_BATCH, len(space.nests)), dtype=bool)
    if volume.box_mm is not None:
        least, most = np.array(volume.box_mm).T
        places = nest_places(space, chain)
        nests = np.all((places >= least) & (places <= most), axis=2).T
    if space.camera is not None:  # a nest of its readings alone: where the tool is, the others say
        nests[:, space.camera.nest - 1] = False
    kept = has_room(space, drawn, chain) & nests.any(axis=1)
    return drawn[kept], nests[kept]


_MOST_TRIED: Final = 6  # volumes that are left out one by one; another plan is made for each


def because_of(
    keep_outs: KeepOuts,
    left_open: tuple[NotIdentifiable, ...],
    open_without: Callable[[KeepOuts], frozenset[str]],
) -> tuple[NotIdentifiable, ...]:
    """Name the volumes without which parameters were determined, beside the reason.

    Parameters
    ----------
    keep_outs : KeepOuts
    left_open : tuple of NotIdentifiable
        What the plan among all of them leaves open.
    open_without : callable
        Returns the parameters that a plan of as many configurations leaves open among other volumes.

    Returns
    -------
    tuple of NotIdentifiable
        The same groups; the reason of those that volumes cost names one that is enough to leave out, several
        of which any one is, or all.
    """
    if not left_open or not keep_outs:
        return left_open
    # One plan without any tells whether volumes matter at all: a plan for each costs seconds.
    without_any = open_without(KeepOuts())
    # What stays open without any volume keeps its own reason.
    freed = [group for group in left_open if without_any.isdisjoint(group.parameters)]
    if not freed:
        return left_open
    without = {name: open_without(keep_outs.without(name)) for name in keep_outs.names[:_MOST_TRIED]}
    return tuple(_blamed(group, keep_outs, without) if group in freed else group for group in left_open)


def _blamed(
    group: NotIdentifiable, keep_outs: KeepOuts, without: dict[str, frozenset[str]]
) -> NotIdentifiable:
    single = [name for name, left in without.items() if left.isdisjoint(group.parameters)]
    # Where no one of them is enough to leave out, all of them together are to blame.
    names = ", ".join(single or keep_outs.names)
    if not single:
        return replace(group, reason=message("open.kept_out.all", reason=group.reason, volumes=names))
    if len(single) > 1:
        return replace(group, reason=message("open.kept_out.any", reason=group.reason, volumes=names))
    return replace(group, reason=message("open.kept_out", reason=group.reason, volumes=names))


def parameters_of(left_open: Iterable[NotIdentifiable]) -> frozenset[str]:
    """Return all parameters that are left open.

    Parameters
    ----------
    left_open : iterable of NotIdentifiable

    Returns
    -------
    frozenset of str
    """
    return frozenset(name for group in left_open for name in group.parameters)
