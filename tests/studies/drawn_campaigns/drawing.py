"""Draws campaigns that can be read: of every kind, each with some of the oddities that occur in shops."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tests.helpers.ballbar.campaigns import ballbar_campaign
from tests.helpers.diagnosis.point_scenes import telling_campaign
from tests.helpers.domain.robots import IRB_120, SEVEN_AXES
from tests.helpers.identification.closed_loops import contact_campaign, with_distance
from tests.helpers.identification.synthetic import leg_campaign, nominal_campaign
from truepose.domain.campaign import Campaign
from truepose.domain.contacts import CENTRES, TargetKind
from truepose.domain.robot import Nest, Robot
from truepose.effects.ports import Trait
from truepose.effects.registry import EFFECTS, effects_with
from truepose.kinematics.chain import forward, nominal_values
from truepose.kinematics.frames import quaternion_from_rotation

_BY_DEFAULT = ("base", "tool", "geometry")
_SHORT = replace(
    IRB_120,
    name="three joints",
    joints=IRB_120.joints[:3],
    masses=IRB_120.masses[:1],
    typical_compliances_rad_per_n_mm=IRB_120.typical_compliances_rad_per_n_mm[:3],
    calibration_ranges=IRB_120.calibration_ranges[:3],
)
_SEVEN = replace(SEVEN_AXES, calibration_ranges=(IRB_120.calibration_ranges[0],) * 7)
_COLUMNS = ("direction", "time_s", "temperature_c", "attachment", "move_rad")
_UNCERTAINTIES_MM = (1e-9, 1e-6, 1.0, 1e3)


@dataclass(frozen=True, slots=True)
class Drawn:
    """A campaign, the effects that are asked for, and how it came about."""

    campaign: Campaign
    effects: tuple[str, ...] | None
    kind: str
    oddities: tuple[str, ...]


class _Readings:
    """The readings of a campaign whatever their kind is: what oddities change."""

    def __init__(self, campaign: Campaign) -> None:
        self.campaign = campaign
        self.field = next(
            name for name in ("calibration", "legs", "contacts") if getattr(campaign, name) is not None
        )
        self.table: Any = getattr(campaign, self.field)
        self.observed = {"calibration": "position_mm", "legs": "length_mm", "contacts": "reading_mm"}[
            self.field
        ]

    @property
    def values(self) -> Any:
        return getattr(self.table, self.observed)

    def with_values(self, values: Any) -> Campaign:
        return self.with_table(replace(self.table, **{self.observed: values}))

    def with_table(self, table: Any) -> Campaign:
        return replace(self.campaign, **{self.field: table})

    def with_stops(self, **columns: Any) -> Campaign:
        return self.with_table(replace(self.table, stops=replace(self.table.stops, **columns)))


Oddity = Callable[[_Readings, np.random.Generator], Campaign]


def _rows(readings: _Readings, rng: np.random.Generator, most: int) -> np.ndarray:
    return rng.choice(len(readings.table), min(most, len(readings.table)), replace=False)


def _few(readings: _Readings, rng: np.random.Generator) -> Campaign:
    kept = np.sort(_rows(readings, rng, int(rng.integers(1, 40))))
    return readings.with_table(readings.table.taken(kept))


def _frozen_joints(readings: _Readings, rng: np.random.Generator) -> Campaign:
    joints = readings.table.stops.joints_rad.copy()
    still = rng.choice(joints.shape[1], rng.integers(1, joints.shape[1]), replace=False)
    joints[:, still] = joints[0, still]
    return readings.with_stops(joints_rad=joints)


def _barely_moving(readings: _Readings, rng: np.random.Generator) -> Campaign:
    joints = readings.table.stops.joints_rad
    shrunk = 10.0 ** rng.uniform(-6.0, 0.0)
    return readings.with_stops(joints_rad=joints[0] + shrunk * (joints - joints[0]))


def _coupled_joints(readings: _Readings, rng: np.random.Generator) -> Campaign:
    joints = readings.table.stops.joints_rad.copy()
    one, other = rng.choice(joints.shape[1], 2, replace=False)
    joints[:, one] = joints[:, other]
    return readings.with_stops(joints_rad=joints)


def _doubled_rows(readings: _Readings, rng: np.random.Generator) -> Campaign:
    rows = np.sort(rng.integers(0, len(readings.table), len(readings.table)))
    return readings.with_table(readings.table.taken(rows))


def _one_row(readings: _Readings, rng: np.random.Generator) -> Campaign:
    row = int(rng.integers(len(readings.table)))
    return readings.with_table(readings.table.taken(np.full(len(readings.table), row)))


def _one_place(readings: _Readings, rng: np.random.Generator) -> Campaign:
    """One row under many numbers."""
    same = _one_row(readings, rng)
    return _Readings(same).with_stops(config=readings.table.stops.config)


def _odd_uncertainty(readings: _Readings, rng: np.random.Generator) -> Campaign:
    stated = readings.table.standard_uncertainty_mm.copy()
    rows = _rows(readings, rng, len(stated) if rng.random() < 0.5 else 3)
    stated[rows] = rng.choice(_UNCERTAINTIES_MM)
    return readings.with_table(replace(readings.table, standard_uncertainty_mm=stated))


def _outliers(readings: _Readings, rng: np.random.Generator) -> Campaign:
    values = readings.values.copy()
    rows = _rows(readings, rng, int(rng.integers(1, len(values) + 1)))
    size_mm = 10.0 ** rng.uniform(-1.0, 4.0)
    values[rows] += size_mm * rng.standard_normal(values[rows].shape)
    return readings.with_values(np.abs(values) if readings.field == "legs" else values)


def _nonsense(readings: _Readings, rng: np.random.Generator) -> Campaign:
    values = readings.values
    return readings.with_values(
        np.abs(rng.permutation(values)) if values.ndim == 1 else rng.permutation(values)
    )


def _constant(readings: _Readings, rng: np.random.Generator) -> Campaign:
    return readings.with_values(np.broadcast_to(readings.values[0], readings.values.shape).copy())


def _constant_columns(readings: _Readings, rng: np.random.Generator) -> Campaign:
    stops = readings.table.stops
    told = {name: getattr(stops, name) for name in ("time_s", "temperature_c", "direction", "attachment")}
    return readings.with_stops(**{
        name: np.broadcast_to(column[:1], column.shape).copy()
        for name, column in told.items()
        if column is not None
    })


def _missing_columns(readings: _Readings, rng: np.random.Generator) -> Campaign:
    left_out = [name for name in _COLUMNS if rng.random() < 0.5]
    return readings.with_stops(**dict.fromkeys(left_out))


def _gaps_in_columns(readings: _Readings, rng: np.random.Generator) -> Campaign:
    stops = readings.table.stops
    changed = {}
    for name in ("time_s", "temperature_c"):
        column = getattr(stops, name)
        if column is not None:
            changed[name] = np.where(rng.random(len(column)) < 0.5, np.nan, column)
    return readings.with_stops(**changed)


def _huge_times(readings: _Readings, rng: np.random.Generator) -> Campaign:
    time_s = readings.table.stops.time_s
    return readings.with_stops(time_s=None if time_s is None else 1e3 * (time_s - time_s[0]) ** 2)


def _unknown_nests(readings: _Readings, rng: np.random.Generator) -> Campaign:
    nests = readings.campaign.nests
    return replace(
        readings.campaign,
        nests=tuple(Nest(None) if rng.random() < 0.7 else Nest(nest.centre_mm, None) for nest in nests),
    )


def _unknown_base(readings: _Readings, rng: np.random.Generator) -> Campaign:
    return replace(readings.campaign, base_nominal=None)


def _without_masses(readings: _Readings, rng: np.random.Generator) -> Campaign:
    campaign = readings.campaign
    return replace(campaign, robot=replace(campaign.robot, masses=()))


def _poses(readings: _Readings, rng: np.random.Generator) -> Campaign:
    if readings.field != "calibration":
        return readings.campaign
    turns = rng.standard_normal((len(readings.table), 4))
    turns /= np.linalg.norm(turns, axis=1)[:, None]
    stated = np.full(len(turns), np.nan if rng.random() < 0.5 else 10.0 ** rng.uniform(-9, 0))
    return readings.with_table(replace(readings.table, quaternion=turns, rotation_uncertainty_rad=stated))


def _measured_torques(readings: _Readings, rng: np.random.Generator) -> Campaign:
    shape = readings.table.stops.joints_rad.shape
    size = 0.0 if rng.random() < 0.3 else 1e4
    return readings.with_stops(torque_n_mm=size * rng.standard_normal(shape))


def _only_held_out(readings: _Readings, rng: np.random.Generator) -> Campaign:
    field = f"validation_{readings.field}" if readings.field != "calibration" else "validation"
    return replace(readings.campaign, **{readings.field: None, field: readings.table})


ODDITIES: dict[str, Oddity] = {
    function.__name__.strip("_"): function
    for function in (
        _few, _frozen_joints, _barely_moving, _coupled_joints, _doubled_rows, _one_row, _one_place,
        _odd_uncertainty, _outliers, _nonsense, _constant, _constant_columns, _missing_columns,
        _gaps_in_columns, _huge_times, _unknown_nests, _unknown_base, _without_masses, _poses,
        _measured_torques,
    )
}  # fmt: skip
_FATAL = ("one_row", "one_place", "constant", "nonsense")  # mostly refused at once: seldom drawn


def drawn_campaign(seed: int) -> Drawn:
    """Return the campaign of a seed."""
    rng = np.random.default_rng(seed)
    kind = str(rng.choice(list(_KINDS)))
    campaign = _KINDS[kind](rng)
    oddities = _oddities(rng)
    for name in oddities:
        campaign = ODDITIES[name](_Readings(campaign), rng)
    campaign = _with_validation(campaign, rng)
    if rng.random() < 0.02:
        campaign, oddities = _only_held_out(_Readings(campaign), rng), (*oddities, "only_held_out")
    return Drawn(campaign, _effects(rng, based=kind in ("points", "poses")), kind, oddities)


def _oddities(rng: np.random.Generator) -> tuple[str, ...]:
    chance = np.array([0.1 if name in _FATAL else 1.0 for name in ODDITIES])
    count = int(rng.integers(0, 4))
    return tuple(rng.choice(list(ODDITIES), count, replace=False, p=chance / chance.sum()).tolist())


def _with_validation(campaign: Campaign, rng: np.random.Generator) -> Campaign:
    """Return the campaign with a validation table: none, one row, or more rows, of its own kind."""
    readings = _Readings(campaign)
    if rng.random() < 0.5:
        return replace(campaign, validation=None, cups=None)
    rows = np.sort(_rows(readings, rng, int(rng.choice([1, 2, 30]))))
    field = "validation" if readings.field == "calibration" else f"validation_{readings.field}"
    return replace(campaign, **{"validation": None, "cups": None, field: readings.table.taken(rows)})


def _effects(rng: np.random.Generator, *, based: bool) -> tuple[str, ...] | None:
    nobody_asks = {
        *effects_with(Trait.NUISANCE),
        *effects_with(Trait.SEARCHED),
        *effects_with(Trait.OF_READINGS),
    }
    if not based and rng.random() < 0.9:
        nobody_asks |= {"base"}
    if rng.random() < 0.9:  # each brings parameters that another of them has too
        nobody_asks |= {"geometry_dhm", "joint_offset", "axis_parallelism"}
    names = [name for name in EFFECTS if name not in nobody_asks]
    draw = rng.random()
    if draw < 0.5:
        return None
    if draw < 0.6:
        return tuple(names)
    if draw < 0.65:
        return tuple(EFFECTS)
    further = rng.choice(names, rng.integers(1, 6), replace=False).tolist()
    if draw < 0.9:
        further = [*(name for name in _BY_DEFAULT if name in names), *further]
    return tuple(dict.fromkeys(further))


def _robot(rng: np.random.Generator) -> Robot:
    return [_SHORT, IRB_120, _SEVEN][rng.choice(3, p=(0.7, 0.2, 0.1))]


def _points(rng: np.random.Generator) -> Campaign:
    n, seed = int(rng.integers(8, 40)), int(rng.integers(1000))
    if rng.random() < 0.5:
        campaign = telling_campaign(n, robot=_robot(rng), seed=seed)
    else:
        campaign = nominal_campaign(n, seed=seed, robot=_robot(rng))
    return _noisy(campaign, rng, 0.015)


def _poses_of_a_camera(rng: np.random.Generator) -> Campaign:
    campaign = _points(rng)
    readings = campaign.calibration
    chain = forward(nominal_values(campaign.robot, readings.stops.joints_rad), np.eye(3), np.zeros(3))
    turns = quaternion_from_rotation(chain.end_rotation)
    stated = np.full(len(readings), np.nan if rng.random() < 0.5 else 1e-4)
    told = replace(readings, quaternion=turns, rotation_uncertainty_rad=stated)
    return replace(campaign, calibration=told)


def _legs(rng: np.random.Generator) -> Campaign:
    campaign, _ = ballbar_campaign(
        stops=int(rng.integers(2, 16)), placements=int(rng.integers(1, 4)), cups=int(rng.integers(3, 5)),
        seed=int(rng.integers(1000)),
    )  # fmt: skip
    legs = campaign.legs
    n = len(legs)
    time_s = 10.0 * np.unique(legs.stops.config, return_inverse=True)[1]
    stops = replace(legs.stops, time_s=time_s, temperature_c=23.0 + 0.01 * np.arange(n))
    told = replace(legs, stops=stops, initialisation=1 + np.arange(n) // 30)
    return _noisy(replace(campaign, legs=told), rng, 0.001)


def _wire(rng: np.random.Generator) -> Campaign:
    return leg_campaign(int(rng.integers(5, 80)), int(rng.integers(1000)))


def _contacts(rng: np.random.Generator) -> Campaign:
    kind = TargetKind(rng.choice(list(TargetKind)))
    options = {}
    if kind not in (TargetKind.PLANE, TargetKind.GAUGE, TargetKind.BALL, TargetKind.FACE):
        options = {"zero_mm": float(rng.choice([0.0, 5.0]))} if rng.random() < 0.5 else {}
    campaign = contact_campaign(
        kind,
        int(rng.integers(4, 30)),
        int(rng.integers(1000)),
        known_nests=bool(rng.random() < 0.7),
        **options,
    )
    return with_distance(campaign) if kind in CENTRES and rng.random() < 0.4 else campaign


def _noisy(campaign: Campaign, rng: np.random.Generator, size_mm: float) -> Campaign:
    """Return the campaign as an instrument reads it, perhaps after the base, or a fixture, was bumped."""
    readings = _Readings(campaign)
    values = readings.values + size_mm * rng.standard_normal(readings.values.shape)
    if rng.random() < 0.3:
        late = np.arange(len(values)) >= rng.integers(len(values))
        values[late] += 10.0 ** rng.uniform(-2.0, 1.0) * rng.standard_normal(values.shape[1:])
    return readings.with_values(values)


_KINDS: dict[str, Callable[[np.random.Generator], Campaign]] = {
    "points": _points,
    "poses": _poses_of_a_camera,
    "legs": _legs,
    "wire": _wire,
    "contacts": _contacts,
}
