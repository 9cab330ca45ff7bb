"""Lengths between cups and nests as far as they are linear in what is unknown of arm, cups and tool."""

from dataclasses import dataclass
from typing import Final

from truepose.domain.arrays import FloatArray
from truepose.domain.measurement.ballbar import Leg

TOLD_APART: Final = 3.0  # standard uncertainties by which two lengths must differ for a swap to be seen


@dataclass(frozen=True, slots=True, eq=False)
class StopLengths:
    """Lengths at one stop of the arm, or between cups: length = nominal + slope x + motion m."""

    pairs: tuple[Leg, ...]  # p of them; cup and nest, or cup and cup
    nominal_mm: FloatArray  # (p,) of the nominal arm with its cups where it holds the ball
    slope: FloatArray  # (p, S) per unit of what is unknown of the session
    motion: FloatArray  # (p, 6) per mm of a shift of the tool, and of a turn at a lever; 0 between cups


@dataclass(frozen=True, slots=True, eq=False)
class ArmKind:
    """How far off an arm may be: one of several suppositions, of which the readings tell the likeliest."""

    share: float  # of all arms
    mean: FloatArray  # (S,) of what is unknown, in the units of the slopes
    covariance: FloatArray  # (S, S)
    motion_mm: float  # by which the tool comes to rest elsewhere at each stop than a model says, per axis
