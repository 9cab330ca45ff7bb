"""Sessions as pages: the list, one as it stands, what it came to, and forms that plan one."""

import json
from dataclasses import replace

import pytest

from tests.helpers.domain.robots import IRB_120
from tests.helpers.web.pages import Page, links
from tests.integration.web.bench import measured, number_of, planned
from tests.integration.web.calibration.stored_models import store_model
from truepose.web.pages.session_results import models_of


@pytest.fixture
def session(client, until):
    """Measure a session and return its number."""

    async def measure(**wanted):
        for device in ("tracker", "robot"):
            await client.post(f"/api/v1/devices/{device}/connect")
        return number_of(await measured(client, until, **wanted))

    return measure


async def test_the_list_leads_to_each_session_and_to_the_results_that_there_are(client, session):
    calibration, validation = await session(), await session(role="validation")

    reply = await client.get("/sessions")

    assert {f"/sessions/{calibration}", f"/sessions/{validation}"} <= set(links(reply))
    assert f"/sessions/{validation}/result" in links(reply)
    assert f"/sessions/{calibration}/result" not in links(reply)  # it identifies, and judges nothing
    assert "/sessions/new" in links(reply)


async def test_a_finished_session_leads_to_its_result_and_a_planned_one_waits_for_a_person(client, session):
    finished = await session(role="validation")
    path = await planned(client, role="validation")

    shown = await client.get(f"/sessions/{finished}")
    waiting = await client.get(path.removeprefix("/api/v1"))

    assert f"/sessions/{finished}/result" in links(shown)
    assert "Every configuration was measured or skipped." in shown.text
    assert not [link for link in links(waiting) if link.endswith("/result")]
    assert "Start (asks before anything moves)" in Page(waiting.text).text


def asked(reply):
    """What the forms of a page ask of the API, and where each leads."""
    forms = [a for tag, a in Page(reply.text).elements if tag == "form" and "data-asks" in a]
    return [([ask["path"] for ask in json.loads(form["data-asks"])], form["data-leads"]) for form in forms]


async def test_a_calibration_is_identified_by_one_tap_and_a_validation_is_judged(client, session):
    calibration, validation = await session(), await session(role="validation")

    leading = asked(await client.get(f"/sessions/{calibration}"))
    judged = asked(await client.get(f"/sessions/{validation}"))

    paths = [f"/api/v1/sessions/{calibration}/campaign", "/api/v1/identifications"]
    assert leading == [(paths, "/identifications")]
    assert judged == []


async def test_readings_for_an_identification_have_no_result_page(client, session):
    reply = await client.get(f"/sessions/{await session()}/result")

    assert reply.status_code == 404
    assert "The readings of this session are for identification" in reply.text


async def test_without_a_model_the_result_says_what_is_missing(client, session):
    number = await session(role="validation")

    reply = await client.get(f"/sessions/{number}/result")
    document = await client.get(f"/api/v1/sessions/{number}/accuracy")

    assert (reply.status_code, document.status_code) == (409, 409)
    assert "A model of ABB IRB 120 is needed" in reply.text
    assert document.json()["detail"] in Page(reply.text).text


async def test_nothing_measured_yet_is_said_in_place_of_a_result(client):
    page = (await planned(client, role="validation")).removeprefix("/api/v1")

    assert (await client.get(f"{page}/result")).status_code == 409
    assert "/result" not in str(links(await client.get("/sessions")))


@pytest.mark.parametrize("number", ["999", "0", "x", "9" * 30])
async def test_what_is_no_session_says_so_in_french(client, number):
    for page in (f"/sessions/{number}", f"/sessions/{number}/result"):
        reply = await client.get(page, headers={"Accept-Language": "fr"})
        assert reply.status_code == 404
        assert "Il n\u2019y a rien à cette adresse" in reply.text


async def test_the_forms_ask_for_validation_and_a_proof_for_a_model(client):
    reply = await client.get("/sessions/new")

    bodies = [a["data-asks"] for _, a in Page(reply.text).elements if "data-asks" in a]
    assert all('"role": "validation"' in body for body in bodies if "sphere" not in body)
    assert [body for body in bodies if "sphere" in body]  # of the ballbar, whose test is no role
    assert [body for body in bodies if "iso9283" in body]
    assert [body for body in bodies if "circles" in body]
    assert not [body for body in bodies if "prove" in body]  # there is nothing to prove yet
    assert "ABB IRB 120 has no model yet: calibrate it first." in Page(reply.text).text


async def test_the_newest_model_of_this_robot_stands_behind_those_of_others(app):
    here = app.state.context
    ours = await store_model(here)
    for _ in range(2):
        await store_model(here, replace(IRB_120, name="Another"))

    assert [one.id for one in await models_of(here, IRB_120.name, 1)] == [ours]
    assert await models_of(here, "A third") == []


async def test_the_proof_that_was_asked_for_is_of_that_model_or_of_one_that_is_chosen(app, client):
    older, _ = await store_model(app.state.context), await store_model(app.state.context)

    def chosen(page):
        options = [a for tag, a in Page(page.text).elements if tag == "option"]
        return [a["value"] for a in options if "selected" in a], {"value": ""} in options[:1]

    assert chosen(await client.get(f"/sessions/new?model_id={older}")) == ([str(older)], False)
    assert chosen(await client.get("/sessions/new?model_id=99")) == ([], True)  # nothing is chosen for them
    assert chosen(await client.get("/sessions/new")) == ([], False)


async def test_pages_speak_french_and_go_on_speaking_it(client, session):
    number = await session(role="validation")

    reply = await client.get(f"/sessions/{number}?language=fr")

    assert '<html lang="fr">' in reply.text
    assert "terminée" in reply.text
    assert '<html lang="fr">' in (await client.get("/sessions")).text
