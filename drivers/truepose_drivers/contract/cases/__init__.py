"""All cases, in the order in which they are asked."""

from truepose_drivers.contract.case import Case, entered_cases
from truepose_drivers.contract.cases import answers, connection, interruptions, offers, targets

__all__ = ["CASES", "answers", "connection", "interruptions", "offers", "targets"]

CASES: tuple[Case, ...] = entered_cases()
