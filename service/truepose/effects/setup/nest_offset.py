"""Nest offset: a certified nest of the tool is not where its certificate says (bent, glued anew, chipped).

    x_nest moves by  (dx, dy, dz)        flange frame [mm]

Only where several certified nests were read: of a single one the arm's own parameters take most of the
offset, and if all are off alike nothing says that it is not the arm.
"""

import numpy as np

from truepose.domain.arrays import distinct_values
from truepose.domain.diagnosis import Detail
from truepose.effects.causes import (
    OF_SUBJECT,
    Candidate,
    Description,
    FittedCause,
    Scene,
    Signature,
    norm_with_uncertainty,
)
from truepose.effects.motions import COMPONENTS, split_motion
from truepose.effects.ports import NOTHING, Need, ParameterSpec, Port, PortKind, Rows, Setting, Term
from truepose.messages.message import Text, message

NAME = "nest_offset"
_WIDTH_MM = 0.3  # five times an offset that spoils a calibration unnoticed


class NestOffset:
    """Three coordinates per nest, in the flange frame."""

    name = NAME
    needs: frozenset[Need] = NOTHING
    signature = Signature(
        OF_SUBJECT, "constant", "group", "distance from the certified position", at="nest", drawn="level"
    )

    def specs(self, setting: Setting) -> tuple[ParameterSpec, ...]:
        """Return the offsets of all certified nests but the first, from which the others are counted."""
        # An offset that all share is one of the tool, which nothing tells from the arm's last parameters.
        return tuple(spec for nest in setting.certified_nests[1:] for spec in _specs(nest))

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        """Move the nest, one to one."""
        return [Term(k, Port(PortKind.NEST, _port_index(name)), 1.0) for k, name in enumerate(names)]

    def unseen(self, scene: Scene) -> Text | None:
        """Need several certified nests."""
        if len(_measured(scene)) < 2:
            return message("unseen.one_certified_nest")
        return None

    def candidates(self, scene: Scene) -> tuple[Candidate, ...]:
        """Propose each certified nest as long as another one stays where it is certified."""
        still = [nest for nest in _measured(scene) if _specs(nest)[0].name not in scene.present]
        # The nests that have an offset already hold nothing; the last one that is still has to.
        if len(still) < 2:
            return ()
        return tuple(Candidate(NAME, f"nest {nest}", _specs(nest)) for nest in still)

    def describe(self, subject: str, fitted: FittedCause, scene: Scene) -> Description:
        """Say how far the nest is from its certified place."""
        amplitude, uncertainty = norm_with_uncertainty(fitted.values, fitted.covariance)
        spread = np.sqrt(np.diag(fitted.covariance))
        details = tuple(
            Detail(name.rsplit("_", 1)[1], float(value), "mm", float(u))
            for name, value, u in zip(fitted.names, fitted.values, spread, strict=True)
        )
        sentence = message("causes.nest_offset", nest=subject, distance_mm=amplitude)
        return Description(subject, amplitude, "mm", uncertainty, sentence, details)


def _specs(nest: int) -> tuple[ParameterSpec, ...]:
    return tuple(ParameterSpec(f"offset_{nest}_{axis}", "mm", 0.0, _WIDTH_MM) for axis in COMPONENTS[:3])


def _port_index(name: str) -> int:
    prefix, component = split_motion(name)
    return 3 * (int(prefix.split("_")[1]) - 1) + component


def _measured(scene: Scene) -> list[int]:
    unknown = scene.setting.unknown_nests
    # Unknown nests have no certified place that they could be away from.
    return [nest for nest in distinct_values(scene.nest).tolist() if nest not in unknown]
