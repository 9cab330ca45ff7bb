"""What a nominal arm reads at the stops of a closed loop."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.measurement.campaign import NO_AXIS, Campaign, ContactReadings, Stops
from truepose.domain.measurement.targets import SEEN_ALONG_AXES, Target, TargetKind
from truepose.identification.observations.contacts.against import Probe, sensor_axes
from truepose.identification.observations.contacts.kinds import KINDS
from truepose.planning.loops.stands import LoopWish, Stands
from truepose.planning.work_volume.work_space import WorkSpace, nominal_chain


def nominal_loop(space: WorkSpace, wish: LoopWish, stands: Stands) -> tuple[Campaign, IntArray]:
    """Return the campaign of an arm without errors, and the stop of each of its readings, shape (m,)."""
    parts = [_read(space, stands, part) for part in _parts(wish, stands)]
    stop = np.concatenate([part.stop for part in parts])
    contacts = ContactReadings(
        stops=Stops(stop, stands.joints_rad[stop]),
        target=np.concatenate([np.full(len(part.stop), part.target.number) for part in parts]),
        nest=stands.nest[stop],
        reading_mm=np.concatenate([part.reading_mm for part in parts]),
        standard_uncertainty_mm=np.full(len(stop), wish.reading_mm),
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


def _parts(wish: LoopWish, stands: Stands) -> Iterator[tuple[Target, int, IntArray]]:
    for number, group in enumerate(wish.groups):
        stop = np.flatnonzero(stands.group == number)
        for target in group:
            yield from ((target, axis, stop) for axis in _axes(target))


def _axes(target: Target) -> tuple[int, ...]:
    """Return the axes of the sensor that are read: a face along z of the tool."""
    if target.kind is TargetKind.FACE:
        return (2,)
    return (0, 1, 2) if target.kind in SEEN_ALONG_AXES else (NO_AXIS,)


def _read(space: WorkSpace, stands: Stands, part: tuple[Target, int, IntArray]) -> _Part:
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
