"""Robots of one type compared: what changes, whom to measure next, what they share; report and terminal."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from markupsafe import Markup
from rich.console import Group, RenderableType
from rich.text import Text

from truepose.exchange.results.fleet import SharedDocument, shared_parameters
from truepose.fleet.changes import Account, RealChange
from truepose.fleet.minimum_detectable_change import least_of_robots
from truepose.fleet.outcome import fleet_outcome
from truepose.fleet.sentences import (
    cause_said,
    change_said,
    change_sentences,
    comparison_sentence,
    day_of,
    headline,
    least_said,
    next_said,
    rivals_said,
    scatter_said,
    what,
    why_said,
)
from truepose.fleet.trend import affected_campaigns, along, due, passing
from truepose.fleet.trials import Kind
from truepose.messages.catalogue import IN_ENGLISH, Catalogue
from truepose.reports.report import Description, Report
from truepose.reports.rounding import MISSING, format_fixed, format_rounded, uncertainty, with_uncertainty
from truepose.reports.tables import Table, heads_of, on_terminal

_KINDS: Final[dict[Kind, str]] = {
    "linear": "fleet.kind.linear",
    "step": "fleet.kind.step",
    "day": "fleet.kind.day",
}
_CHANGE_HEADS: Final = (
    "fleet.head.what",
    "fleet.head.cause",
    "fleet.head.how",
    "fleet.head.since",
    "fleet.head.size",
    "fleet.head.passes",
    "fleet.head.rivals",
)
_TO: Final = f" {MISSING} "
_AT_NO_SIZE: Final = "-"
_NEXT: Final = 5  # robots on a terminal: what a person looks at


@dataclass(frozen=True, slots=True)
class FleetReport(Report):
    """Robots of one type, compared; the days of the account are those of the calendar."""

    account: Account
    robot: str  # the type
    limit_mm: float
    left_out: tuple[tuple[str, str], ...] = ()  # campaigns, and why

    def described(self, words: Catalogue) -> Description:
        """Return what was compared, whom to measure next, the changes, and what the type has in common."""
        account, limit_mm = self.account, self.limit_mm
        each = enumerate(account.named)
        shown = {
            "outcome": words.spoken(fleet_outcome(account, limit_mm)),
            "headline": words.spoken(headline(account)),
            "good": not account.named,
            "compared": [words.spoken(one) for one in (comparison_sentence(account), *scatter_said(account))],
            "least": [words.spoken(one) for one in least_said(account)],
            "least_table": least_table(account, words),
            "change_table": change_table(account, limit_mm, words),
            "changes": [_change(account, one, number, limit_mm, words) for number, one in each],
            "next": words.spoken(next_said(due(account, limit_mm)[0], limit_mm)),
            "due": due_table(account, limit_mm, words, first=1),
            "shared": shared_table(account, words),
            "left_out": self.left_out,
        }
        return Description(words.say("fleet.title", robot=self.robot), self.robot, "fleet.html", shown)


def change_table(account: Account, limit_mm: float, words: Catalogue) -> Table:
    """Return a row per named change, the clearest first: what, why, how, since when, size, limit, rivals."""
    heads = [words.say(key, limit_mm=limit_mm) for key in _CHANGE_HEADS]
    return Table(heads, [_change_row(account, one, limit_mm, words) for one in account.named], names=7)


def due_table(account: Account, limit_mm: float, words: Catalogue, first: int = 0) -> Table:
    """Return a row per robot, the one to be measured next first: when it was last, and what speaks for it."""
    heads = heads_of(words, "fleet.head.robot", "fleet.head.last", "fleet.head.why")
    robots = due(account, limit_mm)[first:]
    rows = [(one.robot, day_of(one.last_day) or "", words.spoken(why_said(one, limit_mm))) for one in robots]
    return Table(heads, rows, names=3)


def least_table(account: Account, words: Catalogue) -> Table:
    """Return from which size on a cause of robots would have been shown, those first that show least."""
    seen = (one for one in least_of_robots(account) if one.of)
    rows = [
        (words.spoken(cause_said(one.cause)), _size(one.size_mm.max()), _size(one.size_mm.min()))
        for one in sorted(seen, key=lambda one: -float(one.size_mm.max()))
    ]
    heads = heads_of(words, "fleet.head.cause", "fleet.head.least.from", "fleet.head.least.best")
    return Table(heads, rows, names=1)


def shared_table(account: Account, words: Catalogue) -> Table:
    """Return a row per parameter of the type; robots differ most in the first, over what was believed."""
    keys = ("side.parameter", "fleet.head.cause", "fleet.head.value", "fleet.head.between", "report.unit")
    each = zip(account.estimated.variances.robot.tolist(), shared_parameters(account), strict=True)
    rows = [_shared_row(one, words) for _, one in sorted(each, key=lambda pair: -pair[0])]
    return Table(heads_of(words, *keys), rows, names=2)


def _size(size_mm: float) -> str:
    return format_fixed(size_mm, 3, "mm") if math.isfinite(size_mm) else _AT_NO_SIZE


def _change_row(account: Account, named: RealChange, limit_mm: float, words: Catalogue) -> tuple[str, ...]:
    change = named.change
    day, between = _passes(account, named, limit_mm, words)
    rivals = "; ".join(words.spoken(change_said(one.change)) for one in named.rivals)
    return (
        words.spoken(what(change)),
        words.spoken(cause_said(change.cause)),
        words.say(_KINDS[change.kind]),
        day_of(change.since) or "",
        with_uncertainty(named.size_mm, named.size_u_mm, "mm"),
        "\n".join(filter(None, (day, _TO.join(between)))),
        rivals or MISSING,
    )


def _passes(
    account: Account, named: RealChange, limit_mm: float, words: Catalogue
) -> tuple[str, tuple[str, ...]]:
    """Return the day on which a limit is passed, and the days between which that is with 90 %."""
    found = passing(account.fleet, named, limit_mm)
    if found is None:
        return words.say("fleet.does_not_go_on"), ()
    day, earliest, latest = (day_of(one) for one in (found.day, found.earliest, found.latest))
    if day is None or earliest is None:
        return words.say("fleet.perhaps_never"), ()
    return day, (earliest, latest or words.say("fleet.perhaps_never"))


def _shared_row(one: SharedDocument, words: Catalogue) -> tuple[str, ...]:
    value, between, u = (number or 0.0 for number in (one.value, one.between_robots, one.between_robots_u))
    return (
        one.name,
        words.effect(one.effect),
        format_rounded(value, between or u),
        uncertainty(between),
        one.unit,
    )


def fleet_summary(account: Account, limit_mm: float, words: Catalogue = IN_ENGLISH) -> Group:
    """Return what was compared, what changes, and which robots are to be measured next, for a terminal."""
    return Group(*_summary(account, limit_mm, words))


def _summary(account: Account, limit_mm: float, words: Catalogue) -> Iterator[RenderableType]:
    changes, following = change_table(account, limit_mm, words), due_table(account, limit_mm, words)
    first = (fleet_outcome(account, limit_mm), comparison_sentence(account), headline(account))
    yield from (Text(words.spoken(one)) for one in first)
    if account.named:
        without_rivals = Table(changes.heads[:-1], [row[:-1] for row in changes.rows], names=6)
        yield on_terminal(without_rivals, words.say("fleet.head.changes"))
    rivals = (one for named in account.named for one in rivals_said(named))
    due_first = next_said(due(account, limit_mm)[0], limit_mm)
    yield from (Text(words.spoken(one)) for one in (*rivals, *least_said(account), due_first))
    yield on_terminal(Table(following.heads, following.rows[:_NEXT], names=3), words.say("fleet.head.next"))
    yield from (Text(words.spoken(one)) for one in scatter_said(account))


def _change(
    account: Account, named: RealChange, number: int, limit_mm: float, words: Catalogue
) -> tuple[str, list[str], Markup]:
    """Return title, sentences and picture of a change."""
    from truepose.reports.figures.over_days import Growth, growth_figure  # the drawing library is slow

    passes = passing(account.fleet, named, limit_mm)
    change = named.change
    title = words.between.join((words.spoken(what(change)), words.spoken(cause_said(change.cause))))
    told, days = along(account, named), account.fleet.day[affected_campaigns(account.fleet, named)]
    growth = Growth(
        first=float(days.min()),
        day=told.day,
        size_mm=told.size_mm,
        u_mm=told.u_mm,
        kind=change.kind,
        since=change.since,
        named_mm=named.size_mm,
        named_u_mm=named.size_u_mm,
        limit_mm=limit_mm,
        passed=None
        if passes is None or not math.isfinite(passes.earliest)
        else (passes.earliest, passes.latest),
    )
    sentences = [words.spoken(one) for one in change_sentences(account, named, passes)]
    return title, sentences, growth_figure(growth, f"growth{number}", title, words)
