"""From a fit to a model that can be saved and predicts.

The standard uncertainty of a parameter is the root of its variance in the covariance that the model keeps,
readings, priors, certificates and registration together.
"""

from dataclasses import dataclass

import numpy as np

from truepose.domain.arrays import FloatArray, distinct_values
from truepose.domain.campaign import Campaign, sites
from truepose.domain.identification import Anchor, Model, NestCentre, Parameter
from truepose.domain.robot import FramePlacement
from truepose.identification.fit.robust import RobustFit
from truepose.identification.model.missing_input_uncertainty import span_of_readings
from truepose.identification.model.structure import (
    LEG_OFFSET,
    TARGET_OWNER,
    Structure,
    anchor_name,
    base_axes,
)
from truepose.identification.model.validity import measured_zone
from truepose.kinematics.frames import angles_xyz, placement_of


@dataclass(frozen=True, slots=True)
class Fits:
    """What a model is made from.

    Attributes
    ----------
    campaign : Campaign
    identified, nominal : RobustFit
        All parameters, and base and unknown nests alone.
    covariance : ndarray, shape (P, P)
        Of the identified parameters with what certificates add, internal units.
    """

    campaign: Campaign
    identified: RobustFit
    nominal: RobustFit
    covariance: FloatArray


def model_of(fits: Fits, *, discrepancy_mm: float, program_version: str) -> Model:
    """Return the model of a fit.

    Parameters
    ----------
    fits : Fits
    discrepancy_mm : float
        What the model lacks, per axis.
    program_version : str
        Kept in the model.

    Returns
    -------
    Model
        Without a shortfall: what the model lacks is described elsewhere.
    """
    structure, campaign = fits.identified.structure, fits.campaign
    # Kept with the model, so that whoever validates it later compares with the same nominal robot.
    nominal_base, nominal_nests = _placed(fits.nominal)
    return Model(
        robot=structure.robot,
        base=placement_of(structure.base_rotation, structure.base_origin_mm),
        nests=_nests(structure.nests_mm),
        tool_rotation_rad=angles_xyz(structure.tool_rotation),
        effects=structure.effects,
        parameters=_parameters(fits),
        covariance=fits.covariance,
        gravity_m_s2=campaign.gravity_m_s2,
        discrepancy_mm=discrepancy_mm,
        repeatability_mm=campaign.robot.repeatability_mm,
        nominal_base=nominal_base,
        nominal_nests=nominal_nests,
        nominal_tool_rotation_rad=_turned(fits.nominal),
        instrument_mm=campaign.tracker_position_mm,
        # Without a spring no torque takes part: rows need not tell it.
        torques_measured=structure.torques_measured and structure.has_springs,
        origin_s=structure.origin_s,
        nominal_leg_offset_mm=_value(fits.nominal, LEG_OFFSET),
        nominal_anchors=_anchors(fits.nominal),
        targets=structure.targets,
        nominal_targets=_of_targets(fits.nominal),
        zone=measured_zone(structure.robot, fits.identified.blocks[0].targets.stops.joints_rad),
        identified_from=_origin(fits),
        program_version=program_version,
    )


def _parameters(fits: Fits) -> tuple[Parameter, ...]:
    structure = fits.identified.structure
    uncertainty = np.sqrt(np.diag(fits.covariance))
    rows = zip(structure.specs, structure.owners, fits.identified.values, uncertainty, strict=True)
    return tuple(
        Parameter(spec.name, owner, float(value), spec.unit, float(u), spec.prior_width)
        for spec, owner, value, u in rows
    )


def _placed(nominal: RobustFit) -> tuple[FramePlacement, tuple[NestCentre, ...]]:
    structure = nominal.structure
    shift = np.array([_value(nominal, name) for name in ("base_x", "base_y", "base_z")])
    turn = np.array([_value(nominal, name) for name in ("base_rx", "base_ry", "base_rz")])
    rotation, _ = base_axes(structure.base_rotation, turn)
    # Certified nests have no parameters of these names and stay where they are.
    moved = structure.nests_mm + np.array([
        [_value(nominal, f"nest_{number}_{axis}") for axis in "xyz"]
        for number in range(1, len(structure.nests_mm) + 1)
    ]).reshape(-1, 3)
    return placement_of(rotation, structure.base_origin_mm + shift), _nests(moved)


def _turned(nominal: RobustFit) -> tuple[float, float, float]:
    # Angles turn about the start, which may be far from the identity; the model states the rotation that
    # results.
    turn = np.array([_value(nominal, name) for name in ("tool_rx", "tool_ry", "tool_rz")])
    return angles_xyz(base_axes(nominal.structure.tool_rotation, turn)[0])


def _nests(centres_mm: FloatArray) -> tuple[NestCentre, ...]:
    return tuple(
        NestCentre(number, (float(x), float(y), float(z)))
        for number, (x, y, z) in enumerate(centres_mm, start=1)
    )


def _value(fit: RobustFit, name: str) -> float:
    # What a structure has no parameter of is as it was at the start.
    structure: Structure = fit.structure
    return float(fit.values[structure.index_of(name)]) if name in structure.names else 0.0


def _anchors(fit: RobustFit) -> tuple[Anchor, ...]:
    found = []
    for anchor in fit.structure.anchors:
        x, y, z = (_value(fit, anchor_name(anchor, component)) for component in range(3))
        found.append(Anchor(*anchor, (x, y, z)))
    return tuple(found)


def _of_targets(fit: RobustFit) -> tuple[float, ...]:
    return tuple(float(fit.values[k]) for k in fit.structure.indices_of(TARGET_OWNER))


def _origin(fits: Fits) -> dict[str, str | int | float]:
    stops, held_out = fits.identified.blocks[0].targets.stops, fits.campaign.held_out
    # Readings that judge the model were taken in the same campaign: what drifted was followed until then.
    judging = () if held_out is None else (held_out.stops,)
    aside = fits.campaign.set_aside
    return {
        "robot": fits.campaign.robot.name,
        "configurations": len(distinct_values(sites(stops))),
        "readings": len(stops),
        "readings_without_weight": fits.identified.without_weight,
        **({} if aside is None else {"readings_set_aside": len(aside.rows)}),
        "chi2_per_dof": fits.identified.chi2_per_dof,
        **span_of_readings((stops, *judging), fits.identified.structure.origin_s),
    }
