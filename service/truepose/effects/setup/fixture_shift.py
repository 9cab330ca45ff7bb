"""Fixture shift: the fixture that carries the base nests moved during one of its placements.

A fixture that is placed anew is a new one; here all its nests move together, once, from a moment on. The
parameters are about the world's origin, the amplitude is that of the fixture about where it stands: at the
middle of its nests.
"""

import numpy as np

from truepose.domain.arrays import distinct_values
from truepose.effects.causes import (
    OF_SUBJECT,
    Candidate,
    Description,
    FittedCause,
    Scene,
    Signature,
    has_spread,
)
from truepose.effects.motions import (
    Gap,
    Widths,
    fitted_jumps,
    gaps,
    jump_terms,
    motion_specs,
    spoken,
    tried,
    without_times,
)
from truepose.effects.ports import Need, ParameterSpec, Port, PortKind, Rows, Setting, Term, Trait
from truepose.messages.message import Text, message

NAME = "fixture_shift"
_WIDTHS = Widths(0.5, 5e-4)
_LEAST_READINGS = 12  # on either side: six parameters need more than one full pose
_MOST_GAPS = 120  # over all placements


class FixtureShift:
    """Six components of a shift of one placement, at a time found by searching the data."""

    name = NAME
    needs: frozenset[Need] = frozenset({"time"})
    traits = frozenset({Trait.SEARCHED, Trait.OF_LENGTHS})
    signature = Signature(OF_SUBJECT, "time", "jump", "translation distance", at="placement")

    def specs(self, setting: Setting) -> tuple[ParameterSpec, ...]:
        """Return none: when a fixture moved is not known beforehand."""
        return ()

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        """Move the base nests of the placement from the moment on: weight 0 before it, 1 from it on."""
        return jump_terms(names, rows, _port)

    def unseen(self, scene: Scene) -> Text | None:
        """Need lengths from base nests with times, several before and after."""
        if not scene.legs:
            return message("unseen.no_fixture")
        if not has_spread(scene.stops.time_s):
            return without_times(scene)
        if not any(_gaps(scene, placement) for placement in _placements(scene)):
            return message("unseen.few_lengths")
        return None

    def candidates(self, scene: Scene) -> tuple[Candidate, ...]:
        """Propose every gap between stops of every placement that has readings enough on either side."""
        placements = _placements(scene) if scene.legs else []
        # Shared among the placements: each gap is a candidate of six columns, and long sessions have many
        # placements.
        most = max(1, _MOST_GAPS // max(1, len(placements)))
        proposed = (
            Candidate(
                NAME,
                f"placement {placement}",
                motion_specs(f"fixture_{placement}_{gap.label}", _WIDTHS),
                gap.middle_s,
            )
            for placement in placements
            for gap in tried(_gaps(scene, placement), scene.between_s, most)
        )
        return tuple(candidate for candidate in proposed if candidate.names[0] not in scene.present)

    def describe(self, subject: str, fitted: FittedCause, scene: Scene) -> Description:
        """Say how far the fixture moved, and when; of several moves the largest is the amplitude."""
        placement = int(subject.split()[1])
        # About the world's origin a small turn shifts the fixture by metres times it; people ask how far it
        # moved itself.
        moves = fitted_jumps(fitted, scene.fixtures_mm[placement])
        time_s, largest = moves.largest
        amplitude, uncertainty = largest.shift
        sentence = message(
            "causes.fixture_shift",
            placement=subject,
            shift_mm=amplitude,
            turn_deg=largest.turn_deg[0],
            after=spoken(time_s - scene.origin_s),
        )
        details = moves.details(_gaps(scene, placement))
        return Description(subject, amplitude, "mm", uncertainty, sentence, details)


def _port(prefix: str, component: int) -> Port:
    return Port(PortKind.FIXTURE, 6 * (int(prefix.split("_")[1]) - 1) + component)


def _placements(scene: Scene) -> list[int]:
    return [] if scene.placement is None else distinct_values(scene.placement).tolist()


def _gaps(scene: Scene, placement: int) -> tuple[Gap, ...]:
    here = np.zeros(len(scene.stops), dtype=bool) if scene.placement is None else scene.placement == placement
    # Of this placement alone: lengths of another one are read from nests that did not move with it.
    return gaps(scene.stops, here, _LEAST_READINGS)
