"""Errors of planning.

PlanningError
├── WorkSpaceError           what is said of the cell does not allow any configuration
└── TooFewCandidatesError    fewer configurations are feasible than were asked for
"""

from service.domain.errors import TrueposeError


class PlanningError(TrueposeError):
    """Base of every error of planning."""


class WorkSpaceError(PlanningError):
    """What is said of the cell does not allow any configuration."""


class TooFewCandidatesError(PlanningError):
    """Fewer configurations are feasible than were asked for."""
