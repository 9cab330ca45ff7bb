"""The service of a plant: what it shows of its cells, and that a cell goes on without it."""

import asyncio

import httpx
import pytest

from tests.helpers.machine import HANGS_S
from tests.helpers.web.clients import client_of
from truepose.app.plants import open_plant
from truepose.domain.people import MACHINE, Role
from truepose.messages.catalogue import catalogue
from truepose.messages.error_codes import explain
from truepose.settings import PlantSettings, Settings
from truepose.storage.errors import ForeignDatabaseError, StorageUnavailableError
from truepose.storage.plant.overview import PlantOverview
from truepose.storage.plant.records import HandDownState
from truepose.web.middleware.rights import LEAST
from truepose.web.middleware.routing import operations_of
from truepose.web.plant.application import create_plant_application


@pytest.fixture
async def service(tmp_path, served_plant):
    """A client of a plant's service that looks for news all the time."""
    async with served_plant(f"sqlite:///{tmp_path / 'plant.sqlite3'}", every_s=0.02) as client:
        yield client


async def until(service, path, holds):
    async with asyncio.timeout(HANGS_S):
        while not holds(found := (await service.get(path)).json()):
            await asyncio.sleep(0.02)
    return found


async def collected(service, cell):
    """Return the cell's entry once everything there is collected."""
    newest = await cell.newest()

    def holds(found):
        visit = found["cell"]["newest_visit"]
        return visit is not None and (visit["head"] or "").startswith(f"{newest}-")

    return await until(service, "/api/v1/plant/cells/left arm", holds)


async def test_a_plant_shows_its_cells_robots_and_instruments(service, cell):
    await cell.measure()

    shown = await collected(service, cell)
    robots = (await service.get("/api/v1/plant/robots")).json()
    life = (await service.get("/api/v1/plant/robots/120-1")).json()
    instrument = (await service.get("/api/v1/plant/instruments/T-7")).json()

    assert shown["cell"]["newest_visit"]["outcome"] == "whole"
    assert shown["cell"]["newest_visit"]["head"] == (await cell.database.head()).text
    assert [robot["serial_number"] for robot in robots] == ["120-1"]
    assert [(day["cell"], day["readings"]) for day in life["days"]] == [("left arm", 3)]
    assert sum(day["readings"] for day in instrument["days"]) == 3


async def test_a_hand_down_reaches_the_cell_and_says_so(service, cell):
    wanted = {"cell": "left arm", "kind": "plan", "name": "monthly", "person": "Ada", "document": {"a": 1}}

    asked = await service.post("/api/v1/plant/hand-downs", json=wanted)

    assert (asked.status_code, asked.json()["state"]) == (201, HandDownState.WAITING)
    told = await until(service, asked.headers["Location"], lambda found: found["state"] == "delivered")
    there = httpx.AsyncClient(transport=cell.transport, base_url="http://localhost")
    async with there:
        kept = (await there.get(f"/api/v1/hand-downs/{told['number_in_cell']}")).json()
    assert (kept["name"], kept["document"]) == ("monthly", {"a": 1})


@pytest.mark.parametrize(
    ("path", "status"),
    [
        ("/health", 200),
        ("/sign-in", 200),
        ("/people", 200),
        ("/audit", 200),
        ("/static/look.css", 200),
        ("/docs", 200),
        ("/errors", 200),
        ("/errors/TP-6001", 200),
        ("/api/v1/plant/cells", 200),
        ("/api/v1/plant/cells/right arm", 404),
        ("/api/v1/plant/robots/none", 404),
        ("/api/v1/plant/instruments/none", 404),
        ("/api/v1/plant/campaigns", 200),
        ("/api/v1/plant/wishes", 422),
        ("/api/v1/plant/campaigns/7/record", 404),
        ("/api/v1/plant/hand-downs/7", 404),
    ],
)
async def test_what_is_there_is_shown_and_what_is_not_is_said(service, path, status):
    assert (await service.get(path)).status_code == status


@pytest.fixture
def gone(monkeypatch):
    """The plant's server is away; the sentence with which that is told."""
    sentence = "The server of postgresql://plant does not answer; see that it runs."

    async def robots(_overview, _upto):
        raise StorageUnavailableError(sentence)

    monkeypatch.setattr(PlantOverview, "robots", robots)
    return sentence


async def test_a_page_that_cannot_be_shown_says_why_and_what_to_do(service, gone):
    page = await service.get("/", headers={"Accept": "text/html,*/*;q=0.8", "Accept-Language": "de"})
    document = await service.get("/")

    assert (page.status_code, document.status_code) == (503, 503)
    assert gone in page.text
    assert explain("TP-6001", catalogue("de")).do in page.text
    assert document.json()["detail"] == gone


async def test_health_tells_strangers_that_something_is_amiss_and_people_what(
    tmp_path, cells_file, monkeypatch
):
    service = Settings(database_url=f"sqlite:///{tmp_path / 'plant.sqlite3'}")
    app = create_plant_application("test", lambda: open_plant(PlantSettings(service, cells_file)))
    async with app.router.lifespan_context(app), client_of(app) as client:
        here = app.state.context
        ada, _ = await here.people.accounts.enter_by_machine("Ada", Role.ADMINISTRATOR)
        _, secret = await here.people.accounts.make_token(ada, "watch", Role.VIEWER, 1, MACHINE)
        monkeypatch.setattr(type(here.database.condition), "fault", "The disk is full.")

        stranger = (await client.get("/health")).json()
        known = (await client.get("/health", headers={"Authorization": f"Bearer {secret}"})).json()

    assert (stranger["status"], stranger["fault"]) == ("degraded", "There is a problem; sign in for details.")
    assert known["fault"] == "The disk is full."


async def test_a_chain_that_is_the_one_collected_needs_no_acceptance(service, cell):
    await cell.measure()
    await collected(service, cell)

    answer = await service.post(
        "/api/v1/plant/cells/left arm/branches", json={"person": "Ada", "reason": "to be sure"}
    )

    assert answer.status_code == 409
    assert "still has the chain that was collected" in answer.json()["detail"]


async def test_a_hand_down_to_a_cell_that_nobody_knows_is_refused(service):
    wanted = {"cell": "right arm", "kind": "plan", "name": "monthly", "person": "Ada", "document": {}}

    answer = await service.post("/api/v1/plant/hand-downs", json=wanted)

    assert (answer.status_code, answer.json()["detail"]) == (
        404,
        "There is no cell 'right arm' in the cells file of this plant.",
    )


async def test_a_hand_down_that_no_cell_could_take_is_refused_at_the_door(service):
    body = b'{"cell": "left arm", "kind": "plan", "name": "m", "person": "Ada", "document": {"a": NaN}}'

    answer = await service.post(
        "/api/v1/plant/hand-downs", content=body, headers={"Content-Type": "application/json"}
    )

    assert answer.status_code == 422
    assert answer.json()["detail"].startswith("document: numbers must be finite")


async def test_a_plant_that_visits_nobody_any_more_says_so(service, monkeypatch):
    before = (await service.get("/health")).json()
    monkeypatch.setattr(service.here.collector, "has_ended", True)

    after = (await service.get("/health")).json()

    assert (before["status"], before["fault"]) == ("ok", None)
    assert (after["status"], after["fault"][:30]) == ("degraded", "Collection from the cells has ")


def test_every_operation_of_a_plant_has_its_least_role():
    app = create_plant_application("test", lambda: None)

    assert {operation.name for operation in operations_of(app.routes)} <= LEAST.keys()


async def test_the_first_person_of_a_plant_enters_by_the_link_that_it_prints(tmp_path, cells_file):
    settings = Settings(database_url=f"sqlite:///{tmp_path / 'peopled.sqlite3'}", host="0.0.0.0")
    app = create_plant_application("test", lambda: open_plant(PlantSettings(settings, cells_file)))
    async with app.router.lifespan_context(app), client_of(app) as client:
        secret = app.state.context.people.accounts.first_secret
        page = await client.get(f"/first-person/{secret}")
        entered = await client.post(
            "/api/v1/first-person",
            json={"secret": secret, "name": "Ada Byron", "password": "on the looms of Lyon"},
        )
        cells = await client.get("/api/v1/plant/cells")

    assert (page.status_code, entered.status_code, cells.status_code) == (200, 201, 200)


async def test_a_name_of_a_cell_may_have_slashes(service):
    await service.here.journal.enter("hall 2/left arm")
    place = "/api/v1/plant/cells/hall%202%2Fleft%20arm"

    assert (await service.get(place)).json()["cell"]["name"] == "hall 2/left arm"
    assert (await service.get(f"{place}/records")).json() == []
    assert (await service.get(f"{place}/visits")).headers["allow"] == "POST"


async def test_a_plant_and_a_cell_do_not_share_a_database(open_cell, open_plant, tmp_path, served_plant):
    async with open_cell("other") as other:
        await other.measure()
        url = str(other.database.backend.url)
    with open_plant("cell") as plant:
        await plant.journal.enter("left arm")

    with pytest.raises(ForeignDatabaseError, match="is the database of a cell, but a plant needs its own"):
        async with served_plant(url):
            pass
    with pytest.raises(
        ForeignDatabaseError, match="is the database of a plant; start it with 'truepose plant'"
    ):
        async with open_cell("both", f"sqlite:///{tmp_path / 'cell.sqlite3'}"):
            pass
