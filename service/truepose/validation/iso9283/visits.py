"""Visits to commanded poses, ISO 9283:1998: means and scatters of them, figures, the cube of five poses.

Means and scatters have the first-order uncertainty that a finite number of visits leaves. A figure that is a
function of the distribution of the visits moves by the mean of its influence function when the visits are
drawn anew; its variance is that of the influence over n (the delta method, which the GUM, JCGM 100:2008,
5.1.2, writes for a function of means). Of values x with mean m and standard deviation S

    mean      influence  x - m,                          u^2 = S^2 / n
    3 S       influence  1.5 ((x - m)^2 / S - S),        u^2 = var(influence) / n,

and of mean + 3 S it is their sum: own derivation, dS = d(S^2) / (2 S).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final, Literal, Self

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray, Table
from truepose.domain.errors import ConfigurationError
from truepose.messages.message import Message, Text, message


@dataclass(frozen=True, slots=True)
class CommandedPose:
    """One of P1 to P5, as the robot was told to take it.

    Attributes
    ----------
    number : int
        From 1.
    position_mm : tuple of float
        In the frame of the readings.
    """

    number: int
    position_mm: tuple[float, float, float]

    @classmethod
    def at(cls, number: int, place_mm: FloatArray) -> Self:
        """Return a pose at a place of shape (3,) [mm]."""
        x, y, z = (float(value) for value in place_mm)
        return cls(number, (x, y, z))

    @property
    def name(self) -> str:
        """The standard's name, e.g. "P1"."""
        return f"P{self.number}"


@dataclass(frozen=True, slots=True)
class Visits(Table):
    """Attained poses, n rows in any order; a visit that was not measured is absent, or NaN.

    Attributes
    ----------
    pose : ndarray of int, shape (n,)
        Number of the commanded pose.
    cycle : ndarray of int, shape (n,)
        From 1.
    position_mm : ndarray, shape (n, 3)
    standard_uncertainty_mm : ndarray, shape (n,)
        Of the instrument, per axis.
    turn_rad : ndarray, shape (n, 3), or None
        From the commanded orientation: about x, y and z (a, b, c).
    rotation_uncertainty_rad : ndarray, shape (n,), or None
        Of the instrument, per axis.

    Raises
    ------
    ConfigurationError
        A pose was measured twice in one cycle.
    """

    pose: IntArray
    cycle: IntArray
    position_mm: FloatArray
    standard_uncertainty_mm: FloatArray
    turn_rad: FloatArray | None = None
    rotation_uncertainty_rad: FloatArray | None = None

    def __len__(self) -> int:
        return int(self.pose.size)

    def __post_init__(self) -> None:
        pose, cycle = self.pose[self.measured], self.cycle[self.measured]
        order = np.lexsort((cycle, pose))
        pose, cycle = pose[order], cycle[order]
        twice = np.flatnonzero((pose[1:] == pose[:-1]) & (cycle[1:] == cycle[:-1]))
        if len(twice):
            first = twice[0]
            raise ConfigurationError(
                f"P{pose[first]} occurs twice in cycle {cycle[first]}. Measure each pose once per cycle."
            )

    @property
    def measured(self) -> BoolArray:
        """Which visits were measured, shape (n,)."""
        read = self.position_mm if self.turn_rad is None else np.hstack([self.position_mm, self.turn_rad])
        return np.asarray(np.isfinite(read).all(axis=1))

    def of_pose(self, number: int) -> "Visits":
        """Return the measured visits of one pose, by cycle."""
        rows = np.flatnonzero((self.pose == number) & self.measured)
        return self.taken(rows[np.argsort(self.cycle[rows], kind="stable")])

    def missing(self, number: int) -> tuple[int, ...]:
        """Return the cycles that one pose lacks, of all that took place, ascending."""
        cycles = np.arange(1, int(self.cycle.max(initial=0)) + 1)
        return tuple(int(cycle) for cycle in np.setdiff1d(cycles, self.of_pose(number).cycle))


def too_few(visits: Visits, number: int, least: int) -> Message | None:
    """Return why a pose was not visited often enough.

    Parameters
    ----------
    visits : Visits
    number : int
        Of the pose.
    least : int
        Visits that are needed.

    Returns
    -------
    Message or None
        None where it was; else with the cycles that lack.
    """
    n = len(visits.of_pose(number))
    if n >= least:
        return None
    missing = _missing(visits.missing(number))
    return message("poses.too_few", pose=f"P{number}", measured=n, missing=missing, least=least)


def _missing(cycles: tuple[int, ...]) -> Text:
    """Return which cycles lack, in words; "" where none does."""
    if not cycles:
        return ""
    if len(cycles) == 1:
        return message("poses.missing_one", cycle=cycles[0])
    return message("poses.missing", cycles=tuple(_runs(cycles)))


def _runs(numbers: tuple[int, ...]) -> Iterator[int | Message]:
    """Yield numbers that stand alone, and runs of them."""
    starts = [k for k, number in enumerate(numbers) if k == 0 or number != numbers[k - 1] + 1]
    for start, end in zip(starts, [*starts[1:], len(numbers)], strict=True):
        first, last = numbers[start], numbers[end - 1]
        yield first if first == last else message("poses.run", first=first, last=last)


# Of three independent normal components of standard deviation 1 (Maxwell): mean and sd of their norm.
_RADIUS_MEAN = 2.0 * np.sqrt(2.0 / np.pi)
_RADIUS_SD = np.sqrt(3.0 - 8.0 / np.pi)
RADIUS_OF_NOISE = float(_RADIUS_MEAN + 3.0 * _RADIUS_SD)  # mean + 3 sd: RP of an instrument alone


def scatter(values: FloatArray) -> float:
    """Return the sample standard deviation of n visits.

    Parameters
    ----------
    values : ndarray, shape (n,)
        n >= 2.

    Returns
    -------
    float
        In their unit; of equal values exactly 0.
    """
    # From the first value: the mean of equal numbers may differ from them in the last digit, and a perfect
    # robot would have a repeatability of rounding.
    return float((values - values[0]).std(ddof=1))


def of_mean(values: FloatArray) -> float:
    """Return the standard uncertainty of a mean of visits, from their own scatter: S / sqrt(n).

    Parameters
    ----------
    values : ndarray, shape (n,)
        n >= 2.

    Returns
    -------
    float
        In their unit.
    """
    return scatter(values) / float(np.sqrt(values.size))


def three_scatters(values: FloatArray) -> tuple[float, float]:
    """Return 3 S of n visits and its standard uncertainty.

    Parameters
    ----------
    values : ndarray, shape (n,)
        n >= 2.

    Returns
    -------
    tuple of float
        In their unit.
    """
    return _with_uncertainty(values, mean_weight=0.0)


def mean_and_three_scatters(values: FloatArray) -> tuple[float, float]:
    """Return mean + 3 S of n visits and its standard uncertainty: RP of their radii (7.2.2).

    Parameters
    ----------
    values : ndarray, shape (n,)
        n >= 2.

    Returns
    -------
    tuple of float
        In their unit.
    """
    return _with_uncertainty(values, mean_weight=1.0)


def _with_uncertainty(values: FloatArray, mean_weight: float) -> tuple[float, float]:
    """Return weight * mean + 3 S and its standard uncertainty, by the influence functions above."""
    s, away = scatter(values), values - values.mean()
    value = mean_weight * float(values.mean()) + 3.0 * s
    if s == 0.0:
        return value, 0.0
    return value, of_mean(mean_weight * away + 1.5 * (away**2 / s - s))


def barycentre(positions_mm: FloatArray) -> FloatArray:
    """Return the mean of visits.

    Parameters
    ----------
    positions_mm : ndarray, shape (n, 3)

    Returns
    -------
    ndarray, shape (3,)
        [mm]; of equal ones exactly what they are.
    """
    return np.asarray(positions_mm[0] + (positions_mm - positions_mm[0]).mean(axis=0))


def barycentre_covariance(positions_mm: FloatArray) -> FloatArray:
    """Return the covariance of the mean of visits, from their own scatter.

    Parameters
    ----------
    positions_mm : ndarray, shape (n, 3)
        n >= 2.

    Returns
    -------
    ndarray, shape (3, 3)
        [mm2].
    """
    return np.asarray(np.cov(positions_mm, rowvar=False)) / len(positions_mm)


def norm_uncertainty(vector: FloatArray, covariance: FloatArray) -> float:
    """Return the standard uncertainty of the length of a vector: u^2 = e^T C e along its direction e.

    Parameters
    ----------
    vector : ndarray, shape (3,)
    covariance : ndarray, shape (3, 3)

    Returns
    -------
    float
        Of no length, that along the worst direction.
    """
    length = float(np.linalg.norm(vector))
    if length == 0.0:
        return float(np.sqrt(np.linalg.norm(covariance, 2)))
    unit = vector / length
    return float(np.sqrt(max(float(unit @ covariance @ unit), 0.0)))


def common(uncertainties: FloatArray) -> float:
    """Return the instrument's uncertainty at one pose: a constant error of it does not average out.

    Parameters
    ----------
    uncertainties : ndarray, shape (n,)
        Of each visit.

    Returns
    -------
    float
        Their root mean square.
    """
    return float(np.sqrt(np.mean(uncertainties**2)))


Symbol = Literal["AP", "RP", "vAP", "AD", "RD", "dAP", "dRP"]
Component = Literal["p", "l", "x", "y", "z", "a", "b", "c"]

CLAUSES: dict[Symbol, str] = {
    "AP": "7.2.1",
    "RP": "7.2.2",
    "vAP": "7.2.3",
    "AD": "7.3",
    "RD": "7.3",
    "dAP": "7.6",
    "dRP": "7.6",
}


@dataclass(frozen=True, slots=True)
class Characteristic:
    """A figure of ISO 9283:1998.

    Accuracies of components have a sign; repeatabilities of angles and distances are half widths (+-).

    Attributes
    ----------
    symbol : str
        "AP", "RP", "vAP", "AD", "RD", "dAP" or "dRP".
    component : str
        p: position; l: radius about the barycentre; x y z; a b c: angles about x y z.
    subject : str
        "P1", or "P2-P4".
    value : float
    standard_uncertainty : float
        Of the value, to first order.
    unit : str
        "mm" or "rad".
    visits : int
    noise : float
        What the instrument's stated scatter alone would show; 0 where it averages out.
    """

    symbol: Symbol
    component: Component
    subject: str
    value: float
    standard_uncertainty: float
    unit: Literal["mm", "rad"]
    visits: int
    noise: float = 0.0

    @property
    def clause(self) -> str:
        """Where the standard defines it."""
        return CLAUSES[self.symbol]


@dataclass(frozen=True, slots=True)
class Missing:
    """A figure that these visits do not give, and why."""

    symbol: Symbol
    subject: str
    reason: Message


@dataclass(frozen=True, slots=True)
class Performance:
    """All figures of a test."""

    characteristics: tuple[Characteristic, ...]
    withheld: tuple[Missing, ...]

    def largest(self, symbol: Symbol, component: Component) -> Characteristic | None:
        """Return the figure of the worst pose, by size.

        Parameters
        ----------
        symbol, component : str

        Returns
        -------
        Characteristic or None
            None where every pose is withheld.
        """
        found = [c for c in self.characteristics if (c.symbol, c.component) == (symbol, component)]
        return max(found, key=lambda figure: abs(figure.value), default=None)

    def joined(self, other: "Performance") -> "Performance":
        """Return the figures of both."""
        return Performance(self.characteristics + other.characteristics, self.withheld + other.withheld)


_DIAGONAL: Final = 0.80  # of that of the cube: P2 to P4, P3 to P5
_OFF: Final = 0.04  # of the diagonal; P2 to P5 may be 0.08 to 0.12 of it away from the corners


@dataclass(frozen=True, slots=True)
class FoundCube:
    """A cube found by the commanded poses, in the frame of the readings."""

    edge_mm: float
    centre_mm: tuple[float, float, float]


def cube_of(commanded: Sequence[CommandedPose]) -> FoundCube | None:
    """Return the cube in whose diagonal plane P1 to P5 lie.

    The sides of their rectangle are 0.8 of an edge and of a diagonal of a face. How the cube is turned does
    not matter: the frame of the readings need not be the base.

    Parameters
    ----------
    commanded : sequence of CommandedPose

    Returns
    -------
    FoundCube or None
        None where they lie otherwise, or are not the five.

    References
    ----------
    ISO 9283:1998, 6.8.
    """
    places = {pose.number: np.array(pose.position_mm) for pose in commanded}
    if set(places) != {1, 2, 3, 4, 5}:
        return None
    diagonals = [float(np.linalg.norm(places[a] - places[b])) for a, b in ((2, 4), (3, 5))]
    edge_mm = float(np.mean(diagonals)) / (_DIAGONAL * np.sqrt(3.0))
    sides = [float(np.linalg.norm(places[a] - places[b])) for a, b in ((2, 3), (4, 5), (3, 4), (5, 2))]
    wanted = _DIAGONAL * edge_mm * np.sqrt([1.0, 1.0, 2.0, 2.0])
    middle = np.mean([places[number] for number in (2, 3, 4, 5)], axis=0)
    off = [*np.abs(np.sort(sides) - wanted), np.ptp(diagonals), np.linalg.norm(places[1] - middle)]
    # The standard lets each pose lie 0.02 of the diagonal nearer to its corner or farther from it, so that a
    # length between two of them may be off by twice that.
    if max(off) > _OFF * edge_mm * np.sqrt(3.0):
        return None
    x, y, z = (float(value) for value in places[1])
    return FoundCube(edge_mm, (x, y, z))
