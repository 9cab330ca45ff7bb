"""Own readings in a browser, by somebody who has never seen the program: from a table to the named cause."""

import time
from types import SimpleNamespace

import pytest
from playwright.sync_api import expect

from tests.helpers.web.performing import perform_here
from tests.integration.web.bench import CELL, Bench
from tests.integration.web.listening import listening
from truepose.app import create_app
from truepose.exchange.import_wizard.files import example_files
from truepose.settings import Settings

MOST_TAPS = 10
MOST_S = 180.0


@pytest.fixture
def service(tmp_path):
    (tmp_path / "cell.toml").write_text(CELL)
    where = Settings(database_url=f"sqlite:///{tmp_path}/t.sqlite3", cell_file=tmp_path / "cell.toml")
    with listening(create_app(where, Bench().registry(), perform_here)) as url:
        yield SimpleNamespace(url=url)


@pytest.fixture
def own_table(tmp_path):
    """A table as a spreadsheet of a German shop writes it, with one torn cell."""
    lines = example_files()["left arm.csv"].decode().splitlines()
    semicolons = [line.replace(",", ";").replace(".", ",") for line in lines]
    semicolons[0] = (
        "Nr;" + ";".join(f"Achse {k} [Grad]" for k in range(1, 7)) + ";Reflektor;X [mm];Y [mm];Z [mm];u [mm]"
    )
    semicolons[40] = semicolons[40].replace(",", ",x", 1)
    file = tmp_path / "messung.csv"
    file.write_bytes("\r\n".join(semicolons).encode("utf-16"))
    return file


def test_somebody_who_has_never_seen_it_reads_the_cause_of_an_own_table(service, tablet, own_table):
    begun_s, taps = time.monotonic(), 2  # the button, and the dialogue's own
    tablet.goto(f"{service.url}/bring")
    tablet.set_input_files("[data-bring] input[multiple]", own_table)

    expect(tablet.locator("td[aria-invalid]")).to_be_visible()
    for answer in ("[data-leave-out]", '[data-day="0"]', "[data-go]"):
        tablet.locator(answer).click()
        taps += 1

    tablet.wait_for_url("**/diagnoses/*", timeout=MOST_S * 1000)
    expect(tablet.get_by_text("joint harmonics (joint 4)").first).to_be_visible()
    assert "SIMULATED" not in tablet.inner_text("body")
    assert taps <= MOST_TAPS
    assert time.monotonic() - begun_s < MOST_S
