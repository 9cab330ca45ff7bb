"""Tool reseating: the tool sits a little differently after each mounting (tool changer, dirt under a flange).

The seats of all mountings together are one effect: draws about a mean that the arm and the certificate of the
tool define. Shift and turn are about the last frame's origin, along its axes.
"""

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.results.causes import Detail
from truepose.domain.sentences import Text, said
from truepose.effects.causes import Candidate, Fitted, Scene, Shown
from truepose.effects.ports import Need, ParameterSpec, Rows, Setting, Term, motion_port
from truepose.effects.shapes.random_effects import deviations
from truepose.effects.shapes.rigid_motion import COMPONENTS, Widths, motion_specs, split_motion

NAME = "tool_reseating"
_WIDTHS = Widths(0.15, 1.5e-3)  # five times what a good tool changer repeats to
_SCALE = np.repeat([_WIDTHS.shift, _WIDTHS.turn], 3)
_SHIFTS_AND_TURNS = np.repeat([0, 1], 3)


class ToolReseating:
    """Six components per mounting."""

    name = NAME
    needs: frozenset[Need] = frozenset({"attachment"})

    def specs(self, setting: Setting) -> tuple[ParameterSpec, ...]:
        """Return the seats of all mountings."""
        return _specs(setting.attachments) if len(setting.attachments) > 1 else ()

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        """Move the tool of that mounting; one that was never seen sits as the tool does on average."""
        split = [split_motion(name) for name in names]
        here = {prefix: _mounted(rows, prefix) for prefix, _ in split}
        tool = rows.robot.n_joints
        return [
            Term(k, motion_port(tool, component), here[prefix]) for k, (prefix, component) in enumerate(split)
        ]

    def unseen(self, scene: Scene) -> Text | None:
        """Need several mountings."""
        if len(scene.setting.attachments) < 2:
            return said("unseen.one_mounting")
        return None

    def candidates(self, scene: Scene) -> tuple[Candidate, ...]:
        """Propose the seats of all mountings together."""
        specs = self.specs(scene.setting)
        if not specs or specs[0].name in scene.present:
            return ()
        return (Candidate(NAME, "tool", specs),)

    def shown(self, subject: str, fitted: Fitted, scene: Scene) -> Shown:
        """Say how far apart the seats are."""
        seats, covariance = _by_mounting(fitted)
        (shift, turn), (shift_u, turn_u) = deviations(seats, covariance, _SCALE, _SHIFTS_AND_TURNS)
        turn_deg, turn_u_deg = float(np.rad2deg(turn)), float(np.rad2deg(turn_u))
        sentence = said(
            "causes.tool_reseating", mountings=len(seats), shift_mm=float(shift), turn_deg=turn_deg
        )
        details = (
            Detail("rotation", turn_deg, "deg", turn_u_deg),
            Detail("mountings", float(len(seats)), "1", 0.0),
        )
        return Shown(subject, float(shift), "mm", float(shift_u), sentence, details)


def _specs(attachments: tuple[int, ...]) -> tuple[ParameterSpec, ...]:
    return tuple(spec for number in attachments for spec in motion_specs(f"seat_{number}", _WIDTHS))


def _mounted(rows: Rows, prefix: str) -> FloatArray:
    attachment = rows.stops.attachment
    if attachment is None:
        return np.zeros(len(rows.stops))
    return np.asarray(attachment == int(prefix.split("_")[1]), dtype=float)


def _by_mounting(fitted: Fitted) -> tuple[FloatArray, FloatArray]:
    """Return seats (M, 6) and their covariance, mounting by mounting."""
    split = [split_motion(name) for name in fitted.names]
    mountings = sorted({prefix for prefix, _ in split})
    order = [split.index((prefix, component)) for prefix in mountings for component in range(len(COMPONENTS))]
    return fitted.values[order].reshape(-1, len(COMPONENTS)), fitted.covariance[np.ix_(order, order)]
