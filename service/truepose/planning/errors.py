"""Errors of planning: each message is one sentence that says what to change in the cell or the request.

PlanningError ├── WorkSpaceError what is said of the cell does not allow any configuration ├──
TooFewCandidatesError fewer configurations are feasible than were asked for ├── AimError no joints near a pose
give its legs the wanted lengths └── NoWayError no clear way was found from one stop to the next, or to any in
its place └── ArmInTheWayError the arm would stand where the base fixture is put next
"""

from truepose.domain.errors import TrueposeError


class PlanningError(TrueposeError):
    """Base of every error of planning."""


class WorkSpaceError(PlanningError):
    """What is said of the cell does not allow any configuration."""


class TooFewCandidatesError(PlanningError):
    """Fewer configurations are feasible than were asked for."""


class AimError(PlanningError):
    """No joints near a pose give its legs the wanted lengths."""


class NoWayError(PlanningError):
    """No clear way was found from one stop to the next."""


class ArmInTheWayError(NoWayError):
    """The arm would stand where the base fixture is put next.

    Parameters
    ----------
    placement : int
        Of the base fixture, 1-based.
    """

    def __init__(self, placement: int) -> None:
        super().__init__(
            f"The arm would be in the way when the base fixture is moved to placement {placement}. "
            "Choose a placement farther from the previous one."
        )
