"""The base fixture: where a person has put it down, and the cups that are clamped on it."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from truepose_simulators.errors import HandsError
from truepose_simulators.physics.arm import Vector
from truepose_simulators.physics.rigid import FloatArray, motion, move, rotation
from truepose_simulators.scenarios.table import require_at_least_0

_NOT_THERE = "the base fixture is not in place yet: put it down first"


@dataclass(frozen=True, slots=True)
class HandsSetup:
    """How exactly a person works, and what the base fixture is like."""

    # In the frame of the fixture: B1 its origin, B2 on x, B3 in the xy plane; B4 hangs below, 300 from all.
    cups_mm: tuple[Vector, ...] = (
        (0.0, 0.0, 0.0),
        (300.0, 0.0, 0.0),
        (150.0, 259.8076, 0.0),
        (150.0, 86.6025, -244.9490),
    )
    place_mm: float = 3.0  # by at most which the fixture stands off its mark, along each axis
    place_deg: float = 0.2  # and about each
    play_mm: float = 15.0  # by which a released cup can be slid
    reach_mm: float = 2.0  # from which its magnet snaps on the ball

    def __post_init__(self) -> None:
        require_at_least_0(self, "place_mm", "place_deg", "play_mm", "reach_mm")


@dataclass(frozen=True, slots=True)
class ClampedCup:
    """A cup where the ball was that it was clamped on."""

    placement: int
    base_point: int
    place_mm: FloatArray  # (3,) world
    clamped_s: float


class Fixture:
    """The base fixture and its cups, in every placement so far."""

    def __init__(
        self,
        setup: HandsSetup,
        shifted_mm: Callable[[ClampedCup, float], FloatArray],
        rng: np.random.Generator,
    ) -> None:
        """Stand nowhere; `shifted_mm` says where a clamped cup is at a cell time."""
        self._setup = setup
        self._shifted_mm = shifted_mm
        self._rng = rng
        self._loose_mm: FloatArray | None = None
        self._clamped: dict[tuple[int, int], ClampedCup] = {}
        self.placement: int | None = None

    @property
    def cups(self) -> tuple[ClampedCup, ...]:
        """All cups that were clamped, of earlier placements too."""
        return tuple(self._clamped.values())

    def put_down(self, placement: int, mark: FloatArray | None) -> None:
        """Put it down about on its mark (4, 4) [world] with its cups released.

        Where no mark is stated, it will prove to stand right as soon as the robot holds the ball there.
        """
        place = self._setup.place_mm * self._rng.uniform(-1.0, 1.0, 3)
        turn = np.radians(self._setup.place_deg) * self._rng.uniform(-1.0, 1.0, 3)
        cups = np.array(self._setup.cups_mm, dtype=np.float64)
        self._loose_mm = None if mark is None else move(mark @ motion(place, rotation(turn)), cups)
        self._clamped = {key: cup for key, cup in self._clamped.items() if key[0] != placement}
        self.placement = placement

    def clamp(self, base_point: int, ball_mm: FloatArray, clamp_mm: float, time_s: float) -> None:
        """Let a cup snap on the ball, then clamp it, off by `clamp_mm` per axis; raises HandsError."""
        if self.placement is None:
            raise HandsError(_NOT_THERE)
        if not 1 <= base_point <= len(self._setup.cups_mm):
            raise HandsError(f"there is no cup {base_point}: the fixture has {len(self._setup.cups_mm)}")
        away_mm = self._away_mm(base_point, ball_mm) - self._setup.play_mm
        if away_mm > self._setup.reach_mm:
            raise HandsError(
                f"cup {base_point} does not snap on: at the end of its travel it is {away_mm:.1f} mm from the"
                f" ball, but its magnet reaches {self._setup.reach_mm:g} mm; have the robot hold the ball "
                "there"
            )
        place = ball_mm + clamp_mm * self._rng.standard_normal(3)
        cup = ClampedCup(self.placement, base_point, place, time_s)
        self._clamped[self.placement, base_point] = cup

    def _away_mm(self, base_point: int, ball_mm: FloatArray) -> float:
        """Return how far a released cup, in the middle of its play, is from the ball."""
        if self._loose_mm is not None:
            return float(np.linalg.norm(ball_mm - self._loose_mm[base_point - 1]))
        # Without a mark only the sides between cups are known: a new one must fit those that are clamped.
        own, norm = np.array(self._setup.cups_mm), np.linalg.norm
        others = [
            cup for cup in self.cups if cup.placement == self.placement and cup.base_point != base_point
        ]
        sides = ((ball_mm - cup.place_mm, own[base_point - 1] - own[cup.base_point - 1]) for cup in others)
        return max((abs(float(norm(side) - norm(meant))) for side, meant in sides), default=0.0)

    def cup_mm(self, base_point: int, time_s: float) -> FloatArray:
        """Where a clamped cup is at a cell time, shape (3,) [world]; raises HandsError."""
        if self.placement is None:
            raise HandsError(_NOT_THERE)
        cup = self._clamped.get((self.placement, base_point))
        if cup is None:
            raise HandsError(f"cup {base_point} is not clamped in placement {self.placement}")
        return self._shifted_mm(cup, time_s)
