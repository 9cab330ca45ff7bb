"""Models of one robot against each other: how far from the nominal one, and what has changed between two.

*Largest shift* from where the nominal robot has the tool, at the worst place of a work space. Points are the
tool nests and the origin of the flange frame. The nominal robot stands where it was fitted, and may be
registered once more by a rigid motion within the base's own prior (10 mm, 0.05 rad): where a robot stands is
no error of its model. A motion beyond that is none of a registration, and counts whole.

The largest shift is found by drawing configurations of the space and its corners, and by drawing again about
the worst of them in ever smaller boxes; it is a lower bound that is close where the error varies slowly.

*Changes* between two models: base and tool are left out of the parameters: they say how the robot was set up
for a measurement. What both campaigns share makes the uncertainty of a difference too large, never too small.
All differences of one comparison share one level (S. Holm, Scand. J. Statist. 6, 1979, 65-70); whether
anything changed at all is one test of all of them together, d' (C1 + C2)^-1 d against chi-squared.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice, product
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.campaign import Readings, Stops
from truepose.domain.errors import ConfigurationError
from truepose.domain.identification import Model, Parameter, Statistics, Unit
from truepose.domain.robot import FramePlacement, JointRange
from truepose.domain.singular_covariance import solve_singular
from truepose.effects.frames.base_frame import WIDTH_MM, WIDTH_RAD
from truepose.effects.names import nest_name
from truepose.effects.ports import Trait
from truepose.effects.registry import effects_with
from truepose.identification import judge, predict
from truepose.identification.distributions import chi2_exceeded, holm
from truepose.identification.model.estimates import Estimate, identified_estimate, nominal_estimate
from truepose.identification.model.evaluation import Targets, evaluate
from truepose.identification.model.structure import COUNTERPARTS
from truepose.identification.verdict.relative_accuracy import aligned_errors, relative_errors
from truepose.kinematics.frames import placement_translation, rigid_alignment

FAR_WIDTHS: Final = 10.0  # of a prior: measured arms have values up to 3 widths from their expectation
FLANGE: Final = 0  # number of the "nest" that is the origin of the flange frame
_DRAWN: Final = 1000
_MOST_CORNERS: Final = 128
_WORST, _ABOUT, _ROUNDS = 8, 32, 6


@dataclass(frozen=True, slots=True)
class LargestShift:
    """The largest shift that was found [mm], and where."""

    shift_mm: float
    joints_rad: tuple[float, ...]
    nest: int  # FLANGE for the origin of the flange frame


@dataclass(frozen=True, slots=True)
class FarValue:
    """A parameter far from its expectation before anybody measured.

    Attributes
    ----------
    parameter : Parameter
    widths : float
        How many standard deviations of its prior.
    """

    parameter: Parameter
    widths: float


def largest_shift(model: Model, ranges: tuple[JointRange, ...] | None = None) -> LargestShift:
    """Return the largest shift of the tool by a model.

    Parameters
    ----------
    model : Model
    ranges : tuple of JointRange, optional
        The space; by default the measured zone, else the limits of the joints, else a whole turn of each.

    Returns
    -------
    LargestShift
        A lower bound: close where the error varies slowly over the space.
    """
    rng = np.random.default_rng(0)  # the same model always gets the same answer
    low, high = _ends(model, ranges)
    joints = np.vstack([rng.uniform(low, high, (_DRAWN, len(low))), _corners(low, high)])
    shifts = _Shifts(model, joints)
    norms = shifts.norms(joints)
    # Boxes of half a side of 1/4 to 1/128 of the space about the eight worst of all drawn so far, so that one
    # wrong start does not decide.
    for width in 0.5 ** np.arange(2, 2 + _ROUNDS):
        worst = joints[np.argsort(norms.max(axis=1))[-_WORST:]]
        steps = rng.uniform(-width, width, (_ABOUT, _WORST, len(low))) * (high - low)
        near = np.clip(worst + steps, low, high).reshape(-1, len(low))
        joints, norms = np.vstack([joints, near]), np.vstack([norms, shifts.norms(near)])
    row, point = np.unravel_index(int(np.argmax(norms)), norms.shape)
    nest = FLANGE if point == norms.shape[1] - 1 else int(point) + 1
    return LargestShift(float(norms[row, point]), tuple(joints[row].tolist()), nest)


def far_values(model: Model) -> tuple[FarValue, ...]:
    """Return the parameters many prior widths from their expectation, farthest first.

    Coordinates of base and tool are expected where the nominal robot was fitted; their rotations, and what
    lengths are read against, have no expectation that a model states.

    Parameters
    ----------
    model : Model

    Returns
    -------
    tuple of FarValue
        Beyond 10 widths.
    """
    expected = _fitted_coordinates(model)
    unexpected = COUNTERPARTS.union(effects_with(Trait.PLACING))
    far = [
        FarValue(one, abs(one.value - expected.get(one.name, 0.0)) / one.prior_width)
        for one in model.parameters
        if one.prior_width > 0.0 and (one.name in expected or one.effect not in unexpected)
    ]
    return tuple(sorted((one for one in far if one.widths > FAR_WIDTHS), key=lambda one: -one.widths))


def moved_to(model: Model, base: FramePlacement, *, nests_known: bool) -> Model:
    """Return a model held against a robot that stands elsewhere.

    Parameters
    ----------
    model : Model
    base : FramePlacement
        Where the robot stands.
    nests_known : bool
        The nests of the tool are known: the nominal tool is the one that the model began with. Otherwise it
        is the one that was fitted with the nominal robot.

    Returns
    -------
    Model
    """
    nests = model.nests if nests_known else model.nominal_nests
    return replace(model, nominal_base=base, nominal_nests=nests)


class _Shifts:
    """Shifts of all points against one registration.

    Parameters
    ----------
    model : Model
    joints_rad : ndarray, shape (n, J)
        Configurations that the nominal robot is registered by.
    """

    def __init__(self, model: Model, joints_rad: FloatArray) -> None:
        self._points = len(model.nests) + 1
        self._torques = model.torques_measured
        self._identified = _with_flange(identified_estimate(model))
        self._nominal = _with_flange(nominal_estimate(model))
        self._rotation, self._translation = np.eye(3), np.zeros(3)
        aligned = rigid_alignment(*self._places(joints_rad)[::-1])
        # Only a motion that a registration may make: a model that turns the robot by 40 deg would be aligned
        # away.
        if _registers(*aligned, placement_translation(model.nominal_base)):
            self._rotation, self._translation = aligned

    def norms(self, joints_rad: FloatArray) -> FloatArray:
        """Return the shift of each point.

        Parameters
        ----------
        joints_rad : ndarray, shape (n, J)

        Returns
        -------
        ndarray, shape (n, points)
            [mm]; the origin of the flange frame is the last point.
        """
        identified, nominal = self._places(joints_rad)
        apart = identified - (nominal @ self._rotation.T + self._translation)
        return np.asarray(np.linalg.norm(apart, axis=1).reshape(-1, self._points))

    def _places(self, joints_rad: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the places of all points by the identified and the nominal model, (n points, 3) each."""
        rows = np.repeat(np.arange(len(joints_rad)), self._points)
        joints = joints_rad[rows]
        stops = Stops(
            rows + 1,
            joints,
            direction=np.ones(joints.shape, np.int64),
            # A model of measured torques needs some; none is measured at a configuration that was drawn.
            torque_n_mm=np.zeros_like(joints) if self._torques else None,
        )
        targets = Targets(stops, np.tile(np.arange(1, self._points + 1), len(joints_rad)))
        identified, nominal = (
            evaluate(of.structure, of.values, targets).unscaled_mm for of in (self._identified, self._nominal)
        )
        return identified, nominal


def _registers(rotation: FloatArray, translation_mm: FloatArray, base_mm: FloatArray) -> bool:
    """Whether a rigid motion moves the base no further than its prior."""
    moved_mm = float(np.linalg.norm(rotation @ base_mm + translation_mm - base_mm))
    turned_rad = float(np.arccos(np.clip((np.trace(rotation) - 1.0) / 2.0, -1.0, 1.0)))
    return moved_mm <= WIDTH_MM and turned_rad <= WIDTH_RAD


def _with_flange(estimate: Estimate) -> Estimate:
    """Return an estimate with one more nest, in the origin of the flange frame."""
    nests = np.vstack([estimate.structure.nests_mm, np.zeros(3)])
    return replace(estimate, structure=replace(estimate.structure, nests_mm=nests))


def _ends(model: Model, ranges: tuple[JointRange, ...] | None) -> tuple[FloatArray, FloatArray]:
    """Return the lower and upper ends of the space, shape (J,) each [rad]."""
    zone = None if model.zone is None else model.zone.joint_ranges
    turn = (JointRange(-np.pi, np.pi),) * model.robot.n_joints
    chosen = ranges or zone or model.robot.joint_limits or turn
    low, high = (np.array([getattr(r, end) for r in chosen]) for end in ("lower_rad", "upper_rad"))
    return low, high


def _corners(low: FloatArray, high: FloatArray) -> FloatArray:
    """Return the corners of the space, at most 128 of them, shape (c, J) [rad]."""
    return np.array(list(islice(product(*zip(low, high, strict=True)), _MOST_CORNERS)))


def _fitted_coordinates(model: Model) -> dict[str, float]:
    """Return where the fit of the nominal robot has the coordinates of base and nests, as parameters."""
    # The model's base is where its own parameters begin; the fit of the nominal robot moved it from there.
    shift = placement_translation(model.nominal_base) - placement_translation(model.base)
    return dict(zip(("base_x", "base_y", "base_z"), shift.tolist(), strict=True)) | dict(_fitted_nests(model))


def _fitted_nests(model: Model) -> Iterator[tuple[str, float]]:
    """Yield the coordinates of the nests by name, as the fit of the nominal robot moved them [mm]."""
    start = {nest.nest: nest.centre_mm for nest in model.nests}
    for nest in model.nominal_nests:
        for component, (fitted, begun) in enumerate(zip(nest.centre_mm, start[nest.nest], strict=True)):
            yield nest_name(nest.nest, component), fitted - begun


LEVEL: Final = 0.05  # of a false "changed" anywhere in one comparison
_FEWEST: Final = 4  # places that an alignment does not make equal by itself


@dataclass(frozen=True, slots=True)
class ParameterChange:
    """A parameter of the robot in both models, in its own unit.

    Attributes
    ----------
    name, effect : str
    unit : Unit
    earlier, later : float
    standard_uncertainty : float
        Of the difference.
    p_value : float or None
        Corrected for all of the comparison; None: an uncertainty is not known.
    significant : bool
    """

    name: str
    effect: str
    unit: Unit
    earlier: float
    later: float
    standard_uncertainty: float
    p_value: float | None
    significant: bool

    @property
    def difference(self) -> float:
        """Later less earlier."""
        return self.later - self.earlier


@dataclass(frozen=True, slots=True)
class ToolShift:
    """By how much the later model puts the tool elsewhere at n places, its base laid on the earlier one's."""

    places_mm: FloatArray  # (n, 3) by the later model, world
    moved_mm: FloatArray  # (n, 3) later less earlier
    mean_mm: float
    max_mm: float


@dataclass(frozen=True, slots=True)
class ModelComparison:
    """What two models of one robot say of a change."""

    changes: tuple[ParameterChange, ...]
    gone: tuple[str, ...]  # parameters of the earlier model that the later one does not have
    new: tuple[str, ...]
    p_value: float | None  # that nothing changed; None: nothing can be compared
    moved: ToolShift | None  # None: too few places
    earlier_now: Statistics | None  # errors of the earlier model at the later readings, base laid on them
    later_now: Statistics | None


def compare_models(earlier: Model, later: Model, readings: Readings) -> ModelComparison:
    """Say what changed on a robot between two models.

    Parameters
    ----------
    earlier, later : Model
        Of the same nominal robot.
    readings : Readings
        Those that judge the later model, or that it is made from.

    Returns
    -------
    ModelComparison

    Raises
    ------
    ConfigurationError
        The models are of different nominal robots, or the readings do not fit one of them.
    """
    if earlier.robot.joints != later.robot.joints:
        raise ConfigurationError(
            f"{earlier.robot.name} and {later.robot.name} have different nominal tables. "
            "Compare models of the same robot."
        )
    before, after = _own(earlier), _own(later)
    common = [name for name in after if name in before]
    return ModelComparison(
        changes=_changes([(before[name], after[name]) for name in common]),
        gone=tuple(name for name in before if name not in after),
        new=tuple(name for name in after if name not in before),
        p_value=_nothing_changed(earlier, later, common),
        moved=_moved(earlier, later, readings),
        earlier_now=_now(earlier, readings),
        later_now=_now(later, readings),
    )


def _own(model: Model) -> dict[str, Parameter]:
    """Return the parameters of the robot by name: base and tool say how it was set up, and are left out."""
    set_up = effects_with(Trait.PLACING)
    return {one.name: one for one in model.parameters if one.effect not in set_up}


def _changes(pairs: Sequence[tuple[Parameter, Parameter]]) -> tuple[ParameterChange, ...]:
    """Return the differences of pairs of parameters, tested together at one level (Holm)."""
    uncertainties = [math.hypot(one.standard_uncertainty, other.standard_uncertainty) for one, other in pairs]
    p_values = holm([
        _p_value(other.value - one.value, u) for (one, other), u in zip(pairs, uncertainties, strict=True)
    ])
    return tuple(
        ParameterChange(
            other.name,
            other.effect,
            other.unit,
            one.value,
            other.value,
            u,
            p,
            p is not None and p < LEVEL,
        )
        for (one, other), u, p in zip(pairs, uncertainties, p_values, strict=True)
    )


def _p_value(difference: float, u: float) -> float | None:
    """Return the two-sided chance of a difference as large; None where an uncertainty is not known."""
    known = math.isfinite(difference) and math.isfinite(u) and u > 0.0
    return math.erfc(abs(difference) / u / math.sqrt(2.0)) if known else None


def _nothing_changed(earlier: Model, later: Model, names: Sequence[str]) -> float | None:
    """Return the chance of differences as large as these where nothing changed."""
    if not names:
        return None
    (before, first), (after, second) = (_of(model, names) for model in (earlier, later))
    covariance = first + second
    scale = np.sqrt(np.diag(covariance))
    if not (np.all(np.isfinite(scale)) and np.all(scale > 0.0)):
        return None
    # In standard deviations: parameters in rad and mm differ by so much that rounding would make them
    # singular.
    scaled = (after - before) / scale
    squared = float(scaled @ solve_singular(covariance / np.outer(scale, scale), scaled))
    return chi2_exceeded(squared, len(names))


def _of(model: Model, names: Sequence[str]) -> tuple[FloatArray, FloatArray]:
    """Return values (m,) and covariance (m, m) of parameters by their names."""
    all_names = [one.name for one in model.parameters]
    rows = [all_names.index(name) for name in names]
    return np.array([model.parameters[row].value for row in rows]), model.covariance[np.ix_(rows, rows)]


def _moved(earlier: Model, later: Model, readings: Readings) -> ToolShift | None:
    """Return where the later model puts the tool, its base laid on the earlier one's; None of few places."""
    # Three places are aligned to almost nothing, whatever the models say.
    if len(readings) < _FEWEST:
        return None
    before, _ = predict(earlier, readings.stops, readings.nest)
    after, _ = predict(later, readings.stops, readings.nest)
    moved = aligned_errors(before, after)
    norms = np.linalg.norm(moved, axis=1)
    return ToolShift(after, moved, float(norms.mean()), float(norms.max()))


def _now(model: Model, readings: Readings) -> Statistics | None:
    """Return the errors of a model at the readings, its base laid on them; None where they are no places."""
    found = relative_errors(judge(model, readings, model.repeatability_mm))
    return None if found is None else found.identified
