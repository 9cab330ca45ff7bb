"""Commands on people and tokens, for the administrator of the machine; the service must not be running."""

import asyncio
from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING, Annotated, TypeVar

import typer

from truepose.cli.files import Json
from truepose.cli.output import print_json, print_lines
from truepose.domain.accounts import Role

if TYPE_CHECKING:
    from truepose.operation.people.accounts import Accounts

T = TypeVar("T")
_BY = "the administrator of the machine"
Name = Annotated[str, typer.Argument(help="Name of the person.")]
Database = Annotated[
    str | None, typer.Option(help="URL of the SQLite database; by default the one in the user's data folder.")
]
RoleOption = Annotated[Role, typer.Option(help="What they may do.")]


def list_command(database: Database = None, json: Json = False) -> int:
    """List everybody who is let in.

    Example: truepose people list --json
    """
    people = _with_accounts(database, _listed)
    if json:
        print_json({"people": people})
    else:
        print_lines(f"{person['name']}: {person['role']}" for person in people)
    return 0


def add_command(
    name: Name, role: RoleOption = Role.OPERATOR, database: Database = None, json: Json = False
) -> int:
    """Enter somebody, and print the last part of the link by which they choose a password.

    The first one has to be an administrator. Example: truepose people add "Ada Byron" --role administrator
    """

    async def add(accounts: "Accounts") -> str:
        return await accounts.link(await accounts.enter_by_machine(name, role, _BY), _BY)

    return _tell_link(name, _with_accounts(database, add), json)


def link_command(name: Name, database: Database = None, json: Json = False) -> int:
    """Print a new link for somebody who has forgotten their password.

    Example: truepose people link "Ada Byron"
    """

    async def link(accounts: "Accounts") -> str:
        return await accounts.link(accounts.register.require(name), _BY)

    return _tell_link(name, _with_accounts(database, link), json)


def role_command(
    name: Name, role: Annotated[Role, typer.Argument(help="What they may do.")], database: Database = None
) -> int:
    """Change what somebody may do.

    Example: truepose people role "Grace Hopper" metrologist
    """

    async def change(accounts: "Accounts") -> None:
        await accounts.register.change_role(accounts.register.require(name), role, _BY)

    _with_accounts(database, change)
    print_lines([f"{name}: {role}"])
    return 0


def remove_command(name: Name, database: Database = None) -> int:
    """Let somebody in no more; what they did stays on record.

    Example: truepose people remove "Grace Hopper"
    """

    async def remove(accounts: "Accounts") -> None:
        await accounts.register.remove(accounts.register.require(name), _BY)

    _with_accounts(database, remove)
    print_lines([f"{name} is let in no more."])
    return 0


def token_command(
    owner: Annotated[str, typer.Argument(help="Person who answers for the program.")],
    name: Annotated[str, typer.Option(help="What the program is called.")],
    role: RoleOption = Role.DEVICE,
    days: Annotated[int, typer.Option(min=1, max=3660, help="After which it ends.")] = 365,
    database: Database = None,
    json: Json = False,
) -> int:
    """Make a token for a program and print its secret, this once.

    Example: truepose people token "Ada Byron" --name "line 3" --role device --days 365
    """

    async def make(accounts: "Accounts") -> str:
        person = accounts.register.require(owner)
        return (await accounts.make_token(person, name, role, days, _BY))[1]

    secret = _with_accounts(database, make)
    if json:
        print_json({"name": name, "owner": owner, "role": role.value, "secret": secret})
    else:
        print_lines([secret])
    return 0


HELP = "Says who is let in, people and programs; the service must not be running."
COMMANDS = {
    "list": list_command,
    "add": add_command,
    "link": link_command,
    "role": role_command,
    "remove": remove_command,
    "token": token_command,
}


async def _listed(accounts: "Accounts") -> list[dict[str, str]]:
    people = (person for person in accounts.register.people if person.active)
    return [{"name": person.name, "role": person.role.value} for person in people]


def _tell_link(name: str, secret: str, json: bool) -> int:
    path = f"/welcome/{secret}"
    if json:
        print_json({"name": name, "link": path})
    else:
        print_lines([f"{name} chooses a password here, once: {path} (behind the address of the service)"])
    return 0


def _with_accounts(database: str | None, work: "Callable[[Accounts], Awaitable[T]]") -> T:
    """Do something with the accounts of a database that no service has open."""
    from truepose.operation.people.accounts import Accounts
    from truepose.operation.people.register import Register
    from truepose.settings import default_database_url
    from truepose.storage.database import Database as OpenDatabase
    from truepose.storage.people.credentials import CredentialRepository

    async def working() -> T:
        opened = await asyncio.to_thread(OpenDatabase, database or default_database_url())
        try:
            register = Register(CredentialRepository(opened))
            await register.load()
            return await work(Accounts(register))
        finally:
            await asyncio.to_thread(opened.close)

    return asyncio.run(working())
