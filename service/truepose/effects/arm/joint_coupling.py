"""Joint coupling: a wrist joint moves along with another joint, as shafts that run through each other do.

    theta_m moves by  sign_m coupling_ms q_s        q_s the source's angle as the controller counts it

The moved joint turns by coupling times the angle of the source, both as the controller counts them.
"""

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.diagnosis import Detail
from truepose.effects.causes import (
    OF_SUBJECT,
    Candidate,
    Description,
    FittedCause,
    OfTurningJoints,
    Scene,
    Signature,
)
from truepose.effects.names import joint_subject
from truepose.effects.ports import ParameterSpec, Port, PortKind, Rows, Setting, Term, Trait
from truepose.messages.message import message

NAME = "joint_coupling"
_WIDTH = 2e-3  # belief: four times what a wrist with a noticeable coupling shows
WRIST_JOINTS = 3


class JointCoupling(OfTurningJoints):
    """One factor per pair of a wrist joint and the joint that moves it along."""

    name = NAME
    traits = frozenset({Trait.STEADY})
    signature = Signature(
        OF_SUBJECT,
        "angle of joint {variant:g}",
        "line",
        "rotation of this joint per rotation of the other",
        drawn="joint",
    )

    def specs(self, setting: Setting) -> tuple[ParameterSpec, ...]:
        """Return the couplings within the wrist: those that its shafts make."""
        n = setting.robot.n_joints
        wrist = range(max(n - WRIST_JOINTS, 0), n)
        return tuple(_spec(moved, source) for moved in wrist for source in wrist if source < moved)

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        """Turn the moved joint by its share of the source's angle: weight sign_m q_s [rad] on its theta."""
        return [Term(k, *_dragged(name, rows)) for k, name in enumerate(names)]

    def candidates(self, scene: Scene) -> tuple[Candidate, ...]:
        """Propose every other joint that turns as the source of every wrist joint."""
        n = scene.setting.robot.n_joints
        return tuple(
            Candidate(NAME, joint_subject(moved), (spec,), float(source + 1))
            # Couplings of other joints have no name of the trade: the cell `along` looks for these.
            for moved in range(max(n - WRIST_JOINTS, 0), n)
            for source in scene.turning
            # A joint that drags itself is a gain.
            if source != moved
            for spec in (_spec(moved, source),)
            if spec.name not in scene.present
        )

    def describe(self, subject: str, fitted: FittedCause, scene: Scene) -> Description:
        """Say which joint drags it along, and how far."""
        shares = np.abs(fitted.values)
        largest = int(shares.argmax())
        spreads = np.sqrt(np.diag(fitted.covariance))
        sources = [_joints(name)[1] for name in fitted.names]
        way = np.ptp(scene.stops.joints_rad[:, sources[largest]]) * shares[largest]
        sentence = message(
            "causes.joint_coupling",
            joint=subject,
            source=joint_subject(sources[largest]),
            share=float(shares[largest]),
            way_deg=float(np.rad2deg(way)),
        )
        details = _details(sources, fitted.values, spreads)
        share, spread = float(fitted.values[largest]), float(spreads[largest])
        return Description(subject, share, "rad/rad", spread, sentence, details)


def _details(sources: list[int], shares: FloatArray, spreads: FloatArray) -> tuple[Detail, ...]:
    """Return the source joints, and their couplings where there are several."""
    found = []
    for source, share, spread in zip(sources, shares.tolist(), spreads.tolist(), strict=True):
        found.append(Detail("source joint", float(source + 1), "1", 0.0))
        if len(sources) > 1:
            found.append(Detail("coupling", share, "rad/rad", spread))
    return tuple(found)


def _spec(moved: int, source: int) -> ParameterSpec:
    return ParameterSpec(f"coupling_{moved + 1}_{source + 1}", "1", 0.0, _WIDTH)


def _joints(name: str) -> tuple[int, int]:
    _, moved, source = name.split("_")
    return int(moved) - 1, int(source) - 1


def _dragged(name: str, rows: Rows) -> tuple[Port, FloatArray]:
    moved, source = _joints(name)
    sign = rows.robot.joints[moved].sign
    return Port(PortKind.THETA, moved), sign * rows.stops.joints_rad[:, source]
