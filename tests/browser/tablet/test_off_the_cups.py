"""The motion that leads to no cup and to no pose says where the arm goes all the same."""

import pytest
from playwright.sync_api import expect

from tests.browser.tablet.bench.fake_desk import step
from tests.browser.tablet.conftest import a_tablet

OFF = step("move", id="placement-1/away/move", target_deg=[0, 45, -30, 0, 30, 0], nominal_mm=None)


@pytest.mark.parametrize(
    ("language", "said"), [("en", "The arm backs away from the cups"), ("fr", "écarte des coupelles")]
)
def test_a_person_reads_that_the_arm_backs_off_the_cups(chromium, url, desk, language, said):
    desk.show(state="running", step=OFF, suspicion=None, ballbar_attached=False)

    with a_tablet(chromium, url, language=language) as page:
        page.goto(f"{url}/operator/3")
        page.locator("body[data-screen=move]").wait_for()

        expect(page.locator("#kicker")).to_contain_text(said)
