"""`truepose people` beside a running service asks through it, and opens nothing else by that."""

import stat

import httpx
import pytest

from tests.helpers.web.clients import client_of, command
from tests.integration.web.listening import listening
from truepose.app import create_app
from truepose.cli.register import administration
from truepose.domain.people import MACHINE, Role
from truepose.people.errors import AccountRefusedError, UnknownPersonError
from truepose.storage.errors import DatabaseInUseError, StorageUnavailableError
from truepose.storage.secret_files import ReachedService, publish_endpoint, service_of


@pytest.fixture
def served(settings, bench):
    """A service on this machine, where nobody is entered yet; gives its URL and its people."""
    app = create_app(settings, bench.registry())
    with listening(app) as url:
        httpx.get(f"{url}/health")
        here = app.state.context
        told = ReachedService(url, here.people.accounts.machine_secret)
        with publish_endpoint(here.database.file, told):
            yield url, here


def test_people_are_entered_while_the_service_runs(served, settings):
    url, here = served

    with administration(settings.database_url) as machine:
        first = machine.add("Ada Byron", Role.ADMINISTRATOR)
        machine.add("Grace Hopper", Role.OPERATOR)
        machine.change_role("grace hopper", Role.METROLOGIST)
        token = machine.token("Ada Byron", "line 3", Role.DEVICE, 30)
        machine.add("Alan Turing", Role.VIEWER)
        machine.remove("Alan Turing")
        again = machine.link("Grace Hopper")

        assert machine.people() == [
            {"name": "Ada Byron", "role": "administrator"},
            {"name": "Grace Hopper", "role": "metrologist"},
        ]
    assert httpx.get(f"{url}/api/v1/sessions").status_code == 401  # the first person has closed it
    program = {"Authorization": f"Bearer {token}"}
    assert httpx.get(f"{url}/api/v1/sessions", headers=program).status_code == 200
    assert here.people.accounts.invited(first.rpartition("/")[2]).name == "Ada Byron"
    assert here.people.accounts.invited(again.rpartition("/")[2]).name == "Grace Hopper"


def test_what_the_service_refuses_is_said_with_its_code(served, settings):
    with administration(settings.database_url) as machine:
        with pytest.raises(AccountRefusedError, match="first person must be an administrator") as refused:
            machine.add("Ada Byron", Role.OPERATOR)
        with pytest.raises(UnknownPersonError, match="no user named Ada"):
            machine.link("Ada")

        assert refused.value.code == "TP-1018"
        assert machine.people() == []


async def test_the_machines_secret_says_who_is_let_in_and_nothing_else(app):
    accounts = app.state.context.people.accounts
    async with client_of(app) as machine:
        machine.headers["Authorization"] = f"Bearer {accounts.machine_secret}"
        entered = await machine.post("/api/v1/people", json={"name": "Ada Byron", "role": "administrator"})
        refused = [
            (await machine.get("/api/v1/sessions")).status_code,
            (await command(machine, "/api/v1/sessions/1", "start", person=None)).status_code,
            (await machine.get("/api/v1/audit/lines")).status_code,
            (await machine.delete("/api/v1/tokens/1")).status_code,
        ]
        machine.headers["Authorization"] = f"Bearer {accounts.first_secret}"
        other = await machine.get("/api/v1/people")
    await app.state.context.people.log.written()
    acts = await app.state.context.people.acts.newest(None, 10)

    assert entered.status_code == 201
    assert refused == [403] * 4
    assert other.status_code == 401
    assert ("enter_person", MACHINE) in [
        (act.operation, act.person) for act in (record.act for record in acts)
    ]


def test_a_service_that_says_nothing_of_itself_is_in_the_way(settings, bench):
    with listening(create_app(settings, bench.registry())) as url:
        httpx.get(f"{url}/health")

        with pytest.raises(DatabaseInUseError), administration(settings.database_url):
            pass


def test_a_service_that_does_not_answer_is_one_sentence(served, settings):
    _, here = served
    told = ReachedService("http://127.0.0.1:9", "secret")

    with (
        publish_endpoint(here.database.file, told),
        pytest.raises(StorageUnavailableError, match="does not answer"),
        administration(settings.database_url) as machine,
    ):
        machine.people()


def test_what_opens_a_service_is_its_owners_alone_and_goes_with_it(tmp_path):
    database = tmp_path / "truepose.sqlite3"
    told = ReachedService("http://127.0.0.1:8000", "secret", "/etc/cell3.pem")
    (tmp_path / "truepose.sqlite3.machine").write_text("of a service that was killed")
    assert service_of(database) is None

    with publish_endpoint(database, told):
        (file,) = tmp_path.iterdir()
        assert stat.S_IMODE(file.stat().st_mode) == 0o600
        assert service_of(database) == told

    assert list(tmp_path.iterdir()) == []
    assert service_of(database) is None
