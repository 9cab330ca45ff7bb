"""Plans of sphere tests: stops all over the part of a sphere that the arm reaches, with ways to them.

The bar goes from the ball in cup 1 of the base fixture to one nest at a time. It is off while the arm moves:
so every stop can be approached from one side, from lower angles of all joints, as the thesis approaches its
tracker's stops (2.4); with the bar on it could not (2.6.3). From a stop the arm first goes back that way.

Stops lie at ball + l n with the bar's length l, along directions n of a Fibonacci lattice over the cap that a
bar may lean in; of those that can be measured each next one is the farthest from all before. Where a model
commands the arm, stops are aimed by it: with g the derivative of the length by the joints, each round adds
the shortest step that mends the length, dq = g (l - |P - B|) / g.g.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.ballbar import (
    BallbarPlan,
    PlannedPlacement,
    PlannedPose,
    PlannedSetup,
    SpherePlanRequest,
)
from truepose.domain.campaign import Stops
from truepose.domain.errors import ConfigurationError
from truepose.identification.model.prediction import predict
from truepose.identification.model.validity import require_same_robot
from truepose.kinematics.chain import theta_gradient
from truepose.kinematics.frames import poses_of
from truepose.kinematics.inverse import all_branches, brought_within
from truepose.planning.ballbar.bodies import BallbarCell, BaseFixture, chain_of, pose_in_base
from truepose.planning.ballbar.clearance import (
    LEAN_RAD,
    Bars,
    arm_room_mm,
    bar_room_mm,
    bodies_at,
)
from truepose.planning.ballbar.motion_clearance import Stop, Surroundings, between, is_clear_along, lift
from truepose.planning.ballbar.paths import Tour, away, tour
from truepose.planning.ballbar.poses import inside, orientations_facing, setup_joints
from truepose.planning.errors import TooFewCandidatesError, WorkSpaceError

BALL_CUP: Final = 1
_BALL_NEST: Final = 1  # that holds the ball while its cup is clamped
_APPROACH_RAD: Final = float(np.radians(5.0))  # on all joints, thesis section 2.4
_DIRECTIONS: Final = 6  # looked at for each stop that is wanted
_ORIENTATIONS: Final = 24  # of the tool, for each direction
_TRIES: Final = 4  # configurations in one direction
_FEWEST: Final = 6  # stops; fewer tell next to nothing of where the ball is
_AIMS: Final = 4  # rounds of Newton along the bar


def plan_sphere(
    cell: BallbarCell, fixture: BaseFixture, wish: SpherePlanRequest, *, seed: int = 0
) -> BallbarPlan:
    """Plan a sphere test about cup 1 of a base fixture; the same seed gives the same plan.

    Where fewer stops can be measured than were wanted, all that were found are planned.

    Parameters
    ----------
    cell : BallbarCell
    fixture : BaseFixture
        Placement 1; of its cups the first alone is used.
    wish : SpherePlanRequest
    seed : int

    Returns
    -------
    BallbarPlan
        One placement, one set-up, one leg a pose.

    Raises
    ------
    ConfigurationError
        A nest is none, or the model is of another robot.
    WorkSpaceError
        The arm cannot hold the ball at the cup.
    TooFewCandidatesError, NoWayError
        It cannot hold a nest a bar's length from it often enough, or not clear of everything.

    References
    ----------
    Thesis of A. Nubiola, 2014, section 2.6.3; docs/decisions/0045.
    """
    _require_nests(cell, wish.nests)
    if wish.model is not None:
        require_same_robot(wish.model, cell.robot)
    held = setup_joints(cell, fixture, BALL_CUP)
    if held is None:
        raise WorkSpaceError(
            "The arm cannot hold the setting ball at base point 1. Move the base fixture closer to the "
            "middle of the arm's workspace."
        )
    around, rng = Surroundings(cell, fixture), np.random.default_rng(seed)
    search = _Search(around, held, wish, rng)
    found = [search.stops(nest) for nest in wish.nests]
    plan = _planned(around, Stop(held, BALL_CUP), wish.nests, found, rng)
    return replace(plan, model_id=wish.model_id)


def _require_nests(cell: BallbarCell, nests: Sequence[int]) -> None:
    known = range(1, len(cell.nests_mm) + 1)
    unknown = [nest for nest in nests if nest not in known]
    if unknown or not nests or len(set(nests)) < len(nests):
        raise ConfigurationError(
            f"Choose the tool nests of a sphere test from 1 to {known[-1]}, each only once."
        )


@dataclass(frozen=True, slots=True)
class _Search:
    """Searches for stops on the sphere about a ball that the arm held."""

    around: Surroundings
    held_rad: FloatArray
    wish: SpherePlanRequest
    rng: np.random.Generator

    def stops(self, nest: int) -> FloatArray:
        """Return configurations (m, J), spread over the directions from the ball.

        Raises
        ------
        TooFewCandidatesError
            There are fewer than six.
        """
        directions = _lattice(self.around.fixture.axes[BALL_CUP - 1], _DIRECTIONS * self.wish.stops)
        joints, row = self._candidates(nest, directions)
        # Before the stops are picked: what the aim moves out of room or range is passed over like any
        # other.
        joints = self._aimed(nest, joints)
        found: list[FloatArray] = []
        for direction in self._spread(directions, np.unique(row)):
            if len(found) == self.wish.stops:
                break
            found += self._usable(joints[row == direction])
        if len(found) < _FEWEST:
            raise TooFewCandidatesError(
                f"The arm can hold nest {nest} at ballbar length from the ball in only {len(found)} "
                f"configurations; {_FEWEST} are needed. Move or rotate the base fixture."
            )
        return np.array(found)

    def _candidates(self, nest: int, directions: FloatArray) -> tuple[FloatArray, IntArray]:
        """Return measurable configurations, in each direction a few far inside their ranges, and which."""
        cell, fixture = self.around.cell, self.around.fixture
        poses = np.concatenate(list(self._poses(nest, directions)))
        joints = all_branches(cell.robot, pose_in_base(cell, poses))
        row = np.repeat(np.arange(len(directions)), _ORIENTATIONS * joints.shape[1])
        turned, within = brought_within(joints.reshape(-1, cell.robot.n_joints), cell.ranges)
        turned, row = turned[within], row[within]
        bodies = bodies_at(cell, fixture, turned)
        joined = Bars(np.full((1, len(turned)), BALL_CUP), np.full((1, len(turned)), nest))
        free = (arm_room_mm(bodies) >= cell.arm_room_mm) & (
            bar_room_mm(bodies, joined)[0] >= cell.bar_room_mm
        )
        turned, row = turned[free], row[free]
        order = np.argsort(-inside(cell.ranges, turned), kind="stable")
        few = [order[row[order] == direction][:_TRIES] for direction in np.unique(row)]
        tried = np.concatenate([order[:0], *few])
        return turned[tried], row[tried]

    def _poses(self, nest: int, directions: FloatArray) -> Iterator[FloatArray]:
        cell, ball = self.around.cell, self.around.fixture.cups_mm[BALL_CUP - 1]
        for direction in directions:
            rotations, _ = orientations_facing(cell, direction)
            some = rotations[self.rng.choice(len(rotations), _ORIENTATIONS, replace=False)]
            yield poses_of(some, ball + cell.leg_mm * direction - some @ cell.nests_mm[nest - 1])

    def _spread(self, directions: FloatArray, rows: IntArray) -> Iterator[int]:
        """Yield rows, each as far as can be from those before."""
        left = directions[rows]
        nearest = np.full(len(rows), -np.inf)
        for _ in range(len(rows)):
            chosen = int(np.argmin(nearest))
            nearest = np.maximum(nearest, left @ left[chosen])
            nearest[chosen] = np.inf
            yield int(rows[chosen])

    def _usable(self, joints_rad: FloatArray) -> list[FloatArray]:
        """Return the first configuration that can be approached, none where none can."""
        for joints in joints_rad:
            if is_clear_along(self.around, between(joints - _APPROACH_RAD, joints)):
                return [joints]
        return []

    def _aimed(self, nest: int, joints_rad: FloatArray) -> FloatArray:
        """Return configurations (m, J) in which the model that commands has the nest on the sphere."""
        model, cell = self.wish.model, self.around.cell
        if model is None or not len(joints_rad):
            return joints_rad
        ball = predict(model, _stops(self.held_rad[None]), np.array([_BALL_NEST]))[0]
        # The arm held the ball, so its errors there moved it: the model says where it is, and the
        # step goes by the nominal arm, which is near enough for a direction.
        nominal_ball = self.around.fixture.cups_mm[BALL_CUP - 1]
        for _ in range(_AIMS):
            places, _ = predict(model, _stops(joints_rad), np.full(len(joints_rad), nest))
            short_mm = cell.leg_mm - np.linalg.norm(places - ball, axis=1)
            arm = chain_of(cell, joints_rad)
            nests = arm.points(cell.nests_mm[nest - 1])
            along = (nests - nominal_ball) / np.linalg.norm(nests - nominal_ball, axis=1)[:, None]
            lever = np.einsum("jni,ni->nj", theta_gradient(arm, nests), along)
            joints_rad = joints_rad + lever * (short_mm / (lever**2).sum(axis=1))[:, None]
        return joints_rad


def _stops(joints_rad: FloatArray) -> Stops:
    """Return stops that the arm comes to from lower angles."""
    n = len(joints_rad)
    return Stops(np.arange(n), joints_rad, direction=np.ones(joints_rad.shape, dtype=np.int64))


def _lattice(axis: FloatArray, count: int) -> FloatArray:
    """Return directions evenly spread about an axis, as far from it as a bar may lean.

    Heights along the axis are evenly spaced, as areas of a sphere are; each next direction turns by the
    golden angle.

    Parameters
    ----------
    axis : ndarray, shape (3,)
        Unit vector.
    count : int

    Returns
    -------
    ndarray, shape (count, 3)
        Unit vectors, from the axis outwards.

    References
    ----------
    A. Gonzalez, Math. Geosciences 42, 2010, 49-64 (Fibonacci lattice).
    """
    k = np.arange(count) + 0.5
    up = 1.0 - k / count * (1.0 - np.cos(LEAN_RAD))
    turn = np.pi * (1.0 + np.sqrt(5.0)) * k
    across = np.sqrt(1.0 - up**2)
    aside = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    aside /= np.linalg.norm(aside)
    frame = np.stack([aside, np.cross(axis, aside), axis])
    return np.asarray(np.column_stack([across * np.cos(turn), across * np.sin(turn), up]) @ frame)


def _planned(
    around: Surroundings,
    held: Stop,
    nests: Sequence[int],
    found: Sequence[FloatArray],
    rng: np.random.Generator,
) -> BallbarPlan:
    joints = np.vstack(found)
    nest = np.repeat(nests, [len(own) for own in found])
    # Ways lead from approach to approach: the last five degrees of each stop, and the first of leaving
    # it, are its own.
    before = joints - _APPROACH_RAD
    waits = away(around, held, before, rng)
    groups = [np.flatnonzero(nest == number).tolist() for number in nests]
    ways = tour(around, before, groups, Stop(np.array(waits.joints_rad)), rng)
    for number in nests:
        if np.count_nonzero(nest[list(ways.order)] == number) < _FEWEST:
            raise TooFewCandidatesError(
                f"No collision-free path to enough configurations of nest {number} on the sphere was found. "
                "Move or rotate the base fixture."
            )
    fixture = around.fixture
    setup = PlannedSetup(BALL_CUP, _row(held.joints_rad), tuple(map(_row, lift(around, held)[:0:-1])))
    cups = tuple((float(x), float(y), float(z)) for x, y, z in fixture.cups_mm)
    poses = tuple(_poses(ways, joints, before, nest, fixture.number))
    placed = PlannedPlacement(fixture.number, fixture.frame, cups, (setup,), poses, waits)
    return BallbarPlan((placed,), test="sphere")


def _poses(
    ways: Tour, joints: FloatArray, before: FloatArray, nest: IntArray, placement: int
) -> Iterator[PlannedPose]:
    back: tuple[tuple[float, ...], ...] = ()
    for config, (row, via) in enumerate(zip(ways.order, ways.vias, strict=True), start=1):
        approach = (_row(before[row]),)
        legs = ((BALL_CUP, int(nest[row])),)
        way = tuple(chain(back, via, approach))
        yield PlannedPose(config, placement, _row(joints[row]), legs, via_rad=way)
        # A stop is left the way it was approached (docs/decisions/0045).
        back = approach


def _row(joints_rad: FloatArray) -> tuple[float, ...]:
    return tuple(float(q) for q in joints_rad)
