"""Campaigns are kept as arrays; those of an older schema are read from the zip of their folder."""

import numpy as np
import pytest
from alembic import command
from sqlalchemy import create_engine

from tests.helpers.domain.builders import make_campaign
from truepose.analysis.workers.tasks import stored_campaign
from truepose.exchange.campaigns.zip_file import write_campaign_zip
from truepose.storage.calibration.campaigns import CampaignRepository, NewCampaign
from truepose.storage.columns import pack
from truepose.storage.connection.migrating import migration_config
from truepose.storage.connection.sqlite.library import LIBRARY
from truepose.storage.database import Database
from truepose.storage.integrity.chain import link_all
from truepose.storage.integrity.verification import verify
from truepose.storage.records import CampaignSummary

ARCHIVE = write_campaign_zip(make_campaign())
ROW = (1, "2026-03-03T10:00:00.000+00:00", "spring", "elbow", "{}", "[]", ARCHIVE)
SUMMARY = CampaignSummary(3, 0, 0, 0, 0)


@pytest.fixture
def file(tmp_path):
    return tmp_path / "truepose.sqlite3"


def migrate(file, revision, *, up):
    engine, config = create_engine(f"sqlite:///{file}"), migration_config()
    with engine.begin() as connection:
        config.attributes["connection"] = connection
        (command.upgrade if up else command.downgrade)(config, revision)
    engine.dispose()


@pytest.fixture
def older(file):
    """A database of schema 0008 with one campaign."""
    migrate(file, "0008", up=True)
    with LIBRARY.connect(file) as connection:
        connection.execute("INSERT INTO campaigns VALUES (?, ?, ?, ?, ?, ?, ?)", ROW)
        link_all(connection, ["campaigns"])
    connection.close()
    return file


async def test_an_older_campaign_is_read_from_its_zip_and_downloaded_as_it_is(older):
    database = Database(f"sqlite:///{older}")
    campaigns = CampaignRepository(database)

    content, archive = await campaigns.content(1), await campaigns.archive(1)
    database.close()

    np.testing.assert_allclose(
        stored_campaign(content).calibration.position_mm, make_campaign().calibration.position_mm, atol=1e-5
    )
    assert archive == ARCHIVE


async def test_older_links_hold_after_the_migration_and_beside_newer_campaigns(older):
    database = Database(f"sqlite:///{older}")
    number = await CampaignRepository(database).add(NewCampaign("autumn", "elbow", SUMMARY, b"columns"))
    database.close()

    assert (number, verify(older).findings) == (2, ())


async def test_a_database_with_campaigns_as_arrays_has_no_way_down(file):
    database = Database(f"sqlite:///{file}")
    await CampaignRepository(database).add(NewCampaign("spring", "elbow", SUMMARY, pack(make_campaign())))
    database.close()

    with pytest.raises(ValueError, match="keep 0009"):
        migrate(file, "0008", up=False)


async def test_an_older_database_goes_down_again(older):
    migrate(older, "head", up=True)

    migrate(older, "0008", up=False)

    with LIBRARY.connect(older) as connection:
        assert connection.execute("SELECT * FROM campaigns").fetchall() == [ROW]
    connection.close()
