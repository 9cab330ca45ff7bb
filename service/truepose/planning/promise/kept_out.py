"""Which keep-out volumes are to blame for what a plan leaves open: without them it would not be."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Final

from truepose.domain.cell.keep_outs import KeepOuts
from truepose.domain.results.identification import NotIdentifiable
from truepose.domain.sentences import said

_MOST_TRIED: Final = 6  # volumes that are left out one by one; another plan is made for each


def because_of(
    keep_outs: KeepOuts,
    left_open: tuple[NotIdentifiable, ...],
    open_without: Callable[[KeepOuts], frozenset[str]],
) -> tuple[NotIdentifiable, ...]:
    """Name the volumes without which parameters were determined, beside the reason.

    Parameters
    ----------
    keep_outs : KeepOuts
    left_open : tuple of NotIdentifiable
    open_without : callable
        Returns the parameters that a plan of as many configurations leaves open among other volumes.
    """
    if not left_open or not keep_outs:
        return left_open
    without_any = open_without(KeepOuts())
    freed = [group for group in left_open if without_any.isdisjoint(group.parameters)]
    if not freed:
        return left_open
    without = {name: open_without(keep_outs.without(name)) for name in keep_outs.names[:_MOST_TRIED]}
    return tuple(_blamed(group, keep_outs, without) if group in freed else group for group in left_open)


def _blamed(
    group: NotIdentifiable, keep_outs: KeepOuts, without: dict[str, frozenset[str]]
) -> NotIdentifiable:
    single = [name for name, left in without.items() if left.isdisjoint(group.parameters)]
    names = ", ".join(single or keep_outs.names)
    if not single:
        return replace(group, reason=said("open.kept_out.all", reason=group.reason, volumes=names))
    if len(single) > 1:
        return replace(group, reason=said("open.kept_out.any", reason=group.reason, volumes=names))
    return replace(group, reason=said("open.kept_out", reason=group.reason, volumes=names))


def parameters_of(left_open: Iterable[NotIdentifiable]) -> frozenset[str]:
    """Return all parameters that are left open."""
    return frozenset(name for group in left_open for name in group.parameters)
