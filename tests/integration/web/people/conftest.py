"""A service that asks who somebody is: people of every role, and what each of them shows."""

import contextlib
import shutil
from dataclasses import dataclass

import pytest
import pytest_asyncio
from argon2 import PasswordHasher

from tests.helpers.web.clients import client_of
from tests.integration.web.bench import CELL, Bench
from truepose.app import create_app
from truepose.domain.people import Person, Role
from truepose.people import secrets, sign_ins
from truepose.settings import Settings

PASSWORD = "on the looms of Lyon"
PIN = "4071"
ORIGIN = {"Origin": "http://localhost"}
NAMES = {
    Role.ADMINISTRATOR: "Ada Byron",
    Role.METROLOGIST: "Grace Hopper",
    Role.OPERATOR: "Alan Turing",
    Role.VIEWER: "Vera Rubin",
}


@pytest.fixture(autouse=True)
def cheap_hashes(request, monkeypatch):
    """Hashes that cost nothing, but where their cost is what a test is about (mark `true_hashes`)."""
    if request.node.get_closest_marker("true_hashes") is None:
        hasher = PasswordHasher(time_cost=1, memory_cost=8, parallelism=1)
        monkeypatch.setattr(secrets, "_HASHER", hasher)
        monkeypatch.setattr(secrets, "MEMORY_KIB", 8)
        monkeypatch.setattr(sign_ins, "NOBODYS", hasher.hash("of nobody"))


@contextlib.asynccontextmanager
async def browser_at(app, peer="127.0.0.1", **headers):
    """A browser at an address that shows pages of the service."""
    async with client_of(app, peer) as opened:
        opened.headers.update(ORIGIN | headers)
        yield opened


@pytest.fixture
def accounts(app):
    return app.state.context.people.accounts


@pytest.fixture
def later(accounts, monkeypatch):
    """Let time go by for everything that looks at the clock."""
    passed = [0.0]
    began = accounts.register.time.elapsed_s
    monkeypatch.setattr(accounts.register.time, "elapsed_s", lambda: began() + passed[0])
    for keeper in (accounts.sign_ins, accounts.attempts.guesses, accounts.attempts.of_strangers):
        monkeypatch.setattr(keeper, "_elapsed_s", lambda: began() + passed[0])

    def go_by(seconds):
        passed[0] += seconds

    return go_by


@dataclass
class House:
    """A service with people, and how each of them asks it."""

    app: object
    people: dict[Role, Person]
    tokens: dict[Role, str]

    @property
    def here(self):
        return self.app.state.context.people

    def client(self, token=None, cookie=None):
        opened = client_of(self.app)
        opened.headers.update(ORIGIN if token is None else ORIGIN | {"Authorization": f"Bearer {token}"})
        opened.cookies.update({} if cookie is None else {"truepose_sign_in": cookie})
        return opened

    def of(self, role):
        """Return a client of a program with the token of a role."""
        return self.client(self.tokens[role])

    async def browser(self, role, fresh=True):
        """Return a client of a browser that a person of that role has signed in."""
        signed_in = await self.here.accounts.sign_ins.opened(self.people[role], "cell 3")
        if not fresh:
            self.here.accounts.sign_ins._used[signed_in.caller.sign_in].shown_s = None
        return self.client(cookie=signed_in.secret)


async def peopled(app):
    accounts = app.state.context.people.accounts
    people, tokens = {}, {}
    for role, name in NAMES.items():
        people[role] = await accounts.register.enter(name, role, "a test")
        _, tokens[role] = await accounts.make_token(people[role], f"script of {name}", role, 1, "a test")
    _, tokens[Role.DEVICE] = await accounts.make_token(
        people[Role.METROLOGIST], "line 3", Role.DEVICE, 1, "a test"
    )
    _, tokens[Role.PLANT] = await accounts.make_token(
        people[Role.ADMINISTRATOR], "plant", Role.PLANT, 1, "a test"
    )
    return House(app, people, tokens)


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def house(tmp_path_factory, empty_database):
    """One for all tests of a module, which therefore leave people and roles as they are."""
    folder = tmp_path_factory.mktemp("people")
    (folder / "cell.toml").write_text(CELL)
    url = f"sqlite:///{shutil.copy(empty_database, folder)}"
    app = create_app(Settings(database_url=url, cell_file=folder / "cell.toml"), Bench().registry())
    async with app.router.lifespan_context(app):
        yield await peopled(app)
