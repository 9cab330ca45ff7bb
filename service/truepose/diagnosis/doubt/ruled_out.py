"""What was ruled out: every cause that was looked at and not found, and those that these data cannot show."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from truepose.diagnosis.doubt.upper_limits import upper_limits_mm
from truepose.diagnosis.screening.explained import Screened, screen
from truepose.diagnosis.screening.selection import LEVEL, Selected
from truepose.domain.results.causes import Cause
from truepose.domain.results.diagnosis import RuledOut
from truepose.domain.sentences import said
from truepose.effects.causes import Scene
from truepose.effects.registry import CAUSES


def ruled_out(
    scene: Scene, selected: Selected, found: frozenset[Cause], without: tuple[str, ...]
) -> tuple[RuledOut, ...]:
    """Return one entry per cause and subject, the least improbable first, then what cannot be seen."""
    tried = _tried(selected, found) if selected.pool.all else ()
    return (
        *sorted(tried, key=lambda one: (not one.visible, one.p_value or 0.0)),
        *_unseen(scene, without),
    )


def _tried(selected: Selected, found: frozenset[Cause]) -> Iterator[RuledOut]:
    view = selected.pool.view()
    screened = screen(view)
    order = np.argsort(screened.p_value, kind="stable").tolist()
    best = _first_of_each(selected, found, order)
    limited = _first_of_each(selected, found, [k for k in order if _has_limit(selected, screened, k)])
    limits = dict(zip(limited, upper_limits_mm(view, tuple(limited.values())), strict=True))
    for cause, index in best.items():
        size, p_value = float(screened.size[index]), float(screened.p_value[index])
        entry = _entry(cause, size, p_value)
        yield replace(entry, upper_limit_mm=limits.get(cause) if entry.visible else None)


def _first_of_each(selected: Selected, found: frozenset[Cause], order: Sequence[int]) -> dict[Cause, int]:
    """Return the first candidate of each cause that was not found."""
    first: dict[Cause, int] = {}
    for index in order:
        candidate = selected.pool.all[index]
        first.setdefault(Cause(candidate.effect, candidate.subject), index)
    return {cause: index for cause, index in first.items() if cause not in found}


def _has_limit(selected: Selected, screened: Screened, index: int) -> bool:
    return float(screened.size[index]) > 0.0 and not selected.pool.all[index].function


def _entry(cause: Cause, size: float, p_value: float) -> RuledOut:
    if size == 0.0:
        return RuledOut(
            cause.effect,
            cause.subject,
            said("ruled_out.absorbed"),
            None,
            visible=False,
        )
    reason = said("ruled_out.chance" if p_value > LEVEL else "ruled_out.costs_more")
    return RuledOut(cause.effect, cause.subject, reason, p_value)


def _unseen(scene: Scene, without: tuple[str, ...]) -> tuple[RuledOut, ...]:
    reasons = ((name, cause.unseen(scene)) for name, cause in CAUSES.items() if name not in without)
    return tuple(
        RuledOut(name, "", reason, None, visible=False) for name, reason in reasons if reason is not None
    )
