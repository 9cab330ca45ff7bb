"""From a campaign to a least-squares problem: structure, blocks of observations, start values."""

from dataclasses import dataclass, replace

import numpy as np

from service.domain.arrays import FloatArray, IntArray
from service.domain.campaign import Campaign, LegReadings, PointReadings, Stops
from service.domain.errors import ConfigurationError
from service.domain.robot import FramePlacement, Robot
from service.effects.ports import ParameterSpec, Setting
from service.effects.registry import effect_named
from service.identification.evaluation import Targets
from service.identification.legs_start import place_legs
from service.identification.observations import (
    LEG_OFFSET,
    Block,
    LegBlock,
    OrientationBlock,
    PositionBlock,
    anchor_name,
)
from service.identification.placement import Known, Placement, place
from service.identification.structure import Structure
from service.kinematics.chain import Chain, forward, nominal_values
from service.kinematics.frames import (
    angles_xyz,
    placement_rotation,
    placement_translation,
    rotation_from_quaternion,
    rotation_from_vector,
    vector_from_rotation,
)
from service.kinematics.gravity import gravity_torques

_ANCHOR_WIDTH_MM = 10.0  # about the start found from the data, as for an unknown base
_LEG_OWNER = "legs"
_GIMBAL_RAD = np.deg2rad(80.0)  # beyond it the angles RotX RotY RotZ about the identity lose their meaning
NOMINAL_EFFECTS = ("base", "tool")  # what is fitted around the nominal model


@dataclass(frozen=True, slots=True)
class Problem:
    """What the solver needs."""

    structure: Structure
    blocks: tuple[Block, ...]
    start: FloatArray  # (P,)
    nominal_residual_mm: FloatArray  # (n, d) of the placed nominal robot

    @property
    def quantity(self) -> str:
        """`position` or `length`: what the first block observes."""
        return "length" if isinstance(self.blocks[0], LegBlock) else "position"


def automatic_effects(campaign: Campaign) -> tuple[str, ...]:
    """Effects of `auto`: base, tool as far as unknown, geometry, and compliance where its torques are known."""
    names: list[str] = ["base"] if campaign.calibration is not None else []
    if _unknown_nests(campaign) or _has_orientations(campaign):
        names.append("tool")
    names.append("geometry")
    if torque_source(campaign) != "unknown":
        names.append("compliance")
    return tuple(names)


def torque_source(campaign: Campaign) -> str:
    """Where joint torques come from: `measured`, `masses` or `unknown`."""
    readings = campaign.calibration or campaign.legs
    if readings is not None and readings.stops.torque_n_mm is not None:
        return "measured"
    return "masses" if campaign.robot.masses else "unknown"


def _unknown_nests(campaign: Campaign) -> tuple[int, ...]:
    return tuple(k + 1 for k, nest in enumerate(campaign.nests) if nest.centre_mm is None)


def _has_orientations(campaign: Campaign) -> bool:
    return campaign.calibration is not None and campaign.calibration.quaternion is not None


def build(campaign: Campaign, effects: tuple[str, ...]) -> Problem:
    """Build the problem of a campaign.

    Raises
    ------
    UnknownEffectError
        An effect is not registered.
    ConfigurationError
        The campaign has nothing to identify from.
    """
    if campaign.calibration is not None:
        return _point_problem(campaign, campaign.calibration, effects)
    if campaign.legs is not None:
        return _leg_problem(campaign, campaign.legs, effects)
    raise ConfigurationError(
        "The campaign has neither calibration points nor legs: give one of them under `files`."
    )


def nominal_chain(robot: Robot, joints_rad: FloatArray) -> Chain:
    """Return the nominal chain with its base at the identity."""
    return forward(nominal_values(robot, joints_rad), np.eye(3), np.zeros(3))


def known_placement(campaign: Campaign) -> Known:
    """Return what the campaign says of base and nests."""
    unknown = np.array([nest.centre_mm is None for nest in campaign.nests])
    centres = np.array([nest.centre_mm or (0.0, 0.0, 0.0) for nest in campaign.nests])
    base = campaign.base_nominal
    if base is None:
        return Known(None, centres, unknown)
    return Known((placement_rotation(base), placement_translation(base)), centres, unknown)


def _point_problem(campaign: Campaign, points: PointReadings, effects: tuple[str, ...]) -> Problem:
    chain = nominal_chain(campaign.robot, points.stops.joints_rad)
    known = known_placement(campaign)
    fitted_base = "base" in effects
    search = replace(known, base=None) if fitted_base else known
    placement = place(chain, points.nest, points.position_mm, search)
    tool = _tool_rotation(chain, placement, points)
    structure, start = _structure(campaign, effects, placement, tool, setting_of(campaign, points.stops))
    blocks: list[Block] = [position_block(points, campaign)]
    if points.quaternion is not None:
        blocks.append(_orientation_block(points, points.quaternion))
    return Problem(structure, tuple(blocks), start, placement.residual_mm)


def setting_of(campaign: Campaign, stops: Stops) -> Setting:
    """Return what effects choose their parameters from."""
    source = torque_source(campaign)
    largest = np.zeros(campaign.robot.n_joints)
    if source == "measured" and stops.torque_n_mm is not None:
        largest = np.abs(stops.torque_n_mm).max(axis=0)
    elif source == "masses":
        rotation = np.eye(3) if campaign.base_nominal is None else placement_rotation(campaign.base_nominal)
        chain = nominal_chain(campaign.robot, stops.joints_rad)
        gravity = rotation.T @ np.array(campaign.gravity_m_s2)
        largest = np.abs(gravity_torques(chain, campaign.robot.masses, gravity)).max(axis=0)
    return Setting(campaign.robot, _unknown_nests(campaign), _has_orientations(campaign), source, largest)


def _tool_rotation(chain: Chain, placement: Placement, points: PointReadings) -> FloatArray:
    if points.quaternion is None:
        return np.eye(3)
    seen = rotation_from_quaternion(points.quaternion)
    in_last = np.swapaxes(placement.rotation @ chain.rotation[-1], 1, 2) @ seen
    middle = in_last[0]
    for _ in range(3):  # the mean rotation, by means of rotation vectors about the last one
        middle = middle @ _mean_turn(np.swapaxes(middle[None], 1, 2) @ in_last)
    return np.asarray(middle)


def _mean_turn(turns: FloatArray) -> FloatArray:
    return rotation_from_vector(np.median(vector_from_rotation(turns), axis=0))


def _structure(
    campaign: Campaign,
    effects: tuple[str, ...],
    placement: Placement,
    tool_rotation: FloatArray,
    setting: Setting,
) -> tuple[Structure, FloatArray]:
    base_start, base_values = _placed_start(campaign, placement)
    tool_start, tool_values = _angles_about(np.eye(3), tool_rotation)
    unknown = known_placement(campaign).nest_unknown
    specs, owners = _specs(effects, setting)
    begin = _begin_values(base_values, tool_values, placement.nests_mm)
    start = np.array([begin.get(spec.name, spec.prior_mean) for spec in specs])
    found_free = campaign.base_nominal is None
    specs = tuple(
        spec._replace(prior_mean=float(value)) if _from_data(spec.name, owner, found_free) else spec
        for spec, owner, value in zip(specs, owners, start, strict=True)
    )
    structure = Structure(
        robot=campaign.robot,
        base_rotation=base_start[0],
        base_origin_mm=base_start[1],
        nests_mm=np.where(unknown[:, None], 0.0, placement.nests_mm),
        tool_rotation=tool_start,
        gravity_m_s2=np.array(campaign.gravity_m_s2),
        effects=effects,
        specs=specs,
        owners=owners,
        instrument_mm=None
        if campaign.tracker_position_mm is None
        else np.array(campaign.tracker_position_mm),
    )
    return structure, start


def _from_data(name: str, owner: str, base_found: bool) -> bool:
    return owner in ("tool", _LEG_OWNER) or (owner == "base" and base_found)


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
        for spec in effect_named(name).specs(setting):
            if spec.name in {earlier.name for earlier in specs}:
                raise ConfigurationError(
                    f"Effect {name!r} brings the parameter {spec.name!r}, which another effect has already: "
                    "leave one of the two out."
                )
            specs.append(spec)
            owners.append(name)
    return tuple(specs), tuple(owners)


def position_block(points: PointReadings, campaign: Campaign) -> PositionBlock:
    """Return the block of position readings, weighted as the campaign states."""
    covariance = points.covariance_mm2
    if covariance is None:
        covariance = points.standard_uncertainty_mm[:, None, None] ** 2 * np.eye(3)
    scatter = 0.0 if campaign.repeatability_in_uncertainty else campaign.robot.repeatability_mm
    targets = Targets(points.stops, points.nest)
    block = PositionBlock(targets, points.position_mm, covariance, scatter, np.ones(len(points)))
    return block.prepared()


def _orientation_block(points: PointReadings, quaternion: FloatArray) -> OrientationBlock:
    stated = points.rotation_uncertainty_rad
    uncertainty = np.zeros(len(points)) if stated is None else np.nan_to_num(stated)
    measured = rotation_from_quaternion(quaternion)
    start = 1e-3 if not uncertainty.any() else 0.0  # replaced by the residuals' own scatter
    return OrientationBlock(
        Targets(points.stops, points.nest), measured, uncertainty, np.ones(len(points)), start
    )


def leg_anchors(legs: LegReadings) -> tuple[tuple[tuple[int, int], ...], IntArray]:
    """Return the distinct (placement, base point) pairs and the index of each reading among them."""
    pairs = list(zip(legs.placement.tolist(), legs.base_point.tolist(), strict=True))
    distinct = sorted(set(pairs))
    return tuple(distinct), np.array([distinct.index(pair) for pair in pairs])


def leg_block(legs: LegReadings, campaign: Campaign, anchors: tuple[tuple[int, int], ...]) -> LegBlock:
    """Return the block of leg readings for a structure with these anchors."""
    scatter = 0.0 if campaign.repeatability_in_uncertainty else campaign.robot.repeatability_mm
    pairs = zip(legs.placement.tolist(), legs.base_point.tolist(), strict=True)
    index = np.array([anchors.index(pair) for pair in pairs])
    targets = Targets(legs.stops, legs.nest)
    return LegBlock(targets, index, legs.length_mm, legs.standard_uncertainty_mm, scatter, np.ones(len(legs)))


def _leg_problem(campaign: Campaign, legs: LegReadings, effects: tuple[str, ...]) -> Problem:
    if "base" in effects:
        raise ConfigurationError(
            "Legs between unknown base points do not see where the base stands: leave `base` out of the effects."
        )
    anchors, index = leg_anchors(legs)
    chain = nominal_chain(campaign.robot, legs.stops.joints_rad)
    known = known_placement(campaign)
    with_offset = campaign.ballbar_nominal_mm is None
    found = place_legs(
        chain, legs.nest, index, legs.length_mm, known.nests_mm, known.nest_unknown, with_offset=with_offset
    )
    placement = Placement(np.eye(3), np.zeros(3), found.nests_mm, np.zeros((0, 3)), np.zeros(0))
    setting = setting_of(campaign, legs.stops)
    structure, start = _structure(_with_base(campaign), effects, placement, np.eye(3), setting)
    structure, start = _with_anchors(
        structure, start, anchors, found.anchors_mm, found.offset_mm, with_offset
    )
    block = leg_block(legs, campaign, anchors)
    nominal = structure.without(tuple(name for name in effects if name not in NOMINAL_EFFECTS))
    keep = [structure.index_of(name) for name in nominal.names]
    residual = block.result(nominal, start[keep], None).residual
    return Problem(structure, (block,), start, residual)


def _with_base(campaign: Campaign) -> Campaign:
    """Return the campaign with the world at the nominal base: legs alone cannot tell them apart."""
    if campaign.base_nominal is not None:
        return campaign
    return replace(campaign, base_nominal=FramePlacement())


def _with_anchors(
    structure: Structure,
    start: FloatArray,
    anchors: tuple[tuple[int, int], ...],
    places_mm: FloatArray,
    offset_mm: float,
    with_offset: bool,
) -> tuple[Structure, FloatArray]:
    names = [anchor_name(anchor, component) for anchor in anchors for component in range(3)]
    values = places_mm.ravel().tolist()
    if with_offset:
        names.append(LEG_OFFSET)
        values.append(offset_mm)
    extra = tuple(
        ParameterSpec(name, "mm", value, _ANCHOR_WIDTH_MM) for name, value in zip(names, values, strict=True)
    )
    widened = replace(
        structure,
        specs=structure.specs + extra,
        owners=structure.owners + (_LEG_OWNER,) * len(extra),
        anchors=anchors,
    )
    return widened, np.concatenate([start, values])
