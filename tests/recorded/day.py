"""Days at a cell over REST: a session of each kind, what is computed of them, every page in the evening."""

import asyncio
import contextlib
import functools
import re
import time

from fastapi.responses import HTMLResponse

from tests.helpers.checkout import CHECKOUT
from tests.helpers.web.clients import client_of, made, prompt_id
from tests.helpers.web.performing import perform_here
from tests.helpers.web.routes import paths_answering, routes_alone
from tests.integration.web.ballbar_bench import BALLBAR, WANTED
from tests.integration.web.bench import CELL, Bench, session_request
from tests.integration.web.contact_bench import GAUGE, WIRE
from tests.integration.web.measurement.test_camera_sessions import CELL as CAMERA_CELL
from tests.integration.web.measurement.test_camera_sessions import CameraBench
from tests.integration.web.measurement.test_camera_sessions import wanted as camera_session
from tests.integration.web.measurement.test_contact_sessions import FakeWire
from tests.recorded.transcript import Transcript, printed, told
from truepose.analysis.job_queue.uploads import Uploads
from truepose.app import create_app
from truepose.exchange.campaigns.folder import read_campaign
from truepose.exchange.campaigns.zip_file import write_campaign_zip
from truepose.settings import Settings
from truepose_drivers.api import DriverPlugin
from truepose_drivers.registry import DriverRegistry

_PATIENCE_S = 60.0
_ACCEPTED = 202
_ORIGIN = {"Origin": "http://localhost"}  # as a browser says
ADA = {"person": "Ada"}
TARGETS = "target,x_mm,y_mm,z_mm,qw,qx,qy,qz\n1,350,0,400,0,0,1,0\n2,350,50,400,0,0,1,0\n"
_AT_REST = {"finished", "aborted", "failed", "faulted", "paused", "awaiting_confirmation"}
# Pages of people, links that are given once; and the reference, which `docs/interface.json` holds.
_OTHER_PAGES = re.compile(r"^/(account|audit|people|not-yours|sign-in|first-person|watch|welcome|docs)")
_PARTS = {
    "/errors/{code}": ["TP-1001"],
    "/operator/{id}": ["1", "2"],
    "/reports/{kind}/{id}": ["identification/1", "validation/1", "diagnosis/1"],
    "/robots/{name:path}": ["ABB%20IRB%20120%2C%20simulated"],
}


class WiredBench(Bench):
    """The bench with a draw wire beside."""

    def registry(self):
        wire = FakeWire(self.clock)
        plugin = DriverPlugin("fake_gauge", "linear_gauge", "fake", {}, lambda options, clock: wire)
        return DriverRegistry({**super().registry().plugins, plugin.name: plugin}, {})


class Day:
    """A client of the service that takes down what it asks and is answered, part of the day by part."""

    def __init__(self, client, application, name):
        self.client = client
        self.application = application
        self.name = name
        self.transcripts = []

    def part(self, name):
        """Begin another transcript."""
        self.transcripts.append(Transcript(f"{self.name}/{len(self.transcripts):02}-{name}"))

    async def ask(self, method, path, **sent):
        """Ask, take down question and answer, and return the answer."""
        reply = await self.client.request(method, path, **sent)
        self._take_down(method, path, reply, **sent)
        return reply

    def _take_down(self, method, path, reply, **sent):
        media_type = reply.headers.get("content-type", "").partition(";")[0]
        asked = [f"### {method} {path}", *([printed(sent["json"])] if "json" in sent else [])]
        # How far a job or a session is by then, is not the same every day.
        if path.endswith("/commands") and reply.is_success:
            body = printed({"sentence": reply.json()["sentence"]})
        else:
            body = "" if reply.status_code == _ACCEPTED else told(reply.content, media_type)
        where = [f"Location: {reply.headers['location']}"] if "location" in reply.headers else []
        self.transcripts[-1].add(*asked, f"-> {reply.status_code} {media_type}", *where, body, "")

    async def get(self, *paths):
        """Ask for several resources."""
        for path in paths:
            await self.ask("GET", path)

    async def result(self, path, **sent):
        """Have a job done; take down its request, its end and its result, and return where that is."""
        accepted = await self.ask("POST", path, **sent)
        found = await made(self.client, accepted)
        await self.get(accepted.headers["location"], found)
        return found

    async def drawn(self, page):
        """Ask for a page until its pictures are there, and take it down."""
        async with asyncio.timeout(_PATIENCE_S):
            while "data-drawing" in (reply := await self.client.get(page)).text:
                await asyncio.sleep(0.05)
        self._take_down("GET", page, reply)

    async def until(self, path, holds):
        """Wait without a word, as a page does that polls."""
        end_s = time.monotonic() + _PATIENCE_S
        while not holds(found := (await self.client.get(path)).json()):
            assert time.monotonic() < end_s, found
            await asyncio.sleep(0.01)
        return found


@contextlib.asynccontextmanager
async def open_day(name, folder, cell, bench):
    """Serve a cell to the client of a day."""
    (folder / "cell.toml").write_text(cell)
    database_url = f"sqlite:///{folder}/truepose.sqlite3"
    settings = Settings(database_url=database_url, cell_file=folder / "cell.toml")
    application = create_app(settings, bench.registry(), perform_here)
    async with application.router.lifespan_context(application):
        application.state.context.campaign_desk.uploads = Uploads(perform_here)
        async with client_of(application) as client:
            yield Day(client, application, name)


async def spend_at_the_tracker(folder):
    """Return the transcripts of a day with tracker and wire, and of what is computed then."""
    async with open_day("day", folder, CELL + GAUGE, WiredBench()) as day:
        for part in (
            _morning,
            _tracker_session,
            _contact_session,
            _campaign,
            _results,
            _second_session,
            _series,
            _hand_down,
            _evening,
        ):
            day.part(part.__name__.strip("_").replace("_", "-"))
            await part(day)
        day.part("pages")
        for page in _pages():
            await day.drawn(page)
        return day.transcripts


async def spend_at_the_camera(folder):
    """Return the transcripts of a session with a camera."""
    async with open_day("camera-day", folder, CAMERA_CELL, CameraBench()) as day:
        day.part("camera-session")
        await _walk(day, await _planned(day, "/api/v1/sessions", camera_session()))
        await day.get("/api/v1/sessions/1/readings", "/api/v1/sessions/1/situation", "/sessions/1")
        return day.transcripts


async def spend_at_the_ballbar(folder):
    """Return the transcripts of a session with a ballbar."""
    async with open_day("ballbar-day", folder, CELL + BALLBAR, Bench()) as day:
        day.part("ballbar-session")
        await _ballbar_session(day)
        await day.get("/sessions/1", "/operator/1")
        return day.transcripts


async def spend_with_people(folder):
    """Return the transcripts of a day on which the service gets to know people."""
    async with open_day("people-day", folder, CELL, Bench()) as day:
        day.part("people")
        await _people(day)
        return day.transcripts


async def _morning(day):
    await day.get("/health", "/api/v1/cells", "/api/v1/devices", "/api/v1/robots", "/api/v1/jobs", "/")
    await day.ask("POST", "/api/v1/devices/tracker/connect")
    await day.get("/api/v1/devices/tracker")
    await day.ask("POST", "/api/v1/devices/tracker/disconnect")


async def _tracker_session(day):
    path = await _planned(day, "/api/v1/sessions", session_request(12))
    await day.get(*(f"{path}/{part}" for part in ("plan", "promise", "outlook", "sheet", "authority")))
    await _walk(day, path)
    parts = (
        "readings",
        "progress",
        "situation",
        "scene",
        "accuracy",
        "space",
        "closing",
        "circles",
        "proof",
    )
    await day.get(path, *(f"{path}/{part}" for part in parts))


async def _ballbar_session(day):
    path = await _planned(day, "/api/v1/sessions", WANTED)
    await day.get(f"{path}/situation", f"{path}/plan", f"{path}/scene")
    await _press(day, path, "abort")
    await day.until(path, lambda session: session["state"] == "aborted")
    await day.get(f"{path}/ledger")


async def _press(day, path, act):
    body = {"command": act, "tablet": "tablet-1", **ADA}
    await day.ask("POST", f"{path}/commands", json=body, headers={"Idempotency-Key": act})


async def _contact_session(day):
    path = await _planned(day, "/api/v1/sessions", WIRE)
    await day.get(f"{path}/plan")
    await _walk(day, path)
    await day.get(path, f"{path}/contact-readings")


async def _campaign(day):
    example = write_campaign_zip(read_campaign(CHECKOUT / "docs" / "examples" / "campaign"))
    await day.ask("POST", "/api/v1/sessions/1/campaign", json={"name": "left arm"})
    await day.ask("POST", "/api/v1/campaigns", files={"file": ("example.zip", example, "application/zip")})
    await day.get(
        "/api/v1/campaigns", "/api/v1/campaigns/1", "/api/v1/campaigns/1/archive", "/api/v1/campaigns/2"
    )
    await day.ask("POST", "/api/v1/drafts", json={"example": True})
    await day.get("/api/v1/drafts/1", "/api/v1/drafts/1/understood")


async def _results(day):
    of = {"campaign_id": 2}
    await day.result("/api/v1/identifications", json=of)
    await day.result("/api/v1/diagnoses", json=of)
    await day.result("/api/v1/validations", json={"model_id": 1, **of, "limit_mm": 0.1})
    await day.result("/api/v1/models/1/corrections", files={"file": ("targets.csv", TARGETS)})
    await day.get(
        "/api/v1/models/1",
        "/api/v1/models/1/file",
        "/api/v1/corrections/1/targets",
        "/api/v1/corrections/1/file",
    )
    await day.get(*(f"/api/v1/models/1/exports/{form}" for form in ("urdf", "ros", "dhm", "controller")))
    results = ("identifications", "diagnoses", "validations")
    await day.get(*(f"/api/v1/{kind}/1/{form}" for form in ("space", "residuals") for kind in results))


async def _second_session(day):
    """A session that is watched, claimed, held, gone on with and ended."""
    path = await _planned(day, "/api/v1/sessions", session_request(60))
    await day.ask("PUT", f"{path}/authority", json={"tablet": "tablet-1", **ADA})
    await day.ask("DELETE", f"{path}/authority", params={"tablet": "tablet-1"})
    await day.ask("POST", f"{path}/commands", json={"command": "abort", **ADA})
    await day.get(path)
    await day.ask(
        "POST", "/api/v1/sessions/1/closing", json={"closed_as": "calibrated", **ADA, "reason": "Checked."}
    )
    await day.get("/api/v1/sessions/1/closing")


async def _series(day):
    """Readings of another program, as they come."""
    columns = ["q1 [deg]", "x [mm]", "y [mm]", "z [mm]"]
    path = await _planned(day, "/api/v1/series", {"name": "left arm", "columns": columns})
    await day.ask("POST", f"{path}/readings", json={"first": 1, "readings": [[12.5, 512.4, None, 640.25]]})
    await day.ask("POST", f"{path}/readings", json={"first": 5, "readings": [[12.5, 512.4, 1.0, 640.25]]})
    await day.get("/api/v1/series", path, f"{path}/readings")
    await day.ask("POST", f"{path}/draft", json={})
    await day.get("/api/v1/drafts")
    await day.ask("DELETE", "/api/v1/drafts/2")


async def _hand_down(day):
    """What a plant hands down, and a model of it."""
    plan = {"kind": "plan", "name": "monthly check", "person": "Ada Byron", "document": {"name": "monthly"}}
    path = "/api/v1/hand-downs"
    await day.ask("POST", path, json=plan, headers={"Idempotency-Key": "plan"})
    await day.ask("POST", f"{path}/1/uses", json={**ADA, "note": "session 12"})
    model = (await day.client.get("/api/v1/models/1/file")).json()
    sent = plan | {"kind": "model", "name": "left arm", "document": model}
    await day.ask("POST", path, json=sent, headers={"Idempotency-Key": "model"})
    await day.get(path, f"{path}/2", f"{path}/2/check")
    await day.ask("POST", f"{path}/2/acceptance", json=ADA)


async def _people(day):
    """Somebody is entered, invites others, and lets a program and a second screen in."""
    secret = day.application.state.context.people.accounts.first_secret
    ada = {"name": "Ada Byron", "password": "on the looms of Lyon", "pin": "4071"}
    await day.ask("POST", "/api/v1/first-person", json={"secret": secret, **ada}, headers=_ORIGIN)
    for path, body in (
        ("/people", {"name": "Alan Turing", "role": "operator"}),
        ("/sessions", session_request()),
        ("/sessions/1/watch-links", {"hours": 12}),
        ("/tokens", {"owner": ada["name"], "name": "line 3", "role": "device", "hours": 24}),
        ("/people/2/link", {}),
        ("/sign-ins/present/fresh", {"pin": ada["pin"]}),
    ):
        await day.ask("POST", f"/api/v1{path}", json=body, headers=_ORIGIN)
    await day.ask("PUT", "/api/v1/people/2/role", json={"role": "viewer"}, headers=_ORIGIN)
    await day.get(
        *(
            f"/api/v1/{path}"
            for path in ("people", "tokens", "sessions/1/watch-links", "sign-ins/present", "audit")
        )
    )
    await day.get("/", "/account", "/people", "/audit", "/sessions/1", "/operator/1")
    for path in ("watch-links/1", "tokens/1", "people/2", "sign-ins/present"):
        await day.ask("DELETE", f"/api/v1/{path}", headers=_ORIGIN)
    await day.get("/", "/sign-in", "/api/v1/sessions")
    await day.ask(
        "POST", "/api/v1/sign-ins", json={"name": ada["name"], "password": "guessed"}, headers=_ORIGIN
    )


async def _evening(day):
    kinds = (
        "sessions",
        "readings",
        "campaigns",
        "identifications",
        "diagnoses",
        "validations",
        "models",
        "corrections",
    )
    await day.get(*(f"/api/v1/{kind}" for kind in kinds), "/api/v1/chain/head", "/api/v1/audit")
    await day.get(
        "/api/v1/readings/1",
        "/api/v1/robots/ABB%20IRB%20120%2C%20simulated",
        "/api/v1/cells/bench",
        "/api/v1/cells/bench/plan",
    )
    await day.get(
        "/api/v1/diagnoses/comparison?robot=ABB%20IRB%20120%2C%20simulated",
        "/api/v1/models/1/corrections",
        "/api/v1/audit/lines",
    )
    await day.get("/api/v1/chain/links", "/api/v1/simulated-hands", "/api/v1/simulated-faults")
    await day.get("/api/v1/sessions/99", "/api/v1/nothing", "/nothing")
    await day.ask("POST", "/api/v1/sessions", json={"name": "nothing"})


async def _planned(day, path, wanted):
    reply = await day.ask("POST", path, json=wanted)
    return reply.headers["location"]


def _asks_anew(last, found):
    """Whether a session waits, and not with the question that was answered last."""
    return found["state"] in _AT_REST and prompt_id(found) != last


async def _walk(day, path):
    """Start a session and confirm whatever it asks, to its end."""
    await day.ask("POST", f"{path}/commands", json={"command": "start", **ADA})
    last = None
    while True:
        found = await day.until(path, functools.partial(_asks_anew, last))
        if found["state"] != "awaiting_confirmation":
            break
        last = prompt_id(found)
        await day.get(path)
        confirmed = await day.ask(
            "POST", f"{path}/commands", json={"command": "confirm", **ADA, "prompt_id": last}
        )
        assert confirmed.is_success, confirmed.text


def _pages():
    """Return the address of every page of this day."""
    place = re.compile(r"{.*}")
    paths = sorted(
        path for path in paths_answering(routes_alone(), HTMLResponse) if not _OTHER_PAGES.match(path)
    )
    return [
        place.sub(part, path)
        for path in paths
        for part in _PARTS.get(path, ["1"])[: None if "{" in path else 1]
    ]


DAYS = (spend_at_the_tracker, spend_at_the_ballbar, spend_at_the_camera, spend_with_people)
