"""Who acts in a session: many may look, one acts, and whoever takes over says so.

Programs are not hindered by it: they answer for what they do by themselves. Halting is for everybody.
"""

from typing import Final

from fastapi import status
from pydantic import Field

from truepose.domain.people import Role, reaches
from truepose.domain.session import SessionState
from truepose.messages.message import message
from truepose.people.errors import FreshSignInNeededError, NotAllowedError
from truepose.people.leases import LEASE_S, Lease
from truepose.people.register import Caller
from truepose.sessions.engine.commands import HALTS, LETS_MOVE, CommandName
from truepose.web.context import Context, Here
from truepose.web.middleware.rights import CurrentCaller, current_request
from truepose.web.resources import READ, Id, problems, resource
from truepose.web.schemas import Reply, Request, example


class AuthorityRequest(Request):
    """Whether to take over the session from the person who controls it."""

    model_config = example({"take_over": False})

    take_over: bool = False


class AuthorityReply(Reply):
    """Person who controls a session."""

    person: str | None = Field(
        description="Person in control; null if anyone may take control.", examples=["Ada Byron"]
    )
    tablet: str = Field(description="Tablet of this person; empty if not named.", examples=["cell 3"])
    mine: bool = Field(description="True if the caller is in control.")
    left_s: float = Field(
        description="Remaining time until control lapses unless it is renewed.", examples=[LEASE_S]
    )


router = resource("/sessions", tags=["people"])
TAKEN_FROM: Final = "taken over from "  # the reason of such an act, before the name of who had it
_SHOWN_FIRST: Final = LETS_MOVE | {CommandName.HAND_OVER}


async def require_authority(here: Context, session_id: int, act: CommandName) -> None:
    """Raise where whoever asks may not do this in a session now.

    Raises NotAllowedError, FreshSignInNeededError, SomebodyElseActsError.
    """
    caller = current_request().caller
    if caller.everybody or act in HALTS:
        return
    if caller.role is None or not reaches(caller.role, Role.OPERATOR):
        raise NotAllowedError(message("refused.role", who=caller.name, role=str(caller.role or "")))
    # A program's token: it answers for what it does by itself, and shows nothing afresh.
    if caller.sign_in is None:
        return
    if act in _SHOWN_FIRST and not _goes_on(here, session_id, act) and not _is_fresh(here, caller):
        raise FreshSignInNeededError
    if act is CommandName.HAND_OVER:
        here.people.leases.take_over(session_id, caller)
    else:
        here.people.leases.claim(session_id, caller)


@router.get("/{id}/authority", responses=READ)
async def get_authority(here: Here, asker: CurrentCaller, id: Id) -> AuthorityReply:
    """Return who controls a session."""
    await here.sessions.get(id)
    return _reply(here, here.people.leases.of(id), asker)


@router.put("/{id}/authority", responses=problems(400, 403, 404, 409, 413, 415, 422, 503))
async def claim_authority(
    here: Here, asker: CurrentCaller, id: Id, wanted: AuthorityRequest
) -> AuthorityReply:
    """Take or renew control of a session; a page renews it every few seconds.

    Another person, or the same person at another tablet, takes control only with `take_over`.
    """
    await here.sessions.get(id)
    if asker.everybody or asker.sign_in is None:
        return _reply(here, None, asker)
    held = here.people.leases.of(id)
    # A page asks every few seconds: put on record, that would be a row each time.
    current_request().renews = held is not None and held.is_of(asker)
    if wanted.take_over:
        if not _is_fresh(here, asker):
            raise FreshSignInNeededError
        _give_reason(held, asker)
        return _reply(here, here.people.leases.take_over(id, asker), asker)
    return _reply(here, here.people.leases.claim(id, asker), asker)


@router.delete("/{id}/authority", status_code=status.HTTP_204_NO_CONTENT, responses=READ)
async def give_up_authority(here: Here, asker: CurrentCaller, id: Id) -> None:
    """Give up control of a session, so that anyone may take it."""
    await here.sessions.get(id)
    here.people.leases.give_up(id, asker)


def _give_reason(held: Lease | None, asker: Caller) -> None:
    """Put on record from whom the authority is taken; to go on having it is no event."""
    if held is not None and not held.is_of(asker):
        current_request().reason = f"{TAKEN_FROM}{held.person}"


def _goes_on(here: Context, session_id: int, act: CommandName) -> bool:
    """Whether a session is under way, so that each motion is confirmed by whoever has been acting."""
    # Asked for at each pose, a PIN would soon be written on the arm (decision 0057).
    under_way = here.session_desk.under_way(session_id)
    running = under_way is not None and under_way.runner.state is SessionState.RUNNING
    return act is CommandName.CONFIRM and running


def _is_fresh(here: Context, caller: Caller) -> bool:
    return here.people.accounts.sign_ins.is_fresh(caller)


def _reply(here: Context, lease: Lease | None, asker: Caller) -> AuthorityReply:
    if lease is None:
        return AuthorityReply(person=None, tablet="", mine=False, left_s=0.0)
    return AuthorityReply(
        person=lease.person,
        tablet=lease.tablet_name,
        mine=lease.is_of(asker),
        left_s=round(here.people.leases.left_s(lease), 1),
    )
