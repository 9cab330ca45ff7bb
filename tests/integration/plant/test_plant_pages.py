"""Pages of a plant's service: the plant at a glance, a robot's life, an instrument's life."""

import asyncio
import html
import json
import re
from datetime import UTC, datetime, timedelta

import pytest

from tests.helpers.machine import HANGS_S
from tests.integration.plant.conftest import all_collected
from truepose.domain.people import MACHINE, Role
from truepose.messages.catalogue import LANGUAGES
from truepose.storage.caches import FleetComparison, LimitForecast, to_bytes
from truepose.storage.plant.records import ClockSeen, Outcome, Visit
from truepose.storage.plant.tables import (
    plant_days,
    plant_instruments,
    plant_results,
    plant_robots,
    plant_told,
)
from truepose.storage.record_insertion import add_row

TODAY = datetime.now(UTC).date()


@pytest.fixture
async def service(tmp_path, empty_database, served_plant):
    """A client of a plant's service that visits its cell once, and when it is told to."""
    database = tmp_path / "plant.sqlite3"
    database.write_bytes(empty_database.read_bytes())
    async with served_plant(f"sqlite:///{database}") as client:
        yield client


async def first_visited(service):
    """Wait for the visit that the plant begins with; the next one comes when it is told to."""
    async with asyncio.timeout(HANGS_S):
        while (await service.here.visits.newest())["left arm"] is None:
            await asyncio.sleep(0.02)


async def found(service, visit):
    """Keep a visit after the one that the plant begins with."""
    await first_visited(service)
    await service.here.visits.keep("left arm", visit)


async def lay(service, *rows):
    await service.here.database.write(lambda c: [add_row(c, table, **values) for table, values in rows])


def robot(serial, days_ago=None, campaign=False):
    """Return rows of a robot, and of its last day where it has one."""
    rows = [(plant_robots, {"serial_number": serial, "robot": "IRB 120"})]
    if days_ago is None:
        return rows
    day = (TODAY - timedelta(days=days_ago)).isoformat()
    of = {"robot_serial_number": serial, "instrument_serial_number": "T-9", "measured_on": day}
    rows.append((plant_days, {"branch_id": 1, "session_id": 1, "readings": 3, **of}))
    if campaign:
        told = {"kind": "campaign", "link": 1, "record_id": int(campaign), "name": "May", "robot": "IRB 120"}
        rows.append((plant_results, {"branch_id": 1, **told, **of}))
    return rows


def validation(serial, number, days_ago, verdict):
    """Return the row of what a validation tells."""
    day = (TODAY - timedelta(days=days_ago)).isoformat()
    of = {"kind": "validation", "link": number, "record_id": number, "robot_serial_number": serial}
    told = {"verdict": verdict, "figure_mm": 0.4, "limit_mm": 0.3, "document": {}}
    return plant_told, {"branch_id": 1, "measured_on": day, **of, **told}


def identification(serial, number, days_ago, figure_mm, known_days_ago=0):
    """Return the row of what an identification tells, which the plant has known for some days."""
    known_since = datetime.now(UTC) - timedelta(days=known_days_ago)
    of = {"kind": "identification", "link": number, "record_id": number, "robot_serial_number": serial}
    told = {"verdict": "converged", "figure_mm": figure_mm, "limit_mm": None, "document": {}}
    when = {"recorded_at": known_since.isoformat(), "measured_on": str(TODAY - timedelta(days=days_ago))}
    return plant_told, {"branch_id": 1, **of, **told, **when}


def under(page, heading, label):
    """Return serial number, words of a column, and where they lead, of each robot under a heading."""
    part = page.partition(f"<h2>{heading}")[2].partition("<h2>")[0]
    of_robot = r'<th><a class="serial" href="/robots/[^"]+">([^<]+)</a></th>.*?'
    rows = re.findall(rf'{of_robot}data-label="{label}">(.*?)</td>', part, re.S)
    return [
        (serial, re.sub("<[^>]+>", "", told).strip(), re.findall('href="([^"]+)"', told))
        for serial, told in rows
    ]


def changed(page):
    """Return serial number, what changed, and where each sentence leads, of the robots that changed."""
    return under(page, "Changes since ", "Change")


def due(page):
    """Return serial number and reason of each robot that is to be measured next."""
    return [(serial, reason) for serial, reason, _ in under(page, "Measure next</h2>", "Reason")]


async def page(service, path, language="en"):
    answer = await service.get(path, headers={"Accept-Language": language})
    assert (answer.status_code, answer.headers["content-type"]) == (200, "text/html; charset=utf-8")
    return answer.text


def outcome(page):
    """Return the sentence below the title of a page."""
    return html.unescape(re.search(r'</h1>\s*<p class="outcome">([^<]+)</p>', page).group(1))


async def test_the_plant_and_a_robots_life_begin_with_one_sentence_about_limits(service):
    unvalidated = outcome(await page(service, "/"))
    table, told = validation("120-1", 7, 3, "failed")
    await lay(service, *robot("120-1", 3), (table, told))

    failed, of_robot = outcome(await page(service, "/")), outcome(await page(service, "/robots/120-1"))

    assert unvalidated.startswith("Robot within its limit in 0 of 1 cells; not validated in 1; overall: ")
    assert failed == (
        "Robot within its limit in 0 of 1 cells; failed in 1 (worst: 120-1 in left arm, largest error 0.400 "
        "mm, limit 0.3 mm); overall: fail."
    )
    assert of_robot == "Largest 0.400 mm, limit 0.3 mm: fail."


@pytest.mark.parametrize("verdict", ["no_limit", "passed"])  # as it is told now, and as it was once
async def test_a_validation_without_a_limit_neither_passes_nor_fails(service, verdict):
    table, told = validation("120-1", 7, 3, verdict)
    means = {"promised": True, "before_mm": 0.499, "after_mm": 0.0331}
    await lay(service, *robot("120-1", 3), (table, {**told, "document": means}))

    at_a_glance, of_robot = outcome(await page(service, "/")), outcome(await page(service, "/robots/120-1"))

    assert at_a_glance == (
        "Robot within its limit in 0 of 1 cells; no limit set in 1; overall: validate with a limit to get a "
        "pass or fail."
    )
    assert of_robot == (
        "Mean error 0.499 mm before (nominal), 0.0331 mm after; no limit set: set a limit to get a pass or "
        "fail."
    )


async def test_a_plant_without_robots_says_so(service):
    shown = await page(service, "/")

    assert "No robots yet." in shown
    assert "No error, cause, model or certificate has changed" in shown
    assert "No cell has sent any records in this period." in shown
    assert "left arm" in shown
    assert due(shown) == []


async def test_robots_are_due_in_the_order_that_the_page_says(service):
    rows = [
        *robot("late", 45),
        *robot("later", 90),
        *robot("never"),
        *robot("tomorrows", -400),
        *robot("just", 31),
    ]
    await lay(service, *rows, *robot("fresh", 30), *robot("late", -400)[1:])

    found = due(await page(service, "/"))

    assert [serial for serial, _ in found] == ["never", "tomorrows", "later", "late", "just"]
    assert [reason.partition(",")[0] for _, reason in found] == [
        "No measurement is on record.",
        "The date of the last measurement",
        f"Last measured on {TODAY - timedelta(days=90)}",
        f"Last measured on {TODAY - timedelta(days=45)}",
        f"Last measured on {TODAY - timedelta(days=31)}",
    ]


async def test_programs_hear_of_no_day_that_is_yet_to_come_where_there_is_another(service):
    honest = (TODAY - timedelta(days=45)).isoformat()
    await lay(service, *robot("late", 45, campaign=7), *robot("late", -400, campaign=8)[1:])
    await lay(service, (plant_instruments, {"serial_number": "T-9"}), *robot("tomorrows", -400))

    async def last(what):
        found = (await service.get(f"/api/v1/plant/{what}")).json()
        return [(one["serial_number"], one["last_measured_on"]) for one in found]

    assert await last("robots") == [
        ("late", honest),
        ("tomorrows", (TODAY + timedelta(days=400)).isoformat()),
    ]
    assert await last("instruments") == [("T-9", honest)]
    life = (await service.get("/api/v1/plant/robots/late")).json()["robot"]
    assert (life["last_measured_on"], life["cell"], life["results"]) == (honest, "left arm", 2)
    shown = await page(service, "/robots/late")
    assert f"Last measured on {honest}, in left arm." in shown
    days = re.findall(r"<tr><th>(\d{4}-\d\d-\d\d)( <span class=\"badge warn)?", shown)
    assert [(day, bool(doubted)) for day, doubted in days] == [
        (honest, False),
        (str(TODAY + timedelta(days=400)), True),
    ]


async def test_a_serial_number_may_have_slashes(service):
    await lay(service, *robot("120/5 01/7?a", 3), (plant_instruments, {"serial_number": "T-9"}))

    link = re.search('href="(/robots/[^"]+)"', await page(service, "/instruments/T-9"))[1]

    assert "120/5 01/7?a</h1>" in await page(service, link)
    assert (await service.get(f"/api/v1/plant{link}")).json()["robot"]["serial_number"] == "120/5 01/7?a"


async def test_a_robot_that_gets_worse_leads_to_the_comparison_that_says_so(service):
    days = [str(TODAY + timedelta(days=ahead)) for ahead in (-90, -3, 20, 5)]
    grows = LimitForecast("120-1", "backlash", "joint 5", 0.0, days[0], 0.06, 0.012, *days[1:])
    await lay(service, *robot("120-1", 3), *robot("120-2", 3))
    compared = FleetComparison("IRB 120", f"{days[1]} 08:00 UTC", 0, 0.1, (grows,))
    await service.here.comparisons.keep(to_bytes(compared))

    shown = await page(service, "/")

    ((serial, reason),) = due(shown)
    assert serial == "120-1"
    said = f"growing by 0.012 mm a month since {days[0]}. This error is expected to exceed 0.1 mm"
    assert reason.startswith(f"Backlash, joint 5: {said}")
    lives = [await page(service, f"/robots/{of}") for of in ("120-1", "120-2")]
    leads = '<a href="/fleet?type=IRB%20120">Backlash, joint 5'
    assert [leads in text for text in (shown, *lives)] == [True, True, False]
    assert "not due" in lives[1]
    assert "forecast to exceed a limit before the next measurement is due" in shown


async def test_a_robot_that_was_never_measured_stands_in_the_cell_that_planned_for_it(service, cell):
    await cell.measure(0, serial="120-9")
    await all_collected(service, cell)

    shown = await page(service, "/")

    assert due(shown) == [("120-9", "No measurement is on record.")]
    assert '<td data-label="Cell">left arm</td>' in shown


async def test_where_no_robot_is_due_none_is_listed(service):
    of_a_wrong_clock = [*robot("fresh", -400)[1:], *robot("fresher", -400, campaign=True)[1:]]
    judged = [validation("fresh", 1, -400, "failed"), validation("fresh", 2, 0, "passed")]
    await lay(service, *robot("fresh", 0), *robot("fresher", 12), *of_a_wrong_clock, *judged)

    shown = await page(service, "/")

    assert due(shown) == []
    assert "No robot is due for measurement" in shown


async def test_what_came_in_leads_to_the_page_of_its_cell(service):
    await lay(service, *robot("120-1", 3, campaign=7))

    shown = [await page(service, path) for path in ("/", "/robots/120-1")]

    assert all('<a href="http://localhost/campaigns/7">Campaign 7: May</a>' in text for text in shown)


async def test_what_changed_is_said_by_robot_the_largest_worsening_first(service):
    serials = ("known", "collected today", "quiet", "late", "never")
    await lay(service, *(row for serial in serials for row in robot(serial)))
    await lay(
        service,
        identification("known", 1, 40, 0.05, known_days_ago=39),
        identification("quiet", 2, 40, 0.05, known_days_ago=39),
        identification("late", 3, 20, 0.05, known_days_ago=19),
        identification("known", 4, 3, 0.06),
        identification("collected today", 5, 40, 0.05),
        identification("collected today", 6, 3, 0.08),
        identification("late", 7, 30, 0.09),
    )

    shown, told = await page(service, "/"), (await service.get("/api/v1/plant/changes")).json()

    before, now = TODAY - timedelta(days=40), TODAY - timedelta(days=3)
    rose = "Mean error of the identified model rose from 0.0500 mm on {} to {} mm on {} (identification {})."
    expected = [
        ("collected today", rose.format(before, "0.0800", now, 6), "http://localhost/identifications/6"),
        ("known", rose.format(before, "0.0600", now, 4), "http://localhost/identifications/4"),
    ]
    assert changed(shown) == [(serial, sentence, [href]) for serial, sentence, href in expected]
    assert [(one["robot_serial_number"], one["sentence"], one["page"]) for one in told] == expected
    assert [(one["what"], one["before_mm"], one["after_mm"]) for one in told] == [
        ("error", 0.05, 0.08),
        ("error", 0.05, 0.06),
    ]


async def test_what_comes_in_between_two_looks_changes_what_is_said(service):
    await lay(service, *robot("120-1"), identification("120-1", 1, 40, 0.05, known_days_ago=39))
    quiet = await page(service, "/")
    await lay(service, identification("120-1", 2, 0, 0.04))

    fell = await page(service, "/")

    assert changed(quiet) == []
    ((serial, sentence, _),) = changed(fell)
    assert serial == "120-1"
    assert " fell from 0.0500 mm on " in sentence


async def test_a_number_of_another_chain_leads_nowhere(service):
    await lay(service, *robot("120-1", 3, campaign=7))
    other = "INSERT INTO plant_branches (recorded_at, cell_id, parent_id, after_link, person, reason)"
    await service.here.database.write(lambda c: c.exec_driver_sql(f"{other} VALUES ('', 1, 1, 0, '', '')"))

    shown = await page(service, "/robots/120-1")

    assert "Campaign 7: May" in shown
    assert "/campaigns/7" not in shown


async def test_lives_show_what_was_collected(service, cell):
    await cell.measure()
    await all_collected(service, cell)

    of_robot, of_instrument = await page(service, "/robots/120-1"), await page(service, "/instruments/T-7")
    glance = await page(service, "/")

    assert 'href="/instruments/T-7"' in of_robot
    assert 'href="/robots/120-1"' in of_instrument
    assert due(glance) == []
    assert "No robot is due for measurement" in glance


async def test_a_certificate_that_ended_is_said_at_a_glance_and_of_its_instrument(service, cell):
    yesterday = (TODAY - timedelta(days=1)).isoformat()
    await cell.measure(certificate="report 1", expires=yesterday)
    await cell.measure(name="second", instrument="T-8", certificate="report 2", expires="2099-01-01")
    await all_collected(service, cell)

    glance, ended = await page(service, "/"), await page(service, "/instruments/T-7")
    told = (await service.get("/api/v1/plant/instruments/T-8")).json()["certificates"]

    ending = glance.partition("<h2>Expired or expiring certificates</h2>")[2].partition("<h2>")[0]
    assert re.findall(r"<th>(report \d)</th>", ending) == ["report 1"]
    assert "report 1" in ended
    changes = glance.partition("<h2>Changes since ")[2].partition("<h2>")[0]
    said = f"Certificate report 1 of tracker T-7 expired on {yesterday}; robots last measured with it: "
    assert re.findall(r'<a href="/instruments/T-7">(.*?)\d\.</a>', changes) == [said]
    assert [(one["certificate"], one["expires"], one["standing"]) for one in told] == [
        ("report 2", "2099-01-01", "holds")
    ]


@pytest.mark.parametrize("path", ["/robots/none", "/instruments/none"])
async def test_a_serial_number_that_nobody_saw_is_said(service, path):
    answer = await service.get(path)

    assert answer.status_code == 404
    assert "No cell of this plant has a record of none" in answer.text


@pytest.mark.parametrize("language", LANGUAGES)
async def test_every_language_shows_every_page(service, language):
    await lay(service, *robot("120-1", 45, campaign=7), *robot("never"))
    await lay(service, *robot("far", -400))

    for path in ("/", "/robots/120-1", "/robots/never", "/cells/left arm"):
        assert f'<html lang="{language}"' in await page(service, path, language)


async def test_a_cell_that_is_away_has_a_sentence_and_loses_nothing(service):
    away = Visit(Outcome.UNREACHABLE, "left arm cannot be reached at http://localhost (refused).")
    await found(service, away)

    shown = await page(service, "/")

    assert "The cell keeps working and loses no records. The plant will try again." in shown
    assert away.sentence in shown


async def test_a_clock_and_another_chain_are_stated(service):
    parted = Visit(Outcome.ANOTHER_CHAIN, "Both are one up to link 311.", clock=ClockSeen(-86400.5, 0.25))
    await found(service, parted)

    shown = await page(service, "/")

    assert "-86400.50 s (± 0.250 s)" in shown
    assert "Nothing is collected until a metrologist accepts this chain." in shown


async def shown_another_chain(service, cell):
    """Have the newest visit say that the cell shows another chain since its last two links."""
    await first_visited(service)
    await cell.measure()
    await service.here.collector.visit("left arm")
    known = await service.here.journal.collected(await service.here.journal.reached("left arm"))
    there, fork = known.position + 3, known.position - 2
    sentence = "left arm has a different chain from the one collected."
    parted = Visit(Outcome.ANOTHER_CHAIN, sentence, newest=there, head=known.head.text, fork=fork)
    await service.here.visits.keep("left arm", parted)
    return fork


async def as_(service, name, role):
    """Enter somebody and return the headers by which they are known."""
    accounts = service.here.people.accounts
    number, _ = await accounts.enter_by_machine(name, role)
    _, secret = await accounts.make_token(number, "desk", role, 1, MACHINE)
    return {"Authorization": f"Bearer {secret}"}


async def test_a_metrologist_accepts_another_chain_after_a_look_at_what_that_does(service, cell):
    fork = await shown_another_chain(service, cell)
    await as_(service, "Ada Byron", Role.ADMINISTRATOR)  # the first that is entered
    viewer = await as_(service, "Mary Ward", Role.VIEWER)
    metrologist = await as_(service, "Grace Hopper", Role.METROLOGIST)

    at_a_glance = (await service.get("/", headers=metrologist)).text
    to_look, to_act = [
        (await service.get("/cells/left arm", headers=who)).text for who in (viewer, metrologist)
    ]
    assert '<a href="/cells/left%20arm">Review and accept</a>' in at_a_glance
    assert f"The first {fork} entries, which both chains share, stay unchanged." in to_look
    assert "Entries that only the plant has now: 2." in to_look
    assert f"collected as a separate branch: 5 (of {fork + 5} in total)." in to_look
    assert "Accept this chain" not in to_look
    assert "Accepted by: Grace Hopper" in to_act
    (asked,) = json.loads(html.unescape(re.search(r'data-asks="([^"]*)"', to_act)[1]))
    said = {"reason": "The backup of Monday was restored."}
    refused = await service.post(asked["path"], json=asked["body"] | said, headers=viewer)
    accepted = await service.post(asked["path"], json=asked["body"] | said, headers=metrologist)
    afterwards = (await service.get("/cells/left arm", headers=metrologist)).text

    assert (refused.status_code, accepted.status_code) == (403, 201)
    assert "Accept this chain" not in afterwards
    assert "Nothing is collected until" not in afterwards
    row = re.search(r"<h2>Accepted chains</h2>.*?</tbody>", afterwards, re.S)[0]
    assert re.findall(r'<td data-label="(?:From entry|Who|Reason)">([^<]*)</td>', row) == [
        str(fork + 1),
        "Grace Hopper",
        said["reason"],
    ]


async def test_a_cell_without_another_chain_offers_none_and_one_that_is_unknown_is_said(service, cell):
    await first_visited(service)
    await cell.measure()
    await service.here.collector.visit("left arm")

    shown, missing = await page(service, "/cells/left arm"), await service.get("/cells/right arm")

    assert "up to date" in shown
    assert "Accept this chain" not in shown
    assert "Accepted chains" not in shown
    assert missing.status_code == 404
    assert "There is no cell right arm in this plant." in missing.text
