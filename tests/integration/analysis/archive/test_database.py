"""The archive of a database: its campaigns, and what was stored of them."""

import asyncio
from dataclasses import replace

import pytest

from tests.helpers.archive import ThisProcess, written_archive
from tests.helpers.domain.builders import make_campaign
from truepose.analysis.archive import Archive, in_database
from truepose.analysis.campaigns.tracker import summary_of
from truepose.analysis.parallel.tasks import Cluster
from truepose.diagnosis.diagnose import diagnose
from truepose.domain.campaign import ReadingName, ReadingsSetAside
from truepose.domain.errors import ConfigurationError
from truepose.exchange.campaigns.folder import read_campaign
from truepose.identification import identify
from truepose.storage.database import Database
from truepose.storage.documents import pack
from truepose.storage.errors import DatabaseAddressError
from truepose.storage.records import JobKind
from truepose.storage.results.campaigns import CampaignRepository, NewCampaign
from truepose.storage.results.diagnoses import DiagnosisRepository
from truepose.storage.results.jobs import JobRepository
from truepose.storage.results.models import ResultRepository


async def _filled(url, campaign, set_aside=None):
    """Store a campaign twice; of the first one what was found is stored as well."""
    database = Database(url)
    campaigns, jobs = CampaignRepository(database), JobRepository(database)
    new = NewCampaign("as measured", campaign.robot.name, summary_of(campaign), pack(campaign))
    first, _ = await campaigns.add(new), await campaigns.add(new)
    job = await jobs.add(JobKind.IDENTIFICATION, {})
    await ResultRepository(database).keep_identification(
        job, first, replace(identify(campaign), set_aside=set_aside)
    )
    job = await jobs.add(JobKind.DIAGNOSIS, {})
    await DiagnosisRepository(database).keep(
        job, first, replace(diagnose(campaign), set_aside=set_aside), None
    )
    database.close()


def test_stored_results_are_what_new_ones_are_compared_with(tmp_path):
    folder = written_archive(tmp_path / "folders", readings=(12,)) / "campaign-1"
    url = f"sqlite:///{tmp_path / 'cell.sqlite3'}"
    asyncio.run(_filled(url, read_campaign(folder)))

    with in_database(url) as campaigns:
        anew = Archive(campaigns, tmp_path / "out").compute(Cluster(ThisProcess()), lambda *_: None)

    first, second = anew.changes
    assert (first.campaign, second.campaign) == ("1 as measured", "2 as measured")
    assert (first.compared, first.differs) == (True, False)
    assert first.mean_before_um == first.mean_now_um
    assert (first.status_before, first.verdict_before) == (first.status_now, first.verdict_now)
    assert not second.compared


def test_results_without_some_of_the_readings_are_not_compared_with(tmp_path):
    folder = written_archive(tmp_path / "folders", readings=(12,)) / "campaign-1"
    url = f"sqlite:///{tmp_path / 'cell.sqlite3'}"
    aside = ReadingsSetAside((ReadingName(1, 1),), "it slipped", "Ada Byron", rows=(0,))
    asyncio.run(_filled(url, read_campaign(folder), aside))

    with in_database(url) as campaigns:
        before = [campaign.before() for campaign in campaigns]

    assert before == [None, None]


def test_a_database_without_campaigns_is_refused(tmp_path):
    url = f"sqlite:///{tmp_path / 'empty.sqlite3'}"
    Database(url).close()

    with pytest.raises(ConfigurationError, match="No campaign found in the database"), in_database(url):
        pass


def test_a_database_that_is_not_there_is_refused_and_not_made(tmp_path):
    with (
        pytest.raises(DatabaseAddressError, match="There is no database"),
        in_database(f"sqlite:///{tmp_path / 'typo.sqlite3'}"),
    ):
        pass
    assert not list(tmp_path.iterdir())


def test_a_database_is_read_as_it_is_also_while_a_service_has_it(tmp_path):
    file = tmp_path / "cell.sqlite3"
    database = Database(f"sqlite:///{file}")
    new = NewCampaign("as measured", "ABB IRB 120", summary_of(make_campaign()), pack(make_campaign()))
    asyncio.run(CampaignRepository(database).add(new))

    with in_database(f"sqlite:///{file}") as campaigns:
        assert [one.name for one in campaigns] == ["1 as measured"]
    database.close()
