"""The study of giant uploads runs, and its giants are what it says."""

from tests.studies.hardening.giant_upload import giant_zip, study
from truepose.exchange.campaigns.zip_file import read_campaign_zip


def test_a_giant_is_a_campaign_of_so_many_rows():
    assert len(read_campaign_zip(giant_zip(500)).calibration) == 500


async def test_uploads_are_watched_one_and_four_at_once(tmp_path):
    found, size = await study(tmp_path, rows=500)

    assert [(crowd.uploads, set(crowd.answers)) for crowd in found] == [(1, {201}), (4, {201})]
    assert all(crowd.with_workers_mb >= crowd.service_mb > 10.0 for crowd in found)
    assert all(crowd.health_asked > 0 for crowd in found)
    assert size < 2**20
