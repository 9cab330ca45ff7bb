"""A program corrected at the tablet, from the form to the file."""

import asyncio
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import SimpleNamespace

import pytest
from playwright.sync_api import expect

from tests.browser.conftest import settings_in
from tests.browser.windows import without_complaint
from tests.helpers.web.performing import perform_here
from tests.integration.web.bench import Bench
from tests.integration.web.calibration.stored_models import store_model
from tests.integration.web.listening import listening
from truepose.app import create_app
from truepose.storage.database import Database
from truepose.storage.results.campaigns import CampaignRepository
from truepose.storage.results.jobs import JobRepository
from truepose.storage.results.models import ResultRepository

REST = "[9E9,9E9,9E9,9E9,9E9,9E9]"
PROGRAM = f"MODULE M\nCONST jointtarget a:=[[20,30,-25,40,50,60],{REST}];\nENDMODULE\n".encode()


async def with_a_model(url):
    database = Database(url)
    results = ResultRepository(database)
    kept = {"campaigns": CampaignRepository(database), "jobs": JobRepository(database), "results": results}
    await store_model(SimpleNamespace(**kept))
    database.close()


@pytest.fixture(scope="module")
def service(tmp_path_factory, empty_database):
    """A service that has a model, and corrects without processes for it."""
    where = settings_in(tmp_path_factory.mktemp("shop"), empty_database)
    with ThreadPoolExecutor(1) as apart:  # the browser's own loop runs in this thread
        apart.submit(asyncio.run, with_a_model(where.database_url)).result()
    with listening(create_app(where, Bench().registry(), perform_here)) as url:
        yield SimpleNamespace(url=url)


def test_a_program_goes_in_and_its_corrected_file_comes_out(service, tablet):
    tablet.goto(f"{service.url}/corrections?model_id=1")

    program = {"name": "m.mod", "mimeType": "", "buffer": PROGRAM}
    tablet.get_by_label("Program (RAPID").set_input_files(program)
    tablet.get_by_role("button", name="Correct the file").click()
    expect(tablet.locator("h1")).to_have_text("Correction of m.mod")
    with tablet.expect_download() as taken:
        tablet.get_by_role("link", name="Download m-corrected.mod").click()

    before, after = PROGRAM.splitlines(), Path(taken.value.path()).read_bytes().splitlines()
    assert taken.value.suggested_filename == "m-corrected.mod"
    assert [k for k, (a, b) in enumerate(zip(before, after, strict=True)) if a != b] == [1]
    expect(tablet.get_by_role("img", name="Shifts of the targets")).to_be_visible()
    assert tablet.evaluate("document.documentElement.scrollWidth <= innerWidth")


def test_what_cannot_be_corrected_is_said_at_the_form(service, chromium):
    refused = ("Failed to load resource",)  # what the browser says of an answer of 422
    with chromium.one(service.url) as page, without_complaint(page, service.url, refused):
        page.goto(f"{service.url}/corrections")
        page.get_by_label("Program (RAPID").set_input_files({"name": "m.txt", "mimeType": "", "buffer": b"x"})
        page.get_by_text("Details not in the file").click()
        page.get_by_label("Arm branch").select_option("back/up/flip")

        with page.expect_request("**/corrections?*") as asked:
            page.get_by_role("button", name="Correct the file").click()

        expect(page.get_by_role("status")).to_contain_text("m.txt: unknown file extension")
        assert asked.value.url.endswith("?branch=back%2Fup%2Fflip")
