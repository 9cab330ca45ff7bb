"""The arm as a ballbar session sees it: its parameters at the nominal robot, and how readings scatter."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.campaign import Campaign, PointReadings, Stops
from truepose.domain.robot import Nest
from truepose.effects.frames.tool_certificate import NAME as TOOL_CERTIFICATE
from truepose.effects.frames.tool_certificate import certificate_specs
from truepose.effects.ports import Trait
from truepose.effects.registry import effects_with
from truepose.identification.model.derivatives import position_jacobian
from truepose.identification.model.evaluation import Targets, evaluate
from truepose.identification.model.structure import Structure
from truepose.identification.problem.build import automatic_effects, build
from truepose.planning.ballbar.bodies import BallbarCell

_MEAN_OF_SIX: Final = 3.5  # of the numbers of a pose's readings


@dataclass(frozen=True, slots=True)
class Scatter:
    """Standard deviations of what a session reads [mm]."""

    # Of the nests at a stop, per axis: the arm's own scatter (0.0035 for arms of this size) and what no model
    # of it contains (up to 0.1). The second is not known beforehand; this is between the two.
    stop_mm: float = 0.015
    leg_mm: float = 0.0016  # of one length: ballbar and its zero
    setup_mm: float = 0.01  # of a clamped cup, per axis
    side_mm: float = 0.0016
    # Of both lengths, the zero: RMS over six readings after an initialisation. It walks with every snap of
    # the magnets, so that readings share it, and the first ones are better than the last.
    zero_mm: float = 0.0

    def walked_mm2(self, lines: int) -> FloatArray:
        """Return the covariance of the zeros of so many readings after one initialisation.

        A random walk, cov(z_i, z_j) = z^2 min(i, j) / 3.5, i and j from 1: the mean of its variances over six
        readings is z^2, which is what `zero_mm` states.

        Parameters
        ----------
        lines : int
            L readings.

        Returns
        -------
        ndarray, shape (L, L)
            [mm2].

        References
        ----------
        Thesis of A. Nubiola, 2014, sections 3.2 and 3.5 (snaps of the magnets add up to 0.003 mm); the walk:
        own model.
        """
        number = np.arange(1.0, lines + 1.0)
        return np.asarray(self.zero_mm**2 * np.minimum.outer(number, number) / _MEAN_OF_SIX)


@dataclass(frozen=True, slots=True)
class ArmModel:
    """The parameters of the arm at the nominal robot.

    Attributes
    ----------
    cell : BallbarCell
    structure : Structure
        Without a base; certified nests last.
    scatter : Scatter
    erring : bool
        Rows are of readings as they err, not as an identification weighs them.
    """

    cell: BallbarCell
    structure: Structure
    scatter: Scatter
    erring: bool = False

    @property
    def parameters(self) -> int:
        """Number of the arm's parameters, those of certified nests included."""
        return len(self.structure.specs)

    @property
    def own_parameters(self) -> int:
        """Number of the arm's parameters alone, which come first."""
        return sum(owner != TOOL_CERTIFICATE for owner in self.structure.owners)

    def nests(self, joints_rad: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the tool nests at configurations, and how they move.

        Parameters
        ----------
        joints_rad : ndarray, shape (n, J)

        Returns
        -------
        position : ndarray, shape (n, 3, 3)
            Of nests 1 to 3 [mm, world].
        motion : ndarray, shape (n, 3, 3, P)
            Per prior width of each parameter [mm].
        """
        n = len(joints_rad)
        stops = Stops(config=np.repeat(np.arange(1, n + 1), 3), joints_rad=np.repeat(joints_rad, 3, axis=0))
        nest = np.tile(np.array([1, 2, 3], dtype=np.int64), n)
        state = evaluate(self.structure, np.zeros(self.parameters), Targets(stops, nest))
        motion = np.moveaxis(position_jacobian(state), 0, -1) * self.structure.prior_widths
        return state.position_mm.reshape(n, 3, 3), motion.reshape(n, 3, 3, self.parameters)


def arm_model(
    cell: BallbarCell, scatter: Scatter | None = None, certified_mm: Sequence[float] = ()
) -> ArmModel:
    """Return the arm with geometry, and compliances where its masses are known.

    Parameters
    ----------
    cell : BallbarCell
    scatter : Scatter, optional
    certified_mm : sequence of float
        How uncertain each of the tool nests is per axis; empty: they are exact.

    Returns
    -------
    ArmModel
    """
    # One reading that says nothing: effects ask a campaign what it shows.
    readings = PointReadings(
        Stops(np.array([1]), np.zeros((1, cell.robot.n_joints))),
        np.array([1]),
        np.zeros((1, 3)),
        np.ones(1),
    )
    # Exact here: what certificates allow comes back below as parameters of its own, since lengths of the
    # measured triangle tell of it.
    nests = tuple(Nest((float(x), float(y), float(z)), 0.0) for x, y, z in cell.nests_mm)
    campaign = Campaign(cell.robot, cell.base, nests, calibration=readings)
    placing = effects_with(Trait.PLACING)
    # What places the arm is left out: lengths to cups that the arm itself placed do not see where its
    # base stands.
    effects = tuple(effect for effect in automatic_effects(campaign) if effect not in placing)
    structure, uncertain = build(campaign, effects).structure, dict(enumerate(certified_mm, start=1))
    nest_specs = certificate_specs(uncertain)
    if nest_specs:
        structure = structure.extended(TOOL_CERTIFICATE, nest_specs)
    return ArmModel(cell, structure, scatter or Scatter())
