"""A fleet on a terminal: what changes, and who is to be measured next."""

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from truepose.fleet.answer.due import due
from truepose.fleet.answer.sentences import (
    compared,
    headline,
    least_said,
    next_said,
    rivals_said,
    scatter_said,
)
from truepose.fleet.changes import Account
from truepose.reports.fleets.rows import change_rows, due_rows
from truepose.words.catalogue import IN_ENGLISH, Catalogue

_NEXT = 5  # robots: what a person looks at


def fleet_summary(account: Account, limit_mm: float, words: Catalogue = IN_ENGLISH) -> Group:
    """Return what was compared, what changes, and which robots are to be measured next."""
    parts: list[RenderableType] = [Text(words.spoken(one)) for one in (compared(account), headline(account))]
    if account.named:
        parts.append(_changes(account, limit_mm, words))
    parts += [Text(words.spoken(one)) for named in account.named for one in rivals_said(named)]
    parts += [Text(words.spoken(one)) for one in least_said(account)]
    first = due(account, limit_mm)[0]
    parts.append(Text(words.spoken(next_said(first, limit_mm))))
    parts.append(_next(account, limit_mm, words))
    parts += [Text(words.spoken(one)) for one in scatter_said(account)]
    return Group(*parts)


def _changes(account: Account, limit_mm: float, words: Catalogue) -> Table:
    table = Table(title=words.say("fleet.head.changes"))
    for name in ("what", "cause"):
        table.add_column(words.say(_HEADS[name]))
    table.add_column(words.say("fleet.head.since"), no_wrap=True)
    table.add_column(Text(words.say("fleet.head.size")), justify="right", no_wrap=True)
    table.add_column(words.say("fleet.head.passes", limit_mm=limit_mm), no_wrap=True)
    for row in change_rows(account, limit_mm, words):
        passes = "\n".join((row.passes, *(f"  {day}" for day in row.between)))
        cells = (row.what, row.cause, f"{row.since}\n{row.how}", row.size, passes)
        table.add_row(*map(Text, cells))
    return table


def _next(account: Account, limit_mm: float, words: Catalogue) -> Table:
    table = Table(title=words.say("fleet.head.next"))
    for name in ("robot", "last", "why"):
        table.add_column(words.say(_HEADS[name]))
    for row in due_rows(account, limit_mm, words)[:_NEXT]:
        table.add_row(*map(Text, (row.robot, row.last, row.why)))
    return table


_HEADS = {
    "what": "fleet.head.what",
    "cause": "fleet.head.cause",
    "robot": "fleet.head.robot",
    "last": "fleet.head.last",
    "why": "fleet.head.why",
}
