"""People and programs that are let in, for administrators; and the record of what they did."""

import json
from collections.abc import AsyncIterator
from typing import Annotated, Final

from fastapi import Depends, Query, status
from fastapi.responses import Response, StreamingResponse
from pydantic import Field

from truepose.domain.people import Person, Role
from truepose.messages.message import message
from truepose.people.accounts import LINK_DAYS
from truepose.people.errors import UnknownPersonError
from truepose.storage.people import ActRecord, CredentialKind, CredentialRecord
from truepose.storage.records import Page
from truepose.web.api.sign_ins import Label, Name
from truepose.web.context import Context, Here
from truepose.web.middleware.rights import CurrentCaller
from truepose.web.resources import ACT, CHANGE, Id, problems, resource, sending
from truepose.web.schemas import NUMBER_LIMIT, RecordedAt, RecordId, Reply, Request, example

RoleName = Annotated[Role, Field(strict=False)]


class EnterRequest(Request):
    """A person to add."""

    model_config = example({"name": "Grace Hopper", "role": "operator"})

    name: Name
    role: RoleName


class RoleRequest(Request):
    """New role of a person."""

    model_config = example({"role": "metrologist"})

    role: RoleName


class TokenRequest(Request):
    """A program to authorise on behalf of a person."""

    model_config = example({"name": "line 3", "owner": "Ada Byron", "role": "device", "hours": 8760})

    name: Label = Field(description="Name of the program.", examples=["line 3"])
    owner: Name = Field(
        description="Person responsible for the token; if their account is removed, the "
        "token becomes invalid."
    )
    role: RoleName
    hours: int = Field(ge=1, le=10 * 8784, description="Hours until the token expires.", examples=[8760])


class PersonReply(Reply):
    """A person with an account."""

    id: RecordId
    name: Name
    role: Role
    has_password: bool
    has_pin: bool
    has_badge: bool
    invited: bool = Field(description="True if a link to choose a password has not been used yet.")

    @classmethod
    def about(cls, person: Person, kinds: set[str], *, has_pin: bool) -> "PersonReply":
        """Return somebody with what opens the service to them."""
        return cls.of(
            person,
            has_password="password" in kinds,
            has_pin=has_pin,
            has_badge="badge" in kinds,
            invited="link" in kinds,
        )


class PeopleReply(Reply):
    """All people with an account."""

    people: list[PersonReply]


class EnteredReply(Reply):
    """The person added, and their link."""

    person: PersonReply
    link: str = Field(
        description=f"Link to choose a password, valid once within {LINK_DAYS} days; it is not shown again.",
        examples=["/welcome/5Yl1pMGRTsAjn3ySZyfRcN0t1RZ3Rlbn8Zt4Yk4mG5k"],
    )


class TokenReply(Reply):
    """An authorised program."""

    id: RecordId
    recorded_at: RecordedAt
    name: str = Field(examples=["line 3"])
    owner: str = Field(description="Person responsible for it.", examples=["Ada Byron"])
    role: Role
    expires_at: RecordedAt

    @classmethod
    def about(cls, record: CredentialRecord, owner: str) -> "TokenReply":
        """Return a token without its secret."""
        said = record.document
        return cls.of(
            record,
            name=said["name"],
            owner=owner,
            role=said["role"],
            expires_at=record.expires_at or "",
        )


class TokensReply(Reply):
    """All authorised programs."""

    tokens: list[TokenReply]


class NewTokenReply(Reply):
    """A token and its secret."""

    token: TokenReply
    secret: str = Field(
        description="Secret of the token, to be sent as `Authorization: Bearer ...`; it is not shown again.",
        examples=["5Yl1pMGRTsAjn3ySZyfRcN0t1RZ3Rlbn8Zt4Yk4mG5k"],
    )


class ActOfPersonReply(Reply):
    """A request that changed something or was refused."""

    id: RecordId
    happened_at: RecordedAt
    person: str | None
    role: str | None
    how: str | None = Field(
        description="How the caller was identified: `sign_in` or `token`.", examples=["sign_in"]
    )
    tablet: str | None
    address: str | None
    operation: str = Field(examples=["start_session"])
    resource: str = Field(examples=["/api/v1/sessions/3/commands"])
    status: int = Field(description="HTTP status of the response.", examples=[202])
    reason: str | None = Field(description="Reason, if given.")

    @classmethod
    def about(cls, record: ActRecord) -> "ActOfPersonReply":
        """Return a stored act."""
        return cls.of(record.act, id=record.id)


class ActsReply(Reply):
    """A section of the audit log, newest first."""

    acts: list[ActOfPersonReply]
    total: int = Field(description="Number of entries that match the search.", examples=[214])


router = resource(tags=["people"])
_HOURS_A_DAY = 24
_OF_MACHINE = "a user of this computer"  # nobody is asked who they are


async def _by(asker: CurrentCaller) -> str:
    return asker.name or _OF_MACHINE


By = Annotated[str, Depends(_by)]


@router.get("/people", responses=problems(503))
async def list_people(here: Here) -> PeopleReply:
    """List all people with an account."""
    return PeopleReply(people=listed_people(here))


@router.post("/people", status_code=status.HTTP_201_CREATED, responses=CHANGE)
async def enter_person(here: Here, asker: CurrentCaller, by: By, wanted: EnterRequest) -> EnteredReply:
    """Add a person; they choose their password with the link in the reply."""
    accounts = here.people.accounts
    if asker.machine:
        person, secret = await accounts.enter_by_machine(wanted.name, wanted.role)
    else:
        person, secret = await accounts.enter(wanted.name, wanted.role, by)
    return EnteredReply(person=_reply(here, person), link=f"/welcome/{secret}")


@router.put("/people/{id}/role", responses=CHANGE)
async def change_role(here: Here, by: By, id: Id, wanted: RoleRequest) -> PersonReply:
    """Change the role of a person with immediate effect."""
    found = await here.people.accounts.register.change_role(_person(here, id), wanted.role, by)
    return _reply(here, found)


@router.delete("/people/{id}", status_code=status.HTTP_204_NO_CONTENT, responses=ACT)
async def remove_person(here: Here, by: By, id: Id) -> None:
    """Remove a person; their browsers and programs lose access at once, their audit entries are kept."""
    await here.people.accounts.register.remove(_person(here, id), by)


@router.post("/people/{id}/link", status_code=status.HTTP_201_CREATED, responses=ACT)
async def make_link(here: Here, by: By, id: Id) -> EnteredReply:
    """Create a new link to choose a password; the previous link becomes invalid."""
    person = _person(here, id)
    secret = await here.people.accounts.link(person, by)
    return EnteredReply(person=_reply(here, person), link=f"/welcome/{secret}")


@router.get("/tokens", responses=problems(503))
async def list_tokens(here: Here) -> TokensReply:
    """List the authorised programs."""
    return TokensReply(tokens=listed_tokens(here))


@router.post("/tokens", status_code=status.HTTP_201_CREATED, responses=CHANGE)
async def make_token(here: Here, by: By, wanted: TokenRequest) -> NewTokenReply:
    """Create a token for a program on behalf of a person; the secret is not shown again."""
    owner = here.people.accounts.register.require(wanted.owner)
    record, secret = await here.people.accounts.make_token(
        owner, wanted.name, wanted.role, wanted.hours / _HOURS_A_DAY, by
    )
    return NewTokenReply(token=_token(here, record), secret=secret)


@router.delete("/tokens/{id}", status_code=status.HTTP_204_NO_CONTENT, responses=ACT)
async def revoke_token(here: Here, by: By, id: Id) -> None:
    """Revoke a token with immediate effect."""
    if id not in {record.id for record in _tokens(here)}:
        raise UnknownPersonError(message("refused.no_token", number=id))
    await here.people.accounts.register.revoke(id, by=by)


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
        raise UnknownPersonError(message("refused.no_person", number=number))
    return found


def _reply(here: Context, person: Person) -> PersonReply:
    accounts = here.people.accounts
    kinds = {record.kind.value for record in accounts.register.of(person.id, *CredentialKind)}
    return PersonReply.about(person, kinds, has_pin=accounts.has_pin(person))


_TOGETHER: Final = 500
_LINES: Final = {"application/jsonl": {"schema": {"type": "string"}}}
Search = Annotated[
    str, Query(max_length=200, description="Text to find in person, operation, resource, reason or address.")
]
Before = Annotated[int | None, Query(ge=1, le=NUMBER_LIMIT, description="Only entries with a lower number.")]
Limit = Annotated[int, Query(ge=1, le=_TOGETHER, description="Maximum number of entries.")]


@router.get("/audit", responses=problems(422, 503))
async def list_acts(here: Here, search: Search = "", before: Before = None, limit: Limit = 100) -> ActsReply:
    """List changes and refused requests, newest first."""
    await here.people.log.written()
    found = await here.people.acts.newest(before, limit, search)
    return ActsReply(
        acts=[ActOfPersonReply.about(record) for record in found], total=await here.people.acts.count(search)
    )


@router.get(
    "/audit/lines",
    response_class=Response,
    responses=sending("One audit entry per line, oldest first.", _LINES) | problems(422, 503),
)
async def download_acts(here: Here, search: Search = "") -> StreamingResponse:
    """Download all audit entries as JSON lines, oldest first."""
    headers = {"Content-Disposition": 'attachment; filename="acts.jsonl"'}
    return StreamingResponse(_lines(here, search), media_type="application/jsonl", headers=headers)


async def _lines(here: Context, search: str) -> AsyncIterator[str]:
    after = 0
    while found := await here.people.acts.page(Page(after, _TOGETHER), search):
        yield "".join(f"{json.dumps(ActOfPersonReply.about(act).model_dump())}\n" for act in found)
        after = found[-1].id
