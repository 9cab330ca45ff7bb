"""The plan of a ballbar session: where the base fixture goes, and which poses are measured there."""

from truepose.analysis.workers.tasks import BallbarPlanTask
from truepose.domain.cell.artefacts import BallbarKit
from truepose.domain.measurement.ballbar import BallbarPlan
from truepose.planning.ballbar.fixture import base_fixture
from truepose.planning.ballbar.plan import ballbar_cell, ballbar_plan, plan_at
from truepose.planning.ballbar.sphere import plan_sphere


def plan_ballbar_session(task: BallbarPlanTask) -> BallbarPlan:
    """Return the plan that is asked for; raises as `truepose.planning.ballbar.plan.ballbar_plan`."""
    cell = task.setup.cell
    kit = cell.ballbar or BallbarKit()
    side_mm = kit.base_bars.nominal_mm
    if task.sphere is not None:
        (place,) = task.frames
        ball = base_fixture(1, place, kit.base_points, side_mm)
        return plan_sphere(ballbar_cell(cell), ball, task.sphere, seed=task.seed)
    if not task.frames:
        return ballbar_plan(
            cell,
            placements=task.n_placements,
            base_points=kit.base_points,
            poses=task.n_poses,
            seed=task.seed,
        )
    numbered = enumerate(task.frames, 1)
    fixtures = [base_fixture(number, frame, kit.base_points, side_mm) for number, frame in numbered]
    return plan_at(ballbar_cell(cell), fixtures, task.n_poses, seed=task.seed)
