"""What a person is asked, and whose answer counts."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from truepose.domain.people import announced_as, fault_of_name, tidy_name
from truepose.messages.message import Text, message
from truepose.sessions.engine.commands import CommandName
from truepose.sessions.errors import (
    PersonMissingError,
    PersonUnknownError,
    PersonUnreadableError,
)

CELL_CLEAR: Final = message("session.cell_clear")


@dataclass(frozen=True, slots=True)
class Prompt:
    """What a person is asked; whoever answers names it by its number."""

    id: int  # of the line of the ledger that asks it: no other prompt has it
    message: Text
    answered_by: CommandName
    leads_to: tuple[int, ...] = ()  # configurations to which the arm may go once it is answered
    people: tuple[str, ...] = ()  # whose answer counts; empty: of whoever gives a name


def require_person(person: str) -> str:
    """Return the name as it is kept; raises PersonMissingError where there is none that can be read."""
    name = tidy_name(person)
    if not name:
        raise PersonMissingError(message("session.refused.no_name"))
    # A name of one invisible character, U+200B, once confirmed a motion (commit d94012a5).
    fault = fault_of_name(name)
    if fault is not None:
        raise PersonUnreadableError(message("session.refused.unreadable_name", fault=fault))
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
        raise PersonUnknownError(message("session.refused.unknown_person", person=name, people=tuple(people)))
    return known
