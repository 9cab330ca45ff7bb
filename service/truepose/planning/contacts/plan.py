"""From a wish to the plan of a session of closed loops: candidates, the choice among them, their order.

There is one place from which the arm comes to every stop, and to which it returns: past all that stands
there. So the way from one stop to the next is known to be clear, also where some of them are left out.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.domain.cell import Cell
from truepose.domain.contacts import SEEN_ALONG_AXES, ContactPlan, ContactStop, Joints, Target, TargetKind
from truepose.domain.session import Vector
from truepose.kinematics.chain import Chain, alpha_gradient, theta_gradient
from truepose.planning.contacts.plan_request import ContactPlanRequest, normal_of, place_of, require_sense
from truepose.planning.contacts.poses import Goals, ReachablePoses, draw_goals, groups_of, reached
from truepose.planning.errors import NoWayError, TooFewCandidatesError
from truepose.planning.exchange_algorithm import choose_by_exchange
from truepose.planning.tracker.path_repair import mended_or_toured, pool_of
from truepose.planning.tracker.plans import short_tour
from truepose.planning.tracker.pose_order import clear_order
from truepose.planning.workspace.bodies import CellBodies, bodies_of
from truepose.planning.workspace.candidates import draw_candidates
from truepose.planning.workspace.path_clearance import Ways, least_rooms_mm
from truepose.planning.workspace.space import (
    WorkSpace,
    nest_places,
    nominal_chain,
    space_to_measure,
    without_tracker,
)

_LOOKS: Final = 40  # along a way
_KEPT_OFF_MM: Final = 20.0  # by the tool's nests and the flange, from what they could touch
_FIXTURE_MM: Final = 40.0  # half the size of a fixture of gauges, or of a ball with its foot
_TRIED: Final = 12  # places from which the arm could come
_BEGINS_TRIED: Final = 20


def hub_of(
    space: WorkSpace,
    bodies: CellBodies,
    wish: ContactPlanRequest,
    begins_rad: FloatArray,
    rng: np.random.Generator,
) -> FloatArray:
    """Return the configuration from which most of the begins are reached by a clear way.

    Parameters
    ----------
    space : WorkSpace
    bodies : CellBodies
    wish : ContactPlanRequest
    begins_rad : ndarray, shape (n, J)
        Where ways to the stops begin; twenty of them are tried.
    rng : numpy.random.Generator

    Returns
    -------
    ndarray, shape (J,)

    Raises
    ------
    NoWayError
        None is reached from any of the twelve that were tried.
    TooFewCandidatesError, WorkSpaceError
        As `draw_candidates`.
    """
    tried = draw_candidates(space, _TRIED, rng).joints_rad
    # Candidates are drawn by the rules of the cell, which know nothing of targets.
    tried = tried[keep_off(space, wish, tried)]
    some = begins_rad[rng.permutation(len(begins_rad))[:_BEGINS_TRIED]]
    reached = [int(clear_from(space, bodies, wish, hub, some).sum()) for hub in tried]
    if not reached or max(reached) == 0:
        raise NoWayError(
            "No collision-free path to the targets was found from any of the positions tried. Move the "
            "targets, or use another seed."
        )
    best: FloatArray = tried[int(np.argmax(reached))]
    return best


def clear_from(
    space: WorkSpace,
    bodies: CellBodies,
    wish: ContactPlanRequest,
    hub_rad: FloatArray,
    begins_rad: FloatArray,
) -> BoolArray:
    """Return whether the straight joint motions from a hub to begins are clear.

    Parameters
    ----------
    space : WorkSpace
    bodies : CellBodies
    wish : ContactPlanRequest
    hub_rad : ndarray, shape (J,)
    begins_rad : ndarray, shape (n, J)

    Returns
    -------
    ndarray of bool, shape (n,)
        Of floor, arm, keep-out volumes and all targets.
    """
    n, joints = begins_rad.shape
    hubs = np.broadcast_to(hub_rad, (n, joints))
    room_mm = least_rooms_mm(bodies, Ways((), hubs, begins_rad))
    share = np.linspace(0.0, 1.0, _LOOKS)[:, None, None]
    along = (hubs + share * (begins_rad - hubs)).reshape(-1, joints)
    off = keep_off(space, wish, along).reshape(_LOOKS, n).all(axis=0)
    clear: BoolArray = (room_mm >= 0.0) & off
    return clear


def keep_off(space: WorkSpace, wish: ContactPlanRequest, joints_rad: FloatArray) -> BoolArray:
    """Return whether the tool's nests and the flange are away from all targets.

    Parameters
    ----------
    space : WorkSpace
    wish : ContactPlanRequest
    joints_rad : ndarray, shape (n, J)

    Returns
    -------
    ndarray of bool, shape (n,)
    """
    chain = nominal_chain(space, joints_rad)
    points_mm = np.concatenate([nest_places(space, chain), chain.origin[-1:]])
    apart = [_keeps_off(target, points_mm).all(axis=0) for target in wish.targets]
    return np.asarray(np.all(apart, axis=0))


def _keeps_off(target: Target, points_mm: FloatArray) -> BoolArray:
    """Whether points (k, n, 3) stay away from a target, shape (k, n)."""
    off_mm = points_mm - place_of(target)
    if target.kind is TargetKind.PLANE:
        return np.asarray(off_mm @ normal_of(target) >= _KEPT_OFF_MM)
    # A wire gives way, and the tool hangs on it at every stop.
    if target.kind is TargetKind.WIRE:
        return np.ones(off_mm.shape[:-1], dtype=bool)
    size_mm = (target.zero_mm or 0.0) if target.kind is TargetKind.SPHERE else _FIXTURE_MM
    return np.asarray(np.linalg.norm(off_mm, axis=-1) >= size_mm + _KEPT_OFF_MM)


_DRAWN: Final = 1500  # at once
_MOST_DRAWS: Final = 12
_CANDIDATES_PER_STOP: Final = 6
_TOOL_SPEED_MM_S: Final = 250.0  # somebody may stand beside the fixture
_KNOWN: Final = 1e-3  # beforehand, of each parameter: fewer readings than parameters can be compared too
_NULL_MM: Final = 0.02  # what is left then acts along the probe's axis, up to 12 deg beside the distance


def plan_of(cell: Cell, wish: ContactPlanRequest) -> ContactPlan:
    """Return a plan with the stops that tell most about the robot.

    Parameters
    ----------
    cell : Cell
    wish : ContactPlanRequest

    Returns
    -------
    ContactPlan
        The same seed gives the same plan.

    Raises
    ------
    ConfigurationError
        Nothing says in which ranges configurations are chosen, or fewer than one stop is wanted.
    WorkSpaceError
        What is wanted contradicts itself or the cell.
    TooFewCandidatesError
        Hardly any place at the targets is reached.
    NoWayError
        No clear way leads to the targets.
    """
    require_sense(cell, wish)
    rng = np.random.default_rng(wish.seed)
    # No approach from below: where the arm comes from is the hub, for every stop alike.
    space, bodies = without_tracker(space_to_measure(cell, None)), bodies_of(cell)
    # Wires need no touching and no way in: any configuration will do in which all are within their
    # stroke.
    found = _hanging(space, wish, rng) if wish.loop == "wires" else _candidates(space, bodies, wish, rng)
    jacobians = _jacobians(space, wish, found)
    known = _KNOWN * np.eye(jacobians.shape[2])
    chosen = choose_by_exchange(jacobians, wish.stops, rng, prior_information=known).indices
    if wish.loop == "wires":
        chosen = _visits(space, found.way_rad[:, -1], chosen)
    stops = tuple(_stop(wish, found, int(row), config) for config, row in enumerate(chosen, start=1))
    return ContactPlan(
        loop=wish.loop,
        role=wish.role,
        nest=wish.nest,
        targets=wish.targets,
        stops=stops,
        distances=wish.distances,
        found_zeros=wish.found_zeros,
        stroke_mm=wish.stroke_mm,
        margin_mm=wish.margin_mm,
        null_mm=_NULL_MM if wish.loop == "probe" else None,
        reading_u_mm=wish.reading_u_mm,
        tool_speed_mm_s=min(_TOOL_SPEED_MM_S, cell.limits.tool_speed_mm_s),
        orientation_speed_rad_s=cell.limits.orientation_speed_rad_s,
    )


def _candidates(
    space: WorkSpace, bodies: CellBodies, wish: ContactPlanRequest, rng: np.random.Generator
) -> ReachablePoses:
    """Return places at the targets with their ways, all of which begin at the same place."""
    near = _near(space, bodies, wish, rng)
    # Without a begin of any way there is nothing to look for a hub by.
    if not len(near.way_rad):
        return _enough(wish, near)
    hub_rad = hub_of(space, bodies, wish, near.way_rad[:, 0], rng)
    parts = [_from_hub(space, bodies, wish, hub_rad, near)]
    for _ in range(1, _MOST_DRAWS):
        if sum(len(part.way_rad) for part in parts) >= _CANDIDATES_PER_STOP * wish.stops:
            break
        parts.append(_from_hub(space, bodies, wish, hub_rad, _near(space, bodies, wish, rng)))
    return _enough(wish, _joined(parts))


def _near(
    space: WorkSpace, bodies: CellBodies, wish: ContactPlanRequest, rng: np.random.Generator
) -> ReachablePoses:
    found = reached(space, bodies, wish, draw_goals(wish, _DRAWN, rng), rng)
    return found.taken(np.flatnonzero(keep_off(space, wish, found.way_rad[:, 0])))


def _from_hub(
    space: WorkSpace, bodies: CellBodies, wish: ContactPlanRequest, hub_rad: FloatArray, found: ReachablePoses
) -> ReachablePoses:
    clear = np.flatnonzero(clear_from(space, bodies, wish, hub_rad, found.way_rad[:, 0]))
    kept = found.taken(clear)
    # The hub becomes the first place of every way: a stop is left the same way, so that any other may
    # follow.
    hubs = np.broadcast_to(hub_rad, (len(clear), 1, len(hub_rad)))
    return ReachablePoses(kept.goals, np.concatenate([hubs, kept.way_rad], axis=1))


def _joined(parts: list[ReachablePoses]) -> ReachablePoses:
    goals = [part.goals for part in parts]
    return ReachablePoses(
        Goals(
            np.concatenate([part.group for part in goals]),
            np.concatenate([part.tip_mm for part in goals]),
            np.concatenate([part.points for part in goals]),
            np.concatenate([part.way_in for part in goals]),
        ),
        np.concatenate([part.way_rad for part in parts]),
    )


def _hanging(space: WorkSpace, wish: ContactPlanRequest, rng: np.random.Generator) -> ReachablePoses:
    """Return configurations all over the work space in which every wire is within its stroke."""
    joints = draw_candidates(space, _DRAWN, rng).joints_rad
    # Drawn by the rules for points, which know neither elbow nor tool against arm.
    joints = joints[pool_of(space, joints).stand(np.arange(len(joints)), 0.0)]
    tip_mm = _tips_mm(space, wish, joints)
    off_mm = np.array([
        np.linalg.norm(tip_mm - place_of(target), axis=1) - (target.zero_mm or 0.0) for target in wish.targets
    ])
    kept = np.flatnonzero((np.abs(off_mm) <= wish.usable_mm).all(axis=0))
    nothing = np.zeros((len(kept), 3))
    goals = Goals(np.zeros(len(kept), dtype=np.int64), tip_mm[kept], nothing, nothing)
    return _enough(wish, ReachablePoses(goals, joints[kept][:, None]))


def _visits(space: WorkSpace, joints_rad: FloatArray, chosen: IntArray) -> IntArray:
    """Return stops without a hub in an order of short ways on which nothing touches.

    What cannot be reached gives its place to what is nearest to it, whatever that tells.
    """
    tour = chosen[short_tour(joints_rad[chosen])]
    tour = tour[clear_order(space, joints_rad[tour])]

    def nearest(order: Sequence[int], at: int) -> IntArray:
        away = np.abs(joints_rad - joints_rad[order[at]]).max(axis=1)
        ranked = np.argsort(away, kind="stable")
        return np.asarray(ranked[~np.isin(ranked, order)])

    return mended_or_toured(pool_of(space, joints_rad), tour, nearest)


def _enough(wish: ContactPlanRequest, found: ReachablePoses) -> ReachablePoses:
    """Return what was found; raises TooFewCandidatesError where it is less than twice the stops."""
    if len(found.way_rad) < 2 * wish.stops:
        raise TooFewCandidatesError(
            f"The arm reaches the targets on only {len(found.way_rad)} of the paths tried; choosing "
            f"{wish.stops} configurations needs twice as many. Move the targets, for example closer to the "
            "arm."
        )
    return found


def _tips_mm(space: WorkSpace, wish: ContactPlanRequest, joints_rad: FloatArray) -> FloatArray:
    return nominal_chain(space, joints_rad).points(np.array(space.nests[wish.nest - 1].centre_mm))


def _jacobians(space: WorkSpace, wish: ContactPlanRequest, found: ReachablePoses) -> FloatArray:
    """Return the derivatives of each candidate's readings, shape (n, rows, parameters).

    In the joint zeros and the twists between joint axes [mm per 1/500 rad], and the places of the targets [mm
    per mm]: angles are counted at the lever of an arm of 500 mm, so that both are lengths. With d the
    direction along which a reading grows with the nest, the columns are d . dP/dp and, of its own target, -d.
    """
    joints = found.way_rad[:, -1]
    chain = nominal_chain(space, joints)
    tip_mm = _tips_mm(space, wish, joints)
    moves = np.concatenate([theta_gradient(chain, tip_mm), alpha_gradient(chain, tip_mm)]) / 500.0
    directions = _directions(wish, chain, found.goals)  # (n, rows, 3)
    of_robot = np.einsum("pni,nri->nrp", moves, directions)
    groups = groups_of(wish)
    places = np.zeros((len(joints), directions.shape[1], 3 * len(groups)))
    for number in range(len(groups)):
        own = found.goals.group == number
        places[own, :, 3 * number : 3 * number + 3] = -directions[own]
    return np.concatenate([of_robot, places], axis=2)


def _directions(wish: ContactPlanRequest, chain: Chain, goals: Goals) -> FloatArray:
    """Return along which directions of the world each candidate's readings are, shape (n, rows, 3)."""
    groups = groups_of(wish)
    if wish.targets[0].kind in SEEN_ALONG_AXES:
        return np.asarray(np.swapaxes(chain.end_rotation, 1, 2))
    rows = [np.stack([_direction(target, goals) for target in targets], axis=1) for targets in groups]
    return np.asarray(np.stack(rows)[goals.group, np.arange(len(goals.group))])


def _direction(target: Target, goals: Goals) -> FloatArray:
    """Return the direction of a reading of one target at each candidate, shape (n, 3)."""
    if target.kind in {TargetKind.SPHERE, TargetKind.WIRE}:
        off = goals.tip_mm - place_of(target)
        return np.asarray(off / np.linalg.norm(off, axis=1, keepdims=True))
    return np.broadcast_to(normal_of(target), goals.tip_mm.shape)


def _stop(wish: ContactPlanRequest, found: ReachablePoses, row: int, config: int) -> ContactStop:
    targets = groups_of(wish)[int(found.goals.group[row])]
    way: tuple[Joints, ...] = tuple(tuple(map(float, place)) for place in found.way_rad[row])
    return ContactStop(
        config=config,
        targets=tuple(target.number for target in targets),
        way_rad=way,
        push=_vector(found.goals.way_in[row]) if wish.loop == "probe" else None,
    )


def _vector(values: FloatArray) -> Vector:
    x, y, z = map(float, values)
    return x, y, z
