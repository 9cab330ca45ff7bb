"""Upper arm and forearm as slender beams (Euler, Bernoulli), each clamped at its lower joint.

A weight F that acts at s along a beam of length L, with the moment M that its lever brings there, turns the
end by (s^2/2 u x F + s M) / EI and moves it by (s^3/3 F + s^2/2 M x u) / EI + (L - s) turn x u, u along the
beam, M without its part along u (torsion is neglected). The beam is round: EI is the same all around.
Source: S. Timoshenko, Strength of Materials, part I, 1940, chapter V.
"""

from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from truepose_simulators.errors import ModelError
from truepose_simulators.physics.arm import Arm, Bodies, CarriedMass, Vector, link_motions, place_bodies
from truepose_simulators.physics.effects import effect
from truepose_simulators.physics.loads import GRAVITY_M_S2, PlacedMass, place_masses
from truepose_simulators.physics.rigid import FloatArray, apply

_SOFTER = MappingProxyType({2: 8.0 / 8.0, 3: 6.0 / 8.0})  # how the 1/EI of `links` compare
_ROLLS_ABOUT_BEAM = 0.9  # cosine between the beam and the axis at its end


@dataclass(frozen=True, slots=True)
class Beam:
    """Link `link`, from its own joint to the next one."""

    link: int  # 1-based
    per_ei: float  # 1/EI [1/(N mm2)]


@dataclass(frozen=True, slots=True)
class BendingLinks:
    """Beams that bend under everything that they carry."""

    beams: tuple[Beam, ...]
    arm: Arm
    from_s: float

    def deflect(self, conditions: effect.Conditions, loads: effect.Loads) -> effect.Deflection:
        """Return turn and shift of each beam's end, in the seat of the joint that sits there."""
        motions = np.zeros((len(conditions), self.arm.n_joints + 2, 6))
        if loads.bodies is not None:
            for beam in self.beams:
                motions[:, beam.link + 1] = beam.per_ei * bending(
                    self.arm, beam.link, loads.bodies, loads.masses, loads.gravity_m_s2
                )
        return effect.Deflection(motions=motions * conditions.since(self.from_s)[:, np.newaxis, np.newaxis])


def bending(
    arm: Arm,
    link: int,
    bodies: Bodies,
    masses: tuple[PlacedMass, ...],
    gravity_m_s2: Vector = GRAVITY_M_S2,
) -> FloatArray:
    """Motion of the end of a beam of EI = 1 N mm2, in the seat there, shape (n, 6) [mm, rad]."""
    start, end = bodies.axis_points_mm[:, link - 1], bodies.axis_points_mm[:, link]
    on_beam = _on_beam(arm, link)
    length = np.linalg.norm(end - start, axis=1, keepdims=True)
    along = (end - start) / length
    turn, shift = np.zeros_like(along), np.zeros_like(along)
    for mass in masses:
        if mass.joint < link:
            continue
        force = np.asarray(mass.mass_kg)[..., np.newaxis] * np.array(gravity_m_s2)
        reach = np.sum((mass.centre_mm - start) * along, axis=1, keepdims=True)
        s = np.clip(reach, 0.0, length) if mass.joint in on_beam else length
        moment = _across(np.cross(mass.centre_mm - start - s * along, force), along)
        turned = s**2 / 2.0 * np.cross(along, force) + s * moment
        turn += turned
        shift += s**3 / 3.0 * _across(force, along) + s**2 / 2.0 * np.cross(moment, along)
        shift += (length - s) * np.cross(turned, along)
    to_seat = np.swapaxes(bodies.placements[:, link, :3, :3] @ arm.seats[link, :3, :3], 1, 2)
    return np.concatenate([apply(to_seat, shift), apply(to_seat, turn)], axis=1)


def sag_mm(arm: Arm, tool: CarriedMass | None, beams: tuple[Beam, ...]) -> float:
    """How far these beams lower the flange of the arm stretched out level under its own weight [mm].

    Stretched: joint 2 laid down by 90 degrees, the forearm as it then hangs brought level by joint 3.
    """
    no_errors = np.zeros((1, arm.n_joints + 2, 6))
    stretched = np.zeros((1, arm.n_joints))
    stretched[0, 1] = np.pi / 2.0
    stretched[0, 2] = -np.pi / 2.0
    straight = place_bodies(arm, link_motions(arm, no_errors), stretched)
    masses = place_masses(straight, arm.masses, tool, ())
    bent = no_errors.copy()
    for beam in beams:
        bent[:, beam.link + 1] = beam.per_ei * bending(arm, beam.link, straight, masses)
    lowered = place_bodies(arm, link_motions(arm, bent), stretched)
    return float(np.linalg.norm(lowered.last_frame[0, :3, 3] - straight.last_frame[0, :3, 3]))


def plant(change: effect.PlantedChange, site: effect.Site) -> BendingLinks:
    """Build the effect; the amplitude is the sag of the stretched arm at its flange [mm]."""
    effect.read_details(effect.NoDetails, change)
    links = effect.link_numbers(change, tuple(_SOFTER))
    soft = tuple(Beam(link, _SOFTER[link]) for link in links)
    # Of EI = 1 N mm2 the sag would be 1e9 mm: the small-motion sum holds for a slender share only.
    slender = tuple(Beam(beam.link, 1e-12 * beam.per_ei) for beam in soft)
    per_ei = 1e-12 * change.amplitude / sag_mm(site.arm, site.tool_mass, slender)
    return BendingLinks(tuple(Beam(b.link, per_ei * b.per_ei) for b in soft), site.arm, change.from_s)


def _across(vector: FloatArray, along: FloatArray) -> FloatArray:
    across: FloatArray = vector - np.sum(vector * along, axis=1, keepdims=True) * along
    return across


def realise(stated: effect.IdentifiedEffect, site: effect.ModelArm) -> tuple[BendingLinks, ...]:
    """Build the identified beams, `sag_<link>` [1/(N mm2)], of links that lead to another joint."""
    beams = tuple(
        Beam(1 + stated.index(link, site.arm.n_joints - 1, "link with a joint at its end"), per_ei)
        for (link,), per_ei in stated.matching(r"sag_([0-9]+)", "sag_<link>")
    )
    for beam in beams:
        _check_length(beam.link, site.arm)
    return (BendingLinks(beams, site.arm, effect.ALWAYS_S),)


def _check_length(link: int, arm: Arm) -> None:
    if np.linalg.norm(_beam(arm, link)) < 1.0:
        raise ModelError(
            f"effect link_bending: link {link} is shorter than 1 mm and cannot bend; use another model"
        )


def _beam(arm: Arm, link: int) -> FloatArray:
    """Way from the joint of a link (1-based) to the next, zero configuration, shape (3,)."""
    way: FloatArray = arm.seats[link, :3, 3] - arm.seats[link - 1, :3, 3]
    return way


def _on_beam(arm: Arm, link: int) -> tuple[int, ...]:
    """Joints whose masses sit on the beam: also one that rolls about it, whose housing the beam is."""
    beam = _beam(arm, link)
    along = abs(float(arm.seats[link, :3, 2] @ beam))
    return (link, link + 1) if along > _ROLLS_ABOUT_BEAM * np.linalg.norm(beam) else (link,)
