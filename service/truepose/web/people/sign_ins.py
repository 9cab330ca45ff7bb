"""Signing in and out, and showing once more who it is."""

from fastapi import Request, Response, status

from truepose.domain.people.accounts import Person
from truepose.operation.people.errors import SignInRefusedError
from truepose.operation.people.register import Caller
from truepose.operation.people.sign_ins import LONGEST_DAYS, SignedIn
from truepose.storage.people.credentials import CredentialKind
from truepose.web.context import Context, Here
from truepose.web.people.asking import Asked
from truepose.web.people.gate import cookie_name
from truepose.web.people.schemas import (
    AcceptRequest,
    CallerReply,
    ChosenRequest,
    FirstPersonRequest,
    ProofRequest,
    SignInRequest,
    SwitchRequest,
    chosen_of,
)
from truepose.web.problems import problems
from truepose.web.resources import resource

router = resource(tags=["people"])
_SECRETS = problems(400, 401, 409, 413, 415, 422, 429, 503)
_DAY_S = 24 * 3600


@router.post("/sign-ins", status_code=status.HTTP_201_CREATED, responses=_SECRETS)
async def sign_in(
    here: Here, request: Request, response: Response, asked: Asked, wanted: SignInRequest
) -> CallerReply:
    """Sign a browser in with name and password; the answer's cookie keeps it so."""
    known = here.people.accounts.register.named(wanted.name)
    asked.about = None if known is None else known.name
    signed_in = await here.people.accounts.sign_ins.sign_in(
        wanted.name, wanted.password, wanted.tablet or "", asked.address
    )
    return _signed_in(here, request, response, signed_in)


@router.get("/sign-ins/present", responses=problems(503))
async def get_caller(here: Here, asked: Asked) -> CallerReply:
    """Say who is signed in, and whether anybody has to be."""
    return caller_reply(here, asked.caller)


@router.delete("/sign-ins/present", status_code=status.HTTP_204_NO_CONTENT, responses=problems(503))
async def sign_out(here: Here, request: Request, response: Response, asked: Asked) -> None:
    """Sign this browser out."""
    await here.people.accounts.sign_ins.sign_out(asked.caller)
    response.delete_cookie(cookie_name(request.scope), secure=_is_secure(request), httponly=True)


@router.post("/sign-ins/present/fresh", responses=_SECRETS)
async def show_again(here: Here, asked: Asked, wanted: ProofRequest) -> CallerReply:
    """Show once more, by PIN or password, who it is; for five minutes an arm may be let move."""
    kind = CredentialKind.PASSWORD if wanted.pin is None else CredentialKind.PIN
    secret = wanted.password if wanted.pin is None else wanted.pin
    await here.people.accounts.sign_ins.show(asked.caller, kind, secret or "")
    return caller_reply(here, asked.caller)


@router.post("/sign-ins/present/person", responses=_SECRETS)
async def switch_person(
    here: Here, request: Request, response: Response, asked: Asked, wanted: SwitchRequest
) -> CallerReply:
    """Have somebody else stand before this browser: by name or badge, and a PIN."""
    who = await _meant(here, wanted)
    switched = await here.people.accounts.sign_ins.switch(asked.caller, who, wanted.pin)
    return _signed_in(here, request, response, switched)


@router.put("/sign-ins/present/secrets", responses=_SECRETS)
async def choose_secrets(
    here: Here, request: Request, response: Response, asked: Asked, wanted: ChosenRequest
) -> CallerReply:
    """Choose another password, PIN or badge; a new password signs out every other browser."""
    person = asked.caller.person
    if person is None or asked.caller.sign_in is None:
        raise SignInRefusedError("Sign in first, with your password.")
    sign_ins = here.people.accounts.sign_ins
    await sign_ins.show(asked.caller, CredentialKind.PASSWORD, wanted.present_password)
    await here.people.accounts.choose(person, chosen_of(wanted))
    if sign_ins.lasts(asked.caller):
        return caller_reply(here, asked.caller)
    opened = await sign_ins.opened(person, asked.caller.tablet_name, asked.address)
    return _signed_in(here, request, response, opened)


@router.post("/first-person", status_code=status.HTTP_201_CREATED, responses=_SECRETS)
async def enter_first_person(
    here: Here, request: Request, response: Response, asked: Asked, wanted: FirstPersonRequest
) -> CallerReply:
    """Enter the first person, who becomes administrator; from then on everybody signs in."""
    asked.about = wanted.name
    signed_in = await here.people.accounts.enter_first(
        wanted.secret, wanted.name, chosen_of(wanted), asked.address
    )
    return _signed_in(here, request, response, signed_in)


@router.post("/links/accepted", status_code=status.HTTP_201_CREATED, responses=_SECRETS)
async def accept_link(
    here: Here, request: Request, response: Response, asked: Asked, wanted: AcceptRequest
) -> CallerReply:
    """Choose a password, and a PIN, by the link that an administrator gave; it works once."""
    invited = here.people.accounts.invited(wanted.secret)
    asked.about = None if invited is None else invited.name
    signed_in = await here.people.accounts.accept(wanted.secret, chosen_of(wanted), asked.address)
    return _signed_in(here, request, response, signed_in)


def caller_reply(here: Context, caller: Caller) -> CallerReply:
    """Return who is asking, as a page shows it."""
    accounts = here.people.accounts
    with_pin = [p.name for p in accounts.register.people if p.active and accounts.has_pin(p)]
    return CallerReply(
        accounts="off" if not accounts.asked_for else "open" if accounts.are_open else "on",
        name=caller.name or None,
        role=caller.role,
        tablet=caller.tablet_name,
        fresh=accounts.sign_ins.is_fresh(caller),
        people=with_pin if caller.sign_in is not None else [],
    )


async def _meant(here: Context, wanted: SwitchRequest) -> Person | None:
    if wanted.badge is not None:
        return await here.people.accounts.sign_ins.badge_of(wanted.badge)
    return None if wanted.name is None else here.people.accounts.register.named(wanted.name)


def _signed_in(here: Context, request: Request, response: Response, signed_in: SignedIn) -> CallerReply:
    response.set_cookie(
        cookie_name(request.scope),
        signed_in.secret,
        max_age=LONGEST_DAYS * _DAY_S,
        secure=_is_secure(request),
        httponly=True,
        samesite="strict",
    )
    return caller_reply(here, signed_in.caller)


def _is_secure(request: Request) -> bool:
    return str(request.scope["scheme"]) == "https"
