"""Link bending: a long link bends under what it carries, as a beam that is clamped at its lower joint.

Euler and Bernoulli's slender round beam of length L along u: a weight F that acts at s, and the moment M that
its lever brings there, turn the beam at s by

    turn  = (s^2 / 2 u x F + s M) / EI        and move it by
    shift = (s^3 / 3 F + s^2 / 2 M x u) / EI,

F and M without their parts along u (what stretches and twists the link is neglected); beyond s the beam is
straight: its end shifts by (L - s) turn x u more. 1/EI is the parameter; a joint's own wind-up is none of it.

Source: S. P. Timoshenko, Strength of Materials, part I, 1940, chapter V (cantilevers, superposition).
"""

from typing import NamedTuple

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.campaign import Stops
from truepose.domain.diagnosis import Detail
from truepose.domain.robot import LinkMass, Robot
from truepose.effects.causes import OF_SUBJECT, SPRING, Candidate, Description, FittedCause, Scene, Signature
from truepose.effects.ports import (
    NOTHING,
    Need,
    ParameterSpec,
    Rows,
    Setting,
    Term,
    known_frames,
    motion_port,
)
from truepose.kinematics.chain import body_gradients, nominal_chain
from truepose.kinematics.frames import cross
from truepose.kinematics.gravity import centre_of_gravity
from truepose.messages.message import Text, message

_UPRIGHT_M_S2 = (0.0, 0.0, -9.81)  # the base stands upright for this figure, however it stands in the cell
_DEGREES = np.arange(-179.0, 181.0)
_ANGLES_RAD = np.deg2rad(_DEGREES[np.argsort(np.abs(_DEGREES), kind="stable")])  # 0 first: joints that do
_SAME_MM = 1e-6  # not matter stay there
_SWEEPS = 10  # joint by joint; of arms with two or three long links the last ones change nothing


def stretched_rows(robot: Robot) -> Rows:
    """Return one row with the flange of the nominal robot as far out as its joints let it be.

    Parameters
    ----------
    robot : Robot

    Returns
    -------
    Rows
        One row: joints 3..J such that the flange is farthest from joint 2, then joint 2 such that it is
        farthest out. The base stands upright, nothing is known of torques.
    """
    joints = np.zeros(robot.n_joints)
    for _ in range(_SWEEPS):
        # Joint 1 turns the arm about the vertical, which changes no sag; joint 2 comes last, when the arm is
        # stretched.
        for joint in range(2, robot.n_joints):
            joints = _farthest(robot, joints, joint, level=False)
    joints = _farthest(robot, joints, 1, level=True)
    stops = Stops(np.zeros(1, dtype=np.int64), joints[None])
    return Rows(
        stops=stops,
        nest=np.ones(1, dtype=np.int64),
        torque_n_mm=None,
        turn_rad=joints[None] * np.array([row.sign for row in robot.joints]),
        frames=known_frames(nominal_chain(robot, joints[None])),
        gravity_m_s2=np.array(_UPRIGHT_M_S2),
        robot=robot,
    )


def _farthest(robot: Robot, joints_rad: FloatArray, joint: int, *, level: bool) -> FloatArray:
    """Turn one joint (0-based) so that the flange is farthest from joint 2, or farthest out.

    Parameters
    ----------
    robot : Robot
    joints_rad : ndarray, shape (J,)
    joint : int
        0-based.
    level : bool
        Whether the distance is taken in the horizontal plane.

    Returns
    -------
    ndarray, shape (J,)
        To whole degrees.
    """
    tried = np.repeat(joints_rad[None], len(_ANGLES_RAD), axis=0)
    tried[:, joint] = _ANGLES_RAD
    chain = nominal_chain(robot, tried)
    away = chain.end_origin - chain.origin[1]
    distance = np.linalg.norm(away[:, :2] if level else away, axis=1)
    # Of angles that are equally far the first, which is the one nearest to 0: joints that do not matter stay
    # there.
    farthest: FloatArray = tried[int(np.argmax(distance >= distance.max() - _SAME_MM))]
    return farthest


NAME = "link_bending"
_SHORTEST_MM = 100.0  # shorter links do not bend: stiffness falls with the cube of the length
_FIRST_BEAM = 2  # link 1 is the column, which weights press rather than bend
_ROLLS_ABOUT_BEAM = 0.9  # cosine above which the next joint turns the rest of this beam about itself
_WIDTH = 5e-11  # 1/(N mm2): belief, six times the upper arm of a small robot


class Beam(NamedTuple):
    """One link as a beam, in its own frame.

    Attributes
    ----------
    link : int
        1-based.
    along : ndarray, shape (3,)
        Unit vector from the joint that carries it to the next one.
    length_mm : float
    carries : tuple of int
        Frames (1-based) whose masses sit on the beam itself.
    """

    link: int  # 1-based
    along: FloatArray  # (3,) unit
    length_mm: float
    carries: tuple[int, ...]  # frames (1-based) whose masses sit on the beam itself


class LinkBending:
    """Bending compliance 1/EI of every long link after the first."""

    name = NAME
    # Weights bend a link where masses are known; no torque about a joint takes part.
    needs: frozenset[Need] = NOTHING
    signature = Signature(OF_SUBJECT, "load", "line", "displacement at the tool", plural="links", at="link")

    def specs(self, setting: Setting) -> tuple[ParameterSpec, ...]:
        """Return 1/EI of each long link where the masses are known."""
        # Without masses nothing is known of what a beam carries.
        return tuple(_spec(link) for link in beams(setting.robot)) if setting.robot.masses else ()

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        """Move what hangs on the end of each beam, by the six components of its body's motion."""
        found = beams(rows.robot)
        links = [_link_of(name) for name in names]
        return [
            Term(k, motion_port(link, component), weight)
            for k, link in enumerate(links)
            for component, weight in enumerate(_motion(found[link], rows).T)
        ]

    def unseen(self, scene: Scene) -> Text | None:
        """Need known masses and long links."""
        if not scene.setting.robot.masses:
            return message("unseen.weight_unknown")
        if not beams(scene.setting.robot):
            return message("unseen.no_long_link")
        return None

    def candidates(self, scene: Scene) -> tuple[Candidate, ...]:
        """Propose each long link, and all of them together."""
        specs = tuple(spec for spec in self.specs(scene.setting) if spec.name not in scene.present)
        single = [Candidate(NAME, f"link {_link_of(spec.name)}", (spec,)) for spec in specs]
        return (*single, Candidate(NAME, "links", specs)) if len(single) > 1 else tuple(single)

    def describe(self, subject: str, fitted: FittedCause, scene: Scene) -> Description:
        """Say by how much the flange of the stretched arm sags; nobody can picture 1/EI."""
        per_unit = _sags_mm(fitted.names, scene)
        sag = float(per_unit @ fitted.values)
        spread = float(np.sqrt(per_unit @ fitted.covariance @ per_unit))
        links = tuple(map(_link_of, fitted.names))
        sentence = message(
            "causes.link_bending.lower" if sag >= 0.0 else "causes.link_bending.higher",
            who=message("causes.link_bending.who", n=len(links), links=links),
            sag_mm=abs(sag),
        )
        spreads = np.sqrt(np.diag(fitted.covariance))
        details = tuple(
            Detail(f"1/EI of link {_link_of(name)}", float(value), "1/(N*mm2)", float(deviation))
            for name, value, deviation in zip(fitted.names, fitted.values, spreads, strict=True)
        )
        return Description(subject, sag, "mm", spread, sentence, details, SPRING)


def beams(robot: Robot) -> dict[int, Beam]:
    """Return the links that may bend, by number: the long ones but for column and wrist.

    The end of link i in its own frame is where row i + 1 of the table puts the next joint,
    (a, -d sin(alpha), d cos(alpha)).

    Parameters
    ----------
    robot : Robot

    Returns
    -------
    dict of int to Beam
        By number of the link, from 1.
    """
    found = {}
    for link in range(_FIRST_BEAM, robot.n_joints - 1):
        row = robot.joints[link]  # of the joint at the end of the link
        end = np.array([
            row.a_mm,
            -row.d_mm * np.sin(row.alpha_rad),
            row.d_mm * np.cos(row.alpha_rad),
        ])
        length = float(np.linalg.norm(end))
        if length < _SHORTEST_MM:
            continue
        axis = np.array([0.0, -np.sin(row.alpha_rad), np.cos(row.alpha_rad)])
        # Where the next joint turns the beam about its own length, as axis 4 does a forearm, what follows
        # that joint is the same beam still.
        rolls = abs(float(axis @ end)) > _ROLLS_ABOUT_BEAM * length
        found[link] = Beam(link, end / length, length, (link, link + 1) if rolls else (link,))
    return found


def _spec(link: int) -> ParameterSpec:
    return ParameterSpec(f"sag_{link}", "1/(N*mm2)", 0.0, _WIDTH)


def _link_of(name: str) -> int:
    return int(name.split("_")[1])


def _motion(beam: Beam, rows: Rows) -> FloatArray:
    """Motion of the body per 1/EI, about its own origin and in its own axes.

    The sum over the weights that the beam carries, shift and turn of its end as in the module's head.

    Parameters
    ----------
    beam : Beam
    rows : Rows
        n of them.

    Returns
    -------
    ndarray, shape (n, 6)
        [mm per 1/(N mm2)], then [rad per 1/(N mm2)].
    """
    chain = rows.chain
    rotation, _ = chain.body(beam.link)
    along = rotation @ beam.along
    start = chain.origin[beam.link - 1]
    turn, shift = np.zeros_like(along), np.zeros_like(along)
    for mass in rows.robot.masses:
        # Weights before the beam's clamp are carried by what holds it.
        if mass.frame >= beam.link:
            lever = centre_of_gravity(chain, mass) - start
            turned, moved = _bent(beam, lever, along, mass.mass_kg * rows.gravity_m_s2, mass)
            turn, shift = turn + turned, shift + moved
    # The body turns about its origin, at the clamped end, and must bring its far end where the beam's is.
    shift -= cross(turn, beam.length_mm * along)
    to_body = np.swapaxes(rotation, 1, 2)
    return np.concatenate([_into(to_body, shift), _into(to_body, turn)], axis=1)


def _into(rotation: FloatArray, vectors: FloatArray) -> FloatArray:
    turned: FloatArray = np.einsum("nij,nj->ni", rotation, vectors)
    return turned


def _bent(
    beam: Beam, lever: FloatArray, along: FloatArray, weight: FloatArray, mass: LinkMass
) -> tuple[FloatArray, FloatArray]:
    """Turn and shift of the beam's end per 1/EI by one weight, shape (n, 3) each.

    Parameters
    ----------
    beam : Beam
    lever : ndarray, shape (n, 3)
        From the clamped end to the centre of gravity [mm].
    along : ndarray, shape (n, 3)
        Unit vector of the beam.
    weight : ndarray, shape (3,)
        [N]
    mass : LinkMass
    """
    reach = np.einsum("ni,ni->n", lever, along)[:, None]
    s = (
        # A weight behind the clamp or beyond the end acts at that end, with the moment that its lever brings.
        np.clip(reach, 0.0, beam.length_mm)
        if mass.frame in beam.carries
        else np.full_like(reach, beam.length_mm)
    )
    force = _across(np.broadcast_to(weight, lever.shape), along)
    moment = _across(cross(lever - s * along, weight), along)
    turn = s**2 / 2.0 * cross(along, force) + s * moment
    shift = s**3 / 3.0 * force + s**2 / 2.0 * cross(moment, along)
    return turn, shift + (beam.length_mm - s) * cross(turn, along)


def _across(vectors: FloatArray, along: FloatArray) -> FloatArray:
    """Return vectors without their part along the beam, shape (n, 3): v - (v . u) u."""
    across: FloatArray = vectors - np.einsum("ni,ni->n", vectors, along)[:, None] * along
    return across


def _sags_mm(names: tuple[str, ...], scene: Scene) -> FloatArray:
    """How far each beam lowers the flange of the arm stretched out level, per 1/EI, shape (k,).

    In mm per 1/(N mm2), by the same motions and gradients by which a model moves.
    """
    rows = stretched_rows(scene.setting.robot)
    down = rows.gravity_m_s2 / np.linalg.norm(rows.gravity_m_s2)
    flange = rows.chain.end_origin
    found = beams(scene.setting.robot)
    sags = []
    for name in names:
        link = _link_of(name)
        moves = body_gradients(rows.chain, link, np.zeros((len(rows.stops), 6)), flange)
        sags.append(float(np.einsum("nk,kni,i->", _motion(found[link], rows), moves, down)))
    return np.array(sags)
