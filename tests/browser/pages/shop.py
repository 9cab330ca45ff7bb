"""A shop after some days: a service with a record of each kind, and the address of each page."""

import contextlib
import re
import time
from urllib.parse import quote

import httpx
from fastapi.responses import HTMLResponse

from tests.helpers.storage.demo_database import write_demo
from tests.helpers.web.performing import perform_here
from tests.helpers.web.routes import paths_answering, routes_alone
from tests.integration.web.ballbar_bench import BALLBAR, WANTED
from tests.integration.web.bench import CELL, Bench, session_request
from tests.integration.web.contact_bench import WIRE
from tests.integration.web.listening import listening
from truepose.analysis.job_queue.uploads import Uploads
from truepose.app import create_app
from truepose.settings import Settings

TARGETS = "target,x_mm,y_mm,z_mm,qw,qx,qy,qz\n1,350,0,400,0,0,1,0\n2,350,50,400,0,0,1,0\n"
ROBOT = "ABB IRB 120"
# What stands in a page's address beside the number of a record; where nothing does, the number is 1.
PARTS = {
    "/errors/{code}": ["TP-1001"],
    "/operator/{id}": ["3", "4", "5"],  # by ballbar, by gauge, by tracker
    "/reports/{kind}/{id}": ["identification/1", "validation/1", "diagnosis/1"],
    "/robots/{name:path}": [quote(ROBOT)],
    "/sessions/{id}/result": ["2"],
}
# Pages of people and of links that are given once are in `house`: this shop knows nobody.
OF_PEOPLE = {"/account", "/audit", "/people", "/not-yours", "/sign-in"}
OF_LINKS = {"/first-person/{secret}", "/watch/{secret}", "/welcome/{secret}"}


def pages():
    """Return the address of every page that the application has, each kind of record once."""
    application = routes_alone()
    found = []
    for path in sorted(paths_answering(application, HTMLResponse) - OF_PEOPLE - OF_LINKS):
        place = re.compile(r"{.*}")
        found += [place.sub(part, path) for part in PARTS.get(path, ["1"])] if "{" in path else [path]
    return found


@contextlib.contextmanager
def open_shop(folder):
    """Serve what a demo left, a ballbar session, a correction and readings of one's own; yields where."""
    file = folder / "truepose.sqlite3"
    write_demo(file)
    (folder / "cell.toml").write_text(CELL + BALLBAR)
    where = Settings(database_url=f"sqlite:///{file}", cell_file=folder / "cell.toml")
    application = create_app(where, Bench().registry(), perform_here)
    with listening(application) as url, httpx.Client(base_url=url, timeout=60, trust_env=False) as client:
        for wanted in (WANTED, WIRE, session_request(12)):
            client.post("/api/v1/sessions", json=wanted).raise_for_status()
        application.state.context.campaign_desk.uploads = Uploads(perform_here)
        client.post("/api/v1/drafts", json={"example": True}).raise_for_status()
        sent = client.post("/api/v1/models/1/corrections", files={"file": ("targets.csv", TARGETS)})
        job = sent.raise_for_status().headers["Location"]
        while client.get(job).json()["state"] != "succeeded":
            time.sleep(0.05)
        yield url
