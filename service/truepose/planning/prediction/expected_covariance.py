r"""What readings of positions will tell of an arm, and what is then still wrong with its predictions.

In the widths of the priors the parameters have the information

    M = I + sum over readings of J~' J~          J~ = J / sigma,   sigma^2 = reading^2 + scatter^2 + lack^2

and what is held at a certificate (tool nests, registration of the world) enters them with the gain K = M^-1
sum J~' H / sigma, H what a standard uncertainty of each does to the readings (consider parameters, as in
`identification.fit.assessment`). With G the motion of a place per parameter and S what the certificates do to
the place itself, a prediction is wrong by

    e = G M^-1/2 z_1 + (G K - S) z_2

The root M^-1/2 comes from an orthogonal transformation of J~, without M: the information squares how much
better readings know one parameter than another, and of what they do not show rounding would leave nothing of
the priors. All derivatives are taken at the nominal robot: errors of some 0.1 % of the lengths change them by
as much.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.campaign import Campaign, Stops
from truepose.domain.errors import ConfigurationError
from truepose.domain.identification import NotIdentifiable
from truepose.domain.robot import FixedNest, Nest, span_triangle
from truepose.effects.frames.tool_certificate import moves
from truepose.effects.ports import Setting
from truepose.identification.model.derivatives import position_jacobian, rotation_jacobian
from truepose.identification.model.evaluation import State, Targets, evaluate
from truepose.identification.model.structure import Structure
from truepose.identification.problem.build import (
    JointPrior,
    automatic_effects,
    build,
    precision_of,
    with_belief,
)
from truepose.identification.verdict.identifiability import undetermined_by_configurations
from truepose.kinematics.frames import cross_matrix
from truepose.messages.message import message
from truepose.planning.prediction.errors import NONE, Discrepancy
from truepose.planning.tracker.plans import nominal_campaign
from truepose.planning.workspace.candidates import Candidates
from truepose.planning.workspace.space import WorkSpace

_M_PER_MM = 1e-3
LEAST_MM: Final = 1e-9  # nothing is read better: positions of metres are rounded by as much


@dataclass(frozen=True, slots=True)
class TrackerAccuracy:
    """Standard deviations of one reading, along the beam and across it: constant, and growing with distance.

    The defaults are typical of laser trackers. The thesis found 0.022 mm on a bar of 2.3 m at 2 m (A.
    Nubiola, 2014, section 2.2), which is two readings.
    """

    along_mm: float = 0.008
    along_mm_per_m: float = 0.0008
    across_mm: float = 0.010
    across_mm_per_m: float = 0.0035

    def covariance_mm2(self, beam_mm: FloatArray) -> FloatArray:
        """Return the covariance of one reading at the end of each beam: a^2 b b' + c^2 (I - b b').

        b is the unit vector along the beam; a along it and c across grow with its length in metres. Where a
        beam is NaN, or has no length, nobody knows whence it comes: b b' is I / 3, the mean over directions,
        at no distance.

        Parameters
        ----------
        beam_mm : ndarray, shape (n, 3)
            From the tracker to the nest.

        Returns
        -------
        ndarray, shape (n, 3, 3)
            [mm2].
        """
        distance = np.linalg.norm(beam_mm, axis=1)
        known = distance > 0.0
        metres = np.where(known, distance, 0.0)[:, None, None] * _M_PER_MM
        along = (self.along_mm + self.along_mm_per_m * metres) ** 2
        across = (self.across_mm + self.across_mm_per_m * metres) ** 2
        way = beam_mm[known] / distance[known, None]
        projector = np.broadcast_to(np.eye(3) / 3.0, (len(beam_mm), 3, 3)).copy()
        projector[known] = way[:, :, None] * way[:, None, :]
        return np.asarray(along * projector + across * (np.eye(3) - projector))


TYPICAL: Final = TrackerAccuracy()


def uniform_accuracy(per_axis_mm: float) -> TrackerAccuracy:
    """Return the accuracy of an instrument that reads equally well everywhere, along every axis.

    Parameters
    ----------
    per_axis_mm : float
        Standard uncertainty of a reading per axis.

    Returns
    -------
    TrackerAccuracy
    """
    return TrackerAccuracy(per_axis_mm, 0.0, per_axis_mm, 0.0)


def covariance_root(rows: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return W with W W' = (J'J)^-1, and J W.

    By J = Q R: W = R^-1 and J W = Q, signs taken so that the diagonal of R is positive. J'J itself is not
    formed, as it squares the ratio of the best known parameter to the worst.

    Parameters
    ----------
    rows : ndarray, shape (m, P)
        J: whitened derivatives of priors and readings, of full rank.

    Returns
    -------
    root : ndarray, shape (P, P)
        Upper triangular, positive on its diagonal: the transposed inverse of Cholesky's factor.
    turned : ndarray, shape (m, P)
        Orthonormal columns.

    Raises
    ------
    numpy.linalg.LinAlgError
        J is not of full rank.

    References
    ----------
    G. H. Golub, C. F. Van Loan, Matrix Computations, 4th edition, 2013, section 5.3.
    """
    turned, triangle = np.linalg.qr(rows)
    # QR leaves the signs open; with a positive diagonal there is one root only.
    side = np.where(np.diag(triangle) < 0.0, -1.0, 1.0)
    return np.linalg.inv(triangle) * side, turned * side


_REGISTRATION_READINGS: Final = 20  # of each fixed nest, as sessions do
_PLACE_A_FRAME: Final = 3  # nests
_MOVED_RAD: Final = np.deg2rad(0.5)  # a joint that stays within this has not moved


@dataclass(frozen=True, slots=True)
class PriorKnowledge:
    """What is known beforehand of arm, artefacts and instrument, beside the work space."""

    accuracy: TrackerAccuracy = TYPICAL
    fixed_nests: tuple[FixedNest, ...] = ()  # none: positions count in the frame of the readings
    discrepancy: Discrepancy = NONE
    nests: tuple[Nest, ...] | None = None  # as certified; None: those of the work space
    base_known: bool = True  # roughly; else it is found from the readings
    believed: JointPrior | None = None  # of the arm's parameters together, as robots of its type tell it

    def believing(self, belief: JointPrior) -> "PriorKnowledge":
        """Return the same with what is believed of the arm."""
        return replace(self, believed=belief)


@dataclass(frozen=True, slots=True)
class PlacesSeen:
    """Nests at n configurations and what moves them."""

    motion: FloatArray  # (n, 3, P) per prior width of each parameter [mm]
    certified: FloatArray  # (n, 3, 3 K) per standard uncertainty of each certified coordinate [mm]
    position_mm: FloatArray  # (n, 3)


@dataclass(frozen=True, slots=True)
class ReadingInformation:
    """What readings at n configurations tell, whitened.

    Attributes
    ----------
    rows : ndarray, shape (n, 3, P), of poses (n, 6, P)
        J / sigma per prior width [1].
    held : ndarray, shape (n, 3 or 6, H)
        Per standard uncertainty of what certificates hold [1]: first the coordinates of certified nests, then
        the registration of the world.
    """

    rows: FloatArray
    held: FloatArray


class ArmKnowledge:
    """The parameters of an arm, and what readings tell of them; all derivatives at the nominal robot.

    Parameters
    ----------
    space : WorkSpace
    candidates : Candidates
        Configurations that the effects are chosen by: what they show.
    knowns : PriorKnowledge

    Raises
    ------
    ConfigurationError
        Fixed nests lie on a line, or a belief is of parameters that are none of this arm.
    """

    def __init__(self, space: WorkSpace, candidates: Candidates, knowns: PriorKnowledge) -> None:
        campaign = _as_known(nominal_campaign(space, candidates), knowns)
        problem = build(campaign, automatic_effects(campaign))
        problem = problem if knowns.believed is None else with_belief(problem, knowns.believed)
        self.structure: Structure = problem.structure
        self._start = problem.start
        self._setting: Setting = problem.setting
        # A nest is held only where its centre is certified and not a parameter: then readings cannot
        # correct it, and the certificate's error goes through to the end.
        self._held = {
            number: nest.standard_uncertainty_mm
            for number, nest in enumerate(campaign.nests, start=1)
            if nest.centre_mm is not None
            and nest.standard_uncertainty_mm
            and not moves(number, self.structure.names)
        }
        self._rotation_u_rad = None if space.camera is None else space.camera.rotation_u_rad
        self._knowns = knowns
        self._tracker_mm = np.array(space.tracker_position_mm or (np.nan,) * 3)
        self._scatter_mm = float(np.hypot(space.robot.repeatability_mm, knowns.discrepancy.per_axis_mm))
        self._frame = self._registration()

    @property
    def repeatability_mm(self) -> float:
        """Scatter of the arm per axis."""
        return self.structure.robot.repeatability_mm

    @property
    def discrepancy(self) -> Discrepancy:
        """What the parameters cannot express."""
        return self._knowns.discrepancy

    def places(self, joints_rad: FloatArray, nest: IntArray) -> PlacesSeen:
        """Return nests at configurations, and what moves them.

        Parameters
        ----------
        joints_rad : ndarray, shape (n, J)
        nest : ndarray, shape (n,)
            1-based.

        Returns
        -------
        PlacesSeen
        """
        state = self._state(joints_rad, nest)
        motion = np.moveaxis(position_jacobian(state), 0, -1) * self.structure.prior_widths
        return PlacesSeen(motion, self._certified(state), state.position_mm)

    def told(self, joints_rad: FloatArray, nest: IntArray) -> ReadingInformation:
        """Return what a reading at each of n configurations tells.

        sigma^2 = reading^2 + scatter^2 + lack^2, of the reading the mean over the three axes.

        Parameters
        ----------
        joints_rad : ndarray, shape (n, J)
        nest : ndarray, shape (n,)
            1-based.

        Returns
        -------
        ReadingInformation
        """
        seen = self.places(joints_rad, nest)
        variance = self._per_axis_mm2(seen.position_mm) + self._scatter_mm**2
        # One number a reading, as most files state it and an identification then weighs it: full
        # covariances would promise some 5 % less error (docs/decisions/0043).
        sigma = np.maximum(np.sqrt(variance), LEAST_MM)[:, None, None]
        frame = _rigid_motion(seen.position_mm) @ self._frame
        points = ReadingInformation(
            seen.motion / sigma, np.concatenate([seen.certified, frame], axis=2) / sigma
        )
        return (
            points
            if self._rotation_u_rad is None
            else self._with_turns(points, self._state(joints_rad, nest), self._rotation_u_rad)
        )

    def _with_turns(self, points: ReadingInformation, state: State, u_rad: float) -> ReadingInformation:
        """Return what poses tell: of their orientations no certificate of a place says anything."""
        rows = np.moveaxis(rotation_jacobian(state), 0, -1) * self.structure.prior_widths / u_rad
        held = np.zeros((*rows.shape[:2], points.held.shape[2]))
        return ReadingInformation(
            np.concatenate([points.rows, rows], axis=1), np.concatenate([points.held, held], axis=1)
        )

    def _state(self, joints_rad: FloatArray, nest: IntArray) -> State:
        stops = Stops(config=np.arange(1, len(nest) + 1), joints_rad=joints_rad)
        return evaluate(self.structure, self._start, Targets(stops, nest))

    def prior(self) -> FloatArray:
        """Return the information before any reading, shape (P, P), per prior width: I without a belief."""
        return precision_of(self.structure, self._knowns.believed)

    def errors(self, told: ReadingInformation, seen: PlacesSeen) -> FloatArray:
        """Return the errors of predicted places after readings, [G M^-1/2, G K - S].

        K = M^-1 sum J~' H / sigma is the gain of what certificates hold; with M^-1/2 = W and J~ W = Q it is W
        Q' H / sigma.

        Parameters
        ----------
        told : ReadingInformation
            Of all readings.
        seen : PlacesSeen
            m places.

        Returns
        -------
        ndarray, shape (m, 3, P + H)
            What a standard deviation of each of P + H independent causes does [mm].
        """
        rows, held = (np.concatenate(list(part)) for part in (told.rows, told.held))
        prior = self._prior_rows()
        root, turned = covariance_root(np.concatenate([prior, rows]))
        gain = root @ (turned[len(prior) :].T @ held)
        own = np.zeros((*seen.certified.shape[:2], held.shape[1]))
        # A registration moves no place of the arm in its own base: only readings, and by these the
        # parameters. A nest off its certificate moves the place as well.
        own[..., : seen.certified.shape[2]] = seen.certified
        return np.concatenate([seen.motion @ root, seen.motion @ gain - own], axis=2)

    def left_open(self, told: ReadingInformation, joints_rad: FloatArray) -> tuple[NotIdentifiable, ...]:
        """Return what readings at configurations would leave open; nothing where they tell it all.

        Parameters
        ----------
        told : ReadingInformation
            Of all readings.
        joints_rad : ndarray, shape (n, J)
            At least one: a joint that never moves is a reason of its own.

        Returns
        -------
        tuple of NotIdentifiable
        """
        rows = told.rows.reshape(-1, told.rows.shape[2])
        widths = self.structure.prior_widths
        covariance = self.covariance(rows) * np.outer(widths, widths)
        moved = np.ptp(joints_rad, axis=0) > _MOVED_RAD
        return undetermined_by_configurations(self.structure, covariance, rows.T / widths[:, None], moved)

    def covariance(self, rows: FloatArray) -> FloatArray:
        """Return the covariance of the parameters after readings, M^-1.

        Parameters
        ----------
        rows : ndarray, shape (m, P)
            Whitened derivatives per prior width; none: that of the priors.

        Returns
        -------
        ndarray, shape (P, P)
            Per prior width, squared.
        """
        root, _ = covariance_root(np.concatenate([self._prior_rows(), rows]))
        return np.asarray(root @ root.T)

    def _prior_rows(self) -> FloatArray:
        return np.asarray(np.linalg.cholesky(self.prior()).T)

    def reading_mm(self, joints_rad: FloatArray, nest: IntArray) -> float:
        """Return the standard uncertainty of readings at configurations, RMS over all and over the axes.

        Parameters
        ----------
        joints_rad : ndarray, shape (n, J)
        nest : ndarray, shape (n,)
            1-based.

        Returns
        -------
        float
            [mm].
        """
        return float(np.sqrt(self._per_axis_mm2(self.places(joints_rad, nest).position_mm).mean()))

    def _per_axis_mm2(self, places_mm: FloatArray) -> FloatArray:
        """Return the variance of readings, mean of the three axes: what most files state of each."""
        return np.asarray(np.trace(self._reading_mm2(places_mm), axis1=1, axis2=2) / 3.0)

    def _reading_mm2(self, places_mm: FloatArray) -> FloatArray:
        return self._knowns.accuracy.covariance_mm2(places_mm - self._tracker_mm)

    def _certified(self, state: State) -> FloatArray:
        last = state.chain.end_rotation
        each = [
            np.where((state.targets.nest == number)[:, None, None], last, 0.0) * u_mm
            for number, u_mm in self._held.items()
        ]
        return np.concatenate([np.zeros((len(last), 3, 0)), *each], axis=2)

    def _registration(self) -> FloatArray:
        """Return the motion of the world per independent cause, shape (6, 6); (6, 0) without fixed nests.

        Each fixed nest is read 20 times, R = D / 20 + u^2 I, and moves with the world by A = [I, -[p]x]. The
        covariance of the six numbers is (sum A' R^-1 A)^-1 = L'^-1 L^-1 with Cholesky's L of the sum;
        returned is L'^-1: shifts [mm] and turns [rad].
        """
        nests = self._knowns.fixed_nests
        # Positions then count in the frame of the readings, which nothing places wrongly.
        if len(nests) < _PLACE_A_FRAME:
            return np.zeros((6, 0))
        # The turn about their line would be free: the sum below has no inverse.
        if not span_triangle(nests):
            raise ConfigurationError(message("plan.refused.nests_on_a_line"))
        centres = np.array([nest.centre_mm for nest in nests])
        certified = np.array([nest.standard_uncertainty_mm for nest in nests])[:, None, None] ** 2 * np.eye(3)
        covariance = self._reading_mm2(centres) / _REGISTRATION_READINGS + certified
        motion = _rigid_motion(centres)
        information = np.swapaxes(motion, 1, 2) @ np.linalg.solve(covariance, motion)
        return np.asarray(np.linalg.inv(np.linalg.cholesky(information.sum(axis=0))).T)


def _rigid_motion(places_mm: FloatArray) -> FloatArray:
    """Return how places (n, 3) move with a small motion of the world, shape (n, 3, 6): [I, -[p]x].

    Three shifts [mm per mm] and three turns about the origin [mm/rad].
    """
    shifts = np.broadcast_to(np.eye(3), (len(places_mm), 3, 3))
    return np.concatenate([shifts, -cross_matrix(places_mm)], axis=2)


def _as_known(campaign: Campaign, knowns: PriorKnowledge) -> Campaign:
    """Return a campaign that knows no more than is known."""
    # A plan for a campaign without a stated base has to pay for finding it, as its identification does.
    base = campaign.base_nominal if knowns.base_known else None
    return replace(campaign, base_nominal=base, nests=knowns.nests or campaign.nests)
