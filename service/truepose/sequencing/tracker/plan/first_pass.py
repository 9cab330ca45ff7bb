"""What is said before the first session of a robot: its dry run, and that the arm goes at reduced speed."""

from truepose.domain.measurement.session import SessionPlan
from truepose.sequencing.engine.motion.limits import binding_speed
from truepose.sequencing.tracker.cell import SessionCell
from truepose.sequencing.tracker.plan.dry_run import dry_run

_S_PER_MIN = 60.0


def first_pass(plan: SessionPlan, cell: SessionCell) -> str:
    """Return the sentence for a robot that has finished no session yet, else nothing."""
    if not cell.first_pass:
        return ""
    run = dry_run(plan, cell.robot, cell.base, cell.nests, len(cell.fixed_nests))
    speed = binding_speed(plan, cell.speed_limits)
    return (
        f"No session of this robot has finished here. By its dry run this one has {run.configurations} "
        f"configurations and {run.moves} motions, in {run.duration_s / _S_PER_MIN:.0f} min and more; the arm "
        f"goes at {speed.tool_speed_mm_s:g} mm/s at most until one has finished."
    )
