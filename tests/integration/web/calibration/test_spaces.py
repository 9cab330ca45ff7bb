"""Errors in space over REST, of a stored result with the campaign that it is made from."""

import numpy as np
import pytest

from tests.helpers.domain.builders import make_campaign, make_identification, make_model
from truepose.domain.campaign import PointReadings, Stops
from truepose.identification import predict
from truepose.storage.documents import pack
from truepose.storage.records import CampaignSummary, JobKind
from truepose.storage.results.campaigns import NewCampaign

_OFF_MM = 0.5


@pytest.fixture
async def stored(app):
    """An identification and a validation; the tool was half a millimetre higher than the model says."""
    here = app.state.context
    stops = Stops(config=np.arange(1, 6), joints_rad=np.linspace(-0.5, 0.5, 15).reshape(5, 3))
    nest = np.ones(5, np.int64)
    position, _ = predict(make_model(), stops, nest)
    above = position + np.array([0.0, 0.0, _OFF_MM])
    seen = PointReadings(stops, nest, above, np.full(5, 0.01))
    campaign = make_campaign(calibration=seen)
    kept = NewCampaign("arm", campaign.robot.name, CampaignSummary(5, 0, 0, 0, 0), pack(campaign))
    number = await here.campaigns.add(kept)
    found = make_identification(model=make_model())
    await here.results.keep_identification(await here.jobs.add(JobKind.IDENTIFICATION, {}), number, found)
    await here.results.keep_identification(
        await here.jobs.add(JobKind.IDENTIFICATION, {}), number, make_identification(model=None)
    )
    return number


async def test_errors_are_seen_minus_foreseen_where_the_tool_stood(client, stored):
    space = (await client.get("/api/v1/identifications/1/space")).json()

    assert space["total"] == len(space["points_mm"]) == 5
    assert space["after_mm"] == [pytest.approx([0.0, 0.0, _OFF_MM], abs=1e-5)] * 5
    assert space["poses"][0]["after_mm"] == pytest.approx(_OFF_MM)
    assert all(len(piece) == 7 for piece in space["poses"][0]["pieces_mm"])


@pytest.mark.parametrize("path", ["identifications/2", "identifications/9", "validations/1", "diagnoses/1"])
async def test_what_has_no_model_has_no_errors_in_space(client, stored, path):
    answer = await client.get(f"/api/v1/{path}/space")

    assert answer.status_code == 404
    assert answer.json()["detail"].startswith("There is no ")
