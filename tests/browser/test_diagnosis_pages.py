"""The pages of diagnoses as a person at the cell sees and taps them."""

import dataclasses

import pytest
from playwright.sync_api import expect

from tests.helpers.diagnosis.diagnosed_cells import described, small_findings, two_findings
from truepose.domain.diagnosis import NextMeasurement

PROPOSED = ((5.0, 40.0, -25.0, 0.0, 30.0, 90.0), (15.0, 45.0, -20.0, 0.0, 35.0, -90.0))


def with_proposals(*configurations_deg):
    proposal = NextMeasurement("Measure joint 2 over its whole range.", configurations_deg)
    return dataclasses.replace(two_findings(), next_measurements=(proposal,))


def test_a_diagnosis_is_found_and_says_first_what_is_to_be_known(service, tablet):
    found = service.diagnosed(service.measured_session("left arm"), with_proposals(*PROPOSED))
    tablet.goto(service.url)
    tablet.get_by_role("link", name="Work").click()
    tablet.get_by_role("link", name="Diagnosis 1").click()
    expect(tablet.locator("h1")).to_have_text("Diagnosis of ABB IRB 120")

    tablet.goto(found)
    expect(tablet.locator(".message")).to_be_in_viewport()
    expect(tablet.get_by_text("Explained.", exact=True)).to_be_in_viewport()
    expect(tablet.locator("robot-view [data-part=pose]")).to_have_text("Loading the 3D view …")
    expect(tablet.get_by_text("has ended (finished)")).to_be_visible()  # and takes no more configurations
    expect(tablet.get_by_role("button", name="Measure these next")).to_have_count(0)
    said = tablet.locator("robot-view").evaluate("""(view) => {
        const poses = [{ config: 4, before_mm: 0.4224, after_mm: 0.0465 }];
        view.space = { poses, times_before: 100, times_after: 2000 };
        view.caption();
        return view.part("pose").textContent;
    }""")
    assert said == "Configuration 4: error 0.422 mm before calibration, 0.047 mm after."


def test_findings_unfold_at_a_tap_and_on_paper_and_the_map_is_told_to_those_who_cannot_see_it(
    service, tablet
):
    session = service.measured_session("left arm")
    tablet.goto(service.diagnosed(session, small_findings()))
    folded, amplitude = tablet.locator("details", has=tablet.locator("#finding-2")), "#finding-2 table"

    expect(tablet.locator(amplitude).first).to_be_hidden()
    folded.locator("summary").click()
    expect(tablet.locator(amplitude).first).to_be_visible()
    folded.locator("summary").click()
    expect(tablet.locator(amplitude).first).to_be_hidden()
    tablet.emulate_media(media="print")
    expect(tablet.locator(amplitude).first).to_be_visible()
    tablet.emulate_media(media="null")

    tablet.goto(service.diagnosed(session, described()))
    expect(tablet.get_by_role("img", name="Map of the error sources")).to_be_visible()
    tablet.get_by_text("As a table").click()
    expect(tablet.get_by_role("cell", name="modelled empirically").first).to_be_visible()
    assert tablet.evaluate("document.documentElement.scrollWidth <= innerWidth")


def test_what_is_proposed_is_added_once_and_with_a_name_and_diagnosed_again(service, tablet):
    session = service.paused_session("left arm")
    planned = len(service.get(f"{session}/plan")["stops"])
    tablet.goto(service.diagnosed(session, with_proposals(*PROPOSED)))
    button = tablet.get_by_role("button", name="Measure these next: 2 configurations")

    button.click()
    assert len(service.get(f"{session}/plan")["stops"]) == planned
    expect(tablet.get_by_role("status")).to_be_empty()

    tablet.get_by_label("Your name").fill("Ada Byron")
    for _ in range(2):
        with tablet.expect_response("**/configurations") as answered:
            button.click()
        asked = answered.value.request.post_data_json
        assert asked["diagnosis_id"] == 1  # which the service then runs again
        expect(tablet.get_by_role("status")).to_contain_text("Added configurations")
        expect(button).to_be_enabled()
    stops = service.get(f"{session}/plan")["stops"]
    assert len(stops) == planned + 2
    assert [stop["joints_deg"] for stop in stops[-2:]] == [pytest.approx(joints) for joints in PROPOSED]

    tablet.get_by_role("button", name="Diagnose session").click()
    tablet.wait_for_url(lambda url: url.endswith("/diagnoses/2"))
    expect(tablet.locator(".message")).to_have_text(two_findings().message)
