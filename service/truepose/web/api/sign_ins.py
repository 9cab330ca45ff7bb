"""Signing in and out, and showing once more who it is."""

from typing import Annotated

from fastapi import Request as HttpRequest
from fastapi import Response, status
from pydantic import AfterValidator, Field

from truepose.domain.people import LONGEST_NAME, NAME_PATTERN, Role, tidy_name
from truepose.messages.message import message
from truepose.people.accounts import LONGEST_SECRET, SHORTEST_PASSWORD, Preferences
from truepose.people.errors import SignInRefusedError
from truepose.people.register import Caller
from truepose.people.sign_ins import LONGEST_DAYS, SignedIn
from truepose.storage.people import CredentialKind
from truepose.web.context import Context, Here
from truepose.web.middleware.authorization import cookie_name
from truepose.web.middleware.rights import CurrentRequest
from truepose.web.resources import problems, resource
from truepose.web.schemas import Reply, Request, example

_ANY = r"^[^\u0000-\u001f\u007f]+$"
Name = Annotated[
    str,
    Field(min_length=1, max_length=LONGEST_NAME, pattern=NAME_PATTERN, examples=["Ada Byron"]),
    AfterValidator(tidy_name),
]
Label = Annotated[str, Field(min_length=1, max_length=100, pattern=NAME_PATTERN), AfterValidator(tidy_name)]
Password = Annotated[str, Field(min_length=1, max_length=LONGEST_SECRET, pattern=_ANY)]
NewPassword = Annotated[str, Field(min_length=SHORTEST_PASSWORD, max_length=LONGEST_SECRET, pattern=_ANY)]
Pin = Annotated[str, Field(pattern=r"^[0-9]{4,12}$", description="PIN of 4 to 12 digits.", examples=["4071"])]
Badge = Annotated[
    str,
    Field(min_length=4, max_length=100, pattern=r"^[!-~]+$", description="Text typed by the badge reader."),
]
Secret = Annotated[str, Field(pattern=r"^[A-Za-z0-9_-]{43}$", description="Last part of the link.")]


class SignInRequest(Request):
    """Name, password and tablet of a sign-in."""

    model_config = example({"name": "Ada Byron", "password": "on the looms of Lyon", "tablet": "cell 3"})

    name: Name
    password: Password
    tablet: Label | None = Field(None, description="Name of this browser, for the records.")


class ProofRequest(Request):
    """Proof of identity of the person signed in: either PIN or password."""

    model_config = example({"pin": "4071"})

    pin: Pin | None = None
    password: Password | None = None


class SwitchRequest(Request):
    """Person who takes over the tablet: name or badge, and always the PIN."""

    model_config = example({"name": "Grace Hopper", "pin": "1906"})

    name: Name | None = None
    badge: Badge | None = None
    pin: Pin


class ChosenRequest(Request):
    """New password, PIN or badge; the present password proves the identity."""

    model_config = example({"present_password": "on the looms of Lyon", "pin": "4071"})

    present_password: Password
    password: NewPassword | None = None
    pin: Pin | None = None
    badge: Badge | None = None


class FirstPersonRequest(Request):
    """The first person, who becomes administrator."""

    model_config = example({
        "secret": "5Yl1pMGRTsAjn3ySZyfRcN0t1RZ3Rlbn8Zt4Yk4mG5k",
        "name": "Ada Byron",
        "password": "on the looms of Lyon",
        "pin": "4071",
    })

    secret: Secret
    name: Name
    password: NewPassword
    pin: Pin | None = None


class AcceptRequest(Request):
    """Secrets chosen by a person who was given a link."""

    model_config = example({
        "secret": "5Yl1pMGRTsAjn3ySZyfRcN0t1RZ3Rlbn8Zt4Yk4mG5k",
        "password": "on the looms of Lyon",
        "pin": "4071",
    })

    secret: Secret
    password: NewPassword
    pin: Pin | None = None
    badge: Badge | None = None


class CallerReply(Reply):
    """The caller of the request."""

    accounts: str = Field(
        description="`off`; `open` until the first person is added; or `on`.", examples=["on"]
    )
    name: str | None = Field(
        description="Name of the person; null if nobody is signed in.", examples=["Ada Byron"]
    )
    role: Role | None
    tablet: str = Field(
        description="Name of this browser; empty if the browser has no name.", examples=["cell 3"]
    )
    fresh: bool = Field(description="True if the person proved their identity within the last five minutes.")
    people: list[str] = Field(
        description="People who may take over this browser with a PIN; empty if nobody signed it in."
    )


def chosen_of(wanted: FirstPersonRequest | AcceptRequest | ChosenRequest) -> Preferences:
    """Return what somebody chose."""
    return Preferences(wanted.password, wanted.pin, getattr(wanted, "badge", None))


router = resource(tags=["people"])
_SECRETS = problems(400, 401, 409, 413, 415, 422, 429, 503)
_DAY_S = 24 * 3600


@router.post("/sign-ins", status_code=status.HTTP_201_CREATED, responses=_SECRETS)
async def sign_in(
    here: Here, request: HttpRequest, response: Response, asked: CurrentRequest, wanted: SignInRequest
) -> CallerReply:
    """Sign a browser in with name and password; the cookie in the response keeps it signed in."""
    known = here.people.accounts.register.named(wanted.name)
    # Nobody is signed in yet, and the record of a refusal has to say as whom somebody tried.
    asked.about = None if known is None else known.name
    signed_in = await here.people.accounts.sign_ins.sign_in(
        wanted.name, wanted.password, wanted.tablet or "", asked.address
    )
    return _signed_in(here, request, response, signed_in)


@router.get("/sign-ins/present", responses=problems(503))
async def get_caller(here: Here, asked: CurrentRequest) -> CallerReply:
    """Return who is signed in, and whether signing in is required."""
    return caller_reply(here, asked.caller)


@router.delete("/sign-ins/present", status_code=status.HTTP_204_NO_CONTENT, responses=problems(503))
async def sign_out(here: Here, request: HttpRequest, response: Response, asked: CurrentRequest) -> None:
    """Sign this browser out."""
    await here.people.accounts.sign_ins.sign_out(asked.caller)
    response.delete_cookie(cookie_name(request.scope), secure=_is_secure(request), httponly=True)


@router.post("/sign-ins/present/fresh", responses=_SECRETS)
async def show_again(here: Here, asked: CurrentRequest, wanted: ProofRequest) -> CallerReply:
    """Prove the identity again with PIN or password; motions may be started for the next five minutes."""
    kind = CredentialKind.PASSWORD if wanted.pin is None else CredentialKind.PIN
    secret = wanted.password if wanted.pin is None else wanted.pin
    await here.people.accounts.sign_ins.show(asked.caller, kind, secret or "")
    return caller_reply(here, asked.caller)


@router.post("/sign-ins/present/person", responses=_SECRETS)
async def switch_person(
    here: Here, request: HttpRequest, response: Response, asked: CurrentRequest, wanted: SwitchRequest
) -> CallerReply:
    """Switch to another person at this browser, by name or badge, and PIN."""
    switched = await here.people.accounts.sign_ins.switch(asked.caller, wanted.name, wanted.badge, wanted.pin)
    return _signed_in(here, request, response, switched)


@router.put("/sign-ins/present/secrets", responses=_SECRETS)
async def choose_secrets(
    here: Here, request: HttpRequest, response: Response, asked: CurrentRequest, wanted: ChosenRequest
) -> CallerReply:
    """Choose a new password, PIN or badge; a new password signs out all other browsers."""
    person = asked.caller.person
    if person is None or asked.caller.sign_in is None:
        raise SignInRefusedError(message("refused.sign_in"))
    sign_ins = here.people.accounts.sign_ins
    await sign_ins.show(asked.caller, CredentialKind.PASSWORD, wanted.present_password)
    kept = await here.people.accounts.choose(person, chosen_of(wanted), resting_on=[asked.caller.sign_in])
    # A new password has closed this browser too; it is opened anew for whoever has just proved who they are.
    if sign_ins.lasts(asked.caller):
        return caller_reply(here, asked.caller)
    opened = await sign_ins.opened(person, asked.caller.tablet_name, asked.address, resting_on=kept)
    return _signed_in(here, request, response, opened)


@router.post("/first-person", status_code=status.HTTP_201_CREATED, responses=_SECRETS)
async def enter_first_person(
    here: Here, request: HttpRequest, response: Response, asked: CurrentRequest, wanted: FirstPersonRequest
) -> CallerReply:
    """Add the first person, who becomes administrator; from then on, everybody must sign in."""
    asked.about = wanted.name
    signed_in = await here.people.accounts.enter_first(
        wanted.secret, wanted.name, chosen_of(wanted), asked.address
    )
    return _signed_in(here, request, response, signed_in)


@router.post("/links/accepted", status_code=status.HTTP_201_CREATED, responses=_SECRETS)
async def accept_link(
    here: Here, request: HttpRequest, response: Response, asked: CurrentRequest, wanted: AcceptRequest
) -> CallerReply:
    """Choose a password and PIN with the link from an administrator; the link works once."""
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


def _signed_in(here: Context, request: HttpRequest, response: Response, signed_in: SignedIn) -> CallerReply:
    response.set_cookie(
        cookie_name(request.scope),
        signed_in.secret,
        max_age=LONGEST_DAYS * _DAY_S,
        secure=_is_secure(request),
        httponly=True,
        samesite="strict",
    )
    return caller_reply(here, signed_in.caller)


def _is_secure(request: HttpRequest) -> bool:
    return str(request.scope["scheme"]) == "https"
