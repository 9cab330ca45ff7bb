"""Plans of ballbar sessions: placements, set-ups, poses in an order with short clear ways."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.ballbar import BallbarPlan, PlannedPlacement, PlannedSetup
from truepose.domain.cell import Cell
from truepose.domain.errors import ConfigurationError
from truepose.kinematics.pose_device import check_triangle
from truepose.planning.ballbar.arm_model import ArmModel, arm_model
from truepose.planning.ballbar.bodies import BallbarCell, BaseFixture
from truepose.planning.ballbar.clearance import is_clear
from truepose.planning.ballbar.expected_information import SPACE_POINTS, work_space_sample
from truepose.planning.ballbar.motion_clearance import Stop, Surroundings, lift
from truepose.planning.ballbar.paths import Tour, away, tour, way
from truepose.planning.ballbar.placements import PlacementRequest, suggest
from truepose.planning.ballbar.pose_selection import Candidates, candidates, choose, require_candidates
from truepose.planning.ballbar.poses import planned_poses, setups, subset
from truepose.planning.errors import ArmInTheWayError, NoWayError, TooFewCandidatesError, WorkSpaceError

_LEGS: Final = 6  # of a pose


def ballbar_plan(
    cell: Cell,
    *,
    placements: int = 1,
    base_points: int = 3,
    poses: int = 61,
    seed: int = 0,
    draws: int = 360,
) -> BallbarPlan:
    """Plan a whole session of a cell: where the base fixture stands, which poses, which ways.

    Parameters
    ----------
    cell : Cell
    placements : int
        How often the base fixture is put down.
    base_points : int
        Cups of the base fixture, 3 or 4.
    poses : int
        Configurations of the whole session.
    seed : int
        The same seed gives the same plan.
    draws : int
        Random places that the search for placements begins with; it takes some ten seconds for 360.

    Returns
    -------
    BallbarPlan
        With all ways; fewer poses where no clear way leads to some.

    Raises
    ------
    ConfigurationError
        The cell lacks what a ballbar needs, or fewer than one placement or pose is asked for.
    WorkSpaceError, TooFewCandidatesError, NoWayError
        The arm does not offer that many poses, or cannot go to them clear of everything.
    """
    moves = draws * 5 // 12
    wish = PlacementRequest(placements, base_points, poses, draws=draws, moves=moves, seed=seed)
    space = ballbar_cell(cell)
    return plan_at(space, suggest(space, wish).fixtures, poses, seed=seed)


def ballbar_cell(cell: Cell) -> BallbarCell:
    """Return what limits the arm in a cell.

    Parameters
    ----------
    cell : Cell

    Returns
    -------
    BallbarCell
        Ranges are those of the calibration, else the joint limits; legs of 300 mm where nothing else is
        stated; the table at the floor of the cell.

    Raises
    ------
    ConfigurationError
        There are not three tool nests with known centres, or they lie on a line.
    WorkSpaceError
        Neither the cell nor the robot says which joint angles are allowed.
    """
    centres = [nest.centre_mm for nest in cell.nests if nest.centre_mm is not None]
    if len(centres) != 3 or len(cell.nests) != 3:
        raise ConfigurationError(
            "A ballbar session needs a tool with three nests whose centres are known. Enter them in the "
            "cell file."
        )
    check_triangle(np.array(centres), "tool nests")
    robot, limits = cell.robot, cell.limits
    ranges = limits.calibration or robot.calibration_ranges or limits.joints or robot.joint_limits
    if ranges is None:
        raise WorkSpaceError(
            f"The joint ranges of {robot.name} are not known. Enter `calibration` ranges in the cell file."
        )
    leg = 300.0 if cell.ballbar is None else cell.ballbar.base_bars.nominal_mm
    return BallbarCell(
        robot,
        cell.base_nominal,
        np.array(centres),
        ranges,
        leg_mm=leg,
        table_z_mm=cell.floor_z_mm,
        keep_outs=limits.keep_outs,
    )


def plan_at(
    cell: BallbarCell,
    fixtures: Sequence[BaseFixture],
    poses: int,
    *,
    seed: int = 0,
    template: BallbarPlan | None = None,
) -> BallbarPlan:
    """Plan a session with the base fixture at given places.

    Where fewer configurations can be measured than were asked for, all of them are planned; those to which no
    clear way is found are left out.

    Parameters
    ----------
    cell : BallbarCell
    fixtures : sequence of BaseFixture
        In the order of their placements, numbered from 1.
    poses : int
        Configurations of the whole session.
    seed : int
        The same seed gives the same plan.
    template : BallbarPlan, optional
        Times, speeds and the number of poses after which targets are aimed.

    Returns
    -------
    BallbarPlan

    Raises
    ------
    ConfigurationError
        Fewer than one pose is asked for.
    WorkSpaceError
        The arm cannot hold the setting ball at a cup.
    TooFewCandidatesError
        Nothing can be measured from a placement, or no pose is chosen there.
    NoWayError
        No way leads to any pose of a placement, or the arm has nowhere to stand for the next.
    """
    rng = np.random.default_rng(seed)
    model = arm_model(cell)
    template = template or _with_precalibration(poses, model.parameters)
    held = [setups(cell, fixture) for fixture in fixtures]
    offers = [candidates(model, fixture, own) for fixture, own in zip(fixtures, held, strict=True)]
    require_candidates(offers)
    chosen = choose(model, offers, poses, rng, work_space_sample(model, SPACE_POINTS, rng))
    for own, rows in zip(offers, chosen, strict=True):
        if not len(rows):
            raise TooFewCandidatesError(
                f"None of the {poses} poses is best measured from placement {own.fixture.number}. Request "
                "more poses, or fewer placements of the base fixture."
            )
    return replace(template, placements=_Session(cell, model, rng, template).planned(offers, held, chosen))


def _with_precalibration(poses: int, parameters: int) -> BallbarPlan:
    """Return an empty plan whose pre-calibration comes where it helps.

    The more poses it rests on, the better it aims; the more follow, the more have legs that differ. A short
    plan has it halfway, but not before there are as many lengths as the arm has parameters: the pose at which
    that comes about is the first of which much is foreseen.
    """
    usual = BallbarPlan(())
    if poses >= 2 * usual.precalibrate_after:
        return usual
    early = max(-(-parameters // _LEGS), poses // 2)
    return BallbarPlan((), precalibrate_after=early, check_at_end=early < poses)


@dataclass(frozen=True, slots=True)
class _Session:
    cell: BallbarCell
    model: ArmModel
    rng: np.random.Generator
    template: BallbarPlan

    def planned(
        self,
        offers: Sequence[Candidates],
        held: Sequence[tuple[PlannedSetup, ...]],
        chosen: Sequence[IntArray],
    ) -> tuple[PlannedPlacement, ...]:
        """Return the placements with all ways, configurations numbered through."""
        found: list[PlannedPlacement] = []
        here: Stop | None = None
        for place, (own, setup, rows) in enumerate(zip(offers, held, chosen, strict=True)):
            after = offers[place + 1].fixture if place + 1 < len(offers) else None
            number = 1 + sum(len(before.poses) for before in found)
            placed = self._placement(own, setup, rows, here, after, number)
            found.append(placed)
            here = Stop(np.array(placed.poses[-1].joints_rad)) if placed.poses else here
        return tuple(found)

    def _placement(
        self,
        own: Candidates,
        held: tuple[PlannedSetup, ...],
        rows: IntArray,
        here: Stop | None,
        after: BaseFixture | None,
        number: int,
    ) -> PlannedPlacement:
        around = Surroundings(self.cell, own.fixture)
        setups_there, last = self._with_ways(around, held, here)
        early = self._early(own, rows) if number == 1 else rows[:0]
        poses = planned_poses(subset(own.found, rows), own.fixture.number)
        joints = np.array([pose.joints_rad for pose in poses]).reshape(-1, self.cell.robot.n_joints)
        first = np.flatnonzero(np.isin(rows, early))
        groups = self._groups(len(poses), first, self._parking(joints, first, after))
        # Off the cups before the first pose: with all of them clamped a person takes the ball out and
        # measures the sides of the base.
        waits = away(around, last, joints, self.rng)
        found = tour(around, joints, groups, Stop(np.array(waits.joints_rad)), self.rng)
        self._check(found, joints, own.fixture, after)
        ordered = tuple(
            replace(poses[row], config=config, via_rad=via)
            for config, (row, via) in enumerate(zip(found.order, found.vias, strict=True), start=number)
        )
        cups = tuple((float(x), float(y), float(z)) for x, y, z in own.fixture.cups_mm)
        return PlannedPlacement(own.fixture.number, own.fixture.frame, cups, setups_there, ordered, waits)

    def _with_ways(
        self, around: Surroundings, held: tuple[PlannedSetup, ...], here: Stop | None
    ) -> tuple[tuple[PlannedSetup, ...], Stop]:
        """Set-ups with their ways, and the last one as a stop.

        Nobody knows where the arm is before the first one of a session: its way is only the last stretch.
        """
        found = []
        for setup in held:
            stop = Stop(np.array(setup.joints_rad), setup.base_point)
            via = _approach(around, stop) if here is None else way(around, here, stop, self.rng)
            found.append(replace(setup, via_rad=via))
            here = stop
        return tuple(found), here if here is not None else Stop(np.zeros(self.cell.robot.n_joints))

    def _early(self, own: Candidates, rows: IntArray) -> IntArray:
        """Return the configurations from which the pre-calibration sees most; they are measured first."""
        few = min(self.template.precalibrate_after, len(rows))
        # Chosen among what is measured anyway: the pre-calibration costs no pose of its own.
        part = replace(own, found=subset(own.found, rows), rows=own.rows.some(rows))
        return rows[choose(self.model, [part], few, self.rng)[0]]

    def _parking(self, joints: FloatArray, first: IntArray, after: BaseFixture | None) -> int | None:
        """Return where the arm may stand while the base fixture is put to its next place; it comes last."""
        if after is None or not len(joints):
            return None
        free = is_clear(self.cell, after, joints)
        # Where the arm waits is its last pose, and those of the pre-calibration come first.
        later = np.setdiff1d(np.flatnonzero(free), first)
        usable = later if len(later) else np.flatnonzero(free)
        if not len(usable):
            raise ArmInTheWayError(after.number)
        return int(usable[0])

    def _check(
        self, found: Tour, joints: FloatArray, fixture: BaseFixture, after: BaseFixture | None
    ) -> None:
        """Refuse a placement that no way leads through, or that leaves the arm where the next one comes."""
        if not found.order:
            raise NoWayError(
                f"No collision-free path from the set-ups of placement {fixture.number} to any pose was "
                "found. Move the base fixture slightly, or let the program suggest a position."
            )
        if after is not None and not is_clear(self.cell, after, joints[list(found.order[-1:])]).all():
            raise ArmInTheWayError(after.number)

    def _groups(self, n: int, first: IntArray, last: int | None) -> list[list[int]]:
        """Return rows in three groups: those of the pre-calibration, the others, the one to end with."""
        early = [int(row) for row in first if row != last]
        later = [row for row in range(n) if row not in first and row != last]
        return [early, later, [] if last is None else [last]]


def _approach(around: Surroundings, stop: Stop) -> tuple[tuple[float, ...], ...]:
    """Return the last stretch to a stop: at a set-up along the cup's axis, else none."""
    return tuple(tuple(float(q) for q in point) for point in lift(around, stop)[:0:-1])
