"""A model on record, without a campaign that it would have to be identified from."""

from dataclasses import replace

from tests.helpers.domain.builders import make_identification
from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.models import model_of, plain_parameters
from truepose.storage.records import CampaignSummary, JobKind
from truepose.storage.results.campaigns import NewCampaign


async def store_model(here, robot=IRB_120):
    """Store the model of a robot like an IRB 120 with errors of every parameter and return its number."""
    plain = model_of(robot, *plain_parameters(IRB_120))
    model = replace(plain, nominal_base=plain.base)
    summary = CampaignSummary(50, 0, 0, 0, 0)
    campaign_id = await here.campaigns.add(NewCampaign("left arm", "ABB IRB 120", summary, b""))
    job_id = await here.jobs.add(JobKind.IDENTIFICATION, {})
    await here.results.keep_identification(job_id, campaign_id, make_identification(model=model))
    return (await here.results.newest_models(1))[0].id
