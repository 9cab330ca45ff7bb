"""Causes: effects that a diagnosis may find, with what it must know to look for them and to name them.

A cause proposes *candidates*: the ways in which it may be present in these data (which joint, which order,
which moment), each with the parameters that it would add to the model. It says when it cannot be seen at
all, and puts what was fitted into its own words.

Amplitudes are lengths of fitted vectors v with covariance C, less what noise adds to them,

    |v|^2 - (tr C - u^2)        u^2 = v^T C v / |v|^2, the variance along v
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, NamedTuple, Protocol, TypeAlias

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.campaign import Stops
from truepose.domain.diagnosis import Detail, Shape
from truepose.effects.ports import NOTHING, Effect, Need, ParameterSpec, Setting
from truepose.kinematics.chain import Chain
from truepose.messages.message import Text, message

FEWEST_TOGETHER = 3  # joints that share a cause; fewer are named one by one
_SMALLEST_TURN_RAD = np.deg2rad(5.0)


@dataclass(frozen=True, slots=True)
class Scene:
    """The data in which causes are looked for: n readings and the model that they were fitted with.

    Attributes
    ----------
    setting : Setting
    stops : Stops
        n rows.
    nest : ndarray of int, shape (n,)
    chain : Chain
        Of the fitted model.
    torque_n_mm : ndarray, shape (n, J), or None
    turn_rad : ndarray, shape (n, J)
        What each joint turns by: its angle with its sign.
    softness_rad_per_n_mm : ndarray, shape (J,)
        Of the fitted model; 0 where it has no spring.
    present : frozenset of str
        Names of the model's parameters.
    effects : tuple of str
        Of the model.
    reference_s : ndarray, shape (r,)
        Times at which fixed nests were read.
    origin_s : float
        Time from which drifts count.
    legs : bool
        Whether these are lengths of a ballbar instead of positions.
    initialisation, placement : ndarray of int, shape (n,), or None
        Of the ballbar and of its base fixture.
    gravity_m_s2 : tuple of float
        In the world.
    between_s : tuple of float, or None
        Where jumps are looked for: every gap between two moments is tried; None: some, anywhere.
    instrument_mm : ndarray, shape (3,), or None
        Its place in the world; None: unknown.
    fixtures_mm : mapping of int to ndarray, shape (3,)
        Of each placement, in the world: the middle of the base nests that lengths were read from.
    """

    setting: Setting
    stops: Stops
    nest: IntArray  # (n,)
    chain: Chain  # of the fitted model
    torque_n_mm: FloatArray | None  # (n, J)
    turn_rad: FloatArray  # (n, J)
    softness_rad_per_n_mm: FloatArray  # (J,) of the fitted model, 0 where it has no spring
    present: frozenset[str]  # names of the model's parameters
    effects: tuple[str, ...]  # of the model
    reference_s: FloatArray  # (r,) times at which fixed nests were read
    origin_s: float
    legs: bool = False  # lengths of a ballbar instead of positions
    initialisation: IntArray | None = None
    placement: IntArray | None = None
    gravity_m_s2: tuple[float, float, float] = (0.0, 0.0, -9.81)  # world
    between_s: tuple[float, float] | None = None  # jumps: every gap there is tried; None: some, anywhere
    instrument_mm: FloatArray | None = None  # (3,) its place in the world; None: unknown
    fixtures_mm: Mapping[int, FloatArray] = field(default_factory=dict)  # (3,) by placement, world

    @property
    def turning(self) -> tuple[int, ...]:
        """Joints (0-based) that turned: over less, what follows an angle cannot be told from an offset."""
        return tuple(np.flatnonzero(np.ptp(self.turn_rad, axis=0) >= _SMALLEST_TURN_RAD).tolist())

    @property
    def robot_name(self) -> str:
        """Name of the robot."""
        return self.setting.robot.name


class Candidate(NamedTuple):
    """One way in which a cause may be present.

    The parameters of a `function` are those of one random function: each is small, there may be more of them
    than readings, and how large they are together is told by the data; their prior widths tell how they
    compare among each other, and how large they are at most.

    Attributes
    ----------
    effect : str
    subject : str
        What it is of: "joint 3", "base", a cell without a name.
    specs : tuple of ParameterSpec
    variant : float
        What was searched over: an order, a time; 0 where nothing was.
    function : bool
    size : float
        Of a function: its prior widths over those that it was proposed with.
    """

    effect: str
    subject: str
    specs: tuple[ParameterSpec, ...]
    variant: float = 0.0  # what was searched over: an order, a time; 0 where nothing was
    function: bool = False
    size: float = 1.0  # of a function: its prior widths over those that it was proposed with

    @property
    def names(self) -> tuple[str, ...]:
        """Names of its parameters."""
        return tuple(spec.name for spec in self.specs)

    def same_as(self, other: "Candidate") -> bool:
        """Whether both are the same way of the same cause, whatever their sizes are."""
        # Sizes follow the data from round to round; a function that was sized anew is the same candidate.
        return (self.effect, self.subject, self.names) == (other.effect, other.subject, other.names)

    def sized(self, factor: float) -> "Candidate":
        """Return it with all prior widths multiplied by a factor [1]."""
        specs = tuple(spec._replace(prior_width=factor * spec.prior_width) for spec in self.specs)
        return self._replace(specs=specs, size=factor * self.size)


class Limits(NamedTuple):
    """What an amplitude can be by physics, in its own unit.

    Attributes
    ----------
    low, high : float
    why : Text
        What is wrong beyond them.
    withdrawn : bool
        Whether a finding beyond them is not kept: under more load its model errs more.
    """

    low: float
    high: float
    why: Text  # what is wrong beyond them
    withdrawn: bool = False  # a finding beyond them is not kept: under more load its model errs more


# What gives, gives way: a passive part that moved against its load would add energy.
SPRING = Limits(0.0, np.inf, message("limits.spring"))
_CLEARLY = 2.0  # standard uncertainties beyond a limit


@dataclass(frozen=True, slots=True)
class Description:
    """A fitted cause in its own words and units (angles in deg).

    Attributes
    ----------
    subject : str
    amplitude : float
    unit : str
    standard_uncertainty : float
        Of the amplitude, in its unit.
    sentence : Text
    details : tuple of Detail
    limits : Limits or None
        None: nature sets none.
    """

    subject: str
    amplitude: float
    unit: str
    standard_uncertainty: float
    sentence: Text
    details: tuple[Detail, ...] = ()
    limits: Limits | None = None

    @property
    def impossible(self) -> bool:
        """Whether the amplitude is beyond its physical limits by more than it is uncertain."""
        if self.limits is None:
            return False
        # An estimate of something possible may lie beyond the limit by chance.
        slack = _CLEARLY * self.standard_uncertainty
        return not self.limits.low - slack <= self.amplitude <= self.limits.high + slack


class FittedCause(NamedTuple):
    """Parameters of one cause on one subject as they were fitted; several candidates may share a subject.

    Attributes
    ----------
    names : tuple of str
        k of them.
    values : ndarray, shape (k,)
        Internal units.
    covariance : ndarray, shape (k, k)
        Of the posterior.
    """

    names: tuple[str, ...]
    values: FloatArray  # (k,) internal units
    covariance: FloatArray  # (k, k)


# The error of one joint, whose number follows the first underscore of its parameters' names; the shift of the
# tool over time or temperature; its shift for each nest or mounting; or else what readings show against what
# the cause foretells.
Drawn: TypeAlias = Literal["joint", "shift", "level", "agreement"]
OF_SUBJECT = "{subject}"  # where a cause acts on what it is named of


class ErrorSignature(NamedTuple):
    """A place, a variable, a shape."""

    where: str
    over: str
    shape: Shape


class Signature(NamedTuple):
    """Where a cause acts, over what, in which shape; `{subject}` and `{variant}` are the candidate's.

    Attributes
    ----------
    where, over : str
        A place and a variable; `OF_SUBJECT` where the place is the subject itself.
    shape : Shape
    amplitude : str
        What its amplitude is.
    searched, function : Shape or None
        Shape of candidates that were searched over, of random functions; None: `shape`.
    plural : str
        Subject of several that share it: "joints", "links"; "": each stands alone.
    at : str
        What its subject is one of, where the subject is the place.
    drawn : Drawn
        Which curve shows it over the readings.
    """

    where: str
    over: str
    shape: Shape
    amplitude: str = ""  # what its amplitude is
    searched: Shape | None = None  # of candidates that were searched over
    function: Shape | None = None  # of random functions
    plural: str = ""  # subject of several that share it: "joints", "links"; "": each stands alone
    at: str = "joint"  # what its subject is one of, where the subject is the place
    drawn: Drawn = "agreement"  # which curve shows it over the readings

    def of(self, subject: str, variant: float = 0.0) -> ErrorSignature:
        """Return the signature of one subject; of any where the subject is "".

        Parameters
        ----------
        subject : str
        variant : float
            Of the candidate.
        """
        told = {"subject": subject or self.at, "variant": variant}
        return ErrorSignature(self.where.format(**told), self.over.format(**told), self.shape)


class Cause(Effect, Protocol):
    """An effect that a diagnosis looks for."""

    @property
    def signature(self) -> Signature | None:
        """Where it acts, over what, in which shape; None where each of its subjects says it itself."""
        ...

    def unseen(self, scene: Scene) -> Text | None:
        """Return why these data cannot show it, and what would; None where they can.

        Parameters
        ----------
        scene : Scene
        """
        ...

    def candidates(self, scene: Scene) -> tuple[Candidate, ...]:
        """Return the ways in which it may be present, none where the model already has it.

        Parameters
        ----------
        scene : Scene
        """
        ...

    def describe(self, subject: str, fitted: FittedCause, scene: Scene) -> Description:
        """Put fitted parameters into words.

        Parameters
        ----------
        subject : str
            As of the candidates.
        fitted : FittedCause
            Of all candidates on that subject that were found, one or more.
        scene : Scene
        """
        ...


def norm_with_uncertainty(vector: FloatArray, covariance: FloatArray) -> tuple[float, float]:
    """Length of a vector that is known with a covariance, less what noise adds to it, and its uncertainty.

    The expected squared length of the estimate exceeds the true one by the trace of the covariance; what is
    taken off makes the amplitude a steeper function of the length, and so less certain than that: with
    A^2 = |v|^2 - (tr C - u^2), dA = |v|/A d|v|. Own derivation; tests draw its coverage.

    Parameters
    ----------
    vector : ndarray, shape (k,)
    covariance : ndarray, shape (k, k)

    Returns
    -------
    amplitude : float
        In the unit of the vector; never below its own uncertainty u along the vector.
    standard_uncertainty : float
        u |v| / A, no less than u; of a vector of zeros sqrt(tr C).
    """
    length = float(np.linalg.norm(vector))
    if length == 0.0:
        return 0.0, float(np.sqrt(np.trace(covariance)))
    spread, amplitude = _spread_along(vector, covariance), norm_beyond_noise(vector, covariance)
    # Never less than it is uncertain: towards zero the amplitude is an ever steeper function of the length,
    # and its uncertainty would grow without bound.
    if amplitude <= spread:
        return spread, max(spread, length)
    return amplitude, spread * length / amplitude


def norm_beyond_noise(vector: FloatArray, covariance: FloatArray) -> float:
    """Length of a vector less what noise across it adds; 0 where that explains all of it.

    Parameters
    ----------
    vector : ndarray, shape (k,)
    covariance : ndarray, shape (k, k)

    Returns
    -------
    float
        sqrt(|v|^2 - (tr C - u^2)), in the unit of the vector.
    """
    if not vector.any():
        return 0.0
    # The noise along the vector lengthens and shortens it alike; only that across it always lengthens.
    across = float(np.trace(covariance)) - _spread_along(vector, covariance) ** 2
    return float(np.sqrt(max(float(vector @ vector) - across, 0.0)))


def _spread_along(vector: FloatArray, covariance: FloatArray) -> float:
    """Return the standard deviation along the vector, sqrt(v^T C v) / |v|."""
    along = vector / np.linalg.norm(vector)
    # Of a vector that is known exactly along itself rounding may leave less than nothing.
    return float(np.sqrt(max(float(along @ covariance @ along), 0.0)))


def has_spread(column: FloatArray | IntArray | None) -> bool:
    """Say whether a column is there and takes more than one known value.

    Parameters
    ----------
    column : ndarray, shape (n,), or None
        NaN and infinity are unknown.
    """
    if column is None:
        return False
    known = column[np.isfinite(column)]
    return known.size > 0 and bool(np.ptp(known) > 0)


class OfTurningJoints:
    """What causes have in common that follow the angle of a joint and nothing else."""

    needs: frozenset[Need] = NOTHING

    def unseen(self, scene: Scene) -> Text | None:
        """Need joints that turn."""
        return None if scene.turning else message("unseen.no_joint_turns")
