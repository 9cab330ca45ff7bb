"""Errors of the night run.

NightError
├── UnknownCaseError        a night is asked for a case or a bench that there is not
└── UnreadableHistoryError  the file of earlier nights is none
"""

from truepose.demo.errors import DemoError


class NightError(DemoError):
    """Base of every error of the night run."""


class UnknownCaseError(NightError):
    """A night is asked for a case or a bench that there is not."""


class UnreadableHistoryError(NightError):
    """The file of earlier nights is none."""
