"""What was ruled out: every cause that was looked at and not found, and those that these data cannot show."""

import numpy as np

from service.diagnosis.screening import screen
from service.diagnosis.selection import LEVEL, Selected
from service.domain.diagnosis import Cause, RuledOut
from service.effects.causes import Scene
from service.effects.registry import CAUSES


def ruled_out(
    scene: Scene, selected: Selected, found: frozenset[Cause], without: tuple[str, ...]
) -> tuple[RuledOut, ...]:
    """Return one entry per cause and subject, the least improbable first, then what cannot be seen."""
    best: dict[Cause, RuledOut] = {}
    if selected.pool.all:
        screened = screen(selected.pool.view())
        for index in np.argsort(screened.p_value).tolist():
            candidate = selected.pool.all[index]
            cause = Cause(candidate.effect, candidate.subject)
            if cause in found or cause in best:
                continue
            size, p_value = float(screened.size[index]), float(screened.p_value[index])
            best[cause] = _entry(cause, size, p_value)
    return (
        *sorted(best.values(), key=lambda one: (not one.visible, one.p_value or 0.0)),
        *_unseen(scene, without),
    )


def _entry(cause: Cause, size: float, p_value: float) -> RuledOut:
    if size == 0.0:
        return RuledOut(
            cause.effect,
            cause.subject,
            "the present model absorbs all that it could do: these configurations cannot show it",
            None,
            visible=False,
        )
    reason = (
        "it explains no more than chance would, at the level kept over everything tried"
        if p_value > LEVEL
        else "it explains something, but not what its parameters cost beside the causes found"
    )
    return RuledOut(cause.effect, cause.subject, reason, p_value)


def _unseen(scene: Scene, without: tuple[str, ...]) -> tuple[RuledOut, ...]:
    reasons = ((name, cause.unseen(scene)) for name, cause in CAUSES.items() if name not in without)
    return tuple(
        RuledOut(name, "", reason, None, visible=False) for name, reason in reasons if reason is not None
    )
