r"""From a campaign to a least-squares problem: structure, blocks of observations, start values.

What answers for a kind of readings is imported where a campaign has them: most have one kind.

Stated priors are widths, one a parameter. What robots of one type tell of parameters together, a belief, is a
mean m and a full covariance S. In the stated widths w, about the stated means n, it is worth

    S~^-1 = V l V'        S~ = S / (w w'),   y = S~^-1 (m - n) / w

of which each direction's first unit is the stated prior itself; what it knows beyond that enters as one
reading a direction, of sqrt(l - 1) v' p~ with the value that makes both together the belief. Directions of
which a belief knows less than was stated (l < 1) keep the stated prior. The stated widths of these parameters
therefore stay as they are (`identification.fit.robust` widens others where readings ask for it).

Sources: as `identification.fit.solver`; A. Gelman et al., Bayesian Data Analysis, 3rd ed., 2013, section 14.8
(a prior as further readings).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.campaign import Campaign, ContactReadings, LegReadings, PointReadings, Quantity, Stops
from truepose.domain.errors import ConfigurationError
from truepose.effects.frames.base_frame import NAME as BASE
from truepose.effects.frames.tool_nests import NAME as TOOL
from truepose.effects.ports import ParameterSpec, Setting, Trait
from truepose.effects.registry import automatic_in, effects_with
from truepose.identification.model.structure import NOMINAL_EFFECTS, Structure
from truepose.identification.observations.blocks import ObservationBlock
from truepose.identification.observations.joint_priors import belief_block
from truepose.identification.observations.poses import position_block
from truepose.identification.problem.initial_frames import Placement, place
from truepose.identification.problem.problem_setup import (
    known_placement,
    outline,
    setting_of,
    started_structure,
    torque_source,
    unknown_nests,
    with_certified_nests,
)
from truepose.kinematics.chain import Chain, nominal_chain
from truepose.kinematics.frames import (
    rotation_from_quaternion,
    rotation_from_vector,
    vector_from_rotation,
)


@dataclass(frozen=True, slots=True)
class Problem:
    """What the solver needs.

    Attributes
    ----------
    structure : Structure
    blocks : tuple of Block
        The readings that identify come first.
    start : ndarray, shape (P,)
        Internal units.
    nominal_residual_mm : ndarray, shape (n, d)
        Observed minus predicted, of the first block and the placed nominal robot.
    setting : Setting
        From which the effects chose their parameters.
    """

    structure: Structure
    blocks: tuple[ObservationBlock, ...]
    start: FloatArray
    nominal_residual_mm: FloatArray
    setting: Setting

    @property
    def quantity(self) -> Quantity:
        """What the campaign's readings are of."""
        # Contacts are lengths too: one number each, along a direction.
        return "length" if self.setting.lengths else "position"


def automatic_effects(campaign: Campaign) -> tuple[str, ...]:
    """Return what `auto` stands for: base, unknown tool, geometry, compliance where torques are known."""
    return automatic_in(outline(campaign))


def build(campaign: Campaign, effects: tuple[str, ...], *, with_reference: bool = False) -> Problem:
    """Build the problem of a campaign.

    Parameters
    ----------
    campaign : Campaign
    effects : tuple of str
        Names of effects that are registered.
    with_reference : bool
        Take readings of fixed nests as observations; they are in any case where an effect moves them.

    Returns
    -------
    Problem
        Times count from its first reading.

    Raises
    ------
    UnknownEffectError
        An effect is not registered.
    ConfigurationError
        The campaign has nothing to identify from, or the effects leave open what it does not know.
    """
    readings = campaign.readings
    if readings is None:
        raise ConfigurationError(
            "The campaign has no calibration points, ballbar lengths or contacts. Give at least one of "
            "these under `files`."
        )
    _check(campaign, readings.stops, effects)
    # Positions are placed by a search over base and nests, lengths by one over what they are read against.
    problem = (
        _point_problem(campaign, readings, effects)
        if isinstance(readings, PointReadings)
        else _length_problem(campaign, readings, effects)
    )
    if not problem.structure.specs:
        raise ConfigurationError(
            f"The campaign leaves no parameters of {', '.join(effects)} unknown. Add effects, e.g. "
            "base,geometry."
        )
    if with_reference or set(effects_with(Trait.ON_FIXED_NESTS)) & set(effects):
        problem = _with_reference(campaign, problem)
    return replace(problem, structure=replace(problem.structure, origin_s=_first_s(campaign, readings.stops)))


def _with_reference(campaign: Campaign, problem: Problem) -> Problem:
    """Add the readings of fixed nests to the readings of positions."""
    from truepose.identification.observations.fixed_nests import reference_block, with_reference_parameters

    # Lengths have no frame that fixed nests could tell of.
    block = None if problem.quantity == "length" else reference_block(campaign)
    if block is None:
        return problem
    structure, start = with_reference_parameters(problem.structure, problem.start, block, campaign)
    return replace(problem, structure=structure, blocks=(*problem.blocks, block), start=start)


def _first_s(campaign: Campaign, stops: Stops) -> float:
    """Return the time of the first reading, fixed nests included, 0 where no times are known."""
    # An instrument drifts from its first reading on, which may be of a fixed nest.
    fixed = campaign.reference if campaign.identified_from == "calibration" else None
    columns = (stops.time_s, None if fixed is None else fixed.time_s)
    known = [column[np.isfinite(column)] for column in columns if column is not None]
    return min((float(column.min()) for column in known if column.size), default=0.0)


def _check(campaign: Campaign, stops: Stops, effects: tuple[str, ...]) -> None:
    if campaign.identified_from == "calibration" and campaign.base_nominal is None and BASE not in effects:
        raise ConfigurationError("The campaign does not give the base position. Add `base` to the effects.")
    unknown = unknown_nests(campaign)
    if unknown and TOOL not in effects:
        raise ConfigurationError(
            f"The campaign does not give the position of nest {unknown[0]}. Add `tool` to the effects."
        )
    # A gap in measured torques would wind up no spring in its row, and bend all others.
    springs = [name for name in effects_with(Trait.SPRINGS) if name in effects]
    if springs and torque_source(campaign) == "measured" and stops.torque_n_mm is not None:
        gaps = ~np.isfinite(stops.torque_n_mm).all(axis=1)
        if gaps.any():
            raise ConfigurationError(
                f"Configuration {int(stops.config[gaps][0])} lacks a measured joint torque. Give all of "
                f"tau1_Nm.., remove these columns, or leave `{springs[0]}` out of the effects."
            )


def _point_problem(campaign: Campaign, points: PointReadings, effects: tuple[str, ...]) -> Problem:
    chain = nominal_chain(campaign.robot, points.stops.joints_rad)
    known = known_placement(campaign)
    # A base that is to be identified is searched for even where a nominal one is stated: it may stand
    # elsewhere.
    search = replace(known, base=None) if BASE in effects else known
    placement = place(chain, points.nest, points.position_mm, search)
    found = placement.rotation if campaign.base_nominal is None else None
    setting = setting_of(campaign, points.stops, found)
    certified = campaign.tool_rotation_uncertainty_rad is not None
    # Of a certified artefact readings are of the flange frame itself: its turn is a parameter near 0.
    tool = np.eye(3) if certified else _tool_rotation(chain, placement, points)
    structure, start = started_structure(campaign, effects, placement, tool, setting)
    if certified:
        structure, start = with_certified_nests(structure, start, campaign, points.nest)
    positions: ObservationBlock = position_block(points, campaign.scatter_mm)
    blocks = (positions, *_orientations(points, effects))
    return Problem(structure, blocks, start, placement.residual_mm, setting)


def _orientations(points: PointReadings, effects: tuple[str, ...]) -> tuple[ObservationBlock, ...]:
    """Return the block of measured orientations; without the tool's as a parameter they say nothing."""
    # Orientations are of a frame of the tool: unless its turn is a parameter, they would bend the arm.
    if points.quaternion is None or TOOL not in effects:
        return ()
    from truepose.identification.observations.poses import orientation_block

    block = orientation_block(points)
    return () if block is None else (block,)


def _tool_rotation(chain: Chain, placement: Placement, points: PointReadings) -> FloatArray:
    if points.quaternion is None:
        return np.eye(3)
    # The fit begins there: from the identity a tool that is turned far would be a long way off.
    seen = rotation_from_quaternion(points.quaternion)
    in_last = np.swapaxes(placement.rotation @ chain.rotation[-1], 1, 2) @ seen
    middle = in_last[0]
    # By medians of rotation vectors about the last one, which a few gross orientations do not turn.
    for _ in range(3):
        middle = middle @ _mean_turn(np.swapaxes(middle[None], 1, 2) @ in_last)
    return np.asarray(middle)


def _mean_turn(turns: FloatArray) -> FloatArray:
    return rotation_from_vector(np.median(vector_from_rotation(turns), axis=0))


def _length_problem(
    campaign: Campaign, lengths: LegReadings | ContactReadings, effects: tuple[str, ...]
) -> Problem:
    setting = setting_of(campaign, lengths.stops)
    if isinstance(lengths, LegReadings):
        from truepose.identification.problem.legs import leg_structure

        structure, blocks, start = leg_structure(campaign, lengths, effects, setting)
    else:
        from truepose.identification.problem.contacts import contact_structure

        structure, blocks, start = contact_structure(campaign, lengths, effects, setting)
    nominal = structure.without(tuple(name for name in effects if name not in NOMINAL_EFFECTS))
    # Anchors and targets stay: without them a nominal robot predicts no length.
    keep = [structure.index_of(name) for name in nominal.names]
    residual = blocks[0].result(nominal, start[keep], None).residual
    return Problem(structure, blocks, start, residual, setting)


@dataclass(frozen=True, slots=True)
class JointPrior:
    """Parameters as they are believed to be before a robot is measured; internal units.

    Attributes
    ----------
    specs : tuple of ParameterSpec, length Q
        As stated: name, unit, prior mean n and width w of each.
    owners : tuple of str, length Q
        Effect of each.
    mean : ndarray, shape (Q,)
        What is believed of all together, m.
    covariance : ndarray, shape (Q, Q)
        Of what is believed, S.
    """

    specs: tuple[ParameterSpec, ...]
    owners: tuple[str, ...]
    mean: FloatArray
    covariance: FloatArray

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters."""
        return tuple(spec.name for spec in self.specs)

    def beyond_stated(self) -> tuple[FloatArray, FloatArray]:
        """Return what it knows beyond the stated priors, as readings of variance 1.

        Returns
        -------
        rows : ndarray, shape (Q, Q)
            sqrt(l - 1) v' / w, per unit of each parameter; zeros for directions of which less is known than
            stated.
        read : ndarray, shape (Q,)
            What rows times parameters are [1].

        Raises
        ------
        ConfigurationError
            The covariance is none: a variance in it is not positive.
        """
        widths = np.array([spec.prior_width for spec in self.specs])
        means = np.array([spec.prior_mean for spec in self.specs])
        # In units of the stated widths: there the stated prior is 1 along every direction.
        spread, turns = np.linalg.eigh(self.covariance / np.outer(widths, widths))
        if not np.all(np.isfinite(spread)) or spread[0] <= 0.0:
            raise ConfigurationError("The covariance of the prior must be positive definite.")
        known, deviation = 1.0 / spread, turns.T @ ((self.mean - means) / widths)
        root = np.sqrt(np.maximum(known - 1.0, 0.0))
        told = np.divide(known * deviation, root, out=np.zeros_like(root), where=root > 0.0)
        rows = root[:, None] * turns.T / widths
        return rows, told + rows @ means


def with_belief(problem: Problem, belief: JointPrior) -> Problem:
    """Return the problem with what is believed of its parameters; those that it lacks are added.

    Parameters
    ----------
    problem : Problem
    belief : JointPrior

    Returns
    -------
    Problem
        With one further block, of the directions of which the belief knows more than was stated.

    Raises
    ------
    ConfigurationError
        The covariance is none.
    """
    structure, start = problem.structure, problem.start
    for effect in dict.fromkeys(belief.owners):
        new = tuple(
            spec
            for spec, owner in zip(belief.specs, belief.owners, strict=True)
            if owner == effect and spec.name not in structure.names
        )
        structure = structure.extended(effect, new)
        start = np.append(start, [spec.prior_mean for spec in new])
    rows, read = belief.beyond_stated()
    # Directions of which the belief knows no more than was stated add nothing.
    telling = rows.any(axis=1)
    rows, read = rows[telling], read[telling]
    block = belief_block(
        belief.names, (rows, read), (belief.mean, belief.covariance), structure.robot.n_joints
    )
    blocks = (*problem.blocks, block) if len(read) else problem.blocks
    return replace(problem, structure=structure, start=start, blocks=blocks)


def precision_of(structure: Structure, belief: JointPrior | None) -> FloatArray:
    """Return what is known beforehand of a structure's parameters.

    Parameters
    ----------
    structure : Structure
        With all parameters of the belief.
    belief : JointPrior, optional

    Returns
    -------
    ndarray, shape (P, P)
        Inverse covariance in units of the stated widths: the identity without a belief.

    Raises
    ------
    ConfigurationError
        The covariance of the belief is none.
    """
    precision = np.eye(len(structure.specs))
    if belief is None:
        return precision
    rows, _ = belief.beyond_stated()
    place: Callable[[str], int] = structure.index_of
    at = np.array([place(name) for name in belief.names], dtype=np.int64)
    # Stated priors are 1 along every parameter; the rows add what is known beyond.
    white = rows * structure.prior_widths[at]
    precision[np.ix_(at, at)] += white.T @ white
    return precision
