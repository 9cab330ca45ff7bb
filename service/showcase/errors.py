"""Errors of the showcase runs.

ShowcaseError
├── UnusableScenarioError   the service refuses the cell that it was asked for
├── ServiceFailedError      the service did not start, or does not answer any more
├── RequestRefusedError     the service answered a request with a problem
├── SessionHaltedError      a session paused or ended before everything was measured
├── JobFailedError          a job ended without a result
└── TruthUnknownError       the simulated cell did not tell its truth
"""

from service.domain.errors import TrueposeError


class ShowcaseError(TrueposeError):
    """Base of every error of the showcase runs."""


class UnusableScenarioError(ShowcaseError):
    """The service refuses the cell that it was asked for."""


class ServiceFailedError(ShowcaseError):
    """The service did not start, or does not answer any more."""


class RequestRefusedError(ShowcaseError):
    """The service answered a request with a problem."""


class SessionHaltedError(ShowcaseError):
    """A session paused or ended before everything was measured."""


class JobFailedError(ShowcaseError):
    """A job ended without a result."""


class TruthUnknownError(ShowcaseError):
    """The simulated cell did not tell its truth."""
