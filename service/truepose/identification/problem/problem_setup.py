"""What a campaign knows before any fit, and the structure and start values that follow from it.

Parameters of base and tool are found by the placement and begin there; those of all other effects begin at
their prior mean. Base and tool are turned by RotX RotY RotZ about a start rotation,

    R = RotX(rx) RotY(ry) RotZ(rz) R_start        |ry| < 80 deg, else R_start = R and all three are 0

A measured triangle of the tool is held against the certificates of its nests: with sides l of uncertainty u_l
between nests certified c_a, c_b to u_a, u_b,

    chi2 = sum (l - |c_a - c_b|)^2 / (u_l^2 + u_a^2 + u_b^2)

and where k sides give more than chance at 0.1 % allows, the certificates are widened by sqrt(chi2 / k).
"""

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray, distinct_values
from truepose.domain.campaign import Campaign, FixtureLengths, PointReadings, Stops
from truepose.domain.contacts import SEEN_ALONG_AXES
from truepose.domain.errors import ConfigurationError
from truepose.effects.frames.tool_certificate import NAME as TOOL_CERTIFICATE
from truepose.effects.frames.tool_certificate import certificate_specs
from truepose.effects.frames.tool_nests import NAME as TOOL
from truepose.effects.ports import ParameterSpec, Setting, Trait
from truepose.effects.registry import effect_named, effects_with
from truepose.identification.distributions import chi2_limit
from truepose.identification.model.structure import NOMINAL_EFFECTS, Structure
from truepose.identification.problem.initial_frames import Placement, PriorPlacement
from truepose.kinematics.chain import nominal_chain
from truepose.kinematics.frames import angles_xyz, placement_rotation, placement_translation
from truepose.kinematics.gravity import gravity_torques


def torque_source(campaign: Campaign) -> str:
    """Where joint torques come from: `measured`, `masses` or `unknown`."""
    readings = campaign.readings
    torque = None if readings is None else readings.stops.torque_n_mm
    # Measured torques contain what masses do not: payloads, hoses, friction.
    if torque is not None and np.isfinite(torque).any():
        return "measured"
    return "masses" if campaign.robot.masses else "unknown"


def unknown_nests(campaign: Campaign) -> tuple[int, ...]:
    """Return the numbers of the nests that must be found from the data."""
    return tuple(k + 1 for k, nest in enumerate(campaign.nests) if nest.centre_mm is None)


def has_orientations(campaign: Campaign) -> bool:
    """Whether the orientation of the tool shows in what was measured."""
    readings = campaign.readings
    if isinstance(readings, PointReadings):
        return readings.quaternion is not None
    return any(target.kind in SEEN_ALONG_AXES for target in campaign.targets)


def known_placement(campaign: Campaign) -> PriorPlacement:
    """Return what the campaign says of base and nests; the centres of unknown nests are zeros."""
    unknown = np.array([nest.centre_mm is None for nest in campaign.nests])
    # Zeros stand for what is not known; `nest_unknown` says of which.
    centres = np.array([nest.centre_mm or (0.0, 0.0, 0.0) for nest in campaign.nests])
    base = campaign.base_nominal
    if base is None:
        return PriorPlacement(None, centres, unknown)
    return PriorPlacement((placement_rotation(base), placement_translation(base)), centres, unknown)


def outline(campaign: Campaign) -> Setting:
    """Return what a campaign knows before a look at its columns."""
    return Setting(
        robot=campaign.robot,
        unknown_nests=unknown_nests(campaign),
        has_orientations=has_orientations(campaign),
        torque_source=torque_source(campaign),
        largest_torque_n_mm=np.zeros(campaign.robot.n_joints),
        lengths=campaign.identified_from != "calibration",
        tool_rotation_u_rad=campaign.tool_rotation_uncertainty_rad,
    )


def setting_of(campaign: Campaign, stops: Stops, base_rotation: FloatArray | None = None) -> Setting:
    """Return what effects choose their parameters from.

    Parameters
    ----------
    campaign : Campaign
    stops : Stops
        At which the robot was measured.
    base_rotation : ndarray, shape (3, 3), optional
        Of the base as found from the data, which says where gravity points; without it the campaign's,
        and the world's where the campaign has none.

    Returns
    -------
    Setting
        With the largest torque about each joint (J,) [N mm] over the stops; zeros where it is unknown.
    """
    known = outline(campaign)
    source, largest = known.torque_source, known.largest_torque_n_mm
    gravity = _gravity_in_base(campaign, base_rotation)
    if source == "measured" and stops.torque_n_mm is not None:
        # Effects ask whether a spring is ever loaded enough to be seen.
        largest = np.nanmax(np.abs(stops.torque_n_mm), axis=0)
    elif source == "masses":
        chain = nominal_chain(campaign.robot, stops.joints_rad)
        largest = np.abs(gravity_torques(chain, campaign.robot.masses, gravity)).max(axis=0)
    legs = campaign.legs if campaign.identified_from == "legs" else None
    return known._replace(
        largest_torque_n_mm=largest,
        certified_nests=_certified_nests(campaign),
        attachments=_numbers(stops.attachment),
        initialisations=_numbers(None if legs is None else legs.initialisation),
        gravity_m_s2=(float(gravity[0]), float(gravity[1]), float(gravity[2])),
    )


def _gravity_in_base(campaign: Campaign, base_rotation: FloatArray | None) -> FloatArray:
    """Return gravity in the frame of the robot's base, (3,) [m/s2]; parameters as of `setting_of`."""
    base = known_placement(campaign).base
    rotation = base_rotation
    if rotation is None:
        rotation = np.eye(3) if base is None else base[0]
    return np.asarray(rotation.T @ np.array(campaign.gravity_m_s2))


def _certified_nests(campaign: Campaign) -> tuple[int, ...]:
    readings = campaign.readings
    unknown = unknown_nests(campaign)
    # A nest that nothing was read of moves no prediction.
    measured = () if readings is None else _numbers(readings.nest)
    return tuple(nest for nest in measured if nest not in unknown)


def _numbers(column: IntArray | None) -> tuple[int, ...]:
    """Return the distinct known numbers of a column; those below 0 stand for unknown ones."""
    return () if column is None else tuple(distinct_values(column[column >= 0]).tolist())


_CONTRADICTION_LEVEL = 1e-3  # at which a measured triangle is found to contradict the nests' certificates


def with_certified_nests(
    structure: Structure, start: FloatArray, campaign: Campaign, nest: IntArray
) -> tuple[Structure, FloatArray]:
    """Let the certified ones among the nests of lengths move within their certificates.

    Parameters
    ----------
    structure : Structure
    start : ndarray, shape (P,)
        Internal units.
    campaign : Campaign
    nest : ndarray of int, shape (n,)
        1-based, of each reading.

    Returns
    -------
    structure : Structure
    start : ndarray, shape (P + p,)
        Nests begin where they are certified.
    """
    known = sorted(set(distinct_values(nest).tolist()) - set(unknown_nests(campaign)))
    stated = {k: campaign.nests[k - 1].standard_uncertainty_mm for k in known}
    # Beside lengths a certificate is the poorer statement: the tool's triangle is measured ten times finer
    # (docs/decisions/0017).
    wider = _certificates_contradicted(campaign)
    specs = certificate_specs({k: wider * u for k, u in stated.items() if u})
    if not specs:
        return structure, start
    return structure.extended(TOOL_CERTIFICATE, specs), np.concatenate([start, np.zeros(len(specs))])


def _certificates_contradicted(campaign: Campaign) -> float:
    """Return how much wider than certified nests scatter, by the measured triangle of the tool; 1 or more."""
    fixture = campaign.fixture
    if fixture is None:
        return 1.0
    from truepose.identification.observations.fixture import TOOL_PLACEMENT  # few have one

    tool = np.flatnonzero(fixture.placement == TOOL_PLACEMENT).tolist()
    squares = [square for row in tool if (square := _against_certificate(campaign, fixture, row)) is not None]
    total = float(np.sum(squares))
    if not squares or total <= chi2_limit(_CONTRADICTION_LEVEL, len(squares)):
        return 1.0
    return float(np.sqrt(total / len(squares)))


def _against_certificate(campaign: Campaign, fixture: FixtureLengths, row: int) -> float | None:
    """Return the square of a side's deviation from its certificate over its variance, None without one."""
    ends = (int(fixture.point_a[row]), int(fixture.point_b[row]))
    if max(ends) > len(campaign.nests):
        return None
    first, second = (campaign.nests[end - 1] for end in ends)
    # An unknown nest has no certificate to contradict.
    if first.centre_mm is None or second.centre_mm is None:
        return None
    off_mm = float(fixture.length_mm[row] - np.linalg.norm(np.subtract(first.centre_mm, second.centre_mm)))
    stated = (first.standard_uncertainty_mm or 0.0, second.standard_uncertainty_mm or 0.0)
    return off_mm**2 / (float(fixture.standard_uncertainty_mm[row]) ** 2 + stated[0] ** 2 + stated[1] ** 2)


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
        Orientation of the tool in the flange frame; the identity where none was measured.
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
        # Unknown nests are parameters that count from the origin of the flange frame.
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
    # About 0 the prior of a found base would pull it towards the world's origin, metres away.
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
                f"Effect {name!r} has no parameters until it is found in the data. Leave it out of the "
                "effects; `diagnose` searches for it."
            )
        for spec in effect_named(name).specs(setting):
            # Two effects that move the same would share it at will, and names must tell parameters apart.
            if spec.name in {earlier.name for earlier in specs}:
                raise ConfigurationError(
                    f"Effect {name!r} has the parameter {spec.name!r}, which another effect already has. "
                    "Leave out one of the two effects."
                )
            specs.append(spec)
            owners.append(name)
    return tuple(specs), tuple(owners)
