"""What an account of a fleet foretells of its robots, as it is kept for pages that cannot wait for one."""

from collections.abc import Iterator
from typing import Final

from truepose.fleet.answer.due import Due, due
from truepose.fleet.answer.sentences import day_of
from truepose.fleet.changes import Account
from truepose.fleet.forecast import Passing
from truepose.storage.files.foreseen import Compared, Foreseen

_MONTH_DAYS: Final = 365.25 / 12.0


def foretold(account: Account, robot: str, newest: int, limit_mm: float, computed_at: str) -> Compared:
    """Return the robots whose change has passed a limit or will, the first to do so first.

    Parameters
    ----------
    account : Account
        Whose days are those of the calendar.
    robot : str
        The type.
    newest : int
        Number of the campaign that was collected last of those compared.
    limit_mm : float
    computed_at : str
    """
    return Compared(robot, computed_at, newest, limit_mm, tuple(_foreseen(due(account, limit_mm))))


def _foreseen(robots: tuple[Due, ...]) -> Iterator[Foreseen]:
    for one in robots:
        if one.why == "passes" and one.named is not None:
            change, passes = one.named.change, one.passing
            yield Foreseen(
                robot=one.robot,
                effect=change.cause.effect,
                subject=change.cause.subject,
                order=float(change.cause.order),
                since=day_of(change.since) or "",
                size_mm=one.named.size_mm,
                rate_mm=None if passes is None else _rate_mm(passes, change.since),
                last_measured_on=day_of(one.last_day) or "",
                day=None if passes is None else day_of(passes.day),
                earliest=None if passes is None else day_of(passes.earliest),
            )


def _rate_mm(passes: Passing, since: float) -> float:
    """Return by how much a line grows in a month."""
    return passes.limit_mm * _MONTH_DAYS / (passes.day - since)
