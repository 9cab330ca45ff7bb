"""Who asks the request that is being answered, for whatever reads its body."""

from contextvars import ContextVar
from dataclasses import dataclass
from typing import Annotated, Final

from fastapi import Depends

from truepose.operation.people.register import EVERYBODY, Caller


@dataclass(slots=True)
class Asking:
    """A request, as far as it goes on record."""

    caller: Caller = EVERYBODY
    address: str = ""
    reason: str | None = None  # why, as the body says
    about: str | None = None  # the person whom it is about, where nobody is signed in yet
    renews: bool = False  # keeps what the same person has already: no event


_ASKING: Final[ContextVar[Asking | None]] = ContextVar("asking", default=None)


def asking() -> Asking:
    """Return who asks; everybody where no gate stands before the routes."""
    return _ASKING.get() or Asking()


def begin(found: Asking) -> None:
    """Say who asks, for the rest of this request."""
    _ASKING.set(found)


def signed_in_name() -> str | None:
    """Return the name of whoever is signed in; None where nobody is asked."""
    return asking().caller.name or None


async def _asking() -> Asking:
    return asking()


async def _caller() -> Caller:
    return asking().caller


Asked = Annotated[Asking, Depends(_asking)]
Asker = Annotated[Caller, Depends(_caller)]
