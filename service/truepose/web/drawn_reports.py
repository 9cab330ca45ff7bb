"""What a worker process draws of a report, without the framework of pages, whose import takes a second."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

from truepose.analysis.job_queue.tasks import held_out, stored_campaign

if TYPE_CHECKING:
    from truepose.domain.identification import Identification, Model
    from truepose.domain.validation import Validation
    from truepose.reports.traceability import ReportConditions


class Drawn(Protocol):
    """A report, or a result as it is stored, which a worker unpacks."""

    def page(self) -> str:
        """Return the report as a page."""


def draw_content(report: Any) -> str:
    """Return a report without its frame and cover; a worker calls it."""
    content: str = report.content()
    return content


def draw_page(report: Drawn) -> str:
    """Return a report as a page; a worker calls it."""
    return report.page()


@dataclass(frozen=True, slots=True)
class StoredIdentification:
    """An identification with its campaign as it is stored: unpacked where the report is drawn."""

    identification: "Identification"
    campaign: bytes
    conditions: "ReportConditions"
    language: str

    def page(self) -> str:
        """Return its report as a page."""
        from truepose.reports.identification.report import IdentificationReport

        campaign = stored_campaign(self.campaign, self.identification.set_aside)
        return IdentificationReport(
            self.identification, campaign, conditions=self.conditions, language=self.language
        ).page()


@dataclass(frozen=True, slots=True)
class StoredValidation:
    """A validation with what it is of, as it is stored: unpacked where the report is drawn."""

    validation: "Validation"
    model: "Model"
    campaign: bytes
    conditions: "ReportConditions"
    language: str

    def page(self) -> str:
        """Return its report as a page."""
        from truepose.reports.validation import ValidationReport
        from truepose.validation.cautions import validation_cautions

        readings = held_out(stored_campaign(self.campaign))
        remarks = tuple(validation_cautions(self.model, readings))
        return ValidationReport(
            self.validation,
            self.model,
            readings,
            remarks,
            conditions=self.conditions,
            language=self.language,
        ).page()
