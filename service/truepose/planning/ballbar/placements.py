"""Where the base fixture stands: a search over places and tilts before the robot.

Each place is judged by the error that the session's model will have over the whole work space, were all
configurations measured that can be from there. Random places first; of them the best one, the one that goes
best with it, and so on; then each is moved about a little as long as that helps.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.errors import ConfigurationError
from truepose.domain.robot import FramePlacement
from truepose.kinematics.frames import (
    placement_of,
    placement_rotation,
    placement_translation,
    rotation_from_vector,
    rotation_z,
)
from truepose.kinematics.inverse import has_closed_form
from truepose.kinematics.pose_device import Assembly
from truepose.planning.ballbar.arm_model import ArmModel, arm_model
from truepose.planning.ballbar.bodies import BallbarCell, BaseFixture, base_fixture, fixture_body
from truepose.planning.ballbar.expected_information import (
    SPACE_POINTS,
    WorkSpaceSample,
    predicted_error_mm,
    work_space_sample,
)
from truepose.planning.ballbar.pose_selection import Candidates, candidates, information_after
from truepose.planning.ballbar.poses import device, setup_joints
from truepose.planning.errors import TooFewCandidatesError
from truepose.planning.workspace.capsules import gaps_mm, look_at

_LOWEST_MM: Final = 60.0  # of cup and hub above the table
_HIGHEST_MM: Final = 600.0  # a stand that high is still stiff
_MOST_TILT_RAD: Final = float(np.radians(75.0))
_SHIFT_MM: Final = 60.0  # of the moves that refine a place
_TURN_RAD: Final = 0.3


@dataclass(frozen=True, slots=True)
class PlacementRequest:
    """What is asked of the search.

    Attributes
    ----------
    placements : int
        How often the base fixture is put down.
    base_points : int
        Cups of it, 3 or 4.
    poses : int
        Of the whole session; by default as many as the thesis of A. Nubiola, 2014, section 4.4.
    draws : int
        Random places that it begins with.
    moves : int
        Small moves of all placements together, per start.
    starts : int
        Sets of places that are refined.
    seed : int
        The same seed finds the same places.

    Raises
    ------
    ConfigurationError
        There is no placement, or fewer poses than placements.
    """

    placements: int = 1
    base_points: int = 3
    poses: int = 61
    draws: int = 360
    moves: int = 150
    starts: int = 4
    seed: int = 0

    def __post_init__(self) -> None:
        if self.placements < 1 or self.poses < self.placements:
            raise ConfigurationError(
                f"A session needs at least one placement, and one pose per placement (got {self.placements} "
                f"placements and {self.poses} poses)."
            )


@dataclass(frozen=True, slots=True)
class Suggestion:
    """Where to place the base fixture, one after the other."""

    fixtures: tuple[BaseFixture, ...]
    error_mm: float  # root mean square over the work space, as far as readings scatter as stated
    tried: int  # places that were looked at
    usable: int  # of these, places from which enough can be measured


def suggest(cell: BallbarCell, wish: PlacementRequest | None = None) -> Suggestion:
    """Search for the placements from which a session identifies the model best.

    The figure is the root mean square error of nest positions over the work space
    (`planning.ballbar.information`).

    Parameters
    ----------
    cell : BallbarCell
    wish : PlacementRequest, optional

    Returns
    -------
    Suggestion

    Raises
    ------
    TooFewCandidatesError
        From none of the places that were tried enough configurations can be measured, or the arm can hold the
        setting ball at every cup.
    ConfigurationError
        The cups would be no length apart, or not 3 or 4.
    """
    wish = _affordable(cell, wish or PlacementRequest())
    rng = np.random.default_rng(wish.seed)
    model = arm_model(cell)
    # Assemblies do not depend on where the fixture stands: worked out once for all places.
    made = device(cell, base_fixture(1, FramePlacement(), wish.base_points, cell.leg_mm))
    search = _Search(model, work_space_sample(model, SPACE_POINTS, rng), wish, made)
    places = [own for own in (search.judged(frame) for frame in _frames(cell, wish, rng)) if own is not None]
    pool = [own for own in places if len(own) >= search.fewest]
    if not pool:
        raise TooFewCandidatesError(search.too_few(places))
    chosen = search.best(pool, rng)
    fixtures = tuple(replace(own.fixture, number=number) for number, own in enumerate(chosen, start=1))
    return Suggestion(fixtures, search.error_mm(chosen), wish.draws, len(pool))


def _affordable(cell: BallbarCell, wish: PlacementRequest) -> PlacementRequest:
    """Return a smaller search for arms whose inverse is searched for, too: it takes twenty times as long."""
    if has_closed_form(cell.robot):
        return wish
    return replace(wish, draws=wish.draws // 8, moves=wish.moves // 8, starts=1)


@dataclass(frozen=True, slots=True)
class _Search:
    model: ArmModel
    sample: WorkSpaceSample
    wish: PlacementRequest
    made: tuple[Assembly, ...]  # of tool and base fixture, wherever it stands

    @property
    def fewest(self) -> int:
        """Configurations that each placement must offer."""
        return int(np.ceil(self.wish.poses / self.wish.placements))

    def judged(self, frame: FramePlacement) -> Candidates | None:
        """Return what can be measured from a place; None where the base fixture cannot stand."""
        fixture = base_fixture(1, frame, self.wish.base_points, self.model.cell.leg_mm)
        heights = np.array([*fixture.cups_mm[:, 2], fixture.hub_mm[2]]) - self.model.cell.table_z_mm
        if heights.min() < _LOWEST_MM or heights.max() > _HIGHEST_MM or self._is_kept_out(fixture):
            return None
        return candidates(self.model, fixture, made=self.made)

    def _is_kept_out(self, fixture: BaseFixture) -> bool:
        body = fixture_body(fixture, self.model.cell.table_z_mm)
        return any(gaps_mm(volume, body).min() < 0.0 for volume in self.model.cell.keep_outs)

    def too_few(self, places: Sequence[Candidates]) -> str:
        """Say that no place offers what is asked for, and how much the best one does."""
        most = max((len(own) for own in places), default=0)
        return (
            f"None of the {self.wish.draws} base fixture positions tried allows {self.fewest} configurations "
            f"to be measured with the ballbar; the best allows {most}. Request fewer configurations or more "
            f"placements, or widen the joint ranges.{look_at(self.model.cell.keep_outs)}"
        )

    def holds_ball(self, own: Candidates) -> bool:
        """Whether the arm can hold the setting ball at every cup."""
        points = range(1, len(own.fixture.cups_mm) + 1)
        return all(setup_joints(self.model.cell, own.fixture, point) is not None for point in points)

    def error_mm(self, placements: Sequence[Candidates]) -> float:
        """Return the error over the work space with the share of poses that each placement gets."""
        known = information_after(self.model, placements, [None] * len(placements), self.wish.poses)
        return predicted_error_mm(known, self.sample)

    def best(self, pool: Sequence[Candidates], rng: np.random.Generator) -> list[Candidates]:
        """Return the best of several sets of places, each refined.

        Raises TooFewCandidatesError where no place lets the arm hold the setting ball at every cup.
        """
        ranked = sorted(pool, key=lambda own: self.error_mm([own]))
        each = (self.greedy(ranked, ranked[k:]) for k in range(self.wish.starts))
        starts = [start for start in each if start is not None]
        if not starts:
            raise TooFewCandidatesError(
                "At none of the base fixture positions tried can the arm hold the setting ball at every cup. "
                "Widen the joint ranges."
            )
        return min((self.refined(start, rng) for start in starts), key=self.error_mm)

    def greedy(self, pool: Sequence[Candidates], first: Sequence[Candidates]) -> list[Candidates] | None:
        """Return the first usable of `first`, then the place that goes best with those before.

        None where from none of them the arm can hold the setting ball at every cup.
        """
        chosen: list[Candidates] = []
        for place in range(self.wish.placements):
            # Beside those chosen, not by itself: a second place like the first tells of the arm
            # what is known already.
            ranked = sorted(pool, key=lambda own: self.error_mm([*chosen, own])) if place else first
            best = next((own for own in ranked if self.holds_ball(own)), None)
            if best is None:
                return None
            chosen.append(best)
        return chosen

    def refined(self, chosen: list[Candidates], rng: np.random.Generator) -> list[Candidates]:
        """Move each placement about as long as the error falls."""
        best = self.error_mm(chosen)
        for move in range(self.wish.moves):
            k = move % len(chosen)
            # Wide moves first, a quarter as wide at the end: they find the basin, then its floor.
            scale = 1.0 - 0.75 * move / self.wish.moves
            own = self.judged(_moved(chosen[k].fixture.frame, scale, rng))
            if own is None or len(own) < self.fewest:
                continue
            tried = [*chosen[:k], own, *chosen[k + 1 :]]
            error = self.error_mm(tried)
            # Asked only of what is better: set-ups are searched for at every cup.
            if error < best and self.holds_ball(own):
                chosen, best = tried, error
        return chosen


def _frames(cell: BallbarCell, wish: PlacementRequest, rng: np.random.Generator) -> Iterator[FramePlacement]:
    """Random frames of the base triangle, its centre in the arm's reach, its normal up to a tilt.

    About axis 1 by the range of joint 1, from 30 to 85 % of the length of the arm's links away. The
    triangle's middle is (1/2, sqrt(3)/6, 0) of its side from cup 1.
    """
    reach = sum(abs(row.a_mm) + abs(row.d_mm) for row in cell.robot.joints[1:])
    first = cell.ranges[0]
    base_rotation, base_origin = placement_rotation(cell.base), placement_translation(cell.base)
    for _ in range(wish.draws):
        turn = rng.uniform(max(first.lower_rad, -np.pi), min(first.upper_rad, np.pi))
        distance = reach * rng.uniform(0.3, 0.85)
        height = cell.table_z_mm - base_origin[2] + rng.uniform(_LOWEST_MM, 0.6 * _HIGHEST_MM)
        centre = np.array([distance * np.cos(turn), distance * np.sin(turn), height])
        rotation = _tilted(rng)
        corner = np.array([0.5, np.sqrt(3.0) / 6.0, 0.0]) * cell.leg_mm
        origin = base_rotation @ centre + base_origin - rotation @ corner
        yield placement_of(rotation, origin)


def _tilted(rng: np.random.Generator) -> FloatArray:
    """Return a rotation whose z leans from the plumb by up to 75 deg to any side, spun at random, (3, 3)."""
    direction = rng.uniform(-np.pi, np.pi)
    lean = np.array([np.cos(direction), np.sin(direction), 0.0]) * rng.uniform(0.0, _MOST_TILT_RAD)
    return np.asarray(rotation_from_vector(lean) @ rotation_z(rng.uniform(-np.pi, np.pi)))


def _moved(frame: FramePlacement, scale: float, rng: np.random.Generator) -> FramePlacement:
    turn = rotation_from_vector(scale * _TURN_RAD * rng.standard_normal(3))
    shift = scale * _SHIFT_MM * rng.standard_normal(3)
    return placement_of(turn @ placement_rotation(frame), placement_translation(frame) + shift)
