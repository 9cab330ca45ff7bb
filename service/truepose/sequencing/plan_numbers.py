"""Numbers of a plan, whatever it measures with: which of them are none that a session could keep to."""

from math import inf

from truepose.domain.measurement.ballbar import BallbarPlan
from truepose.domain.measurement.contacts import ContactPlan
from truepose.domain.measurement.session import SessionPlan
from truepose.sequencing.errors import PlanRefusedError


def check_numbers(plan: SessionPlan | BallbarPlan | ContactPlan, *positive: str) -> None:
    """Raise PlanRefusedError for the first of the `positive` that is not, or for a negative rest."""
    for name in positive:
        value = getattr(plan, name)
        if not 0 < value < inf:
            raise PlanRefusedError(f"The plan's {name} is {value}; it must be above 0.")
    if not 0 <= plan.settle_s < inf:
        raise PlanRefusedError(f"The plan's settle_s is {plan.settle_s}; it must not be negative.")
