"""Whether readings are simulated, and when they were taken, is told by their record, however old it is."""

from dataclasses import replace

import pytest

from tests.helpers.ballbar.sessions import make_ballbar_plan, measured
from tests.helpers.diagnosis.answers import make_diagnosis
from tests.helpers.domain.builders import make_identification, make_model
from tests.helpers.domain.tracker_sessions import make_plan, make_setup
from truepose.domain.cell import SimulatedCell
from truepose.domain.ledger import EntryKind, LedgerEntry
from truepose.storage.ledger.entries import LedgerRepository
from truepose.storage.ledger.sessions import SessionRepository
from truepose.storage.records import CampaignSummary, JobKind, Page
from truepose.storage.results.campaigns import CampaignRepository, NewCampaign
from truepose.storage.results.diagnoses import DiagnosisRepository
from truepose.storage.results.jobs import JobRepository
from truepose.storage.results.models import ResultRepository

REAL = make_setup()
SIMULATED = replace(REAL, cell=replace(REAL.cell, simulated=SimulatedCell("irb120-tilted", 0)))
EMPTY = CampaignSummary(0, 0, 0, 0, 0)


class Records:
    def __init__(self, database):
        self.sessions = SessionRepository(database)
        self.campaigns = CampaignRepository(database)
        self.results = ResultRepository(database)
        self.diagnoses = DiagnosisRepository(database)
        self.jobs = JobRepository(database)

    async def campaign(self, session_ids=(), **summary):
        summed = replace(EMPTY, **summary)
        stored = NewCampaign("left", "elbow", summed, b"columns", session_ids=tuple(session_ids))
        return await self.campaigns.add(stored)

    async def diagnosis(self, campaign_id):
        job = await self.jobs.add(JobKind.DIAGNOSIS, {})
        return await self.diagnoses.keep(job, campaign_id, make_diagnosis(), None)


@pytest.fixture
def records(database):
    return Records(database)


async def test_a_campaign_is_simulated_where_any_of_its_sessions_is(records):
    real = await records.sessions.add("first", REAL, make_plan(3))
    simulated = await records.sessions.add("second", SIMULATED, make_plan(3))

    for numbers in ((real,), (simulated,), (real, simulated)):
        await records.campaign(numbers)

    assert [session.simulated for session in await records.sessions.page(Page())] == [False, True]
    assert [entry.simulated for entry in await records.campaigns.page(Page())] == [False, True, True]


async def test_results_and_diagnoses_are_simulated_as_the_campaign_that_they_are_of(records):
    for said in (True, None):
        campaign_id = await records.campaign(simulated=said)
        await records.diagnosis(campaign_id)
        job = await records.jobs.add(JobKind.IDENTIFICATION, {})
        await records.results.keep_identification(job, campaign_id, make_identification(model=make_model()))

    assert [entry.simulated for entry in await records.diagnoses.page(Page())] == [True, False]
    assert [entry.simulated for entry in await records.results.identifications(Page())] == [True, False]
    models = await records.results.models(Page())
    assert [entry.simulated for entry in models] == [True, True, False, False]
    assert [(await records.results.model(entry.id)).simulated for entry in models] == [
        True,
        True,
        False,
        False,
    ]


async def test_a_ballbar_session_is_dated_by_its_last_length(database, records):
    ledger = LedgerRepository(database)
    number = await records.sessions.add("first", REAL, make_ballbar_plan())
    await ledger.append(number, measured("placement-1/pose-1/leg-1-1"))
    taken = (await ledger.whole(number))[-1].recorded_at
    await ledger.append(number, LedgerEntry("placement-1/pose-1/detach", EntryKind.CONFIRMED, 90.0))

    found = await records.diagnoses.get(await records.diagnosis(await records.campaign([number])))

    assert found.measured_at == taken


async def test_an_upload_has_the_day_that_somebody_stated_or_none(records):
    silent, dated = await records.campaign(), await records.campaign(measured_on="2025-11-03")

    for number in (silent, dated):
        await records.diagnosis(number)

    assert [entry.measured_at for entry in await records.diagnoses.page(Page())] == [None, "2025-11-03"]
