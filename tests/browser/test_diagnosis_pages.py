"""The pages of diagnoses as a person at the cell sees and taps them."""

import dataclasses

import pytest
from playwright.sync_api import expect

from tests.helpers.diagnosis.diagnosed_cells import consistent, described, small_findings, two_findings
from truepose.domain.diagnosis import NextMeasurement

PROPOSED = ((5.0, 40.0, -25.0, 0.0, 30.0, 90.0), (15.0, 45.0, -20.0, 0.0, 35.0, -90.0))


def with_proposals(*configurations_deg):
    proposal = NextMeasurement("Measure joint 2 over its whole range.", configurations_deg)
    return dataclasses.replace(two_findings(), next_measurements=(proposal,))


def test_the_message_is_seen_without_scrolling(service, tablet):
    tablet.goto(service.diagnosed(service.measured_session("left arm"), two_findings()))

    expect(tablet.locator(".message")).to_be_in_viewport()
    expect(tablet.get_by_text("Explained.", exact=True)).to_be_in_viewport()


def test_small_findings_unfold_at_a_tap_and_on_paper(service, tablet):
    tablet.goto(service.diagnosed(service.measured_session("left arm"), small_findings()))
    folded, amplitude = tablet.locator("details", has=tablet.locator("#finding-2")), "#finding-2 table"

    expect(tablet.locator(amplitude).first).to_be_hidden()
    folded.locator("summary").click()
    expect(tablet.locator(amplitude).first).to_be_visible()
    folded.locator("summary").click()
    expect(tablet.locator(amplitude).first).to_be_hidden()

    tablet.emulate_media(media="print")
    expect(tablet.locator(amplitude).first).to_be_visible()


def test_the_map_fits_the_tablet_and_is_told_to_those_who_cannot_see_it(service, tablet):
    tablet.goto(service.diagnosed(service.measured_session("left arm"), described()))

    expect(tablet.get_by_role("img", name="Map of the error sources")).to_be_visible()
    tablet.get_by_text("As a table").click()
    expect(tablet.get_by_role("cell", name="modelled empirically").first).to_be_visible()
    assert tablet.evaluate("document.documentElement.scrollWidth <= innerWidth")


def test_the_line_below_the_arm_has_lengths_and_no_nan(service, tablet):
    tablet.goto(service.diagnosed(service.measured_session("left arm"), two_findings()))

    said = tablet.locator("robot-view").evaluate("""(view) => {
        const poses = [{ config: 4, before_mm: 0.4224, after_mm: 0.0465 }];
        view.space = { poses, times_before: 100, times_after: 2000 };
        view.caption();
        return view.part("pose").textContent;
    }""")

    assert said == "Configuration 4: error 0.422 mm before calibration, 0.047 mm after."


def test_a_view_that_is_not_there_yet_says_so(service, tablet):
    tablet.goto(service.diagnosed(service.measured_session("left arm"), two_findings()))

    expect(tablet.locator("robot-view [data-part=pose]")).to_have_text("Loading the 3D view …")


def test_the_list_leads_to_the_report(service, tablet):
    service.diagnosed(service.measured_session("left arm"), consistent())

    tablet.goto(service.url)
    tablet.get_by_role("link", name="Work").click()
    tablet.get_by_role("link", name="Diagnosis 1").click()

    expect(tablet.locator("h1")).to_have_text("Diagnosis of ABB IRB 120")


def test_one_tap_adds_what_is_proposed_to_the_plan(service, tablet):
    session = service.paused_session("left arm")
    tablet.goto(service.diagnosed(session, with_proposals(*PROPOSED)))

    tablet.get_by_label("Your name").fill("Ada Byron")
    with tablet.expect_request("**/configurations") as asked:
        tablet.get_by_role("button", name="Measure these next: 2 configurations").click()

    assert asked.value.post_data_json["diagnosis_id"] == 1  # which the service then runs again
    expect(tablet.get_by_role("status")).to_contain_text("Added configurations")
    stops = service.get(f"{session}/plan")["stops"]
    assert [stop["joints_deg"] for stop in stops[-2:]] == [pytest.approx(joints) for joints in PROPOSED]


def test_two_taps_do_not_add_them_twice(service, tablet):
    session = service.paused_session("left arm")
    planned = len(service.get(f"{session}/plan")["stops"])
    tablet.goto(service.diagnosed(session, with_proposals(*PROPOSED)))
    tablet.get_by_label("Your name").fill("Ada Byron")
    button = tablet.get_by_role("button", name="Measure these next")

    for _ in range(2):
        with tablet.expect_response("**/configurations"):
            button.click()
        expect(button).to_be_enabled()

    assert len(service.get(f"{session}/plan")["stops"]) == planned + 2


def test_nothing_is_added_without_a_name(service, tablet):
    session = service.paused_session("left arm")
    planned = len(service.get(f"{session}/plan")["stops"])
    tablet.goto(service.diagnosed(session, with_proposals(*PROPOSED)))

    tablet.get_by_role("button", name="Measure these next").click()

    assert len(service.get(f"{session}/plan")["stops"]) == planned
    expect(tablet.get_by_role("status")).to_be_empty()


def test_a_session_that_has_ended_takes_no_more_and_says_so(service, tablet):
    tablet.goto(service.diagnosed(service.measured_session("left arm"), with_proposals(*PROPOSED)))

    expect(tablet.get_by_text("has ended (finished)")).to_be_visible()
    expect(tablet.get_by_role("button", name="Measure these next")).to_have_count(0)


def test_diagnosing_again_leads_to_the_new_diagnosis(service, tablet):
    session = service.paused_session("left arm")
    first = service.diagnosed(session, with_proposals(*PROPOSED))
    tablet.goto(first)

    tablet.get_by_role("button", name="Diagnose session").click()

    tablet.wait_for_url(lambda url: url.endswith("/diagnoses/2"))
    expect(tablet.locator(".message")).to_have_text(two_findings().message)
