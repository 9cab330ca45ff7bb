"""Errors of the demo and the night run.

DemoError
├── UnusableScenarioError   the service refuses the cell that it was asked for
├── ServiceFailedError      the service did not start, or does not answer any more
├── RequestRefusedError     the service answered a request with a problem
├── SessionHaltedError      a session paused or ended before everything was measured
├── JobFailedError          a job ended without a result
├── TruthUnknownError       the simulated cell did not tell its truth
├── UnknownCaseError        a night is asked for a case or a bench that there is not
└── UnreadableHistoryError  the file of earlier nights is none
"""

from truepose.domain.errors import TrueposeError


class DemoError(TrueposeError):
    """Base of every error of the demo and the night run."""


class UnusableScenarioError(DemoError):
    """The service refuses the cell that it was asked for."""


class ServiceFailedError(DemoError):
    """The service did not start, or does not answer any more."""


class RequestRefusedError(DemoError):
    """The service answered a request with a problem."""


class SessionHaltedError(DemoError):
    """A session paused or ended before everything was measured."""


class JobFailedError(DemoError):
    """A job ended without a result."""


class TruthUnknownError(DemoError):
    """The simulated cell did not tell its truth."""


class UnknownCaseError(DemoError):
    """A night is asked for a case or a bench that there is not."""


class UnreadableHistoryError(DemoError):
    """The file of earlier nights is none."""
