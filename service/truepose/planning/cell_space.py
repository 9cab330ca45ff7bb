"""From a cell to the work space in which its configurations are chosen and judged."""

from truepose.domain.cell import Cell
from truepose.domain.robot import JointRange
from truepose.planning.work_space import WorkSpace


def space_of_cell(cell: Cell, ranges: tuple[JointRange, ...], approach_offset_rad: float | None) -> WorkSpace:
    """Return the work space of `cell` for configurations in `ranges`, approached from that offset."""
    return WorkSpace(
        robot=cell.robot,
        base=cell.base_nominal,
        nests=cell.nests,
        ranges=ranges,
        tracker_position_mm=cell.tracker_position_mm,
        joint_limits=cell.limits.joints or cell.robot.joint_limits,
        table_z_mm=0.0 if cell.limits.floor_z_mm is None else cell.limits.floor_z_mm,
        approach_offset_rad=approach_offset_rad,
    )
