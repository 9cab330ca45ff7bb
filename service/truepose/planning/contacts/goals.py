"""Random places and directions of the tool at its targets, before anybody asks whether the arm gets there."""

from typing import Final, NamedTuple

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.measurement.targets import Target, TargetKind
from truepose.planning.contacts.wish import ContactWish, normal_of, place_of

_CAP_COSINE: Final = 0.25  # of a sphere: the rest is where its stem is
_PROBE_TILT_RAD: Final = float(np.radians(12.0))  # of the probe against what it touches
_STEM_TILT_RAD: Final = float(np.radians(50.0))  # of a ball's stem, or a sensor, against the way in
_SHARE: Final = 0.15  # of the usable stroke, in which stops are planned: arm and fixture err as well


class Goals(NamedTuple):
    """n wanted places of the tool."""

    group: IntArray  # (n,) which targets are read: a place in `groups_of`
    tip_mm: FloatArray  # (n, 3) of the nest, world
    points: FloatArray  # (n, 3) unit: where the tool's axis points
    way_in: FloatArray  # (n, 3) unit: direction of the last millimetres

    def taken(self, rows: IntArray) -> "Goals":
        """Return some of them, in the order of `rows`."""
        return Goals(self.group[rows], self.tip_mm[rows], self.points[rows], self.way_in[rows])


def groups_of(wish: ContactWish) -> tuple[tuple[Target, ...], ...]:
    """Return which targets are read together at a stop: a probe touches one, all else reads all."""
    if wish.loop == "probe":
        return tuple((target,) for target in wish.targets)
    return (wish.targets,)


def draw_goals(wish: ContactWish, n: int, rng: np.random.Generator) -> Goals:
    """Draw n places of a tool that touches, or comes near."""
    groups = groups_of(wish)
    group = rng.integers(len(groups), size=n)
    goals = [_of_group(wish, targets, n, rng) for targets in groups]
    return Goals(group, *(np.choose(group[:, None], column) for column in zip(*goals, strict=True)))


def _of_group(
    wish: ContactWish, targets: tuple[Target, ...], n: int, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray, FloatArray]:
    first = targets[0]
    match first.kind:
        case TargetKind.SPHERE:
            outwards = _within_cone(normal_of(first), np.arccos(_CAP_COSINE), n, rng)
            tip_mm = place_of(first) + (first.zero_mm or 0.0) * outwards
            return _probing(tip_mm, -outwards, rng)
        case TargetKind.PLANE:
            normal = normal_of(first)
            across = np.linalg.svd(normal[None])[2][1:]
            beside_mm = wish.plane_mm * rng.uniform(-1.0, 1.0, (n, 2)) @ across
            return _probing(place_of(first) + beside_mm, np.broadcast_to(-normal, (n, 3)), rng)
        case _:
            return _approaching(wish, targets, n, rng)


def _probing(
    tip_mm: FloatArray, inwards: FloatArray, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray, FloatArray]:
    points = np.array([_within_cone(way, _PROBE_TILT_RAD, 1, rng)[0] for way in inwards])
    return tip_mm, points, points  # a probe is pushed in along its own axis


def _approaching(
    wish: ContactWish, targets: tuple[Target, ...], n: int, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Into a fixture of gauges along the middle of their directions; down to a ball for a sensor."""
    grows = np.mean([normal_of(target) for target in targets], axis=0)
    way = grows / np.linalg.norm(grows) * (-1.0 if wish.loop == "sensor" else 1.0)
    middle_mm = np.mean([place_of(target) for target in targets], axis=0)
    off_mm = _SHARE * wish.usable_mm * rng.uniform(-1.0, 1.0, (n, 3))
    points = _within_cone(way, _STEM_TILT_RAD, n, rng)
    return middle_mm + off_mm, points, np.broadcast_to(way, (n, 3))


def _within_cone(about: FloatArray, widest_rad: float, n: int, rng: np.random.Generator) -> FloatArray:
    """Draw unit vectors evenly over the cap about a direction, shape (n, 3)."""
    across = np.linalg.svd(about[None])[2][1:]
    cosine = rng.uniform(np.cos(widest_rad), 1.0, n)
    turn = rng.uniform(-np.pi, np.pi, n)
    sine = np.sqrt(1.0 - cosine**2)
    drawn: FloatArray = (
        cosine[:, None] * about
        + (sine * np.cos(turn))[:, None] * across[0]
        + (sine * np.sin(turn))[:, None] * across[1]
    )
    return drawn
