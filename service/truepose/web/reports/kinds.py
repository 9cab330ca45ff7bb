"""What every kind of report has in common: where it is listed, and what it is made from."""

from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, TypeAlias

from truepose.domain.sentences import Text
from truepose.web.context import Context
from truepose.web.results.kinds import Choice
from truepose.words.catalogue import Catalogue

if TYPE_CHECKING:
    from truepose.reports.traceability.conditions import ReportConditions

LISTED: Final = 100  # of a kind, at most


@dataclass(frozen=True, slots=True)
class ReportRow:
    """A report as lists name it."""

    kind: str
    id: int
    title: str  # key of the catalogue
    recorded_at: str
    robot: str
    sentence: Text
    simulated: bool
    serial: str = ""
    name: str = ""


@dataclass(frozen=True, slots=True)
class Drawable:
    """What a report is made from, but for its number and the moment."""

    document: object  # the same result as a document
    conditions: Callable[[Catalogue], Awaitable["ReportConditions"]]
    draw: Callable[[Any], str]  # of a module: a worker calls it
    of: Callable[["ReportConditions"], object]  # what it is called with, once the conditions are whole


Rows: TypeAlias = Callable[[Context, str], Awaitable[list[ReportRow]]]
Made: TypeAlias = Callable[[Context, int, Choice, Catalogue], Awaitable[Drawable]]


@dataclass(frozen=True, slots=True)
class ReportKind:
    """A kind of report."""

    name: str  # in its address
    title: str  # key of the catalogue
    rows: Rows  # the latest of a month (`2026-11`), or of all
    drawable: Made
