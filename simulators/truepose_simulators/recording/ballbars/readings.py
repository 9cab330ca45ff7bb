"""What is read in a ballbar session: sides of triangles, and legs."""

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.instruments.accuracy import rounded_mm, walked_zeros_mm
from truepose_simulators.physics.effects.ports import NestNumbers
from truepose_simulators.physics.rigid import FloatArray
from truepose_simulators.recording.ballbars.tour import TRIANGLE_S, PlannedLegs, Tour
from truepose_simulators.recording.rows import Rows


@dataclass(frozen=True, slots=True)
class Legs(Rows):
    """n legs that were read, or that were out of range."""

    placement: NestNumbers  # (n,)
    config: NestNumbers  # (n,)
    joints_deg: FloatArray  # (n, J) commanded
    direction: FloatArray  # (n, J)
    time_s: FloatArray  # (n,)
    temperature_c: FloatArray  # (n,) as sensed
    attachment: FloatArray  # (n,)
    init: NestNumbers  # (n,) number of the last initialisation
    base_point: NestNumbers  # (n,)
    tool_point: NestNumbers  # (n,)
    length_mm: FloatArray  # (n,)
    true_mm: FloatArray  # (n,) of the pair that is written down, without noise, scatter and zero


@dataclass(frozen=True, slots=True)
class Sides(Rows):
    """m sides of triangles that were within range; placement 0 is the tool's."""

    placement: NestNumbers  # (m,)
    point_a: NestNumbers  # (m,)
    point_b: NestNumbers  # (m,)
    length_mm: FloatArray  # (m,)


@dataclass(frozen=True, slots=True)
class Cups:
    """k cups, clamped where the robot held the ball."""

    placement: NestNumbers  # (k,)
    base_point: NestNumbers  # (k,)
    joints_deg: FloatArray  # (k, J) at which the robot held it
    clamped_s: FloatArray  # (k,)
    true_mm: FloatArray  # (k, 3) world, as clamped
    read_mm: FloatArray  # (k, 3) by the tracker
    u_mm: FloatArray  # (k,) of the tracker's readings, per axis

    def of_legs(self, legs: PlannedLegs, tour: Tour) -> NestNumbers:
        """Return which of the cups each leg begins at, shape (n,)."""
        placement = tour.placement[legs.stop][:, np.newaxis]
        mine = (placement == self.placement) & (legs.base_point[:, np.newaxis] == self.base_point)
        which: NestNumbers = mine.argmax(axis=1)
        return which


class BallbarSession:
    """One session: the ballbar is initialised before every triangle and every pose."""

    def __init__(
        self,
        cell: Cell,
        tour: Tour,
        legs: PlannedLegs,
        cups: Cups,
        scatter_mm: FloatArray,
        rng: np.random.Generator,
    ) -> None:
        """Prepare it; the readings of a stop share the arm's scatter, shape (S, 3)."""
        self._cell, self._tour, self._legs, self._cups = cell, tour, legs, cups
        self._setup = cell.scenario.ballbar
        self._rng = rng
        self._initialisation = 0
        self._conditions = tour.conditions(cell, legs.stop, legs.time_s)
        self._nests_mm = cell.true_positions(self._conditions)
        self._scatter_mm = scatter_mm[legs.stop]

    def read(self) -> tuple[Sides, Legs]:
        """Measure the tool, then placement by placement cups and legs, those out of range included."""
        tour = self._tour
        sides, legs = [self._read_tool()], []
        for placement in dict.fromkeys(tour.placement.tolist()):
            sides.append(self._read_base(placement))
            stops = np.flatnonzero((tour.placement == placement) & ~tour.is_setup)
            legs += [self._read_pose(np.flatnonzero(self._legs.stop == stop)) for stop in stops]
        return Sides.joined(sides), Legs.joined(legs)

    def _read_tool(self) -> Sides:
        nests = self._cell.true_nests_mm(self._cell.conditions_now())[0]
        numbers = np.arange(1, len(nests) + 1)
        return self._read_triangle(0, numbers, nests, 0.0, self._setup.tool_nominal_mm)

    def _read_base(self, placement: int) -> Sides:
        """Measure the triangle or tetrahedron of the cups, once all are clamped."""
        cups = self._cups
        mine = np.flatnonzero(cups.placement == placement)
        mine = mine[np.argsort(cups.base_point[mine])]
        start_s = float(cups.clamped_s[mine].max())
        places = self._places_mm(mine, np.full(len(mine), start_s))
        return self._read_triangle(placement, cups.base_point[mine], places, start_s, self._setup.nominal_mm)

    def _read_pose(self, rows: NestNumbers) -> Legs:
        tour, legs, n = self._tour, self._legs, len(rows)
        stop, time_s, tool_point = legs.stop[rows], legs.time_s[rows], legs.tool_point[rows]
        cup = self._places_mm(self._cups.of_legs(legs, tour)[rows], time_s)
        # What is written down is the leg that was asked for; what is read, the one that the person connected.
        connected = self._cell.nests_read(tool_point, time_s)
        stood = self._nests_mm[rows, connected - 1] + self._scatter_mm[rows]
        length = self._read(np.linalg.norm(stood - cup, axis=1), time_s, time_s - tour.start_s[stop])
        sensor = self._cell.scenario.air.sensor_noise_k if self._cell.scenario.noise else 0.0
        return Legs(
            placement=tour.placement[stop],
            config=tour.number[stop],
            joints_deg=tour.joints_deg[stop],
            direction=tour.direction[stop],
            time_s=time_s,
            temperature_c=self._conditions.temperature_c[rows] + sensor * self._rng.standard_normal(n),
            attachment=self._conditions.attachment[rows],
            init=np.full(n, self._initialisation),
            base_point=legs.base_point[rows],
            tool_point=tool_point,
            length_mm=length,
            true_mm=np.linalg.norm(self._nests_mm[rows, tool_point - 1] - cup, axis=1),
        )

    def _read_triangle(
        self, placement: int, numbers: NestNumbers, places_mm: FloatArray, start_s: float, nominal_mm: float
    ) -> Sides:
        pairs = np.array(list(combinations(range(len(numbers)), 2))).reshape(-1, 2)
        first, second = pairs.T
        since_s = TRIANGLE_S * np.arange(1, len(pairs) + 1) / len(pairs)
        true = np.linalg.norm(places_mm[second] - places_mm[first], axis=1)
        length = self._read(true, start_s + since_s, since_s)
        kept = np.abs(length - nominal_mm) <= self._setup.range_mm
        first, second = first[kept], second[kept]
        return Sides(np.full(len(first), placement), numbers[first], numbers[second], length[kept])

    def _places_mm(self, which: NestNumbers, time_s: FloatArray) -> FloatArray:
        """Return where cups are at times, shape (n, 3)."""
        cups = self._cups
        return self._cell.planted.shifted_mm(
            cups.true_mm[which], cups.placement[which], cups.clamped_s[which], time_s
        )

    def _read(self, true_mm: FloatArray, time_s: FloatArray, since_s: FloatArray) -> FloatArray:
        """Initialise, then read lengths `since_s` later, shape (n,)."""
        self._initialisation += 1
        cell, n = self._cell, len(true_mm)
        numbers = np.full(n, self._initialisation)
        shown = true_mm + cell.planted.length_errors_mm(true_mm, numbers, since_s, time_s)
        shown = shown + cell.wild_lengths_mm(time_s)
        if not cell.scenario.noise:
            return shown
        noise = self._setup.noise_mm * self._rng.standard_normal(n)
        return rounded_mm(self._setup, shown + noise + walked_zeros_mm(self._setup, n, self._rng))
