"""What a campaign of a plant tells is kept for that campaign, and for no other of its numbers."""

import dataclasses

from truepose.analysis.fleets.campaign_summaries import CampaignSummaryService
from truepose.storage.plant.queries import ResultRecord

CAMPAIGN = ResultRecord(
    1, "left arm", "campaign", 1, "spring", "IRB 120", "120-1", "T-1", "2026-03-03", None, branch_id=1
)


class Campaigns:
    async def content(self, campaign):
        return campaign.robot_serial_number.encode()


class Drawing:
    async def draw(self, work, asked):
        return work(asked)


async def test_a_plant_that_was_begun_anew_is_not_told_what_another_robot_told(tmp_path, monkeypatch):
    monkeypatch.setattr("truepose.analysis.fleets.campaigns.tell", lambda content, _seed: b"of " + content)

    def desk():
        return CampaignSummaryService(
            Campaigns(), CampaignSummaryService.folder(tmp_path / "plant.sqlite3"), Drawing()
        )

    (first,) = await desk().told([CAMPAIGN])
    (kept,) = await desk().known([CAMPAIGN])
    (other,) = await desk().told([dataclasses.replace(CAMPAIGN, robot_serial_number="120-2")])

    assert (first.told, kept.told, other.told) == (b"of 120-1", b"of 120-1", b"of 120-2")
