"""What a fleet says as rows of tables, for a terminal and for pages alike."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from truepose.exchange.results.fleet import SharedDocument, shared
from truepose.fleet.answer.due import due
from truepose.fleet.answer.sentences import cause_said, change_said, day_of, what, why_said
from truepose.fleet.changes import Account, Named
from truepose.fleet.forecast import passing
from truepose.fleet.least import least_of_robots
from truepose.fleet.trials import Kind
from truepose.reports.wording.rounding import rounded, uncertainty, with_uncertainty
from truepose.words.catalogue import Catalogue

_KINDS: Final[dict[Kind, str]] = {
    "linear": "fleet.kind.linear",
    "step": "fleet.kind.step",
    "day": "fleet.kind.day",
}
_AT_NO_SIZE: Final = "-"


@dataclass(frozen=True, slots=True)
class ChangeRow:
    """A named change as text."""

    what: str
    cause: str
    how: str
    since: str
    size: str
    passes: str
    between: tuple[str, ...]  # days of 5 and 95 %; none where it does not go on
    rivals: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class DueRow:
    """A robot, when it was measured last, and what speaks for measuring it."""

    robot: str
    last: str
    why: str


@dataclass(frozen=True, slots=True)
class LeastRow:
    """From which size on a cause would have been shown, as text."""

    cause: str
    size: str
    best: str


@dataclass(frozen=True, slots=True)
class SharedRow:
    """A parameter as the type has it, as text."""

    name: str
    effect: str
    value: str
    between: str
    unit: str


def change_rows(account: Account, limit_mm: float, words: Catalogue) -> tuple[ChangeRow, ...]:
    """Return a row per named change, the clearest first."""
    return tuple(_change_row(account, one, limit_mm, words) for one in account.named)


def due_rows(account: Account, limit_mm: float, words: Catalogue) -> tuple[DueRow, ...]:
    """Return a row per robot, the one to be measured next first."""
    return tuple(
        DueRow(one.robot, day_of(one.last_day) or "", words.spoken(why_said(one, limit_mm)))
        for one in due(account, limit_mm)
    )


def least_rows(account: Account, words: Catalogue) -> Iterator[LeastRow]:
    """Yield a row per cause of robots, those first that show least."""
    seen = (one for one in least_of_robots(account) if one.of)
    for one in sorted(seen, key=lambda one: -float(one.size_mm.max())):
        sizes = (_size(float(size)) for size in (one.size_mm.max(), one.size_mm.min()))
        yield LeastRow(words.spoken(cause_said(one.cause)), *sizes)


def _size(size_mm: float) -> str:
    return f"{size_mm:.3f}" if math.isfinite(size_mm) else _AT_NO_SIZE


def shared_rows(account: Account, words: Catalogue) -> Iterator[SharedRow]:
    """Yield a row per parameter, those first in which robots differ most over what was believed."""
    each = zip(account.estimated.variances.robot.tolist(), shared(account), strict=True)
    for _, one in sorted(each, key=lambda pair: -pair[0]):
        yield _shared_row(one, words)


def _change_row(account: Account, named: Named, limit_mm: float, words: Catalogue) -> ChangeRow:
    change = named.change
    return ChangeRow(
        words.spoken(what(change)),
        words.spoken(cause_said(change.cause)),
        words.say(_KINDS[change.kind]),
        day_of(change.since) or "",
        with_uncertainty(named.size_mm, named.size_u_mm),
        *_passes(account, named, limit_mm, words),
        tuple(words.spoken(change_said(one.change)) for one in named.rivals),
    )


def _passes(account: Account, named: Named, limit_mm: float, words: Catalogue) -> tuple[str, tuple[str, ...]]:
    """Return the day on which a limit is passed, and the days between which that is with 90 %."""
    found = passing(account.fleet, named, limit_mm)
    if found is None:
        return words.say("fleet.does_not_go_on"), ()
    day, earliest, latest = (day_of(one) for one in (found.day, found.earliest, found.latest))
    if day is None or earliest is None:
        return words.say("fleet.perhaps_never"), ()
    return day, (earliest, latest or words.say("fleet.perhaps_never"))


def _shared_row(one: SharedDocument, words: Catalogue) -> SharedRow:
    value, between, u = (number or 0.0 for number in (one.value, one.between_robots, one.between_robots_u))
    return SharedRow(
        one.name,
        words.effect(one.effect),
        rounded(value, between or u),
        uncertainty(between),
        one.unit,
    )
