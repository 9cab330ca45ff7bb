"""Hose pull: a hose beside the forearm comes taut where joint 4 turns far, and turns joint 5 against it."""

import numpy as np

from truepose.effects.causes import OF_SUBJECT, Candidate, Description, Signature
from truepose.effects.ports import ParameterSpec, Port, PortKind, Term

_SLACK_RAD = 0.6
_PULL = ParameterSpec("pull_5", "1", 0.0, 1e-3)


def tension(turn_rad):
    """By how much joint 4 is beyond the slack of the hose, shape (n,) [rad]."""
    return np.maximum(np.abs(turn_rad[:, 3]) - _SLACK_RAD, 0.0)


class HosePull:
    """One share of the angle beyond the slack."""

    name = "hose_pull"
    needs = frozenset()
    signature = Signature(
        OF_SUBJECT, "angle of joint 4", "curve", "turn per turn beyond slack", drawn="joint"
    )

    def specs(self, setting):
        return (_PULL,)

    def terms(self, names, rows):
        return [Term(0, Port(PortKind.THETA, 4), tension(rows.turn_rad))] if names else []

    def unseen(self, scene):
        return None if tension(scene.turn_rad).any() else "the hose was never taut"

    def candidates(self, scene):
        return () if _PULL.name in scene.present else (Candidate(self.name, "joint 5", (_PULL,)),)

    def describe(self, subject, fitted, scene):
        pull, spread = float(fitted.values[0]), float(np.sqrt(fitted.covariance[0, 0]))
        return Description(subject, pull, "1", spread, f"A hose pulls at {subject} where joint 4 turns far.")


EFFECT = HosePull()
