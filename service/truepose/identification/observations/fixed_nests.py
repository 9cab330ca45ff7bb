"""Readings of fixed nests as observations: they stand still, so that what moves them is the instrument.

Nests that stand still are the witnesses of the instrument: a model that they contradict must not judge them
(docs/decisions/0029). So the scatter of their readings is told by the differences between successive ones of
the same nest (von Neumann et al. 1941),

    variance per axis = median(|x_(k+1) - x_k|^2 / 2) / (median of chi-square with 3 degrees of freedom)

of which a kick of the instrument makes one large and a drift none; the median passes it over. And where most
readings of one look are off, it is not a nest that moved: none of them is gross, unless it is far from those
before and after it as well.

A certified place c, off by its own error e, is registered in the world with the error f of a small rigid
motion about the world's origin, and then seen as the instrument sees everything:

    prediction = seen(c + e + shift(f) + turn(f) x (c + e))

The registration is that of the start; of the readings of the arm the base takes it.

References
----------
J. von Neumann, R. H. Kent, H. R. Bellinson, B. I. Hart, Annals of Mathematical Statistics 12(2), 1941,
153-162.
"""

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray, distinct_values
from truepose.domain.campaign import Campaign, Stops
from truepose.effects.frames.fixed_nests import NAME, place_name, reference_specs
from truepose.effects.motions import COMPONENTS
from truepose.identification.distributions import chi2_exceeded, chi2_limit, chi2_median, f_exceeded
from truepose.identification.model.derivatives import seen_jacobian
from truepose.identification.model.evaluation import State, Targets
from truepose.identification.model.structure import Structure
from truepose.identification.observations.blocks import FALSE_ALARM, BlockResult, IndependentReadings
from truepose.kinematics.frames import cross, turned_axes

_FEWEST = 4  # differences of each nest: of fewer, a kick is too large a part of what is seen
# Three times the scatter of a median of chi-square variates, 1 / sqrt(n) of it, and a third more because
# successive differences share readings.
_BEYOND = 4.0
_WORTH = 0.7  # degrees of freedom of a difference of three components: for the median, and what they share


class _Scatter(NamedTuple):
    """What successive looks show: variance per axis, from so many differences."""

    variance_mm2: float
    differences: int


@dataclass(frozen=True, slots=True)
class NestLooks:
    """Readings of fixed nests.

    Attributes
    ----------
    time_s : ndarray, shape (n,), or None
        None: in the order of their rows.
    fixed_nest : ndarray of int, shape (n,)
        1-based.
    measured_mm : ndarray, shape (n, 3)
        World frame.
    variance_mm2 : ndarray, shape (n,)
        Per axis.
    """

    time_s: FloatArray | None
    fixed_nest: IntArray
    measured_mm: FloatArray
    variance_mm2: FloatArray

    def discrepancy_mm(self, stated_mm2: float) -> float:
        """Return by how much readings scatter beyond what is stated.

        Parameters
        ----------
        stated_mm2 : float
            Stated variance per axis.

        Returns
        -------
        float
            Standard deviation per axis [mm] to be added; 0 where few tell, or no more than chance shows.
        """
        scatter = self._scatter()
        if scatter is None:
            return 0.0
        # Fewer looks must scatter more to be believed.
        clearly = stated_mm2 * (1.0 + _BEYOND / np.sqrt(scatter.differences))
        return float(np.sqrt(scatter.variance_mm2 - stated_mm2)) if scatter.variance_mm2 > clearly else 0.0

    def bad_among(self, off: BoolArray) -> BoolArray:
        """Return which readings off the model are bad ones; the others speak against it.

        Parameters
        ----------
        off : ndarray of bool, shape (n,)
            Readings that are off the model.

        Returns
        -------
        ndarray of bool, shape (n,)
            Of these, where at most half of their look is off, or they are far from their nest's neighbours in
            time.
        """
        look = self._numbers()
        # What most of a look shows is the instrument, not a nest.
        shared = np.bincount(look, off)[look] > 0.5 * np.bincount(look)[look]
        return np.asarray(off & (~shared | self._alone()))

    def chance_of(self, squared: float, degrees: float) -> float:
        """Return the chance that residuals have this sum of normalised squares by their scatter alone.

        The scatter is the stated one, or what looks show of it where that is more, known as a median
        knows it.

        Parameters
        ----------
        squared : float
            Sum over residuals of square over stated variance.
        degrees : float
            Of freedom.

        Returns
        -------
        float
            0 to 1; small where the readings contradict the model.
        """
        scatter = self._scatter()
        if scatter is None or degrees == 0.0:
            return chi2_exceeded(squared, max(degrees, 1.0))
        # Never less than stated: a few looks may agree by chance.
        more = max(scatter.variance_mm2 / float(np.mean(self.variance_mm2)), 1.0)
        return f_exceeded(squared / more / degrees, degrees, _WORTH * scatter.differences)

    def _scatter(self) -> _Scatter | None:
        nests = self._of_nests()
        apart = np.concatenate([np.diff(self.measured_mm[rows], axis=0) for rows in nests])
        if len(apart) < _FEWEST * len(nests):
            return None
        # A difference of two readings has twice the variance of one.
        squared = (apart**2).sum(axis=1) / 2.0
        return _Scatter(float(np.median(squared) / chi2_median(3)), len(apart))

    def _between(self) -> list[tuple[int, IntArray]]:
        """Return every reading that has one of its nest before and one after it, with these two."""
        return [
            (int(rows[k]), rows[[k - 1, k + 1]]) for rows in self._of_nests() for k in range(1, len(rows) - 1)
        ]

    def _of_nests(self) -> list[IntArray]:
        """Return the readings of each nest in the order of time."""
        order = self._in_time()
        return [order[self.fixed_nest[order] == nest] for nest in distinct_values(self.fixed_nest)]

    def _in_time(self) -> IntArray:
        # Without times the order of the rows stands for that of the readings.
        count = len(self.fixed_nest)
        return np.arange(count) if self.time_s is None else np.argsort(self.time_s, kind="stable")

    def _alone(self) -> BoolArray:
        """Return which readings are far from both of their nest that are next in time, shape (n,)."""
        alone = np.zeros(len(self.fixed_nest), dtype=bool)
        limit = chi2_limit(FALSE_ALARM / len(alone), 3)
        for now, both in self._between():
            # A kick between two readings leaves each of them near one of its neighbours.
            apart = ((self.measured_mm[now] - self.measured_mm[both]) ** 2).sum(axis=1)
            expected = self.variance_mm2[now] + self.variance_mm2[both]
            alone[now] = bool(np.all(apart > limit * expected))
        return alone

    def _numbers(self) -> IntArray:
        """Return the number of each reading's look, shape (n,): one ends where the nests begin anew.

        Of a single nest, each reading is a look.
        """
        looks = np.zeros(len(self.fixed_nest), dtype=np.int64)
        seen: list[int] = []
        number, alone = 0, len(distinct_values(self.fixed_nest)) == 1
        for row in self._in_time().tolist():
            nest = int(self.fixed_nest[row])
            # A nest that is read again at once is still the same look; after others it begins a new one.
            if seen and (alone or (nest in seen[:-1] and nest != seen[-1])):
                number, seen = number + 1, []
            seen.append(nest)
            looks[row] = number
        return looks


_FRAME = tuple(f"frame_{component}" for component in COMPONENTS)


@dataclass(frozen=True, slots=True, kw_only=True)
class ReferenceBlock(IndependentReadings):
    """Readings of fixed nests, each a stop of its own that it shares with no configuration of the arm.

    A model that they contradict does not judge them: they judge one another (`looks`). What the world is off
    by is among their own parameters and carries nothing into the others.

    Attributes
    ----------
    fixed_nest : ndarray of int, shape (n,)
        1-based.
    certified_mm : ndarray, shape (n, 3)
        Place of the nest of each reading, world frame.
    measured_mm : ndarray, shape (n, 3)
        World frame.
    """

    quantity: ClassVar[str] = "position"
    table: ClassVar[str] = "reference"
    components: ClassVar[int] = 3
    of_arm: ClassVar[bool] = False

    fixed_nest: IntArray
    certified_mm: FloatArray
    measured_mm: FloatArray

    def result(self, structure: Structure, values: FloatArray, previous: BlockResult | None) -> BlockResult:
        """Return residuals and derivatives, parameters as of `Block.result`.

        Returns
        -------
        BlockResult
            Residual (n, 3) [mm]: measured place minus where the instrument should see the registered nest.
        """
        state = self.evaluated(structure, values, previous)
        residual = self.measured_mm - state.seen(self._registered(state)[0])
        return BlockResult(residual, self.differentiated(state), state, self.whitening())

    def derivatives(self, state: State) -> FloatArray:
        """Return the motions of the predictions.

        Parameters
        ----------
        state : State
            At n readings.

        Returns
        -------
        ndarray, shape (P, n, 3)
            mm per internal unit: of registration, places of nests, and all that moves the instrument.
        """
        names = state.structure.names
        points, turn, axes, arms = self._registered(state)
        jacobian = np.zeros((len(names), len(points), 3))
        for component, name in enumerate(_FRAME):
            if name in names:
                own = np.eye(3)[component] if component < 3 else cross(axes[component - 3], arms)
                jacobian[names.index(name)] = own
        for nest in distinct_values(self.fixed_nest).tolist():
            here = self.fixed_nest == nest
            for component in range(3):
                name = place_name(nest, component)
                if name in names:
                    jacobian[names.index(name), here] = turn[:, component]
        return seen_jacobian(state, points, jacobian)

    def _registered(self, state: State) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Return the places in the world (n, 3), the registration's turn (3, 3), its axes, and its arms."""
        value = dict(zip(state.structure.names, state.values.tolist(), strict=True))
        frame = np.array([value.get(name, 0.0) for name in _FRAME])
        # One registration for the whole campaign: that of the start.
        turn, axes = turned_axes(frame[None, 3:])
        errors = {
            nest: [value.get(place_name(nest, component), 0.0) for component in range(3)]
            for nest in distinct_values(self.fixed_nest).tolist()
        }
        places = self.certified_mm + np.array([errors[nest] for nest in self.fixed_nest.tolist()])
        arms = places @ turn[0].T
        return arms + frame[:3], turn[0], axes[:, 0], arms

    def ends(self) -> tuple[IntArray, ...]:
        """Return the fixed nests."""
        return (self.fixed_nest,)

    def own_discrepancy(self) -> float | None:
        """Return by how much looks scatter beyond what is stated, per axis [mm]."""
        return self._looks().discrepancy_mm(self.stated_sigma() ** 2)

    def bad_among(self, off: BoolArray) -> BoolArray:
        """Return which readings that are off the model are bad ones; the others speak against it.

        Parameters
        ----------
        off : ndarray of bool, shape (n,)

        Returns
        -------
        ndarray of bool, shape (n,)
            As of `NestLooks.bad_among`.
        """
        return self._looks().bad_among(off)

    def contradiction(self, result: BlockResult) -> float:
        """Return the chance that readings without a bad one lie so far off the model by scatter alone.

        Parameters
        ----------
        result : BlockResult
            At the solution.

        Returns
        -------
        float
            0 to 1; as of `NestLooks.chance_of`, with three degrees of freedom a reading.
        """
        squared = float((self.weights * self.squared(result)).sum())
        return self._looks().chance_of(squared, 3.0 * float(self.weights.sum()))

    def _looks(self) -> NestLooks:
        return NestLooks(
            self.targets.stops.time_s, self.fixed_nest, self.measured_mm, self.component_variance()
        )


def reference_block(campaign: Campaign) -> ReferenceBlock | None:
    """Return the readings of certified fixed nests; None where the campaign has none.

    Parameters
    ----------
    campaign : Campaign
        Readings of nests without a certificate are passed over.
    """
    readings = campaign.reference
    if readings is None:
        return None
    # A nest without a certified place says nothing of where the instrument is.
    certified = np.flatnonzero(
        (readings.fixed_nest >= 1) & (readings.fixed_nest <= len(campaign.fixed_nests))
    )
    if certified.size == 0:
        return None
    nest = readings.fixed_nest[certified]
    places = np.array([fixed.centre_mm for fixed in campaign.fixed_nests])
    # Numbers that no configuration of the arm has: nothing is shared with one, no fold leaves it out.
    stops = Stops(
        config=-1 - certified,
        joints_rad=np.zeros((len(certified), campaign.robot.n_joints)),
        time_s=readings.time_s[certified],
    )
    return ReferenceBlock(
        targets=Targets(stops, np.ones(len(certified), dtype=np.int64), fixed_mm=places[nest - 1]),
        fixed_nest=nest,
        certified_mm=places[nest - 1],
        measured_mm=readings.position_mm[certified],
        uncertainty=readings.standard_uncertainty_mm[certified],
        weights=np.ones(len(certified)),
    )


def with_reference_parameters(
    structure: Structure, start: FloatArray, block: ReferenceBlock, campaign: Campaign
) -> tuple[Structure, FloatArray]:
    """Return structure and start values with the parameters that the readings of fixed nests need.

    Parameters
    ----------
    structure : Structure
    start : ndarray, shape (P,)
        Internal units.
    block : ReferenceBlock
    campaign : Campaign
        Whose certificates are the priors of the nests' places.

    Returns
    -------
    structure : Structure
    start : ndarray, shape (P + p,)
        Registration and places of the nests begin at 0.
    """
    read = distinct_values(block.fixed_nest).tolist()
    specs = reference_specs({k: campaign.fixed_nests[k - 1].standard_uncertainty_mm for k in read})
    return structure.extended(NAME, specs), np.concatenate([start, np.zeros(len(specs))])
