"""Ports: the places at which an effect acts on the kinematic chain, and what an effect is.

An effect has parameters p_k and acts by terms (k, port, w), linear in its parameters: at row i a port is
moved by

    sum over its terms of w_i p_k                w a number, or one for each of n rows

of all effects together; effects that move one port add up and do not know of each other. The chain turns
moved ports into positions and derivatives (`identification.model`), so that an effect needs no calculus, and
its derivative cannot contradict its prediction (docs/decisions/0001).

Units inside: mm, rad, N mm, kg, s, degC. The unit of a weight is that of the port per that of the parameter.
"""

from collections.abc import Callable
from enum import StrEnum
from typing import Literal, NamedTuple, Protocol, runtime_checkable

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.campaign import Stops
from truepose.domain.identification import NotIdentifiable, Unit
from truepose.domain.robot import Robot
from truepose.kinematics.chain import Chain


class PortKind(StrEnum):
    """What a port moves; its index says which one."""

    BASE = "base"  # 0..2 translation [mm] in the world, 3..5 RotX RotY RotZ [rad] before the start rotation
    ALPHA = "alpha"  # joint, 0-based
    A = "a"
    BETA = "beta"
    THETA = "theta"
    D = "d"
    NEST = "nest"  # 3 * (nest - 1) + component [mm, flange frame]
    TOOL_ROTATION = "tool_rotation"  # 0..2: RotX RotY RotZ [rad] of the tool before its start rotation
    SCALE = "scale"  # lengths as the instrument sees them, about its own place [1]
    # 6 * body + component [mm, rad]: body 0 is the base, 1..J the link that joint turns, J carries the tool;
    # shift, then RotX RotY RotZ, in the body's own axes.
    MOTION = "motion"
    TORQUE = "torque"  # joint: load on its gearbox beyond what is known [N mm]
    INSTRUMENT = "instrument"  # 0..5: shift and turn of everything that is read, about the world's origin
    LENGTH = "length"  # 0: what a length reads too much [mm]
    # 6 * (placement - 1) + component [mm, rad]: shift and turn of a base fixture, about the world's origin
    FIXTURE = "fixture"


class Port(NamedTuple):
    """One scalar place of action.

    Attributes
    ----------
    kind : PortKind
    number : int
        Which of that kind, 0-based, as `PortKind` counts them.
    """

    kind: PortKind
    number: int  # which of that kind, 0-based


class Term(NamedTuple):
    """Parameter -> port: the port moves by `weight` per unit of the parameter.

    Attributes
    ----------
    parameter : int
        Index within the names given to the effect.
    port : Port
    weight : float or ndarray, shape (n,)
        For all rows, or one for each.
    """

    parameter: int  # index within the names given to the effect
    port: Port
    weight: float | FloatArray  # scalar, or (n,) for n rows


def motion_port(body: int, component: int) -> Port:
    """Return the port of one component of the motion of a body.

    Parameters
    ----------
    body : int
        0 is the base, 1..J the link that joint turns.
    component : int
        0..2 shift [mm], 3..5 RotX RotY RotZ [rad], in the body's own axes.
    """
    return Port(PortKind.MOTION, 6 * body + component)


class ParameterSpec(NamedTuple):
    """A parameter as an effect proposes it.

    Attributes
    ----------
    name : str
        Unique in a model. `terms` and descriptions are rebuilt from it alone: it carries joint, order, time.
    unit : Unit
        Internal.
    prior_mean : float
    prior_width : float
        Standard deviation of what is believed before any reading.
    """

    name: str
    unit: Unit
    prior_mean: float
    prior_width: float  # standard deviation of what is believed before any reading


class Setting(NamedTuple):
    """What is known before any identification; effects choose their parameters from it.

    Attributes
    ----------
    robot : Robot
        Nominal.
    unknown_nests : tuple of int
        1-based.
    has_orientations : bool
        Whether orientations of the tool were measured.
    torque_source : str
        "measured", "masses" or "unknown".
    largest_torque_n_mm : ndarray, shape (J,)
        Over the configurations; zeros where unknown.
    certified_nests : tuple of int
        1-based, known and measured.
    attachments : tuple of int
        Numbers of the tool's mountings.
    initialisations : tuple of int
        Numbers of the ballbar's.
    lengths : bool
        Whether lengths were read instead of positions.
    tool_rotation_u_rad : float or None
        Certified: measured orientations are of the flange frame to this, per axis.
    gravity_m_s2 : tuple of float, length 3
        In the frame of the robot's base.
    """

    robot: Robot
    unknown_nests: tuple[int, ...]  # 1-based
    has_orientations: bool
    torque_source: str  # "measured", "masses" or "unknown"
    largest_torque_n_mm: FloatArray  # (J,) over the configurations; zeros where unknown
    certified_nests: tuple[int, ...] = ()  # 1-based, known and measured
    attachments: tuple[int, ...] = ()  # numbers of the tool's mountings
    initialisations: tuple[int, ...] = ()  # numbers of the ballbar's
    lengths: bool = False  # lengths were read instead of positions
    tool_rotation_u_rad: float | None = None  # certified: of measured orientations, to the flange frame
    gravity_m_s2: tuple[float, float, float] = (0.0, 0.0, -9.81)  # in the robot's base


class Rows(NamedTuple):
    """The n evaluation rows with what effects may depend on."""

    stops: Stops
    nest: IntArray  # (n,)
    # Torques and frames are those of the arm as it yields: an effect sees the balance that is being found,
    # and not the one of the nominal arm.
    torque_n_mm: FloatArray | None  # (n, J) measured, or gravity's at the present parameters; None: unknown
    turn_rad: FloatArray  # (n, J) what each joint turns by: its angle with its sign
    frames: Callable[[], Chain]  # at the present parameters, or near them
    gravity_m_s2: FloatArray  # (3,) world
    robot: Robot
    origin_s: float = 0.0  # time from which drifts and warm-ups count
    last_s: float | None = None  # of the readings that a model was made from; None while it is made
    initialisation: IntArray | None = None  # (n,) of the ballbar
    placement: IntArray | None = None  # (n,) of the ballbar's base fixture, from 1
    length_mm: FloatArray | None = None  # (n,) nominal length of each leg
    instrument_mm: FloatArray | None = None  # (3,) the instrument's place in the world; None: unknown
    nests_mm: FloatArray | None = None  # (K, 3) in the flange frame; None: unknown
    fixed_mm: FloatArray | None = None  # (n, 3) world: what is looked at, where it is not the tool

    @property
    def chain(self) -> Chain:
        """Frames of the rows; worked out once somebody asks for them."""
        return self.frames()

    @property
    def sighted_mm(self) -> FloatArray | None:
        """Where the instrument looks, as near as the direction of its beam asks for, shape (n, 3)."""
        if self.fixed_mm is not None or self.nests_mm is None:
            return self.fixed_mm
        # The nests of the start and not the fitted ones: a beam of metres turns by some tens of microradians
        # for a tenth of a millimetre, which no error of an instrument's circles notices.
        return self.chain.points(self.nests_mm[self.nest - 1])


def known_frames(chain: Chain) -> Callable[[], Chain]:
    """Return a function that gives frames which are known already; `Rows.frames` is called, never read.

    Parameters
    ----------
    chain : Chain
        Of the n rows.
    """
    return lambda: chain


Need = Literal["torque", "direction", "move", "time", "temperature", "attachment", "initialisation"]
NOTHING: frozenset[Need] = frozenset()


class Trait(StrEnum):
    """What an effect tells of itself beside its parameters: what others have to know of it, not its name."""

    PLACING = "placing"  # where robot and tool are: it is fitted around the nominal model too
    GEOMETRY = "geometry"  # the parameters of the nominal table
    SPRINGS = "springs"  # each yields the way it is loaded, so that the torque of every row must be known
    NUISANCE = "nuisance"  # what certificates leave open: nobody asks for it, and no model keeps it
    SEARCHED = "searched"  # only a search in the data tells what it is like: a time, a pair of nests
    OF_LENGTHS = "of lengths"  # positions do not know of it
    ON_FIXED_NESTS = "on fixed nests"  # it moves readings of fixed nests too, or stands for these
    # Springs are balanced in up to four passes; what no load changes is worked out in the first of them only.
    STEADY = "steady"  # its terms follow from the stop alone: no load, no frame of the arm changes them
    OF_READINGS = "of readings"  # it lies in single readings, not in the robot
    ZEROS = "zeros"  # the zeros of the joints, and nothing else
    WAVES = "waves"  # its parameters are waves of a joint's angle, as `effects.waves` names them
    AGEING = "ageing"  # it grows over the years, in a robot or in what measures it
    OF_MATERIAL = "of material"  # lengths follow the temperature, and do so as well in years to come
    SCALE = "scale"  # one factor on all lengths that the instrument reads


class Effect(Protocol):
    """A physical source of error.

    Whoever asks hands in plain data and gets plain data: an effect keeps nothing between two calls, and where
    a row does not tell what it depends on (None, NaN, a direction of 0) it moves nothing.
    """

    @property
    def name(self) -> str:
        """Name in commands and documents."""
        ...

    @property
    def needs(self) -> frozenset[Need]:
        """What a row must tell so that this effect can be predicted there.

        Rows that lack one of these are predicted as if the effect did not act.
        """
        ...

    def specs(self, setting: Setting) -> tuple[ParameterSpec, ...]:
        """Return the parameters this effect has in that setting; none where it cannot be fitted there.

        Parameters
        ----------
        setting : Setting
        """
        ...

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        """Return how the parameters `names` of this effect act on the ports of each row.

        Parameters
        ----------
        names : tuple of str
            Any of the effect's parameters, p of them, in any order; those that a search found as well.
        rows : Rows
            n of them.

        Returns
        -------
        list of Term
            With `parameter` in 0..p-1.
        """
        ...


@runtime_checkable
class Summed(Protocol):
    """An effect of many parameters that adds up what they move faster than term by term."""

    # Sixty orders on six joints are 720 columns of 10,000 rows in each evaluation, of which only the sum is
    # wanted.
    def sums(self, names: tuple[str, ...], values: FloatArray, rows: Rows) -> dict[Port, FloatArray]:
        """Return by how much parameters move each port, as the sum of their terms says.

        Parameters
        ----------
        names : tuple of str
            p of them.
        values : ndarray, shape (p,)
            Internal units.
        rows : Rows
            n of them.

        Returns
        -------
        dict of Port to ndarray, shape (n,)
        """
        ...


@runtime_checkable
class Drifting(Protocol):
    """An effect of which some parameters move things ever further in time: a made model holds these.

    Beyond the readings that a model was made from nobody knows how a drift goes on (docs/decisions/0028).
    """

    def goes_on(self, names: tuple[str, ...]) -> bool:
        """Return whether one of these parameters does."""
        ...


@runtime_checkable
class EffectWithTraits(Protocol):
    """An effect with traits."""

    @property
    def traits(self) -> frozenset[Trait]:
        """What is so of it."""
        ...


@runtime_checkable
class Automatic(Protocol):
    """An effect that is identified where nobody says which ones are."""

    def automatic(self, setting: Setting) -> bool:
        """Return whether it is in that setting."""
        ...


@runtime_checkable
class LeavesOpen(Protocol):
    """An effect that by its construction has no parameter where somebody may expect one."""

    def left_open(self, names: tuple[str, ...], setting: Setting) -> list[NotIdentifiable]:
        """Return what it leaves open beside the parameters `names` of a whole model, and why.

        Parameters
        ----------
        names : tuple of str
            Of all effects of the model.
        setting : Setting
        """
        ...


@runtime_checkable
class Discrepancy(Protocol):
    """An effect of joints whose parameters stand, as random functions, for what a model leaves out."""

    def unmodelled(self, setting: Setting, stops: Stops) -> bool:
        """Say whether such stops may show it where a model has no parameter of it.

        Parameters
        ----------
        setting : Setting
        stops : Stops
            n of them.
        """
        ...


@runtime_checkable
class Compliant(Protocol):
    """An effect by which joints yield to their load."""

    def softness(
        self, names: tuple[str, ...], values: FloatArray, joint: int, load_n_mm: FloatArray | None
    ) -> FloatArray | float:
        """Return how far a joint turns more per torque at its loads: the derivative of its characteristic.

        Parameters
        ----------
        names : tuple of str
            Of a whole model; by those of the p that are its own.
        values : ndarray, shape (p,)
            Internal units.
        joint : int
            0-based.
        load_n_mm : ndarray, shape (n,), or None
            Torque about the joint; None: not known.

        Returns
        -------
        float or ndarray, shape (n,)
            [rad/(N mm)]; 0 where the effect says nothing of the joint.
        """
        ...


class WithoutParameters:
    """What such effects have in common: they need nothing and move nothing that the arm reaches."""

    needs: frozenset[Need] = NOTHING

    def specs(self, setting: Setting) -> tuple[ParameterSpec, ...]:
        """Return none."""
        return ()

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        """Return none."""
        return []
