"""Where an arm may stand in a closed loop: a tool nest at the place of a target, the tool from all sides."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.domain.errors import ConfigurationError
from truepose.domain.measurement.campaign import TargetDistances
from truepose.domain.measurement.targets import Target, TargetKind
from truepose.kinematics.chain import theta_gradient
from truepose.planning.errors import TooFewCandidatesError
from truepose.planning.work_volume.candidates import has_room
from truepose.planning.work_volume.keep_outs import look_at
from truepose.planning.work_volume.work_space import WorkSpace, nominal_chain

_BATCH: Final = 4096
_MOST_BATCHES: Final = 80
_HOPELESS: Final = 10  # batches of which none arrives
_NEAR_MM: Final = 250.0  # from which an arm is led to its place
_STEPS: Final = 12
_ARRIVED_MM: Final = 1e-6
_LEAN: Final = float(np.cos(np.radians(75.0)))  # of the tool against the way in
_FACING: Final = float(np.cos(np.radians(25.0)))  # of a sensor against the face that it looks at
_PATCH_MM: Final = 150.0  # of a plane, to either side of its place
_TRAVEL_MM: Final = 2.0  # of gauges and sensors, to either side
_STAND_OFF_MM: Final = 40.0  # of a sensor from a face
_USUAL_ZERO_MM: Final = 15.7  # a sphere of one inch and a probe's tip of 6 mm
_UP: Final = (0.0, 0.0, 1.0)


@dataclass(frozen=True, slots=True)
class LoopWish:
    """What a closed loop is planned with."""

    targets: tuple[Target, ...]  # each with the place where it stands, roughly
    nests: tuple[int, ...]  # of the tool that are used, by turns
    reading_mm: float  # standard uncertainty of a reading
    distances: TargetDistances | None = None  # certified, of two centres

    def __post_init__(self) -> None:
        for target in self.targets:
            if target.place_mm is None:
                raise ConfigurationError(
                    f"Target {target.number} has no place: a plan needs to know roughly where it stands "
                    "(x_mm, y_mm, z_mm)."
                )

    @property
    def groups(self) -> tuple[tuple[Target, ...], ...]:
        """Targets that are read at one stop: all wires, gauges at one place, else each by itself."""
        together: dict[object, list[Target]] = {}
        for target in self.targets:
            together.setdefault(_read_with(target), []).append(target)
        return tuple(tuple(group) for group in together.values())


def _read_with(target: Target) -> object:
    if target.kind is TargetKind.WIRE:
        return target.kind
    return target.place_mm if target.kind is TargetKind.GAUGE else target.number


@dataclass(frozen=True, slots=True)
class Stands:
    """n stops and what is read there."""

    joints_rad: FloatArray  # (n, J)
    nest: IntArray  # (n,) 1-based
    group: IntArray  # (n,) index among the groups of the wish


def draw_stands(space: WorkSpace, wish: LoopWish, n: int, rng: np.random.Generator) -> Stands:
    """Draw n stops, nests and groups of targets in equal parts.

    Raises
    ------
    TooFewCandidatesError
        The arm hardly reaches one of the targets.
    """
    pairs = [(nest, group) for group in range(len(wish.groups)) for nest in wish.nests]
    each = -(-n // len(pairs))
    joints = [_stops(space, wish.groups[group], nest, each, rng) for nest, group in pairs]
    nests, groups = (np.repeat(np.array(column), each) for column in zip(*pairs, strict=True))
    return Stands(np.concatenate(joints), nests.astype(np.int64), groups.astype(np.int64))


def _stops(
    space: WorkSpace, group: tuple[Target, ...], nest: int, n: int, rng: np.random.Generator
) -> FloatArray:
    found, parts = 0, list[FloatArray]()
    for batch in range(1, _MOST_BATCHES + 1):
        parts.append(_batch(space, group, nest, rng))
        found += len(parts[-1])
        if found >= n:
            return np.concatenate(parts)[:n]
        if batch == _HOPELESS and not found:
            break
    raise TooFewCandidatesError(
        f"Nest {nest} comes to target {group[0].number} in {found} of {_BATCH * batch} tries, "
        f"{n} are needed: check its place, the joint ranges and the table's height.{look_at(space.keep_outs)}"
    )


def _batch(space: WorkSpace, group: tuple[Target, ...], nest: int, rng: np.random.Generator) -> FloatArray:
    low = np.array([limit.lower_rad for limit in space.ranges])
    high = np.array([limit.upper_rad for limit in space.ranges])
    joints = low + (high - low) * rng.random((_BATCH, len(low)))
    centre = np.array(space.nests[nest - 1].centre_mm)
    if group[0].kind is not TargetKind.WIRE:
        joints = _led(space, group, centre, joints, rng)
    inside = ((joints >= low) & (joints <= high)).all(axis=1)
    joints = joints[inside]
    kept: FloatArray = joints[_have_room(space, joints)]
    return kept


def _have_room(space: WorkSpace, joints_rad: FloatArray) -> BoolArray:
    room = has_room(space, joints_rad, nominal_chain(space, joints_rad))
    begin = joints_rad[room] + (space.approach_offset_rad or 0.0)
    room[room] = has_room(space, begin, nominal_chain(space, begin))
    return room


def _led(
    space: WorkSpace,
    group: tuple[Target, ...],
    centre_mm: FloatArray,
    joints_rad: FloatArray,
    rng: np.random.Generator,
) -> FloatArray:
    """Return configurations led to places near by, those that arrive and come from where they may."""
    wanted, inward = _wanted(group, len(joints_rad), rng)
    near = np.linalg.norm(nominal_chain(space, joints_rad).points(centre_mm) - wanted, axis=1) < _NEAR_MM
    joints, wanted, inward = joints_rad[near], wanted[near], inward[near]
    for _ in range(_STEPS):
        chain = nominal_chain(space, joints)
        places = chain.points(centre_mm)
        slopes = np.moveaxis(theta_gradient(chain, places), 0, 2)  # (n, 3, J)
        signs = np.array([row.sign for row in space.robot.joints])
        steps = np.einsum("nji,ni->nj", np.linalg.pinv(slopes * signs), wanted - places)
        joints = joints + steps
    chain = nominal_chain(space, joints)
    arrived = np.linalg.norm(chain.points(centre_mm) - wanted, axis=1) < _ARRIVED_MM
    leaning = _FACING if group[0].kind is TargetKind.FACE else _LEAN
    pointing = (chain.end_rotation[:, :, 2] * inward).sum(axis=1)
    return np.asarray(joints[arrived & (pointing > leaning)])


def _wanted(group: tuple[Target, ...], n: int, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Return places for the nest, and the way in from where the tool comes, shape (n, 3) each."""
    first = group[0]
    place = np.broadcast_to(np.array(first.place_mm), (n, 3))
    if first.kind is TargetKind.SPHERE:
        outward = rng.standard_normal((n, 3))
        outward[:, 2] = np.abs(outward[:, 2])
        outward /= np.linalg.norm(outward, axis=1)[:, None]
        return place + (first.zero_mm or _USUAL_ZERO_MM) * outward, -outward
    normal = _mean_normal(group)
    inward = np.broadcast_to(-normal, (n, 3))
    travel = rng.uniform(-_TRAVEL_MM, _TRAVEL_MM, (n, 3))
    if first.kind in (TargetKind.GAUGE, TargetKind.BALL):
        return place + travel, inward
    across = np.linalg.svd(normal[None])[2][1:]
    on_it = rng.uniform(-_PATCH_MM, _PATCH_MM, (n, 2)) @ across
    off = (_STAND_OFF_MM + travel[:, :1]) if first.kind is TargetKind.FACE else np.zeros((n, 1))
    return place + on_it + off * normal, inward


def _mean_normal(group: tuple[Target, ...]) -> FloatArray:
    total = np.sum([np.array(target.normal or _UP) for target in group], axis=0)
    return np.asarray(total / np.linalg.norm(total))
