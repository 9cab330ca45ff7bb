"""What is planned for: a cell as its owner describes it, or a robot as a campaign has shown it."""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from truepose.domain.campaign import Campaign, PointReadings, sites
from truepose.domain.cell import Cell, KeepOuts
from truepose.domain.errors import ConfigurationError
from truepose.domain.identification import Model
from truepose.domain.robot import JointRange, Nest
from truepose.planning.prediction.errors import NONE, Discrepancy
from truepose.planning.prediction.expected_covariance import TYPICAL as TRACKER
from truepose.planning.prediction.expected_covariance import PriorKnowledge, TrackerAccuracy, uniform_accuracy
from truepose.planning.prediction.tracker import ExistingReadings
from truepose.planning.workspace.space import TABLE_CLEARANCE_MM, WorkSpace, space_of_cell, space_to_measure

# 0.146 mm on average were left of a small arm (A. Nubiola, thesis, 2014, section 2.5), 0.022 mm of it the
# tracker's; 0.149 and 0.176 with other instruments and artefacts. Nobody knows how another arm is.
TYPICAL: Final = Discrepancy(0.09, 0.3)
APPROACH_RAD: Final = -0.0872664626  # -5 deg on all joints, thesis of A. Nubiola, 2014, section 2.4


@dataclass(frozen=True, slots=True)
class Subject:
    """What a tracker session is planned for.

    Attributes
    ----------
    space : WorkSpace
    knowns : PriorKnowledge
    measured : ExistingReadings or None
        What was measured before; None: nothing.
    nominal_mm : float or None
        Mean error of the nominal robot on what was measured before; None: nobody knows it.
    """

    space: WorkSpace
    knowns: PriorKnowledge
    measured: ExistingReadings | None = None
    nominal_mm: float | None = None

    def reading(self, per_axis_mm: float) -> "Subject":
        """Return the subject with an instrument of this standard uncertainty per axis [mm]."""
        return replace(self, knowns=replace(self.knowns, accuracy=uniform_accuracy(per_axis_mm)))

    def keeping_out(self, keep_outs: KeepOuts) -> "Subject":
        """Return the subject with further keep-out volumes."""
        return replace(self, space=replace(self.space, keep_outs=self.space.keep_outs.joined(keep_outs)))

    def lacking(self, discrepancy_mm: float) -> "Subject":
        """Return the subject with another discrepancy per axis [mm], which then counts as known exactly."""
        return replace(self, knowns=replace(self.knowns, discrepancy=Discrepancy(discrepancy_mm)))


def of_cell(cell: Cell) -> Subject:
    """Return a cell before anything is measured.

    Where nothing says in which ranges configurations are chosen, they are chosen in the joint limits, once
    round at most.

    Parameters
    ----------
    cell : Cell

    Returns
    -------
    Subject

    Raises
    ------
    ConfigurationError
        Neither the cell nor its robot says how far the joints turn.
    """
    knowns = PriorKnowledge(
        accuracy=TRACKER if cell.camera is None else uniform_accuracy(cell.camera.position_u_mm),
        fixed_nests=cell.fixed_nests,
        discrepancy=expected_discrepancy(cell),
    )
    if cell.limits.calibration or cell.robot.calibration_ranges:
        return Subject(space_to_measure(cell, APPROACH_RAD), knowns)
    limits = cell.limits.joints or cell.robot.joint_limits
    if limits is None:
        raise ConfigurationError(
            f"Joint limits are missing for both the cell and {cell.robot.name}. Enter `calibration_deg` "
            "under [limits] in the cell file, or `joint_limits_deg` in the robot file."
        )
    once_round = tuple(JointRange(max(one.lower_rad, -np.pi), min(one.upper_rad, np.pi)) for one in limits)
    return Subject(space_of_cell(cell, once_round, APPROACH_RAD), knowns)


def expected_discrepancy(cell: Cell) -> Discrepancy:
    """Return what parameters are likely not to express: nothing where no real robot is behind the cell.

    Parameters
    ----------
    cell : Cell
        With devices that are not simulated a robot is behind it.

    Returns
    -------
    Discrepancy
    """
    return TYPICAL if cell.devices and cell.simulated is None else NONE


def of_campaign(campaign: Campaign, model: Model) -> Subject:
    """Return the robot of a campaign as it was measured and identified, to go on from there.

    Parameters
    ----------
    campaign : Campaign
    model : Model
        Identified from it.

    Returns
    -------
    Subject

    Raises
    ------
    ConfigurationError
        The campaign has no positions.
    """
    points = campaign.calibration
    if points is None:
        raise ConfigurationError(
            "The campaign has no position measurements to build on. Plan a ballbar session from the cell "
            "file."
        )
    measured = ExistingReadings(points.stops.joints_rad, points.nest, len(np.unique(sites(points.stops))))
    return Subject(_space(campaign, points, model), _knowns(campaign, points, model), measured)


def _space(campaign: Campaign, points: PointReadings, model: Model) -> WorkSpace:
    """Return where it was measured: in the ranges of its joints, no lower, before the same tracker."""
    robot, tracker = campaign.robot, campaign.tracker_position_mm
    # A campaign says nothing of table and column: where its nests were is known to be free, lower is not.
    lowest = float(points.position_mm[:, 2].min())
    # The base where it was found to stand, whatever was stated of it: in that place the tracker sees the
    # nests.
    return WorkSpace(
        robot=robot,
        base=model.nominal_base,
        nests=_nests(campaign, model),
        ranges=robot.calibration_ranges or _ranges(points),
        tracker_position_mm=tracker,
        joint_limits=robot.joint_limits,
        table_z_mm=lowest - TABLE_CLEARANCE_MM,
        approach_offset_rad=APPROACH_RAD,
    )


def _ranges(points: PointReadings) -> tuple[JointRange, ...]:
    joints = points.stops.joints_rad
    ends = zip(joints.min(axis=0).tolist(), joints.max(axis=0).tolist(), strict=True)
    return tuple(JointRange(*pair) for pair in ends)


def _nests(campaign: Campaign, model: Model) -> tuple[Nest, ...]:
    """Return the nests where they were found on the nominal robot."""
    # Facings mean nothing to a work space without a tracker, which refuses them (`require_consistent`).
    seen = campaign.tracker_position_mm is not None
    found = {nest.nest: nest.centre_mm for nest in model.nominal_nests}
    return tuple(
        replace(nest, centre_mm=found[number], facing=nest.facing if seen else None)
        for number, nest in enumerate(campaign.nests, start=1)
    )


def _knowns(campaign: Campaign, points: PointReadings, model: Model) -> PriorKnowledge:
    return PriorKnowledge(
        accuracy=_accuracy(points),
        fixed_nests=campaign.fixed_nests,
        discrepancy=_discrepancy(points, model),
        nests=campaign.nests,
        base_known=campaign.base_nominal is not None,
    )


def _discrepancy(points: PointReadings, model: Model) -> Discrepancy:
    """Return what held-out residuals show, known as well as so many configurations tell.

    The three axes of a place share their causes: a configuration counts once, three parameters take one away.
    """
    # A standard deviation of k degrees of freedom is known to 1 / sqrt(2 k).
    left = len(np.unique(sites(points.stops))) - len(model.parameters) / 3.0
    return Discrepancy(model.discrepancy_mm, 1.0 / np.sqrt(2.0 * max(left, 1.0)))


def _accuracy(points: PointReadings) -> TrackerAccuracy:
    """Return how exactly the readings of the campaign were stated to be."""
    return uniform_accuracy(float(np.sqrt(np.mean(points.standard_uncertainty_mm**2))))
