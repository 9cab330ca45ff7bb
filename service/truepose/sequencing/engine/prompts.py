"""What a person is asked, and whose answer counts."""

from collections.abc import Sequence
from typing import Final

from truepose.domain.people.names import announced_as, fault_of_name, tidy_name
from truepose.sequencing.errors import (
    PersonMissingError,
    PersonUnknownError,
    PersonUnreadableError,
)

CELL_CLEAR: Final = (
    "The robot is about to move. Is the cell clear of people and things, and is an emergency stop in reach?"
)


def require_person(person: str) -> str:
    """Return the name as it is kept; raises PersonMissingError where there is none that can be read."""
    name = tidy_name(person)
    if not name:
        raise PersonMissingError("A confirmation needs the name of the person who looked at the cell.")
    fault = fault_of_name(name)
    if fault is not None:
        raise PersonUnreadableError(
            f"A confirmation needs a name that can be read; the one that was given {fault}."
        )
    return name


def require_announced(person: str, people: Sequence[str]) -> str:
    """Return the name as the cell announces it; where it announces nobody, every name that can be read.

    Raises PersonMissingError, PersonUnknownError.
    """
    name = require_person(person)
    if not people:
        return name
    known = announced_as(name, people)
    if known is None:
        raise PersonUnknownError(
            f"{name} is not among the people of this cell ({', '.join(people)}). Let one of them confirm, or "
            "have the name added to `people` in the cell file."
        )
    return known
