"""Errors of the demo.

DemoError
├── UnusableScenarioError   the service refuses the cell that it was asked for
├── ServiceFailedError      the service did not start, or does not answer any more
├── RequestRefusedError     the service answered a request with a problem
├── SessionHaltedError      a session paused or ended before everything was measured
├── JobFailedError          a job ended without a result
└── TruthUnknownError       the simulated cell did not tell its truth
"""

from truepose.domain.errors import TrueposeError


class DemoError(TrueposeError):
    """Base of every error of the demo."""


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
