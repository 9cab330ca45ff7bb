"""Pages on a link that is cut now and then: a request that failed is no answer to what was asked."""

from playwright.sync_api import expect

from tests.browser.test_session_pages import planned
from tests.browser.windows import without_complaint

CUT = ("Failed to load resource",)  # what the browser says of it
GATEWAY = "<html>502 Bad Gateway</html>"


def test_a_job_is_followed_to_its_end_whatever_is_cut_meanwhile(service, chromium):
    service.plan_with(planned())
    for device in ("tracker", "robot"):
        service.post(f"/api/v1/devices/{device}/connect")
    with chromium.one(service.url) as page, without_complaint(page, service.url, CUT):
        page.goto(f"{service.url}/sessions/new")
        page.route("**/api/v1/jobs/*", lambda route: route.abort(), times=2)

        page.locator("#iso9283").get_by_role("button", name="Plan test").click()

        expect(page.locator("#state")).to_have_text("planned")


def test_a_page_of_a_gateway_is_no_answer_to_files(service, chromium, tmp_path):
    (tmp_path / "arm.csv").write_text("x;y\n")
    with chromium.one(service.url) as page, without_complaint(page, service.url, CUT):
        page.goto(f"{service.url}/bring")
        page.route("**/drafts/*/files?*", lambda route: route.fulfill(status=502, body=GATEWAY))

        page.set_input_files("[data-bring] input[multiple]", tmp_path / "arm.csv")

        said = page.locator("[data-bring] output")
        expect(said).to_have_text("The service does not respond. Check that it is running, then try again.")
