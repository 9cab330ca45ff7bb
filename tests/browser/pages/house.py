"""A service of named people: the pages that are theirs, and how a browser comes to each."""

import contextlib
from dataclasses import dataclass

import httpx

from tests.integration.web.bench import CELL, Bench, session_request
from tests.integration.web.listening import listening
from truepose.app import create_app
from truepose.settings import Settings

ADA = {"name": "Ada Byron", "password": "on the looms of Lyon", "pin": "4071"}
# Of somebody who has signed in; and of whoever has the link.
SIGNED_IN = ("/", "/account", "/people", "/audit", "/not-yours", "/sessions/1", "/operator/1")
OF_LINKS = ("/sign-in", "/welcome", "/watch")


@dataclass(frozen=True)
class House:
    """Where it is, the cookies of an administrator, and the addresses that have a secret in them."""

    url: str
    cookies: list
    secret: dict

    def address(self, page):
        return self.url + self.secret.get(page, page)


@contextlib.contextmanager
def open_house(folder):
    """Serve a cell to an administrator, who has invited somebody and lets a second screen look on."""
    (folder / "cell.toml").write_text(CELL)
    where = Settings(database_url=f"sqlite:///{folder}/house.sqlite3", cell_file=folder / "cell.toml")
    application = create_app(where, Bench().registry())
    with listening(application) as url, httpx.Client(base_url=url, timeout=60, trust_env=False) as client:
        client.get("/health").raise_for_status()  # it listens before it has opened everything
        accounts = application.state.context.people.accounts
        post(client, "/first-person", {"secret": accounts.first_secret, **ADA})
        post(client, "/sessions", session_request())
        welcome = post(client, "/people", {"name": "Alan Turing", "role": "operator"})["link"]
        watch = post(client, "/sessions/1/watch-links", {"hours": 12})["url"]
        post(client, "/tokens", {"owner": ADA["name"], "name": "line 3", "role": "device", "hours": 24})
        cookies = [{"name": name, "value": value, "url": url} for name, value in client.cookies.items()]
        yield House(url, cookies, {"/welcome": welcome, "/watch": httpx.URL(watch).path})


def post(client, path, body):
    origin = {"Origin": str(client.base_url).rstrip("/")}  # as a browser says
    return client.post(f"/api/v1{path}", json=body, headers=origin).raise_for_status().json()
