"""A robot over the months, as a page: what its reader is told first."""

import numpy as np
import pytest

from tests.helpers.diagnosis.answers import make_diagnosis, make_finding
from tests.helpers.domain.builders import make_campaign, make_model
from truepose.domain.campaign import PointReadings, Stops
from truepose.identification import predict
from truepose.storage.documents import pack
from truepose.storage.records import CampaignSummary, JobKind
from truepose.storage.results.campaigns import NewCampaign

_ROBOT = make_model().robot.name


def _campaign():
    joints = np.linspace(-0.9, 0.9, 24).reshape(8, 3) + 0.1 * np.random.default_rng(4).normal(size=(8, 3))
    stops = Stops(np.arange(1, 9), joints, temperature_c=np.linspace(20.0, 23.5, 8))
    nest = np.ones(8, np.int64)
    return make_campaign(
        calibration=PointReadings(stops, nest, predict(make_model(), stops, nest)[0], np.full(8, 0.01))
    )


@pytest.fixture
def diagnosed(app):
    """Store a diagnosis with a backlash of that size on that day."""
    here = app.state.context

    async def keep(day, amplitude, robot=_ROBOT):
        kept = NewCampaign("arm", robot, CampaignSummary(8, 0, 0, 0, 0, measured_on=day), pack(_campaign()))
        number = await here.campaigns.add(kept)
        found = make_finding(amplitude=amplitude, amplitude_standard_uncertainty=0.002)
        diagnosis = make_diagnosis(robot=robot, findings=(found,), model=make_model())
        return await here.diagnoses.keep(await here.jobs.add(JobKind.DIAGNOSIS, {}), number, diagnosis, None)

    return keep


async def test_a_cause_that_grew_is_the_first_thing_on_the_page(client, diagnosed):
    await diagnosed("2026-02-03", 0.021)
    await diagnosed("2026-09-14", 0.047)

    answer = await client.get(f"/robots/{_ROBOT}?whole=true")

    assert answer.status_code == 200
    page = answer.text
    assert "One cause is significantly larger than before" in page
    assert "Backlash, joint 3 grew by" in page
    assert page.index("grew by") < page.index("<h2>")


async def test_a_robot_that_did_not_change_says_so(client, diagnosed):
    await diagnosed("2026-02-03", 0.021)
    await diagnosed("2026-09-14", 0.022)

    page = (await client.get(f"/robots/{_ROBOT}?whole=true")).text

    assert "No cause grew significantly: 2 measurements in 7 months." in page
    assert "No evidence that the robot changed" in page
    assert "20" in page and "°C" in page


async def test_two_measurements_are_chosen_for_comparison(client, diagnosed):
    numbers = [await diagnosed(f"2026-0{month}-01", 0.02) for month in (1, 4, 7)]

    page = (await client.get(f"/robots/{_ROBOT}?earlier={numbers[1]}&later={numbers[2]}&whole=true")).text

    chosen = [line for line in page.splitlines() if "selected" in line]
    assert [f'value="{number}" selected' in line for number, line in zip(numbers[1:], chosen, strict=True)]


async def test_a_robot_that_was_never_measured_has_a_page_that_leads_on(client):
    answer = await client.get("/robots/KUKA%20KR%206")

    assert answer.status_code == 404
    assert "No measurement of KUKA KR 6 has been diagnosed yet." in answer.text
    assert 'href="/plan"' in answer.text


async def test_the_comparison_lists_the_alarms(client, diagnosed):
    await diagnosed("2026-02-03", 0.021)
    await diagnosed("2026-09-14", 0.047)

    found = (await client.get("/api/v1/diagnoses/comparison", params={"robot": _ROBOT})).json()

    ((alarm),) = found["alarms"]
    assert (alarm["effect"], alarm["subject"], alarm["kind"]) == ("backlash", "joint 3", "grown")
    assert alarm["sentence"].startswith("Backlash, joint 3 grew by 0.0260")
