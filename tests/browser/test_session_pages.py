"""A test from its form to its result, as a person with a tablet does it."""

import time
from dataclasses import replace

import numpy as np
from playwright.sync_api import expect

from tests.browser.windows import without_complaint
from tests.helpers.diagnosis.diagnosed_cells import two_findings
from tests.integration.web.bench import session_request, stops
from truepose.domain.session import PlannedStop, SessionPlan


def planned(n=3):
    rows = stops(n)
    joints = (tuple(np.radians(stop["joints_deg"]).tolist()) for stop in rows)
    return SessionPlan("validation", tuple(PlannedStop(k, q, 1) for k, q in enumerate(joints, start=1)))


def test_a_test_is_planned_started_and_followed_to_its_result(service, tablet):
    service.plan_with(planned())
    for device in ("tracker", "robot"):
        service.post(f"/api/v1/devices/{device}/connect")

    tablet.goto(f"{service.url}/sessions/new")
    form = tablet.locator("#iso9283")
    with tablet.expect_request("**/api/v1/sessions") as asked:
        form.get_by_role("button", name="Plan test").click()
    expect(tablet.locator("#state")).to_have_text("planned")
    tablet.get_by_role("button", name="Start").click()
    expect(tablet.get_by_label("Your name")).to_be_focused()  # nothing moves without a name
    tablet.get_by_label("Your name").fill("Ada Byron")
    tablet.get_by_role("button", name="Start").click()
    expect(tablet.locator("#question")).to_contain_text("Is the cell clear")
    tablet.get_by_role("button", name="The cell is clear").click()

    expect(tablet.locator("#state")).to_have_text("finished")
    expect(tablet.locator("main, aside").get_by_role("button", name="Abort the session")).to_have_count(0)
    expect(tablet.get_by_role("link", name="See the result")).to_be_visible()
    body = asked.value.post_data_json
    whole = {"method": "iso9283", "test": "poses", "plane": "y+", "cycles": 30, "hours": 8}
    assert body["plan"] == whole  # what is empty is left out
    assert body["role"] == "validation"


def test_where_the_fixture_stands_is_asked_before_a_sphere_test_is_planned(service, tablet):
    tablet.goto(f"{service.url}/sessions/new")
    form = tablet.locator("#sphere")

    form.get_by_role("button", name="Plan test").click()
    expect(form.get_by_label("Fixture x")).to_be_focused()  # the browser asks for what is needed
    for label, value in (("Fixture x", "350"), ("Fixture y", "-150"), ("Fixture z", "150")):
        form.get_by_label(label).fill(value)
    made = {"id": 1, "state": "planned", "result_url": "/sessions/1/result"}
    tablet.route("**/api/v1/sessions", lambda route: route.fulfill(json=made))
    tablet.route("**/sessions/1", lambda route: route.fulfill(body="the session"))
    with tablet.expect_request("**/api/v1/sessions") as asked:
        form.get_by_role("button", name="Plan test").click()
    expect(tablet.get_by_text("the session")).to_be_visible()

    place = {"x_mm": 350, "y_mm": -150, "z_mm": 150, "rx_deg": 0, "ry_deg": 0, "rz_deg": 0}
    assert asked.value.post_data_json["placements"] == [place]
    assert asked.value.post_data_json["plan"] == {"method": "sphere", "configurations": 24}
    assert asked.value.post_data_json["kind"] == "ballbar"


def test_what_the_service_refuses_is_said_at_the_form(service, chromium):
    refused = ("Failed to load resource",)  # what the browser says of an answer of 422
    with chromium.one(service.url) as page, without_complaint(page, service.url, refused):
        page.goto(f"{service.url}/sessions/new")
        form = page.locator("#iso9283")

        form.get_by_label("Centre x").fill("300")
        form.get_by_role("button", name="Plan test").click()

        expect(form.get_by_role("status")).to_contain_text("centre_mm")
        assert page.url.endswith("/sessions/new")


def test_another_tracker_is_accepted_by_the_number_that_a_person_types(service, tablet):
    service.plan_with(planned())
    number = service.post("/api/v1/sessions", session_request(role="validation")).json()["id"]
    session = service.get(f"/api/v1/sessions/{number}")
    foreign = {"device": "tracker", "finding": "foreign", "serial_number": "42"}
    questioned = {
        **session,
        "state": "awaiting_confirmation",
        "prompt": {"id": 5, "message": "Another tracker answers."},
        "tracker_in_question": foreign,
    }
    told = {"Truepose-Time": str(time.monotonic())}  # as every answer tells it
    tablet.route(f"**/api/v1/sessions/{number}", lambda route: route.fulfill(json=questioned, headers=told))
    answer = {"sentence": "", "session": {**questioned, "tracker_in_question": None, "state": "running"}}
    tablet.route("**/commands", lambda route: route.fulfill(json=answer))
    tablet.goto(f"{service.url}/sessions/{number}")
    tablet.get_by_label("Your name").fill("Ada Byron")

    tablet.get_by_label("Serial number of the tracker that you accept").fill("42")
    with tablet.expect_request("**/commands") as asked:
        tablet.get_by_role("button", name="The cell is clear: continue").click()

    said = asked.value.post_data_json
    assert said.pop("pressed_at_s") <= time.monotonic()
    assert said == {
        "command": "confirm",
        "person": "Ada Byron",
        "prompt_id": 5,
        "accept_serial_number": "42",
    }


def test_where_no_tracker_is_questioned_no_number_is_asked(service, tablet):
    number = service.post("/api/v1/sessions", session_request(role="validation")).json()["id"]

    tablet.goto(f"{service.url}/sessions/{number}")

    expect(tablet.locator("#state")).to_have_text("planned")
    expect(tablet.get_by_label("Serial number of the tracker")).to_be_hidden()


def test_a_calibration_is_planned_beside_its_promise_and_identified_by_one_tap(service, tablet):
    service.plan_with(replace(planned(), role="calibration"))
    for device in ("tracker", "robot"):
        service.post(f"/api/v1/devices/{device}/connect")

    tablet.goto(f"{service.url}/plan?n=30")
    with tablet.expect_request("**/api/v1/sessions") as asked:
        tablet.get_by_role("button", name="Plan test").click()
    expect(tablet.locator("#state")).to_have_text("planned")
    expect(tablet.get_by_role("button", name="Identify")).to_have_count(0)
    tablet.get_by_label("Your name").fill("Ada Byron")
    tablet.get_by_role("button", name="Start").click()
    tablet.get_by_role("button", name="The cell is clear").click()
    expect(tablet.locator("#state")).to_have_text("finished")
    made = {"id": 7, "state": "succeeded", "result_id": 4, "fraction": 1.0}
    tablet.route("**/api/v1/sessions/*/campaign", lambda route: route.fulfill(json={"id": 5}))
    tablet.route("**/api/v1/identifications", lambda route: route.fulfill(json=made))
    tablet.route("**/identifications/4", lambda route: route.fulfill(body="Here is number 4."))
    with tablet.expect_request("**/api/v1/identifications") as identified:
        tablet.get_by_role("button", name="Identify", exact=True).click()  # another one also diagnoses

    expect(tablet.get_by_text("Here is number 4.")).to_be_visible()
    assert identified.value.post_data_json == {"campaign_id": 5}
    whole = {"method": "choose", "configurations": 30}
    assert (asked.value.post_data_json["role"], asked.value.post_data_json["plan"]) == ("calibration", whole)


def test_identify_and_diagnose_makes_both_and_the_trail_has_both(service, tablet):
    session = service.paused_session("left arm")
    service.plan_with(two_findings())

    tablet.goto(service.url + session.removeprefix("/api/v1"))
    tablet.get_by_role("button", name="Identify and diagnose").click()

    expect(tablet).to_have_url(f"{service.url}/diagnoses/1")
    expect(tablet.get_by_role("link", name="Identification 1")).to_be_visible()
    expect(tablet.get_by_text("No identification")).to_have_count(0)
    assert service.get("/api/v1/identifications/1")["campaign_id"] == 1
    assert service.get("/api/v1/diagnoses/1")["campaign_id"] == 1
