"""A report of whatever kind: one description, of which its page, its file and its PDF are made.

A kind says in its own file what it is of (`Report`) and what of that is shown (`Description`). Its template
lays that out, and what a terminal shows too are tables of the same file. Nothing else knows the kind.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from markupsafe import Markup

from truepose.messages.catalogue import ENGLISH, Catalogue, catalogue
from truepose.reports.cover_page import Front, front_page
from truepose.reports.pages import rendered
from truepose.reports.paper import write_report_text
from truepose.reports.traceability import (
    Audit,
    PageMargins,
    ReportConditions,
    audit_rows,
    condition_rows,
    imprint_of,
)


@dataclass(frozen=True, slots=True)
class Description:
    """What a report shows."""

    title: str
    robot: str
    template: str  # of its content
    filled_in: Mapping[str, object]
    front: Front | None = None
    imprint: PageMargins | None = None  # None: of the robot


@dataclass(frozen=True, slots=True, kw_only=True)
class Report(ABC):
    """A result as people read it.

    Attributes
    ----------
    conditions : ReportConditions
    language : str
        One of `LANGUAGES`, with units where they are others.
    audit : Audit or None
        The records behind the result of a session; None: it is of no session.
    """

    conditions: ReportConditions = field(default_factory=ReportConditions)
    language: str = ENGLISH
    audit: Audit | None = None

    @abstractmethod
    def described(self, words: Catalogue) -> Description:
        """Return what is shown of it, whatever shows it."""

    @property
    def simulated(self) -> bool:
        """Whether its readings come from simulated devices."""
        return self.conditions.simulated

    def content(self) -> Markup:
        """Return it without a frame, for a page that has one of its own."""
        words = catalogue(self.language)
        found = self.described(words)
        return rendered(found.template, **self._filled_in(found, words), framed=False)

    def page(self) -> Markup:
        """Return it as one self-contained page that begins with its cover."""
        words = catalogue(self.language)
        found = self.described(words)
        front = None if found.front is None else front_page(found.front, self.conditions, words)
        return rendered(
            "report.html",
            **self._filled_in(found, words),
            framed=True,
            title=found.title,
            content=found.template,
            front=front,
            imprint=found.imprint or imprint_of(found.robot, self.conditions, words),
            simulated=self.simulated,
        )

    def write(self, path: Path) -> None:
        """Write the page into a file, replaced where it exists: as a PDF where its name ends in `.pdf`.

        Raises
        ------
        UnwritableReportError
            The file cannot be written.
        NoPdfError
            It should be a PDF, and the machine lacks the library that sets text.
        """
        write_report_text(path, self.page())

    def _filled_in(self, found: Description, words: Catalogue) -> dict[str, object]:
        return {
            "words": words,
            "say": words.say,
            "robot": found.robot,
            "outcome": "" if found.front is None else found.front.outcome,
            "conditions": self.conditions,
            "condition_rows": tuple(condition_rows(self.conditions, words)),
            "audit": self.audit,
            "audit_rows": () if self.audit is None else tuple(audit_rows(self.audit, words)),
            **found.filled_in,
        }
