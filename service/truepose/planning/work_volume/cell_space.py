"""From a cell to the work space in which its configurations are chosen and judged."""

from truepose.domain.cell.description import Cell
from truepose.domain.errors import ConfigurationError
from truepose.domain.robot import JointRange
from truepose.planning.work_volume.work_space import SEEN_WITHIN_RAD, WorkSpace


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
        keep_outs=cell.limits.keep_outs,
        seen_within_rad=cell.limits.seen_within_rad or SEEN_WITHIN_RAD,
        camera=cell.camera,
    )


def space_to_measure(cell: Cell, approach_offset_rad: float | None) -> WorkSpace:
    """Return the work space in which the configurations of a session are chosen.

    Raises ConfigurationError where neither cell nor robot says it.
    """
    ranges = cell.limits.calibration or cell.robot.calibration_ranges
    if ranges is None:
        raise ConfigurationError(
            f"Neither the cell nor {cell.robot.name} says in which ranges configurations are chosen; "
            "give them under [limits] of the cell file, or give the stops."
        )
    return space_of_cell(cell, ranges, approach_offset_rad)
