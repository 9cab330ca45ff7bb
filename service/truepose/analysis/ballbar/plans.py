"""The plan of a ballbar session: where the base fixture goes, and which poses are measured there."""

from collections.abc import Sequence

from truepose.domain.cell.artefacts import BallbarKit
from truepose.domain.cell.description import Cell
from truepose.domain.measurement.ballbar import BallbarPlan, SphereWish
from truepose.domain.robot import FramePlacement
from truepose.planning.ballbar.fixture import base_fixture
from truepose.planning.ballbar.plan import ballbar_cell, ballbar_plan, plan_at
from truepose.planning.ballbar.sphere import plan_sphere


def plan_ballbar_session(
    cell: Cell,
    frames: Sequence[FramePlacement],
    *,
    placements: int,
    poses: int,
    seed: int,
    sphere: SphereWish | None,
) -> BallbarPlan:
    """Return the plan that is asked for; raises as `truepose.planning.ballbar.plan.ballbar_plan`.

    Without `frames` the base fixture is placed here; a test by a `sphere` has exactly one.
    """
    kit = cell.ballbar or BallbarKit()
    side_mm = kit.base_bars.nominal_mm
    if sphere is not None:
        (place,) = frames
        ball = base_fixture(1, place, kit.base_points, side_mm)
        return plan_sphere(ballbar_cell(cell), ball, sphere, seed=seed)
    if not frames:
        return ballbar_plan(cell, placements=placements, base_points=kit.base_points, poses=poses, seed=seed)
    numbered = enumerate(frames, 1)
    fixtures = [base_fixture(number, frame, kit.base_points, side_mm) for number, frame in numbered]
    return plan_at(ballbar_cell(cell), fixtures, poses, seed=seed)
