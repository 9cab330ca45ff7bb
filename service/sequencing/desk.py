"""Where a session waits for a person: one open question at a time, and nothing moves while it is open."""

import asyncio
from typing import Final

from service.sequencing.errors import NotNowError, PersonMissingError

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
    """Return the name without blanks around it; raises PersonMissingError where nothing is left."""
    name = person.strip()
    if not name:
        raise PersonMissingError("A confirmation needs the name of the person who looked at the cell.")
    return name
