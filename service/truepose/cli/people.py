"""Commands on people and tokens, for the administrator of the machine."""

from typing import Annotated

import typer

from truepose.cli.files import Json
from truepose.cli.output import print_json, print_lines
from truepose.domain.people import Role

Name = Annotated[str, typer.Argument(help="Name of the person.")]
Database = Annotated[
    str | None, typer.Option(help="URL of the database; by default the one in the user's data folder.")
]
RoleOption = Annotated[Role, typer.Option(help="Role, which determines their rights.")]


def list_command(database: Database = None, json: Json = False) -> int:
    """List everybody who has access.

    Example: truepose people list --json
    """
    from truepose.cli.register import administration

    with administration(database) as here:
        people = here.people()
    if json:
        print_json({"people": people})
    else:
        print_lines(f"{person['name']}: {person['role']}" for person in people)
    return 0


def add_command(
    name: Name, role: RoleOption = Role.OPERATOR, database: Database = None, json: Json = False
) -> int:
    """Give somebody access, and print the last part of the link by which they choose a password.

    The first person must be an administrator. Example: truepose people add "Ada Byron" --role administrator
    """
    from truepose.cli.register import administration

    with administration(database) as here:
        link = here.add(name, role)
    return _tell_link(name, link, json)


def link_command(name: Name, database: Database = None, json: Json = False) -> int:
    """Print a new link for somebody who has forgotten their password.

    Example: truepose people link "Ada Byron"
    """
    from truepose.cli.register import administration

    with administration(database) as here:
        link = here.link(name)
    return _tell_link(name, link, json)


def role_command(
    name: Name,
    role: Annotated[Role, typer.Argument(help="Role, which determines their rights.")],
    database: Database = None,
) -> int:
    """Change the role of somebody.

    Example: truepose people role "Grace Hopper" metrologist
    """
    from truepose.cli.register import administration

    with administration(database) as here:
        here.change_role(name, role)
    print_lines([f"{name}: {role}"])
    return 0


def remove_command(name: Name, database: Database = None) -> int:
    """Withdraw somebody's access; their records are kept.

    Example: truepose people remove "Grace Hopper"
    """
    from truepose.cli.register import administration

    with administration(database) as here:
        here.remove(name)
    print_lines([f"{name} no longer has access."])
    return 0


def token_command(
    owner: Annotated[str, typer.Argument(help="Person responsible for the program.")],
    name: Annotated[str, typer.Option(help="Name of the program.")],
    role: RoleOption = Role.DEVICE,
    days: Annotated[int, typer.Option(min=1, max=3660, help="Days until the token expires.")] = 365,
    database: Database = None,
    json: Json = False,
) -> int:
    """Make a token for a program and print its secret, this once.

    Example: truepose people token "Ada Byron" --name "line 3" --role device --days 365
    """
    from truepose.cli.register import administration

    with administration(database) as here:
        secret = here.token(owner, name, role, days)
    if json:
        print_json({"name": name, "owner": owner, "role": role.value, "secret": secret})
    else:
        print_lines([secret])
    return 0


HELP = "Manages who has access: people and programs. The service may be running."
COMMANDS = {
    "list": list_command,
    "add": add_command,
    "link": link_command,
    "role": role_command,
    "remove": remove_command,
    "token": token_command,
}


def _tell_link(name: str, path: str, json: bool) -> int:
    if json:
        print_json({"name": name, "link": path})
    else:
        print_lines([f"{name} can set a password here, once: {path} (append to the address of the service)"])
    return 0
