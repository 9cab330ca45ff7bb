"""The structure of the chosen effects about a start, and the start values of its parameters."""

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.errors import ConfigurationError
from truepose.domain.measurement.campaign import Campaign
from truepose.effects.ports import ParameterSpec, Setting, Trait
from truepose.effects.registry import effect_named, effects_with
from truepose.effects.tool.tool_nests import NAME as TOOL
from truepose.identification.model.parameters.structure import NOMINAL_EFFECTS, Structure
from truepose.identification.problem.placement import Placement
from truepose.identification.problem.setting import known_placement
from truepose.kinematics.frames import angles_xyz

_GIMBAL_RAD = np.deg2rad(80.0)  # beyond it the angles RotX RotY RotZ about the start lose their meaning


def started_structure(
    campaign: Campaign,
    effects: tuple[str, ...],
    placement: Placement,
    tool_rotation: FloatArray,
    setting: Setting,
) -> tuple[Structure, FloatArray]:
    """Return the structure of the chosen effects about a placement, and its start values.

    Parameters
    ----------
    campaign : Campaign
    effects : tuple of str
    placement : Placement
        Base and nests of the nominal robot.
    tool_rotation : ndarray, shape (3, 3)
        Orientation of the tool in the last frame; the identity where none was measured.
    setting : Setting

    Returns
    -------
    structure : Structure
    start : ndarray, shape (P,)

    Raises
    ------
    UnknownEffectError, ConfigurationError
        An effect is not registered, two have the same parameter, or one is only found by a search.
    """
    base_start, base_values = _placed_start(campaign, placement)
    tool_start, tool_values = _angles_about(np.eye(3), tool_rotation)
    unknown = known_placement(campaign).nest_unknown
    instrument = campaign.tracker_position_mm
    specs, owners = _specs(effects, setting)
    begin = _begin_values(base_values, tool_values, placement.nests_mm)
    start = np.array([begin.get(spec.name, spec.prior_mean) for spec in specs])
    structure = Structure(
        robot=campaign.robot,
        base_rotation=base_start[0],
        base_origin_mm=base_start[1],
        nests_mm=np.where(unknown[:, None], 0.0, placement.nests_mm),
        tool_rotation=tool_start,
        gravity_m_s2=np.array(campaign.gravity_m_s2),
        effects=effects,
        specs=_about_start(specs, owners, start, base_found=campaign.base_nominal is None),
        owners=owners,
        torques_measured=setting.torque_source == "measured",
        instrument_mm=None if instrument is None else np.array(instrument),
    )
    return structure, start


def _about_start(
    specs: tuple[ParameterSpec, ...], owners: tuple[str, ...], start: FloatArray, *, base_found: bool
) -> tuple[ParameterSpec, ...]:
    """Put the priors of what was found from the data about where it was found."""
    found = NOMINAL_EFFECTS if base_found else (TOOL,)
    return tuple(
        spec._replace(prior_mean=float(value)) if owner in found else spec
        for spec, owner, value in zip(specs, owners, start, strict=True)
    )


def _placed_start(
    campaign: Campaign, placement: Placement
) -> tuple[tuple[FloatArray, FloatArray], dict[str, float]]:
    known = known_placement(campaign)
    start_rotation, origin = (np.eye(3), np.zeros(3)) if known.base is None else known.base
    rotation, angles = _angles_about(start_rotation, placement.rotation)
    shift = placement.origin_mm - origin
    names = ("base_x", "base_y", "base_z", "base_rx", "base_ry", "base_rz")
    values = dict(zip(names, (*(float(x) for x in shift), *angles.values()), strict=True))
    return (rotation, origin), values


def _angles_about(start: FloatArray, found: FloatArray) -> tuple[FloatArray, dict[str, float]]:
    """Angles RotX RotY RotZ of `found` about `start`; about `found` itself where they would lock."""
    angles = angles_xyz(found @ start.T)
    if abs(angles[1]) > _GIMBAL_RAD:
        start, angles = found, (0.0, 0.0, 0.0)
    return start, dict(zip(("tool_rx", "tool_ry", "tool_rz"), angles, strict=True))


def _begin_values(base: dict[str, float], tool: dict[str, float], nests_mm: FloatArray) -> dict[str, float]:
    nests = {
        f"nest_{k + 1}_{axis}": float(value)
        for k, nest in enumerate(nests_mm)
        for axis, value in zip("xyz", nest, strict=True)
    }
    return base | tool | nests


def _specs(effects: tuple[str, ...], setting: Setting) -> tuple[tuple[ParameterSpec, ...], tuple[str, ...]]:
    specs: list[ParameterSpec] = []
    owners: list[str] = []
    for name in effects:
        if name in effects_with(Trait.SEARCHED):
            raise ConfigurationError(
                f"Effect {name!r} has no parameters until it is found in the data: "
                "leave it out of the effects, `diagnose` looks for it."
            )
        for spec in effect_named(name).specs(setting):
            if spec.name in {earlier.name for earlier in specs}:
                raise ConfigurationError(
                    f"Effect {name!r} brings the parameter {spec.name!r}, which another effect has already: "
                    "leave one of the two out."
                )
            specs.append(spec)
            owners.append(name)
    return tuple(specs), tuple(owners)
