"""What a campaign knows before any fit: nests, base, torques. Effects choose their parameters from it."""

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray, distinct_values
from truepose.domain.measurement.campaign import Campaign, Stops
from truepose.domain.measurement.targets import SEEN_ALONG_AXES
from truepose.effects.ports import Setting
from truepose.identification.problem.placement import Known
from truepose.kinematics.chain import nominal_chain
from truepose.kinematics.frames import placement_rotation, placement_translation
from truepose.kinematics.gravity import gravity_torques


def torque_source(campaign: Campaign) -> str:
    """Where joint torques come from: `measured`, `masses` or `unknown`."""
    readings = campaign.readings
    torque = None if readings is None else readings.stops.torque_n_mm
    if torque is not None and np.isfinite(torque).any():
        return "measured"
    return "masses" if campaign.robot.masses else "unknown"


def unknown_nests(campaign: Campaign) -> tuple[int, ...]:
    """Return the numbers of the nests that must be found from the data."""
    return tuple(k + 1 for k, nest in enumerate(campaign.nests) if nest.centre_mm is None)


def has_orientations(campaign: Campaign) -> bool:
    """Whether the orientation of the tool shows in what was measured."""
    if campaign.calibration is None:
        return any(target.kind in SEEN_ALONG_AXES for target in campaign.targets)
    return campaign.calibration.quaternion is not None


def known_placement(campaign: Campaign) -> Known:
    """Return what the campaign says of base and nests."""
    unknown = np.array([nest.centre_mm is None for nest in campaign.nests])
    centres = np.array([nest.centre_mm or (0.0, 0.0, 0.0) for nest in campaign.nests])
    base = campaign.base_nominal
    if base is None:
        return Known(None, centres, unknown)
    return Known((placement_rotation(base), placement_translation(base)), centres, unknown)


def outline(campaign: Campaign) -> Setting:
    """Return what a campaign knows before a look at its columns."""
    return Setting(
        robot=campaign.robot,
        unknown_nests=unknown_nests(campaign),
        has_orientations=has_orientations(campaign),
        torque_source=torque_source(campaign),
        largest_torque_n_mm=np.zeros(campaign.robot.n_joints),
        lengths=campaign.calibration is None,
        tool_rotation_u_rad=campaign.tool_rotation_uncertainty_rad,
    )


def setting_of(campaign: Campaign, stops: Stops, base_rotation: FloatArray | None = None) -> Setting:
    """Return what effects choose their parameters from.

    Parameters
    ----------
    campaign : Campaign
    stops : Stops
    base_rotation : ndarray, shape (3, 3), optional
        Of the base as found from the data, which says where gravity points; without it the campaign's,
        and the world's where the campaign has none.
    """
    known = outline(campaign)
    source, largest = known.torque_source, known.largest_torque_n_mm
    if source == "measured" and stops.torque_n_mm is not None:
        largest = np.nanmax(np.abs(stops.torque_n_mm), axis=0)
    elif source == "masses":
        base = known_placement(campaign).base
        rotation = base_rotation
        if rotation is None:
            rotation = np.eye(3) if base is None else base[0]
        gravity = rotation.T @ np.array(campaign.gravity_m_s2)
        chain = nominal_chain(campaign.robot, stops.joints_rad)
        largest = np.abs(gravity_torques(chain, campaign.robot.masses, gravity)).max(axis=0)
    legs = campaign.legs if campaign.calibration is None else None
    return known._replace(
        largest_torque_n_mm=largest,
        certified_nests=_certified_nests(campaign),
        attachments=_numbers(stops.attachment),
        initialisations=_numbers(None if legs is None else legs.initialisation),
    )


def _certified_nests(campaign: Campaign) -> tuple[int, ...]:
    readings = campaign.readings
    unknown = unknown_nests(campaign)
    measured = () if readings is None else _numbers(readings.nest)
    return tuple(nest for nest in measured if nest not in unknown)


def _numbers(column: IntArray | None) -> tuple[int, ...]:
    """Return the distinct known numbers of a column; those below 0 stand for unknown ones."""
    return () if column is None else tuple(distinct_values(column[column >= 0]).tolist())
