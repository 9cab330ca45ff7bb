"""Plans of tracker sessions: whether this cell can do them, and what to watch on the ways."""

from collections.abc import Sequence

from truepose.domain.cell.description import Cell
from truepose.domain.measurement.session import PlannedStop, SessionPlan
from truepose.planning.work_volume.cell_bodies import CellBodies, bodies_of
from truepose.planning.work_volume.room_at_stops import what_is_in_the_way
from truepose.planning.work_volume.room_on_ways import Ways, ways_between, what_blocks_a_way, what_to_watch
from truepose.sequencing.errors import PlanRefusedError
from truepose.sequencing.tracker.plan.dry_run import check_plan, motion_limits


def judged(cell: Cell, plan: SessionPlan) -> str:
    """Return what to watch on the ways of a plan; raises PlanRefusedError where this cell cannot do it."""
    require_fit(cell, plan)
    bodies = bodies_of(cell)
    _refuse(what_is_in_the_way(bodies, plan.stops, plan.approach_offset_rad))
    return _watched(bodies, ways_between(plan.stops, plan.approach_offset_rad))


def judged_addition(cell: Cell, plan: SessionPlan, added: Sequence[PlannedStop]) -> str:
    """Return what to watch on the ways to added stops; raises PlanRefusedError where one cannot be."""
    return _watched(bodies_of(cell), ways_between((*plan.stops[-1:], *added), plan.approach_offset_rad))


def require_fit(cell: Cell, plan: SessionPlan, done: frozenset[int] = frozenset()) -> None:
    """Raise PlanRefusedError for what no session can do; configurations in `done` need not be reached."""
    limits = motion_limits(cell.robot, cell.limits.joints or cell.robot.joint_limits, plan)
    check_plan(plan, cell.robot, cell.nests, cell.fixed_nests, limits, done)


def refuse_below_floor(
    bodies: CellBodies, stops: Sequence[PlannedStop], approach_offset_rad: float | None
) -> None:
    """Raise PlanRefusedError for the first stop, else the first way to one, that leads through the floor."""
    _refuse(what_is_in_the_way(bodies, stops, approach_offset_rad, floor_only=True))
    _refuse(what_blocks_a_way(bodies, ways_between(stops, approach_offset_rad), floor_only=True))


def _watched(bodies: CellBodies, ways: Ways) -> str:
    _refuse(what_blocks_a_way(bodies, ways))
    return what_to_watch(bodies, ways)


def _refuse(blocked: str | None) -> None:
    if blocked is not None:
        raise PlanRefusedError(blocked)
