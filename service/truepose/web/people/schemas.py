"""What travels of people, sign-ins, tokens, acts and the authority over a session."""

from typing import Annotated, Any

from pydantic import AfterValidator, Field

from truepose.domain.people.accounts import Person, Role
from truepose.domain.people.names import LONGEST_NAME, NAME_PATTERN, tidy_name
from truepose.operation.people.accounts import LINK_DAYS, LONGEST_SECRET, SHORTEST_PASSWORD, Chosen
from truepose.operation.people.leases import LEASE_S
from truepose.storage.people.acts import ActRecord
from truepose.storage.people.credentials import CredentialRecord
from truepose.web.schemas.base import RecordedAt, RecordId, Reply, Request, example

_ANY = r"^[^\u0000-\u001f\u007f]+$"
Name = Annotated[
    str,
    Field(min_length=1, max_length=LONGEST_NAME, pattern=NAME_PATTERN, examples=["Ada Byron"]),
    AfterValidator(tidy_name),
]
Label = Annotated[str, Field(min_length=1, max_length=100, pattern=NAME_PATTERN), AfterValidator(tidy_name)]
Password = Annotated[str, Field(min_length=1, max_length=LONGEST_SECRET, pattern=_ANY)]
NewPassword = Annotated[str, Field(min_length=SHORTEST_PASSWORD, max_length=LONGEST_SECRET, pattern=_ANY)]
Pin = Annotated[str, Field(pattern=r"^[0-9]{4,12}$", description="4 to 12 digits.", examples=["4071"])]
Badge = Annotated[
    str, Field(min_length=4, max_length=100, pattern=r"^[!-~]+$", description="As the reader types it.")
]
Secret = Annotated[str, Field(pattern=r"^[A-Za-z0-9_-]{43}$", description="The last part of the link.")]
RoleName = Annotated[Role, Field(strict=False)]


class SignInRequest(Request):
    """Who comes in, and where they sit."""

    model_config = example({"name": "Ada Byron", "password": "on the looms of Lyon", "tablet": "cell 3"})

    name: Name
    password: Password
    tablet: Label | None = Field(None, description="What this browser is called, for whoever looks later.")


class ProofRequest(Request):
    """Something that only the person knows who is signed in; one of the two."""

    model_config = example({"pin": "4071"})

    pin: Pin | None = None
    password: Password | None = None


class SwitchRequest(Request):
    """Who stands before the tablet now: by name or by badge, and a PIN in any case."""

    model_config = example({"name": "Grace Hopper", "pin": "1906"})

    name: Name | None = None
    badge: Badge | None = None
    pin: Pin


class ChosenRequest(Request):
    """What somebody chooses for themselves; the present password proves who they are."""

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
    """What somebody chooses who was given a link."""

    model_config = example({
        "secret": "5Yl1pMGRTsAjn3ySZyfRcN0t1RZ3Rlbn8Zt4Yk4mG5k",
        "password": "on the looms of Lyon",
        "pin": "4071",
    })

    secret: Secret
    password: NewPassword
    pin: Pin | None = None
    badge: Badge | None = None


class EnterRequest(Request):
    """Somebody who shall be let in."""

    model_config = example({"name": "Grace Hopper", "role": "operator"})

    name: Name
    role: RoleName


class RoleRequest(Request):
    """What somebody may do from now on."""

    model_config = example({"role": "metrologist"})

    role: RoleName


class TokenRequest(Request):
    """A program that shall be let in, on behalf of a person."""

    model_config = example({"name": "line 3", "owner": "Ada Byron", "role": "device", "hours": 8760})

    name: Label = Field(description="What the program is called.", examples=["line 3"])
    owner: Name = Field(description="Who answers for it; it ends with them.")
    role: RoleName
    hours: int = Field(ge=1, le=10 * 8784, description="After which it ends.", examples=[8760])


class WatchLinkRequest(Request):
    """For how long somebody may look at a session."""

    model_config = example({"hours": 12})

    hours: int = Field(12, ge=1, le=24 * 31, description="After which it ends.")


class AuthorityRequest(Request):
    """Whether to take the authority from whoever has it."""

    model_config = example({"take_over": False})

    take_over: bool = False


class CallerReply(Reply):
    """Who is asking."""

    accounts: str = Field(description="off, open (until somebody is entered), or on.", examples=["on"])
    name: str | None = Field(description="Null: nobody is signed in.", examples=["Ada Byron"])
    role: Role | None
    tablet: str = Field(description="What this browser is called; empty: nothing.", examples=["cell 3"])
    fresh: bool = Field(description="Whether it was shown within five minutes who it is.")
    people: list[str] = Field(
        description="Who may take over this browser by a PIN; empty: nobody signed it in."
    )


class PersonReply(Reply):
    """Somebody who is entered."""

    id: RecordId
    name: Name
    role: Role
    has_password: bool
    has_pin: bool
    has_badge: bool
    invited: bool = Field(description="A link to choose a password waits to be used.")

    @classmethod
    def about(cls, person: Person, kinds: set[str], *, has_pin: bool) -> "PersonReply":
        """Return somebody with what opens the service to them."""
        return cls(
            id=person.id,
            name=person.name,
            role=person.role,
            has_password="password" in kinds,
            has_pin=has_pin,
            has_badge="badge" in kinds,
            invited="link" in kinds,
        )


class PeopleReply(Reply):
    """Everybody who is entered."""

    people: list[PersonReply]


class EnteredReply(Reply):
    """Somebody who was entered, and the link for them."""

    person: PersonReply
    link: str = Field(
        description=f"To choose a password, once, within {LINK_DAYS} days; shown this once.",
        examples=["/welcome/5Yl1pMGRTsAjn3ySZyfRcN0t1RZ3Rlbn8Zt4Yk4mG5k"],
    )


class TokenReply(Reply):
    """A program that is let in."""

    id: RecordId
    recorded_at: RecordedAt
    name: str = Field(examples=["line 3"])
    owner: str = Field(description="Who answers for it.", examples=["Ada Byron"])
    role: Role
    expires_at: RecordedAt

    @classmethod
    def about(cls, record: CredentialRecord, owner: str) -> "TokenReply":
        """Return a token without its secret."""
        return cls(
            id=record.id,
            recorded_at=record.recorded_at,
            name=record.document["name"],
            owner=owner,
            role=Role(record.document["role"]),
            expires_at=record.expires_at or "",
        )


class TokensReply(Reply):
    """All programs that are let in."""

    tokens: list[TokenReply]


class NewTokenReply(Reply):
    """A token and its secret."""

    token: TokenReply
    secret: str = Field(
        description="Shown this once; send it as `Authorization: Bearer ...`.",
        examples=["5Yl1pMGRTsAjn3ySZyfRcN0t1RZ3Rlbn8Zt4Yk4mG5k"],
    )


class WatchLinkReply(Reply):
    """A link that lets whoever has it look at one session."""

    id: RecordId
    session_id: RecordId
    expires_at: RecordedAt
    by: str = Field(description="Who made it.", examples=["Ada Byron"])

    @classmethod
    def about(cls, record: CredentialRecord) -> "WatchLinkReply":
        """Return a link without its secret."""
        said: dict[str, Any] = record.document
        return cls(
            id=record.id, session_id=said["session_id"], expires_at=record.expires_at or "", by=said["by"]
        )


class WatchLinksReply(Reply):
    """All such links of a session."""

    links: list[WatchLinkReply]


class NewWatchLinkReply(Reply):
    """A new link, and how it gets to a telephone."""

    link: WatchLinkReply
    url: str = Field(
        description="Shown this once.",
        examples=["http://localhost:8000/watch/5Yl1pMGRTsAjn3ySZyfRcN0t1RZ3Rlbn8Zt4Yk4mG5k"],
    )
    qr_svg: str = Field(
        description="The same as a QR code, an SVG image as a data address.",
        examples=["data:image/svg+xml;charset=utf-8,%3Csvg ... %3C/svg%3E"],
    )


class AuthorityReply(Reply):
    """Who acts in a session."""

    person: str | None = Field(description="Null: whoever acts next.", examples=["Ada Byron"])
    tablet: str = Field(description="Where; empty: nobody said.", examples=["cell 3"])
    mine: bool = Field(description="Whether it is whoever asks.")
    left_s: float = Field(description="How long it lasts if nothing renews it.", examples=[LEASE_S])


class ActOfPersonReply(Reply):
    """One request that changed something, or that was refused."""

    id: RecordId
    happened_at: RecordedAt
    person: str | None
    role: str | None
    how: str | None = Field(description="sign_in or token.", examples=["sign_in"])
    tablet: str | None
    address: str | None
    operation: str = Field(examples=["start_session"])
    resource: str = Field(examples=["/api/v1/sessions/3/start"])
    status: int = Field(description="HTTP status of the answer.", examples=[202])
    reason: str | None = Field(description="Why, where it was given.")

    @classmethod
    def about(cls, record: ActRecord) -> "ActOfPersonReply":
        """Return a stored act."""
        act = record.act
        return cls(id=record.id, **{name: getattr(act, name) for name in type(act).__dataclass_fields__})


class ActsReply(Reply):
    """A part of the acts, newest first."""

    acts: list[ActOfPersonReply]
    total: int = Field(description="How many there are that were searched for.", examples=[214])


def chosen_of(wanted: FirstPersonRequest | AcceptRequest | ChosenRequest) -> Chosen:
    """Return what somebody chose."""
    return Chosen(wanted.password, wanted.pin, getattr(wanted, "badge", None))
