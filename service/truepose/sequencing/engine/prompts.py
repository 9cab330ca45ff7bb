"""Where a session waits for a person: one open question at a time, and nothing moves while it is open."""

import asyncio
from collections.abc import Sequence
from typing import Final

from truepose.domain.people import announced_as, fault_of_name, tidy_name
from truepose.sequencing.errors import (
    NotNowError,
    PersonMissingError,
    PersonUnknownError,
    PersonUnreadableError,
)

CELL_CLEAR: Final = (
    "The robot is about to move. Is the cell clear of people and things, and is an emergency stop in reach?"
)


class Desk:
    """Holds the open question and wakes the session when it is answered."""

    def __init__(self) -> None:
        self._question: str | None = None
        self._answered = asyncio.Event()

    @property
    def question(self) -> str | None:
        """What a person is asked; None where nothing is asked."""
        return self._question

    def ask(self, question: str) -> None:
        """Put a question; raises NotNowError where one is open already."""
        if self._question is not None:
            raise NotNowError(f"A question is open already: {self._question}")
        self._question = question
        self._answered.clear()

    def answer(self) -> None:
        """Close the question."""
        self._question = None
        self._answered.set()

    async def wait(self) -> None:
        """Wait until the question is closed."""
        await self._answered.wait()


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
