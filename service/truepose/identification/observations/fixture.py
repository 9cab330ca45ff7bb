"""What ties the base cups of a ballbar together: sides of triangles, and cups clamped on the robot's ball.

The sides are lengths between two cups, or between two tool nests, measured with the ballbar that measures
the legs. A cup was clamped on the ball in tool nest 1 while the robot held it: its place, of the fixture as
it then stood, is where the robot was. Together they fix the frame that lengths alone leave open.

With cups b_i (parameters), tool nests x_k in the flange frame, x what effects add to a length
and p where the ball was held,

    side = |b_j - b_i| + x, or |x_l - x_k| + x        0 = b_i - p, three coordinates

No arm is in a side: whatever a model of it lacks, a side does not (docs/decisions/0017).

Source of the procedure: A. Nubiola, thesis, 2014, sections 3.5 and 4.1.
"""

from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.campaign import CupSetups, FixtureLengths, Stops
from truepose.domain.robot import Robot
from truepose.effects.ports import PortKind
from truepose.identification.model.derivatives import excess_mm, position_jacobian
from truepose.identification.model.evaluation import State, Targets, nest_centres
from truepose.identification.model.structure import Structure, anchor_places, first_anchor
from truepose.identification.observations.blocks import BlockResult, IndependentReadings
from truepose.kinematics.frames import directions

TOOL_PLACEMENT = 0  # number of the placement that stands for the tool
BALL_NEST = 1  # tool nest that holds the setting ball
Anchors = tuple[tuple[int, int], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class SideBlock(IndependentReadings):
    """Measured sides; a point is an anchor of the structure, or a tool nest counted on after the anchors.

    The targets are no stops of the arm: joints 0, configurations of their own.

    Attributes
    ----------
    points : ndarray of int, shape (n, 2)
        That each side joins.
    length_mm : ndarray, shape (n,)
    """

    quantity: ClassVar[str] = "length"
    table: ClassVar[str] = "fixture"
    components: ClassVar[int] = 1
    of_arm: ClassVar[bool] = False

    points: IntArray
    length_mm: FloatArray

    def result(self, structure: Structure, values: FloatArray, previous: BlockResult | None) -> BlockResult:
        """Return residuals and derivatives, parameters as of `Block.result`.

        Returns
        -------
        BlockResult
            Residual (n, 1) [mm]: measured side minus distance of its ends and what is read too much.
        """
        state = self.evaluated(structure, values, previous)
        distance = np.linalg.norm(self._joined(state), axis=1)
        residual = (self.length_mm - distance - excess_mm(state))[:, None]
        return BlockResult(residual, self.differentiated(state), state, self.whitening())

    def derivatives(self, state: State) -> FloatArray:
        """Return the changes of the predicted sides.

        Parameters
        ----------
        state : State

        Returns
        -------
        ndarray, shape (P, n, 1)
            mm per internal unit: of anchors, of tool nests, of what is read too
            much.
        """
        # Unknown nests may begin at one place: their side has no direction there, and must not divide by 0.
        direction, _ = directions(self._joined(state))
        first, n_anchors = first_anchor(state.structure), len(state.structure.anchors)
        rows = np.arange(len(direction))
        jacobian = np.zeros((len(state.structure.names), len(direction)))
        for end, sign in ((0, -1.0), (1, 1.0)):
            base = self.points[:, end] < n_anchors
            for component in range(3):
                parameter = first + 3 * self.points[base, end] + component
                jacobian[parameter, rows[base]] += sign * direction[base, component]
        for term in state.terms:
            # Tool nests move within their certificates, which their measured sides tell better.
            if term.port.kind is PortKind.NEST:
                nest, component = divmod(term.port.number, 3)
                # A side runs from its first end to its second: what moves the first one shortens it.
                moves = (self.points == n_anchors + nest).astype(float) @ np.array([-1.0, 1.0])
                jacobian[term.parameter] += term.weight * moves * direction[:, component]
            elif term.port.kind is PortKind.LENGTH:
                jacobian[term.parameter] += term.weight
        return jacobian[:, :, None]

    def _joined(self, state: State) -> FloatArray:
        """Return the vector from the first to the second end of each side, shape (n, 3)."""
        # Of the placement as it was when its cups were clamped: fixtures move later, and take whole triangles
        # along.
        anchors = anchor_places(state.structure, state.values)
        points = np.concatenate([anchors, nest_centres(state.structure, state.moved)])
        return np.asarray(points[self.points[:, 1]] - points[self.points[:, 0]])

    def own_discrepancy(self) -> float | None:
        """Return none: sides are as good as they are stated to be."""
        return 0.0

    def weighted(self, weights: FloatArray, discrepancy: float) -> Self:
        """Return the block with other weights; no model of an arm is in it that could lack something."""
        return replace(self, weights=weights)


@dataclass(frozen=True, slots=True, kw_only=True)
class ClampBlock(IndependentReadings):
    """Cups that were clamped on the ball which the robot held: three coordinates each.

    The uncertainty is of cup against ball and of the arm's stop: each cup is clamped at a stop of its own,
    which shares its configuration with no other.

    Attributes
    ----------
    anchor : ndarray of int, shape (n,)
        Index in the structure's anchors.
    """

    quantity: ClassVar[str] = "position"
    table: ClassVar[str] = "setup"
    components: ClassVar[int] = 3

    anchor: IntArray

    def result(self, structure: Structure, values: FloatArray, previous: BlockResult | None) -> BlockResult:
        """Return how far each cup is from the ball, and derivatives; parameters as of `Block.result`.

        Returns
        -------
        BlockResult
            Residual (n, 3) [mm]: cup minus ball, world frame.
        """
        state = self.evaluated(structure, values, previous)
        # Where the ball was is what the model says of the arm; where the cup is, its own parameters.
        residual = anchor_places(structure, values)[self.anchor] - state.position_mm
        return BlockResult(residual, self.differentiated(state), state, self.whitening())

    def derivatives(self, state: State) -> FloatArray:
        """Return the motions of the ball away from the cups.

        Parameters
        ----------
        state : State
            At n set-ups.

        Returns
        -------
        ndarray, shape (P, n, 3)
            mm per internal unit; -1 for the cup itself, which the residual holds with the opposite sign.
        """
        jacobian = position_jacobian(state)
        first, rows = first_anchor(state.structure), np.arange(len(self.anchor))
        for component in range(3):
            jacobian[first + 3 * self.anchor + component, rows, component] -= 1.0
        return jacobian


def side_block(fixture: FixtureLengths, anchors: Anchors, nests: int, robot: Robot) -> SideBlock | None:
    """Return the sides between points that legs were measured from or to; None where there is none.

    Parameters
    ----------
    fixture : FixtureLengths
    anchors : tuple of (placement, base point)
        Of the structure.
    nests : int
        Number of tool nests.
    robot : Robot
    """
    every = range(len(fixture.placement))
    ends = np.array([[_point(fixture, row, end, anchors, nests) for end in "ab"] for row in every])
    ends = ends.reshape(-1, 2)
    # A cup without legs is no parameter: a side to it says nothing of the others.
    rows = np.flatnonzero((ends >= 0).all(axis=1))
    if rows.size == 0:
        return None
    length = fixture.length_mm[rows]
    # Numbers that no configuration of a campaign has: no fold leaves a side out, no stop shares with it.
    stops = Stops(-1 - np.arange(len(rows)), np.zeros((len(rows), robot.n_joints)))
    targets = Targets(stops, np.ones(len(rows), dtype=np.int64), length_mm=length)
    return SideBlock(
        targets=targets,
        points=ends[rows],
        length_mm=length,
        uncertainty=fixture.standard_uncertainty_mm[rows],
        weights=np.ones(len(rows)),
    )


def _point(fixture: FixtureLengths, row: int, end: str, anchors: Anchors, nests: int) -> int:
    """Return the number of a point as `SideBlock` counts them, -1 for one that has no legs."""
    placement = int(fixture.placement[row])
    number = int((fixture.point_a if end == "a" else fixture.point_b)[row])
    # Tool nests have a place whether legs were read from them or not.
    if placement == TOOL_PLACEMENT:
        return len(anchors) + number - 1 if number <= nests else -1
    return anchors.index((placement, number)) if (placement, number) in anchors else -1


def clamp_block(setup: CupSetups, anchors: Anchors, uncertainty_mm: float) -> ClampBlock | None:
    """Return the clamped cups that legs were measured from; None where there is none.

    Parameters
    ----------
    setup : CupSetups
    anchors : tuple of (placement, base point)
        Of the structure.
    uncertainty_mm : float
        Of a cup against the place that the robot was sent to, per axis.
    """
    pairs = list(zip(setup.placement.tolist(), setup.base_point.tolist(), strict=True))
    rows = [row for row, pair in enumerate(pairs) if pair in anchors]
    if not rows:
        return None
    numbers = -1 - 10_000 - np.arange(len(rows))  # apart from those of the sides
    targets = Targets(Stops(numbers, setup.joints_rad[rows]), np.full(len(rows), BALL_NEST))
    index = np.array([anchors.index(pairs[row]) for row in rows])
    return ClampBlock(
        targets=targets,
        anchor=index,
        uncertainty=np.full(len(rows), uncertainty_mm),
        weights=np.ones(len(rows)),
    )
