"""The one place from which the arm comes to every stop, and to which it returns: past all that stands there.

So the way from one stop to the next is known to be clear, also where some of them are left out.
"""

from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray
from truepose.domain.measurement.targets import Target, TargetKind
from truepose.planning.contacts.wish import ContactWish, normal_of, place_of
from truepose.planning.errors import NoWayError
from truepose.planning.work_volume.candidates import draw_candidates
from truepose.planning.work_volume.cell_bodies import CellBodies
from truepose.planning.work_volume.room_on_ways import Ways, least_rooms_mm
from truepose.planning.work_volume.work_space import WorkSpace, nest_places, nominal_chain

_LOOKS: Final = 40  # along a way
_KEPT_OFF_MM: Final = 20.0  # by the tool's nests and the flange, from what they could touch
_FIXTURE_MM: Final = 40.0  # half the size of a fixture of gauges, or of a ball with its foot
_TRIED: Final = 12  # places from which the arm could come
_BEGINS_TRIED: Final = 20


def hub_of(
    space: WorkSpace, bodies: CellBodies, wish: ContactWish, begins_rad: FloatArray, rng: np.random.Generator
) -> FloatArray:
    """Return the configuration from which most of the begins (n, J) are reached by a clear way, shape (J,).

    Raises NoWayError where none is reached from any that was tried.
    """
    tried = draw_candidates(space, _TRIED, rng).joints_rad
    tried = tried[keep_off(space, wish, tried)]
    some = begins_rad[rng.permutation(len(begins_rad))[:_BEGINS_TRIED]]
    reached = [int(clear_from(space, bodies, wish, hub, some).sum()) for hub in tried]
    if not reached or max(reached) == 0:
        raise NoWayError(
            "From no place that was tried a clear way leads to the targets: put them elsewhere, or take "
            "another seed."
        )
    best: FloatArray = tried[int(np.argmax(reached))]
    return best


def clear_from(
    space: WorkSpace, bodies: CellBodies, wish: ContactWish, hub_rad: FloatArray, begins_rad: FloatArray
) -> BoolArray:
    """Whether the straight joint motions from a hub to begins (n, J) are clear, shape (n,)."""
    n, joints = begins_rad.shape
    hubs = np.broadcast_to(hub_rad, (n, joints))
    room_mm = least_rooms_mm(bodies, Ways((), hubs, begins_rad))
    share = np.linspace(0.0, 1.0, _LOOKS)[:, None, None]
    along = (hubs + share * (begins_rad - hubs)).reshape(-1, joints)
    off = keep_off(space, wish, along).reshape(_LOOKS, n).all(axis=0)
    clear: BoolArray = (room_mm >= 0.0) & off
    return clear


def keep_off(space: WorkSpace, wish: ContactWish, joints_rad: FloatArray) -> BoolArray:
    """Whether the tool's nests and the flange are away from all targets at configurations (n, J)."""
    chain = nominal_chain(space, joints_rad)
    points_mm = np.concatenate([nest_places(space, chain), chain.origin[-1:]])
    apart = [_keeps_off(target, points_mm).all(axis=0) for target in wish.targets]
    return np.asarray(np.all(apart, axis=0))


def _keeps_off(target: Target, points_mm: FloatArray) -> BoolArray:
    """Whether points (k, n, 3) stay away from a target, shape (k, n)."""
    off_mm = points_mm - place_of(target)
    if target.kind is TargetKind.PLANE:
        return np.asarray(off_mm @ normal_of(target) >= _KEPT_OFF_MM)
    if target.kind is TargetKind.WIRE:
        return np.ones(off_mm.shape[:-1], dtype=bool)
    size_mm = (target.zero_mm or 0.0) if target.kind is TargetKind.SPHERE else _FIXTURE_MM
    return np.asarray(np.linalg.norm(off_mm, axis=-1) >= size_mm + _KEPT_OFF_MM)
