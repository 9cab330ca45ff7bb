"""All cases, in the order in which they are asked."""

from truepose_drivers.contract.case import Case, entered_cases
from truepose_drivers.contract.cases import answers, connection, offers

__all__ = ["CASES", "answers", "connection", "offers"]

CASES: tuple[Case, ...] = entered_cases()
