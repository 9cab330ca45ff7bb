"""Results whose model is half a millimetre off, each with the campaign that it is made from."""

import numpy as np
import pytest

from tests.helpers.domain.builders import make_campaign, make_identification, make_model
from truepose.domain.campaign import PointReadings, Stops
from truepose.identification import predict
from truepose.storage.documents import pack
from truepose.storage.records import CampaignSummary, JobKind
from truepose.storage.results.campaigns import NewCampaign

OFF_MM = 0.5


@pytest.fixture
async def stored(app):
    """An identification and a validation; the tool was half a millimetre higher than the model says."""
    here = app.state.context
    stops = Stops(config=np.arange(1, 6), joints_rad=np.linspace(-0.5, 0.5, 15).reshape(5, 3))
    nest = np.ones(5, np.int64)
    position, _ = predict(make_model(), stops, nest)
    above = position + np.array([0.0, 0.0, OFF_MM])
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
