"""Where an arm may stand in a closed loop, and what a nominal arm reads there.

Configurations are drawn in the joint ranges and led to the targets by Newton's steps, with P the nest, P* its
wanted place and J' = dP/dq: q <- q + J'^+ (P* - P). Those that arrive, point where they must and have room
are kept.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.domain.campaign import NO_AXIS, Campaign, ContactReadings, Stops, TargetDistances
from truepose.domain.contacts import SEEN_ALONG_AXES, Target, TargetKind
from truepose.domain.errors import ConfigurationError
from truepose.identification.observations.contact_targets import KINDS, Probe, sensor_axes
from truepose.kinematics.chain import theta_gradient
from truepose.planning.contacts.plan_request import mean_normal
from truepose.planning.errors import TooFewCandidatesError
from truepose.planning.prediction.expected_covariance import LEAST_MM
from truepose.planning.workspace.candidates import has_room
from truepose.planning.workspace.capsules import look_at
from truepose.planning.workspace.space import WorkSpace, nominal_chain

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


@dataclass(frozen=True, slots=True)
class LoopPlanRequest:
    """What a closed loop is planned with.

    Attributes
    ----------
    targets : tuple of Target
        Each with the place where it stands, roughly.
    nests : tuple of int
        Of the tool that are used, by turns; 1-based, one at least.
    reading_mm : float
        Standard uncertainty of a reading.
    distances : TargetDistances or None
        Certified, of two centres.

    Raises
    ------
    ConfigurationError
        There is no target, or one has no place.
    """

    targets: tuple[Target, ...]
    nests: tuple[int, ...]
    reading_mm: float
    distances: TargetDistances | None = None

    def __post_init__(self) -> None:
        if not self.targets:
            raise ConfigurationError("A closed-loop plan needs at least one target.")
        for target in self.targets:
            if target.place_mm is None:
                raise ConfigurationError(
                    f"Target {target.number} has no position. Give its approximate position (x_mm, y_mm, "
                    "z_mm)."
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
class LoopStops:
    """n stops and what is read there."""

    joints_rad: FloatArray  # (n, J)
    nest: IntArray  # (n,) 1-based
    group: IntArray  # (n,) index among the groups of the wish


def draw_stands(space: WorkSpace, wish: LoopPlanRequest, n: int, rng: np.random.Generator) -> LoopStops:
    """Draw stops, nests and groups of targets in equal parts.

    Parameters
    ----------
    space : WorkSpace
    wish : LoopPlanRequest
    n : int
        How many at least: each pair of nest and group gets the same number, rounded up.
    rng : numpy.random.Generator

    Returns
    -------
    LoopStops

    Raises
    ------
    ConfigurationError
        No nest is given, or one that the tool has not.
    TooFewCandidatesError
        The arm hardly reaches one of the targets.
    WorkSpaceError
        Gauges at one place read along directions that cancel each other.
    """
    if not wish.nests or not set(wish.nests) <= set(range(1, len(space.nests) + 1)):
        raise ConfigurationError(
            f"A closed-loop plan needs at least one tool nest. Choose from 1 to {len(space.nests)}."
        )
    pairs = [(nest, group) for group in range(len(wish.groups)) for nest in wish.nests]
    each = -(-n // len(pairs))
    joints = [_stops(space, wish.groups[group], nest, each, rng) for nest, group in pairs]
    nests, groups = (np.repeat(np.array(column), each) for column in zip(*pairs, strict=True))
    return LoopStops(np.concatenate(joints), nests.astype(np.int64), groups.astype(np.int64))


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
        f"Nest {nest} reaches target {group[0].number} in {found} of {_BATCH * batch} random configurations; "
        f"{n} are needed. Check the target position, the joint ranges and the table height."
        f"{look_at(space.keep_outs)}"
    )


def _batch(space: WorkSpace, group: tuple[Target, ...], nest: int, rng: np.random.Generator) -> FloatArray:
    low = np.array([limit.lower_rad for limit in space.ranges])
    high = np.array([limit.upper_rad for limit in space.ranges])
    joints = low + (high - low) * rng.random((_BATCH, len(low)))
    centre = np.array(space.nests[nest - 1].centre_mm)
    # A wire reaches everywhere: its end needs no leading.
    if group[0].kind is not TargetKind.WIRE:
        joints = _led(space, group, centre, joints, rng)
    # Newton's steps know no limits.
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
    """Return configurations led to places near by, those that arrive and come from where they may.

    Twelve steps q <- q + J'^+ (P* - P), the shortest each, as a place has three coordinates and an arm more
    joints.
    """
    wanted, inward = _wanted(group, len(joints_rad), rng)
    near = np.linalg.norm(nominal_chain(space, joints_rad).points(centre_mm) - wanted, axis=1) < _NEAR_MM
    joints, wanted, inward = joints_rad[near], wanted[near], inward[near]
    for _ in range(_STEPS):
        chain = nominal_chain(space, joints)
        places = chain.points(centre_mm)
        slopes = np.moveaxis(theta_gradient(chain, places), 0, 2)  # (n, 3, J)
        # The derivatives are by the angles of the model; a controller may count a joint the other way
        # round.
        signs = np.array([row.sign for row in space.robot.joints])
        steps = np.einsum("nji,ni->nj", np.linalg.pinv(slopes * signs), wanted - places)
        joints = joints + steps
    chain = nominal_chain(space, joints)
    arrived = np.linalg.norm(chain.points(centre_mm) - wanted, axis=1) < _ARRIVED_MM
    leaning = _FACING if group[0].kind is TargetKind.FACE else _LEAN
    pointing = (chain.end_rotation[:, :, 2] * inward).sum(axis=1)
    return np.asarray(joints[arrived & (pointing > leaning)])


def _wanted(group: tuple[Target, ...], n: int, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Return places for the nest, and the way in from where the tool comes, shape (n, 3) each.

    On the sphere of the zero about a centre, its upper half; else about the place, with normal n: within the
    travel of a gauge or sensor, in a square of a plane, 40 mm off a face. The way in is n to a gauge, which
    reads the more the further it is pushed in, and -n to all else.
    """
    first = group[0]
    place = np.broadcast_to(np.array(first.place_mm), (n, 3))
    if first.kind is TargetKind.SPHERE:
        outward = rng.standard_normal((n, 3))
        # The lower half is where its stem is.
        outward[:, 2] = np.abs(outward[:, 2])
        outward /= np.linalg.norm(outward, axis=1)[:, None]
        return place + (first.zero_mm or _USUAL_ZERO_MM) * outward, -outward
    normal = mean_normal(group)
    inward = np.broadcast_to(normal if first.kind is TargetKind.GAUGE else -normal, (n, 3))
    travel = rng.uniform(-_TRAVEL_MM, _TRAVEL_MM, (n, 3))
    if first.kind in (TargetKind.GAUGE, TargetKind.BALL):
        return place + travel, inward
    across = np.linalg.svd(normal[None])[2][1:]
    on_it = rng.uniform(-_PATCH_MM, _PATCH_MM, (n, 2)) @ across
    off = (_STAND_OFF_MM + travel[:, :1]) if first.kind is TargetKind.FACE else np.zeros((n, 1))
    return place + on_it + off * normal, inward


def nominal_loop(space: WorkSpace, wish: LoopPlanRequest, stands: LoopStops) -> tuple[Campaign, IntArray]:
    """Return the campaign of an arm without errors, and the stop of each of its readings.

    Parameters
    ----------
    space : WorkSpace
    wish : LoopPlanRequest
    stands : LoopStops

    Returns
    -------
    campaign : Campaign
        With contacts and targets, and no positions.
    stop : ndarray, shape (m,)
        Row among the stands of each of m readings.
    """
    parts = [_read(space, stands, part) for part in _parts(wish, stands)]
    stop = np.concatenate([part.stop for part in parts])
    contacts = ContactReadings(
        stops=Stops(stop, stands.joints_rad[stop]),
        target=np.concatenate([np.full(len(part.stop), part.target.number) for part in parts]),
        nest=stands.nest[stop],
        reading_mm=np.concatenate([part.reading_mm for part in parts]),
        # Readings without any uncertainty would weigh infinitely.
        standard_uncertainty_mm=np.full(len(stop), max(wish.reading_mm, LEAST_MM)),
        axis=np.concatenate([np.full(len(part.stop), part.axis) for part in parts]),
    )
    campaign = Campaign(
        robot=space.robot,
        base_nominal=space.base,
        nests=space.nests,
        contacts=contacts,
        targets=wish.targets,
        target_distances=wish.distances,
    )
    return campaign, stop


@dataclass(frozen=True, slots=True)
class _Part:
    """What one target reads at some of the stops, along one axis."""

    target: Target
    axis: int
    stop: IntArray  # (k,)
    reading_mm: FloatArray  # (k,)


def _parts(wish: LoopPlanRequest, stands: LoopStops) -> Iterator[tuple[Target, int, IntArray]]:
    for number, group in enumerate(wish.groups):
        stop = np.flatnonzero(stands.group == number)
        for target in group:
            yield from ((target, axis, stop) for axis in _axes(target))


def _axes(target: Target) -> tuple[int, ...]:
    """Return the axes of the sensor that are read: a face along z of the tool."""
    if target.kind is TargetKind.FACE:
        return (2,)
    return (0, 1, 2) if target.kind in SEEN_ALONG_AXES else (NO_AXIS,)


def _read(space: WorkSpace, stands: LoopStops, part: tuple[Target, int, IntArray]) -> _Part:
    target, axis, stop = part
    chain = nominal_chain(space, stands.joints_rad[stop])
    centres = np.array([nest.centre_mm for nest in space.nests])[stands.nest[stop] - 1]
    place = chain.end_origin + np.einsum("nij,nj->ni", chain.end_rotation, centres)
    probe = Probe(place, sensor_axes(chain.end_rotation, np.full(len(stop), axis)))
    return _Part(target, axis, stop, KINDS[target.kind].reading_mm(target, _values(target), probe))


def _values(target: Target) -> FloatArray:
    """Return the parameters of a target that stands where it is said to."""
    if target.kind is TargetKind.BALL:
        return np.array(target.place_mm)
    if target.kind not in (TargetKind.SPHERE, TargetKind.WIRE):
        return np.zeros(3)
    exact = target.zero_mm is not None and target.zero_uncertainty_mm == 0.0
    return np.array([*(target.place_mm or ()), *([] if exact else [target.zero_mm or 0.0])])
