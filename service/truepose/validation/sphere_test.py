"""The sphere test of a campaign of lengths: for each ball and model the radial errors, or why there are none.

With the bar between one ball and a nest of the tool, the nest runs on a sphere. Who commands the arm by a
model sees that model's errors on the bar itself; who did not, sees them against the length that the model
predicts for where the arm was sent.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.campaign import Campaign, LegReadings, Stops
from truepose.domain.errors import ConfigurationError
from truepose.domain.identification import Model
from truepose.identification.model.prediction import predict
from truepose.identification.observations.fixture import BALL_NEST
from truepose.kinematics.chain import nominal_chain
from truepose.messages.message import Message, message
from truepose.validation.sphere_errors import (
    Centre,
    RadialErrors,
    SphereFigures,
    best_centre,
    radial_errors,
    taught_centre,
)
from truepose.validation.uncertainty import ROUNDING_MM, Figure

BY_CHANCE: Final = 0.01  # so rarely noise alone shows errors as large
_FEWEST: Final = 6  # lengths about one ball: three say where it is
_FEWEST_OF_A_NEST: Final = 2
NOMINAL: Final = "nominal"


@dataclass(frozen=True, slots=True)
class SphereOfModel:
    """Errors of one model about one centre, of all nests and of each."""

    model: str  # "nominal", or what somebody calls a model
    errors: RadialErrors
    by_nest: tuple[tuple[int, SphereFigures], ...]
    whole: SphereFigures

    @property
    def is_noise(self) -> bool:
        """Whether scatter alone shows errors as large."""
        return self.errors.noise_chance >= BY_CHANCE


@dataclass(frozen=True, slots=True)
class Sphere:
    """All lengths about one ball.

    Attributes
    ----------
    placement, base_point : int
    config, nest : ndarray of int, shape (n,)
    length_mm : ndarray, shape (n,)
    shown_mm : ndarray, shape (n,), or None
        Lengths less the bar's nominal one; None where that is not known.
    models : tuple of SphereOfModel
    withheld : tuple of Message
        Which errors are missing, and why.
    """

    placement: int
    base_point: int
    config: IntArray
    nest: IntArray
    length_mm: FloatArray
    shown_mm: FloatArray | None
    models: tuple[SphereOfModel, ...]
    withheld: tuple[Message, ...]

    @property
    def nests(self) -> tuple[int, ...]:
        """The nests that the bar was on."""
        return tuple(np.unique(self.nest).tolist())

    def of(self, model: str, *, taught: bool) -> SphereOfModel | None:
        """Return the errors of a model about a centre of that kind.

        Parameters
        ----------
        model : str
        taught : bool
            About the centre that was taught; else the best one.

        Returns
        -------
        SphereOfModel or None
        """
        same = (
            one for one in self.models if one.model == model and one.errors.centre.is_fitted is not taught
        )
        return next(same, None)


@dataclass(frozen=True, slots=True)
class SphereTest:
    """The spheres of a campaign."""

    nominal_mm: float | None  # length of the bar
    spheres: tuple[Sphere, ...]
    skipped: int | None = None  # stops that a person left out; None: nobody said

    @property
    def order(self) -> tuple[tuple[str, Figure], ...]:
        """The models by the RMS of all their errors, least first [mm].

        About the centres that were taught, or the best ones where a ball was not taught.
        """
        # One kind of centre for all balls: an RMS over both would rank models by which ball was taught.
        taught = all(sphere.of(NOMINAL, taught=True) is not None for sphere in self.spheres)
        names = dict.fromkeys(one.model for sphere in self.spheres for one in sphere.models)
        found = [(name, self._rms_mm(name, taught=taught)) for name in names]
        return tuple(sorted(((name, rms) for name, rms in found if rms), key=lambda one: one[1].value))

    def _rms_mm(self, model: str, *, taught: bool) -> Figure | None:
        """Return the RMS of a model's errors over all balls; None where it has none.

        Of balls with n_i lengths and RMS r_i: r^2 = sum n_i r_i^2 / n. The balls are taken for independent.
        """
        own = [one for sphere in self.spheres if (one := sphere.of(model, taught=taught)) is not None]
        if not own:
            return None
        n = np.array([one.whole.n for one in own])
        rms, u = np.array([(one.whole.rms_mm.value, one.whole.rms_mm.standard_uncertainty) for one in own]).T
        whole = float(np.sqrt(n @ rms**2 / n.sum()))
        share = n * rms / (n.sum() * whole) if whole > 0.0 else n / n.sum()
        return Figure(whole, float(np.linalg.norm(share * u)))

    @property
    def is_complete(self) -> bool:
        """Whether every ball has its errors about the best centre."""
        return all(any(one.errors.centre.is_fitted for one in sphere.models) for sphere in self.spheres)


def sphere_test(campaign: Campaign, models: Mapping[str, Model] | None = None) -> SphereTest:
    """Return what the lengths about each ball say of the nominal robot, and of models.

    Parameters
    ----------
    campaign : Campaign
        Its `legs`, or those to validate with where it has both; its `setup` says where the ball was taught.
    models : mapping of str to Model, optional
        Identified of the same robot with the same tool.

    Returns
    -------
    SphereTest
        Balls by placement and number. A ball with too few lengths has reasons instead of errors.

    Raises
    ------
    ConfigurationError
        There is no length, one is outside the ballbar's range, the centre of a nest is not known, or the
        readings do not fit a model.
    """
    legs = _legs(campaign)
    _require_in_range(campaign, legs)
    nests_mm = _nests(campaign, legs)
    cups = sorted(set(legs.cups))
    spheres = [
        _Judge(campaign, models or {}, nests_mm, cup).sphere(legs.taken(_rows(legs, cup))) for cup in cups
    ]
    return SphereTest(campaign.ballbar_nominal_mm, tuple(spheres))


def _legs(campaign: Campaign) -> LegReadings:
    """Return the lengths that the test is made of: those to validate with, where there are any."""
    legs = campaign.validation_legs or campaign.legs
    if not legs:
        raise ConfigurationError("A sphere test needs lengths between a ball and the tool; there are none.")
    return legs


def _require_in_range(campaign: Campaign, legs: LegReadings) -> None:
    """Refuse lengths that the ballbar cannot read."""
    nominal, reach = campaign.ballbar_nominal_mm, campaign.ballbar_range_mm
    if nominal is None or reach is None:
        return
    # Negated, so that NaN counts as outside as well.
    outside = np.flatnonzero(~(np.abs(legs.length_mm - nominal) <= reach))
    if outside.size:
        row = int(outside[0])
        raise ConfigurationError(
            f"Configuration {legs.stops.config[row]} has a length of {legs.length_mm[row]:g} mm, outside the "
            f"ballbar range of {nominal:g} +-{reach:g} mm. Check the ballbar and the unit."
        )


def _nests(campaign: Campaign, legs: LegReadings) -> FloatArray:
    """Return the centres of the nests, shape (N, 3); NaN where one is not known and not needed."""
    places = [nest.centre_mm or (np.nan,) * 3 for nest in campaign.nests]
    used = np.unique(legs.nest).tolist()
    unknown = [nest for nest in used if nest > len(places) or not np.isfinite(places[nest - 1]).all()]
    if unknown:
        raise ConfigurationError(
            f"The centre of tool nest {unknown[0]} is not known. Give it in `tool_nests_mm` for a sphere "
            "test."
        )
    return np.array(places)


def _rows(legs: LegReadings, cup: tuple[int, int]) -> IntArray:
    """Return the rows of one ball (placement, base point)."""
    return np.flatnonzero((legs.placement == cup[0]) & (legs.base_point == cup[1]))


@dataclass(frozen=True, slots=True)
class _Judge:
    """Judges the lengths about one ball."""

    campaign: Campaign
    models: Mapping[str, Model]
    nests_mm: FloatArray
    cup: tuple[int, int]

    def sphere(self, legs: LegReadings) -> Sphere:
        """Return the errors of all models about the ball, from its lengths."""
        nominal = self.campaign.ballbar_nominal_mm
        answers = list(self._answers(legs))
        return Sphere(
            placement=self.cup[0],
            base_point=self.cup[1],
            config=legs.stops.config,
            nest=legs.nest,
            length_mm=legs.length_mm,
            shown_mm=None if nominal is None else legs.length_mm - nominal,
            models=tuple(one for one in answers if isinstance(one, SphereOfModel)),
            withheld=tuple(dict.fromkeys(one for one in answers if isinstance(one, Message))),
        )

    def _answers(self, legs: LegReadings) -> Iterator[SphereOfModel | Message]:
        """Yield the errors about each centre, or why they are missing."""
        few = _too_few(legs)
        if few is not None:
            yield few
            return
        held = self._held()
        if held is None:
            yield message("sphere.not_taught")
        for subject in (NOMINAL, *self.models):
            yield from self._of_model(subject, legs, held)

    def _of_model(
        self, subject: str, legs: LegReadings, held: Stops | None
    ) -> Iterator[SphereOfModel | Message]:
        """Yield the errors of one model: about the taught centre where there is one, then about the best."""
        places = self._places(subject, legs.stops, legs.nest)
        variance = self._variance(legs)
        if held is not None:
            # Where this model has the arm when it held the ball: its error there is one of its errors.
            taught = self._places(subject, held, np.full(1, BALL_NEST))[0]
            scatter = float(np.hypot(self.campaign.setup_uncertainty_mm or 0.0, self.campaign.scatter_mm))
            yield _judged(subject, legs, places, variance, taught_centre(taught, scatter))
        best = best_centre(places, legs.length_mm, variance)
        yield best if isinstance(best, Message) else _judged(subject, legs, places, variance, best)

    def _places(self, subject: str, stops: Stops, nest: IntArray) -> FloatArray:
        """Return where a model has the nests at the stops, shape (n, 3) [mm]."""
        if subject in self.models:
            return predict(self.models[subject], stops, nest)[0]
        return nominal_chain(self.campaign.robot, stops.joints_rad).points(self.nests_mm[nest - 1])

    def _held(self) -> Stops | None:
        """Return where the arm held the ball that the bar starts from; None where nobody says."""
        setup = self.campaign.setup
        if setup is None or not np.isfinite(self.nests_mm[BALL_NEST - 1]).all():
            return None
        own = np.flatnonzero((setup.placement == self.cup[0]) & (setup.base_point == self.cup[1]))
        return Stops(np.zeros(1, dtype=np.int64), setup.joints_rad[own[:1]]) if own.size else None

    def _variance(self, legs: LegReadings) -> FloatArray:
        """Return the variance of each length, the arm's scatter included, shape (n,) [mm2]."""
        stated = np.maximum(legs.standard_uncertainty_mm, ROUNDING_MM) ** 2
        return np.asarray(stated + self.campaign.scatter_mm**2)


def _too_few(legs: LegReadings) -> Message | None:
    """Return why lengths are too few for a sphere; None where they are not."""
    nests, lengths = np.unique(legs.nest, return_counts=True)
    if len(legs) < _FEWEST:
        return message("sphere.few", lengths=len(legs), needed=_FEWEST)
    if lengths.min() < _FEWEST_OF_A_NEST:
        return message("sphere.one_of_a_nest", nest=int(nests[lengths.argmin()]))
    return None


def _judged(
    subject: str, legs: LegReadings, places: FloatArray, variance: FloatArray, centre: Centre
) -> SphereOfModel:
    """Return the errors of a model about a centre, of all nests and of each."""
    # A constant error of the bar is taken to be as large as what its readings state.
    instrument = float(np.median(legs.standard_uncertainty_mm))
    errors = radial_errors(centre, places, legs.length_mm, variance, instrument)
    by_nest = tuple((nest, errors.figures(legs.nest == nest)) for nest in np.unique(legs.nest).tolist())
    return SphereOfModel(subject, errors, by_nest, errors.figures(np.ones(len(legs), dtype=bool)))
