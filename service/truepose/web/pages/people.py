"""Pages of signing in, of people and of their acts; each asks the public API, as any client does."""

from http import HTTPStatus
from typing import Annotated, Final

from fastapi import APIRouter, Query
from fastapi.responses import HTMLResponse, RedirectResponse, Response

from truepose.domain.people import OF_PROGRAMS, Role
from truepose.storage.people import CredentialKind
from truepose.web.api.people import Before, listed_people, listed_tokens
from truepose.web.pages.rendering import Visited

router = APIRouter(include_in_schema=False)
_SHOWN: Final = 100


@router.get("/sign-in", response_class=HTMLResponse)
async def sign_in_page(visit: Visited) -> HTMLResponse:
    """Ask who it is."""
    return visit.page("people/sign_in.html")


@router.get("/first-person/{secret}", response_class=HTMLResponse)
async def first_person_page(visit: Visited, secret: str) -> HTMLResponse:
    """Ask for the first person, by the link that the service printed."""
    accounts = visit.here.people.accounts
    return _choosing(visit, "first", "" if accounts.opens_first(secret) else None)


@router.get("/welcome/{secret}", response_class=HTMLResponse)
async def welcome_page(visit: Visited, secret: str) -> HTMLResponse:
    """Let somebody choose a password, by their link."""
    invited = visit.here.people.accounts.invited(secret)
    return _choosing(visit, "welcome", None if invited is None else invited.name)


@router.get("/not-yours", response_class=HTMLResponse)
async def not_yours_page(visit: Visited, page: Annotated[str, Query(max_length=200)] = "") -> HTMLResponse:
    """Say that a page is for somebody else, and let them come to the tablet."""
    return visit.page("people/not_yours.html", HTTPStatus.FORBIDDEN, page=page)


@router.get("/account", response_class=HTMLResponse)
async def account_page(visit: Visited) -> Response:
    """Let whoever is signed in choose another password, PIN or badge."""
    person = visit.caller.person
    if person is None or visit.caller.sign_in is None:
        return RedirectResponse("/sign-in?next=/account", HTTPStatus.SEE_OTHER)
    of_person = visit.here.people.accounts.register.of
    return visit.page(
        "people/account.html",
        person=person,
        has_pin=visit.here.people.accounts.has_pin(person),
        has_badge=bool(of_person(person.id, CredentialKind.BADGE)),
    )


@router.get("/people", response_class=HTMLResponse)
async def people_page(visit: Visited) -> HTMLResponse:
    """Show who is let in, people and programs."""
    here = visit.here
    return visit.page(
        "people/people.html",
        people=listed_people(here),
        tokens=listed_tokens(here),
        of_people=[role for role in Role if role not in OF_PROGRAMS],
        of_programs=[Role.DEVICE, Role.PLANT, Role.VIEWER, Role.OPERATOR, Role.METROLOGIST],
        nobody=here.people.accounts.nobody_entered,
    )


@router.get("/audit", response_class=HTMLResponse)
async def audit_page(
    visit: Visited, q: Annotated[str, Query(max_length=200)] = "", before: Before = None
) -> HTMLResponse:
    """Show who changed what, newest first."""
    people = visit.here.people
    await people.log.written()
    found = await people.acts.newest(before, _SHOWN, q)
    return visit.page(
        "people/audit.html",
        acts=found,
        total=await people.acts.count(q),
        search=q,
        before=before,
        older=found[-1].id if len(found) == _SHOWN else None,
        recording=not people.accounts.are_open,
    )


def _choosing(visit: Visited, kind: str, name: str | None) -> HTMLResponse:
    """Return the page on which somebody chooses a password; None: their link opens nothing."""
    if name is None:
        return visit.page("people/link_over.html", HTTPStatus.UNAUTHORIZED)
    return visit.page("people/choose.html", kind=kind, name=name)
