"""Plans of tracker sessions: which configurations, in which order, which of them again."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.campaign import Campaign, PointReadings, Stops
from truepose.domain.cell import Camera
from truepose.domain.errors import ConfigurationError
from truepose.domain.session import PlannedStop, Role, SessionPlan
from truepose.identification.model.evaluation import evaluate
from truepose.identification.problem.build import automatic_effects, build
from truepose.kinematics.chain import Chain
from truepose.kinematics.frames import quaternion_from_rotation
from truepose.planning.exchange_algorithm import Selection, choose_by_exchange, rank_substitutes
from truepose.planning.tracker.path_repair import is_clear, mended_or_toured, pool_of
from truepose.planning.tracker.pose_order import clear_order
from truepose.planning.workspace.candidates import Candidates, draw_candidates
from truepose.planning.workspace.space import WorkSpace, nominal_chain

N_CANDIDATES: Final = 5000  # thesis of A. Nubiola, 2014, section 2.5.2
REVISITED_SHARE: Final = 0.1
FEWEST_REVISITS: Final = 5  # their spread is known to a third then, which is enough to see a lack of fit
_SPARE: Final = 200  # more configurations than a validation has, drawn where some cannot be reached

_READING_MM: Final = 0.015  # of a tracker in the work space; makes Jacobian and priors comparable


def plan_session(space: WorkSpace, template: SessionPlan, n: int, seed: int) -> SessionPlan:
    """Fill the stops of a template: chosen by observability to calibrate, at random to validate.

    Parameters
    ----------
    space : WorkSpace
        Its approach is replaced by the template's.
    template : SessionPlan
        Role, approach and all else.
    n : int
        Different configurations.
    seed : int
        The same seed gives the same plan.

    Returns
    -------
    SessionPlan

    Raises
    ------
    ConfigurationError
        Fewer than one configuration was asked for to calibrate.
    WorkSpaceError, TooFewCandidatesError, NoWayError
        As `plan_calibration`.
    """
    # Configurations are judged with the approach that the session will have.
    approached = replace(space, approach_offset_rad=template.approach_offset_rad)
    if template.role == "calibration":
        plan = plan_calibration(approached, n, seed)
    else:
        plan = plan_validation(approached, n, seed)
    return replace(template, stops=plan.stops)


def plan_calibration(
    space: WorkSpace,
    n: int,
    seed: int,
    *,
    n_candidates: int = N_CANDIDATES,
) -> SessionPlan:
    """Choose n configurations by observability, put them in random order, revisit some at the end.

    Parameters
    ----------
    space : WorkSpace
    n : int
        Number of different configurations; the revisits come on top.
    seed : int
        The same seed gives the same plan.
    n_candidates : int
        Random candidates to choose from.

    Returns
    -------
    SessionPlan

    Raises
    ------
    ConfigurationError
        Fewer than one configuration was asked for.
    WorkSpaceError, TooFewCandidatesError, NoWayError
        The cell does not offer that many configurations, or no ways between them.

    References
    ----------
    Thesis of A. Nubiola, 2014, section 2.5.2 (O1, exchange, 5000 candidates).
    """
    rng = _generator(seed, "calibration")
    candidates = draw_candidates(space, max(n, n_candidates), rng)
    jacobians = scaled_jacobians(space, candidates)
    chosen = choose_calibration(jacobians, n, rng).indices
    order = rng.permutation(chosen)  # a slow drift then looks like noise, not like a joint's error
    order = order[clear_order(space, candidates.joints_rad[order])]

    def informative(order: Sequence[int], at: int) -> IntArray:
        return _most_informative(jacobians, candidates.nest, order, at)

    order = mended_or_toured(pool_of(space, candidates.joints_rad), order, informative)
    stops = with_revisits(space, _stops(candidates.subset(order)), rng)
    return SessionPlan("calibration", stops, approach_offset_rad=space.approach_offset_rad)


def plan_validation(space: WorkSpace, n: int, seed: int) -> SessionPlan:
    """Draw n random configurations and visit them on short ways.

    Parameters
    ----------
    space : WorkSpace
    n : int
        At least one.
    seed : int
        The same seed gives the same plan; of the same seed a calibration draws other configurations.

    Returns
    -------
    SessionPlan

    Raises
    ------
    ConfigurationError
        Fewer than one configuration was asked for.
    WorkSpaceError, TooFewCandidatesError, NoWayError
        As `plan_calibration`.
    """
    if n < 1:
        raise ConfigurationError(f"The number of configurations must be at least 1 (got {n}).")
    rng = _generator(seed, "validation")
    candidates = draw_candidates(space, n, rng)
    tour = short_tour(candidates.joints_rad)
    ordered = candidates.subset(tour[clear_order(space, candidates.joints_rad[tour])])
    # Only then is more drawn: a plan that is clear stays as it is.
    if not is_clear(pool_of(space, ordered.joints_rad)):
        ordered = _mended_validation(space, ordered, rng)
    return SessionPlan("validation", _stops(ordered), approach_offset_rad=space.approach_offset_rad)


def _mended_validation(space: WorkSpace, ordered: Candidates, rng: np.random.Generator) -> Candidates:
    pool = ordered.joined(draw_candidates(space, len(ordered) + _SPARE, rng))

    def nearest(order: Sequence[int], at: int) -> IntArray:
        return _nearest(pool, order, at)

    return pool.subset(mended_or_toured(pool_of(space, pool.joints_rad), np.arange(len(ordered)), nearest))


def _generator(seed: int, role: Role) -> np.random.Generator:
    """Return a generator of its own for each role: a validation must not meet what calibration chose from."""
    return np.random.default_rng([seed, ("calibration", "validation").index(role)])


def choose_calibration(jacobians: FloatArray, n: int, rng: np.random.Generator) -> Selection:
    """Choose n of the candidates by O1.

    Parameters
    ----------
    jacobians : ndarray, shape (n_candidates, rows, P)
        As of `scaled_jacobians`.
    n : int
    rng : numpy.random.Generator
        Draws the start.

    Returns
    -------
    Selection

    Raises
    ------
    ConfigurationError, TooFewCandidatesError
        As `choose_by_exchange`.
    """
    return choose_by_exchange(jacobians, n, rng, prior_information=_known(jacobians))


def _known(jacobians: FloatArray) -> FloatArray:
    """Return what is known beforehand: in the scaling of the Jacobians every prior has the variance 1."""
    return np.eye(jacobians.shape[2])


def _most_informative(jacobians: FloatArray, nest: IntArray, order: Sequence[int], at: int) -> IntArray:
    """Return what may take the place of a calibration stop: the same nest, first what loses least O1."""
    chosen = np.zeros(len(nest), dtype=bool)
    chosen[list(order)] = True
    chosen[order[at]] = False
    ranked = rank_substitutes(jacobians, chosen, _known(jacobians))
    # With the same nest the next best candidate costs less than 0.1 % of O1.
    fits = (nest[ranked] == nest[order[at]]) & (ranked != order[at])
    return np.asarray(ranked[fits])


def _nearest(candidates: Candidates, order: Sequence[int], at: int) -> IntArray:
    """Return what may take the place of a validation stop: the same nest, first on the shortest way."""
    leaves = order[at]
    way = np.max(np.abs(candidates.joints_rad - candidates.joints_rad[leaves]), axis=1)
    free = candidates.nest == candidates.nest[leaves]
    free[list(order)] = False
    ranked = np.argsort(way, kind="stable")
    return np.asarray(ranked[free[ranked]])


def scaled_jacobians(
    space: WorkSpace, candidates: Candidates, effects: tuple[str, ...] | None = None
) -> FloatArray:
    """Return the derivatives of what is read at the nominal robot: positions, and orientations of a camera.

    Parameters
    ----------
    space : WorkSpace
    candidates : Candidates
        n configurations.
    effects : tuple of str, optional
        By default those that `identify` takes by itself.

    Returns
    -------
    ndarray, shape (n, 3 or 6, P)
        In standard uncertainties of a reading per prior width of each of the P parameters [1].

    Raises
    ------
    UnknownEffectError, ConfigurationError
        As `identification.problem.build.build`.
    """
    campaign = nominal_campaign(space, candidates)
    problem = build(campaign, effects or automatic_effects(campaign))
    state = evaluate(problem.structure, problem.start, problem.blocks[0].targets)
    rows = [
        block.derivatives(state) / np.sqrt(block.component_variance())[:, None] for block in problem.blocks
    ]
    widths = problem.structure.prior_widths[:, None, None]
    return np.moveaxis(np.concatenate(rows, axis=2) * widths, 0, -1)


def nominal_campaign(space: WorkSpace, candidates: Candidates) -> Campaign:
    """Return the campaign that a robot without errors would give at the candidates.

    Parameters
    ----------
    space : WorkSpace
    candidates : Candidates
        n of them.

    Returns
    -------
    Campaign
        Readings as exact as a tracker's in the work space, or as a camera's.
    """
    n = len(candidates)
    centres = np.array([nest.centre_mm for nest in space.nests])
    stops = Stops(config=np.arange(1, n + 1), joints_rad=candidates.joints_rad)
    chain = nominal_chain(space, candidates.joints_rad)
    places = chain.points(centres[candidates.nest - 1])
    readings = PointReadings(stops, candidates.nest, places, np.full(n, _READING_MM))
    camera = space.camera
    return Campaign(
        robot=space.robot,
        base_nominal=space.base,
        nests=space.nests,
        calibration=readings if camera is None else _as_poses(readings, chain, camera),
        tracker_position_mm=space.tracker_position_mm,
        tool_rotation_uncertainty_rad=None if camera is None else camera.artefact_rotation_u_rad,
    )


def _as_poses(points: PointReadings, chain: Chain, camera: Camera) -> PointReadings:
    n = len(points)
    return replace(
        points,
        standard_uncertainty_mm=np.full(n, camera.position_u_mm),
        quaternion=quaternion_from_rotation(chain.end_rotation),
        rotation_uncertainty_rad=np.full(n, camera.rotation_u_rad),
    )


def _stops(candidates: Candidates) -> tuple[PlannedStop, ...]:
    return tuple(
        PlannedStop(config, tuple(float(q) for q in joints), int(nest))
        for config, (joints, nest) in enumerate(
            zip(candidates.joints_rad, candidates.nest, strict=True), start=1
        )
    )


def with_revisits(
    space: WorkSpace, stops: tuple[PlannedStop, ...], rng: np.random.Generator
) -> tuple[PlannedStop, ...]:
    """Return the stops and after them the revisits: a tenth, never fewer than five, in another order.

    They come after all first visits, so that what changed meanwhile is in their differences. Fewer than five
    stops are revisited more than once.

    Parameters
    ----------
    space : WorkSpace
    stops : tuple of PlannedStop
        One at least.
    rng : numpy.random.Generator
        Draws which, and their order.

    Returns
    -------
    tuple of PlannedStop

    Raises
    ------
    NoWayError
        None can be reached.
    """
    count = max(FEWEST_REVISITS, int(np.ceil(REVISITED_SHARE * len(stops))))
    # Each once before any is visited a second time.
    drawn = np.resize(rng.permutation(len(stops)), count)
    if _ascends(drawn):  # by chance the order of the first visits
        drawn = drawn[::-1]
    joints = np.array([stop.joints_rad for stop in stops])

    def rarest(order: Sequence[int], _: int) -> IntArray:
        return np.argsort(np.bincount(order, minlength=len(stops)), kind="stable")

    drawn = drawn[clear_order(space, joints[drawn], joints[-1])]
    drawn = mended_or_toured(
        pool_of(space, joints), drawn, rarest, start=len(stops) - 1, allowed=lambda order: not _ascends(order)
    )
    again = (stops[index] for index in drawn)
    first = max(stop.config for stop in stops) + 1
    revisits = tuple(
        PlannedStop(config, stop.joints_rad, stop.nest, repeat_of=stop.config)
        for config, stop in enumerate(again, start=first)
    )
    return stops + revisits


def _ascends(order: Sequence[int] | IntArray) -> bool:
    """Return whether revisits come in the order of the first visits, which `with_revisits` rules out."""
    return bool(np.all(np.diff(order) > 0))


def short_tour(joints_rad: FloatArray) -> IntArray:
    """Order configurations so that each is the nearest left to the one before, by its largest joint motion.

    Parameters
    ----------
    joints_rad : ndarray, shape (n, J)
        The arm comes from all joints at 0.

    Returns
    -------
    ndarray, shape (n,)
        Indices, beginning with the configuration nearest to the start.
    """
    left = np.ones(len(joints_rad), dtype=bool)
    order = np.empty(len(joints_rad), dtype=np.int64)
    here = np.zeros(joints_rad.shape[1])
    for k in range(len(order)):
        way = np.where(left, np.max(np.abs(joints_rad - here), axis=1), np.inf)
        order[k] = np.argmin(way)
        left[order[k]] = False
        here = joints_rad[order[k]]
    return order
