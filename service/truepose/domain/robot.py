"""The robot as its maker describes it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray

_FEWEST_NESTS: Final = 3  # fixed ones that place a frame
_LEAST_HEIGHT_MM: Final = 50.0  # of a triangle of fixed nests; below it they are as good as on a line


@dataclass(frozen=True, slots=True)
class JointRow:
    """One row of a DH-Modified table (Craig): RotX(alpha) TransX(a) RotZ(sign*q + theta_offset) TransZ(d).

    Makers' tables have no beta, RotY(beta) before RotZ (Hayati). Tables from other descriptions need it where
    axes are nearly parallel: their common normal may lie kilometres away (docs/decisions/0042).

    Attributes
    ----------
    alpha_rad, theta_offset_rad, beta_rad : float
    a_mm, d_mm : float
    sign : int
        -1 where the controller counts the joint against its z axis.
    """

    alpha_rad: float
    a_mm: float
    theta_offset_rad: float
    d_mm: float
    sign: int = 1
    beta_rad: float = 0.0


@dataclass(frozen=True, slots=True)
class LinkMass:
    """A mass fixed in the frame of one joint (1-based); the flange frame carries the tool.

    Attributes
    ----------
    frame : int
    mass_kg : float
    centre_of_gravity_mm : tuple of float
        In that frame. What a frame carries of its neighbours is written to it as well: the thesis puts link 3
        into frame 4.
    """

    frame: int
    mass_kg: float
    centre_of_gravity_mm: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class JointRange:
    """Closed interval of one joint angle."""

    lower_rad: float
    upper_rad: float


@dataclass(frozen=True, slots=True)
class Robot:
    """The nominal robot: any number of revolute joints in series.

    Attributes
    ----------
    name : str
    joints : tuple of JointRow
    masses : tuple of LinkMass
        Empty: they are unknown, and springs are seen as products with them only.
    gear_ratios : tuple of float, or None
        Turns of the motor per turn of each joint; None: the maker does not tell.
    typical_compliances_rad_per_n_mm : tuple of float, or None
        Of gearboxes of that kind: mean and width of the springs' priors.
    repeatability_mm : float
        Standard deviation of the arm itself, per axis.
    calibration_ranges : tuple of JointRange, or None
        Where configurations are chosen.
    rated_payload_kg : float or None
    source : str
        Where the table is from.
    joint_limits : tuple of JointRange, or None
        Of the controller; None: unknown.
    """

    name: str
    joints: tuple[JointRow, ...]
    masses: tuple[LinkMass, ...] = ()
    gear_ratios: tuple[float, ...] | None = None
    # Springs of which data see little would else be held at nothing, and the arm would be foretold to hang
    # too high.
    typical_compliances_rad_per_n_mm: tuple[float, ...] | None = None
    repeatability_mm: float = 0.0  # standard deviation of the arm itself, per axis
    calibration_ranges: tuple[JointRange, ...] | None = None
    rated_payload_kg: float | None = None
    source: str = ""
    joint_limits: tuple[JointRange, ...] | None = None  # of the controller; None: unknown

    @property
    def n_joints(self) -> int:
        """Number of joints."""
        return len(self.joints)

    @property
    def table(self) -> FloatArray:
        """What the rows say, shape (J, 6): alpha, a, theta offset, d, beta, sign; rad and mm."""
        return np.array([
            (row.alpha_rad, row.a_mm, row.theta_offset_rad, row.d_mm, row.beta_rad, row.sign)
            for row in self.joints
        ])


@dataclass(frozen=True, slots=True)
class FramePlacement:
    """A frame placed in another: Trans(x, y, z) RotX RotY RotZ, in that order."""

    x_mm: float = 0.0
    y_mm: float = 0.0
    z_mm: float = 0.0
    rx_rad: float = 0.0
    ry_rad: float = 0.0
    rz_rad: float = 0.0


@dataclass(frozen=True, slots=True)
class Nest:
    """A tool nest in the frame of the last joint; `None` where it must be found from the data."""

    centre_mm: tuple[float, float, float] | None
    standard_uncertainty_mm: float | None = None
    # Unit vector its reflector faces; None: seen from everywhere.
    facing: tuple[float, float, float] | None = None


@dataclass(frozen=True, slots=True)
class FixedNest:
    """A nest on the table, certified in the world frame."""

    centre_mm: tuple[float, float, float]
    standard_uncertainty_mm: float


def span_triangle(nests: Sequence[FixedNest]) -> bool:
    """Say whether fixed nests place a frame: three or more that do not lie on a line, nor nearly.

    By the second singular value of the centred points: of a flat triangle about 0.8 of its height.

    Parameters
    ----------
    nests : sequence of FixedNest
    """
    if len(nests) < _FEWEST_NESTS:
        return False
    points = np.array([nest.centre_mm for nest in nests])
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(spread[1] >= _LEAST_HEIGHT_MM)


@dataclass(frozen=True, slots=True)
class WorldRegistration:
    """How well the frame of the readings sits in the world: covariance of a small motion about its origin.

    Attributes
    ----------
    covariance : ndarray, shape (6, 6)
        Translation [mm], then rotation vector [rad].
    """

    covariance: FloatArray  # (6, 6): translation [mm], rotation vector [rad]
