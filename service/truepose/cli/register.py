"""People for the machine's administrator: in a database, or through the service that has it."""

import asyncio
import contextlib
import ssl
from abc import ABC, abstractmethod
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from truepose.domain.people import MACHINE, Role
from truepose.people.errors import AccountRefusedError, UnknownPersonError

if TYPE_CHECKING:
    import httpx

    from truepose.storage.database import Database
    from truepose.storage.secret_files import ReachedService

_HOURS_A_DAY = 24
_ANSWER_S = 60.0  # a service whose disk is busy takes its time


class RefusedByServiceError(AccountRefusedError):
    """The service said no; the sentence and the code are its own."""

    def __init__(self, sentence: str, code: str) -> None:
        super().__init__(sentence)
        self.code = code


class Administration(ABC):
    """Who is let in, people and programs."""

    @abstractmethod
    def people(self) -> list[dict[str, str]]:
        """Return everybody who is let in, with their role."""

    @abstractmethod
    def add(self, name: str, role: Role) -> str:
        """Enter somebody; return the path of the link by which they choose a password."""

    @abstractmethod
    def link(self, name: str) -> str:
        """Return the path of a new link to choose a password."""

    @abstractmethod
    def change_role(self, name: str, role: Role) -> None:
        """Change what somebody may do."""

    @abstractmethod
    def remove(self, name: str) -> None:
        """Let somebody in no more."""

    @abstractmethod
    def token(self, owner: str, name: str, role: Role, days: int) -> str:
        """Let a program in, and return its secret."""


@contextlib.contextmanager
def administration(url: str | None) -> Iterator[Administration]:
    """Yield what administers the people of a database, which a service may have open.

    Raises
    ------
    StorageError
        The database cannot be used, or a service has it that does not say how it is reached.
    """
    from truepose.settings import default_database_url
    from truepose.storage.database import Database
    from truepose.storage.engine.reading import lies_beside
    from truepose.storage.errors import DatabaseInUseError
    from truepose.storage.secret_files import service_of

    address = url or default_database_url()
    try:
        database = Database(address)
    except DatabaseInUseError:
        service = service_of(lies_beside(address))
        if service is None:
            raise
        with _asked(service) as http:
            yield _ThroughService(http)
        return
    try:
        yield _InDatabase(database)
    finally:
        database.close()


class _InDatabase(Administration):
    """Works on a database that no service has open."""

    def __init__(self, database: "Database") -> None:
        from truepose.people.accounts import Accounts
        from truepose.people.register import Register
        from truepose.people.secrets import Pins
        from truepose.storage.people import CredentialRepository
        from truepose.storage.secret_files import Pepper

        self._register = Register(CredentialRepository(database))
        asyncio.run(self._register.load())
        self._accounts = Accounts(self._register, Pins(Pepper.beside(database.file)))

    def people(self) -> list[dict[str, str]]:
        active = (person for person in self._register.people if person.active)
        return [{"name": person.name, "role": person.role.value} for person in active]

    def add(self, name: str, role: Role) -> str:
        _, secret = asyncio.run(self._accounts.enter_by_machine(name, role))
        return f"/welcome/{secret}"

    def link(self, name: str) -> str:
        secret = asyncio.run(self._accounts.link(self._register.require(name), MACHINE))
        return f"/welcome/{secret}"

    def change_role(self, name: str, role: Role) -> None:
        asyncio.run(self._register.change_role(self._register.require(name), role, MACHINE))

    def remove(self, name: str) -> None:
        asyncio.run(self._register.remove(self._register.require(name), MACHINE))

    def token(self, owner: str, name: str, role: Role, days: int) -> str:
        person = self._register.require(owner)
        _, secret = asyncio.run(self._accounts.make_token(person, name, role, days, MACHINE))
        return secret


class _ThroughService(Administration):
    """Asks the service that has the database open."""

    def __init__(self, http: "httpx.Client") -> None:
        self._http = http

    def people(self) -> list[dict[str, str]]:
        return [{"name": one["name"], "role": one["role"]} for one in self._entered()]

    def add(self, name: str, role: Role) -> str:
        return str(self._ask("POST", "/people", {"name": name, "role": role.value})["link"])

    def link(self, name: str) -> str:
        return str(self._ask("POST", f"/people/{self._number(name)}/link")["link"])

    def change_role(self, name: str, role: Role) -> None:
        self._ask("PUT", f"/people/{self._number(name)}/role", {"role": role.value})

    def remove(self, name: str) -> None:
        self._ask("DELETE", f"/people/{self._number(name)}")

    def token(self, owner: str, name: str, role: Role, days: int) -> str:
        wanted = {"name": name, "owner": owner, "role": role.value, "hours": days * _HOURS_A_DAY}
        return str(self._ask("POST", "/tokens", wanted)["secret"])

    def _entered(self) -> list[dict[str, Any]]:
        entered: list[dict[str, Any]] = self._ask("GET", "/people")["people"]
        return entered

    def _number(self, name: str) -> int:
        from truepose.domain.people import same_person

        found = next((one["id"] for one in self._entered() if same_person(one["name"], name)), None)
        if found is None:
            raise UnknownPersonError(f"There is no user named {name} here.")
        return int(found)

    def _ask(self, method: str, path: str, body: dict[str, Any] | None = None) -> dict[str, Any]:
        answer = self._http.request(method, path, json=body)
        told: dict[str, Any] = answer.json() if answer.content else {}
        if answer.is_error:
            raise RefusedByServiceError(told["detail"], told["code"])
        return told


@contextlib.contextmanager
def _asked(service: "ReachedService") -> "Iterator[httpx.Client]":
    """Yield a client of a service of this machine; raises StorageUnavailableError where none answers."""
    import httpx

    from truepose.storage.errors import StorageUnavailableError

    headers = {"Authorization": f"Bearer {service.secret}"}
    trusted = service.certificate is None or _only(Path(service.certificate))
    base = f"{service.url}/api/v1"
    try:
        # trust_env off: a proxy for the world's traffic has nothing to do with this machine.
        with httpx.Client(
            base_url=base, headers=headers, verify=trusted, timeout=_ANSWER_S, trust_env=False
        ) as http:
            yield http
    except httpx.TransportError as error:
        raise StorageUnavailableError(
            f"The service at {service.url}, which has the database, does not answer ({error}); see its log."
        ) from error


def _only(certificate: Path) -> ssl.SSLContext:
    """Return what trusts this certificate alone, whatever name it is for: it lies on this machine."""
    context = ssl.create_default_context(cafile=certificate)
    context.check_hostname = False
    context.verify_flags |= ssl.VERIFY_X509_PARTIAL_CHAIN
    context.verify_flags &= ~ssl.VERIFY_X509_STRICT  # of a chain, which this one has none of
    return context
