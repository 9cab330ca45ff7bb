"""Errors of the reports.

ReportsError
├── UnwritableReportError   the file cannot be written
└── NoPdfError              the machine lacks what a PDF is made with
"""

from truepose.domain.errors import TrueposeError


class ReportsError(TrueposeError):
    """Base of every error of this package."""


class UnwritableReportError(ReportsError):
    """The report cannot be written where it should go."""


class NoPdfError(ReportsError):
    """The machine lacks what a PDF is made with."""
