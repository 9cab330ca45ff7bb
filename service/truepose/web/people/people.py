"""People and programs that are let in: for administrators."""

from fastapi import status

from truepose.domain.people.accounts import Person
from truepose.operation.people.errors import UnknownPersonError
from truepose.storage.people.credentials import CredentialKind, CredentialRecord
from truepose.web.context import Context, Here
from truepose.web.people.asking import Asker
from truepose.web.people.schemas import (
    EnteredReply,
    EnterRequest,
    NewTokenReply,
    PeopleReply,
    PersonReply,
    RoleRequest,
    TokenReply,
    TokenRequest,
    TokensReply,
)
from truepose.web.problems import problems
from truepose.web.requests.parameters import Id
from truepose.web.resources import resource

router = resource(tags=["people"])
_CHANGE = problems(400, 404, 409, 413, 415, 422, 503)
_REVOKE = problems(404, 409, 422, 503)
_HOURS_A_DAY = 24
_OF_MACHINE = "somebody at this computer"  # nobody is asked who they are


@router.get("/people", responses=problems(503))
async def list_people(here: Here) -> PeopleReply:
    """List everybody who is let in."""
    return PeopleReply(people=listed_people(here))


@router.post("/people", status_code=status.HTTP_201_CREATED, responses=_CHANGE)
async def enter_person(here: Here, asker: Asker, wanted: EnterRequest) -> EnteredReply:
    """Enter somebody; they choose their password by the link in the answer."""
    accounts = here.people.accounts
    if asker.machine:
        person, secret = await accounts.enter_by_machine(wanted.name, wanted.role)
    else:
        person, secret = await accounts.enter(wanted.name, wanted.role, asker.name or _OF_MACHINE)
    return EnteredReply(person=_reply(here, person), link=f"/welcome/{secret}")


@router.put("/people/{id}/role", responses=_CHANGE)
async def change_role(here: Here, asker: Asker, id: Id, wanted: RoleRequest) -> PersonReply:
    """Change what somebody may do, from this moment on."""
    found = await here.people.accounts.register.change_role(
        _person(here, id), wanted.role, asker.name or _OF_MACHINE
    )
    return _reply(here, found)


@router.delete("/people/{id}", status_code=status.HTTP_204_NO_CONTENT, responses=_REVOKE)
async def remove_person(here: Here, asker: Asker, id: Id) -> None:
    """Let somebody in no more; their browsers and programs are out at once, their acts stay."""
    await here.people.accounts.register.remove(_person(here, id), asker.name or _OF_MACHINE)


@router.post("/people/{id}/link", status_code=status.HTTP_201_CREATED, responses=_REVOKE)
async def make_link(here: Here, asker: Asker, id: Id) -> EnteredReply:
    """Make somebody a new link to choose a password; the one before opens nothing any more."""
    person = _person(here, id)
    secret = await here.people.accounts.link(person, asker.name or _OF_MACHINE)
    return EnteredReply(person=_reply(here, person), link=f"/welcome/{secret}")


@router.get("/tokens", responses=problems(503))
async def list_tokens(here: Here) -> TokensReply:
    """List the programs that are let in."""
    return TokensReply(tokens=listed_tokens(here))


@router.post("/tokens", status_code=status.HTTP_201_CREATED, responses=_CHANGE)
async def make_token(here: Here, asker: Asker, wanted: TokenRequest) -> NewTokenReply:
    """Let a program in, on behalf of somebody; the secret is shown this once."""
    owner = here.people.accounts.register.require(wanted.owner)
    by = asker.name or _OF_MACHINE
    record, secret = await here.people.accounts.make_token(
        owner, wanted.name, wanted.role, wanted.hours / _HOURS_A_DAY, by
    )
    return NewTokenReply(token=_token(here, record), secret=secret)


@router.delete("/tokens/{id}", status_code=status.HTTP_204_NO_CONTENT, responses=_REVOKE)
async def revoke_token(here: Here, asker: Asker, id: Id) -> None:
    """Let a program in no more, from this moment on."""
    if id not in {record.id for record in _tokens(here)}:
        raise UnknownPersonError(f"There is no token {id}.")
    await here.people.accounts.register.revoke(id, by=asker.name or _OF_MACHINE)


def listed_people(here: Context) -> list[PersonReply]:
    """Return everybody who is let in."""
    return [_reply(here, person) for person in here.people.accounts.register.people if person.active]


def listed_tokens(here: Context) -> list[TokenReply]:
    """Return the programs that are let in."""
    return [_token(here, record) for record in _tokens(here)]


def _tokens(here: Context) -> list[CredentialRecord]:
    return [r for r in here.people.accounts.register.credentials if r.kind is CredentialKind.TOKEN]


def _token(here: Context, record: CredentialRecord) -> TokenReply:
    owner = here.people.accounts.register.person(record.person_id)
    return TokenReply.about(record, "" if owner is None else owner.name)


def _person(here: Context, number: int) -> Person:
    found = here.people.accounts.register.person(number)
    if found is None:
        raise UnknownPersonError(f"There is no person {number}.")
    return found


def _reply(here: Context, person: Person) -> PersonReply:
    accounts = here.people.accounts
    kinds = {record.kind.value for record in accounts.register.of(person.id, *CredentialKind)}
    return PersonReply.about(person, kinds, has_pin=accounts.has_pin(person))
